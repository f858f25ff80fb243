//! Shared words of geometry: places, displacements, boxes. Millimetres everywhere; the frame is said by whoever uses them.
//!
//! A place ([`Point`]) and a displacement ([`Vector`]) are two types, as `nalgebra` has them.

/// A place in space, mm.
pub type Point = nalgebra::Point3<f64>;
/// A displacement in space, mm.
pub type Vector = nalgebra::Vector3<f64>;
/// A place in the plane of the machine's table, mm.
pub type Point2 = nalgebra::Point2<f64>;
/// A displacement in the plane of the machine's table, mm.
pub type Vector2 = nalgebra::Vector2<f64>;

/// The table-plane part of a place.
#[inline]
pub fn xy(p: &Point) -> Point2 {
    Point2::new(p.x, p.y)
}

/// An axis-aligned box, mm. Empty when `min > max` on any axis (as [`Box3::empty`] is).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Box3 {
    /// Lowest corner.
    pub min: Point,
    /// Highest corner.
    pub max: Point,
}

impl Box3 {
    /// The box that holds nothing; growing it by a point gives that point.
    pub fn empty() -> Self {
        let inf = f64::INFINITY;
        Box3 {
            min: Point::new(inf, inf, inf),
            max: Point::new(-inf, -inf, -inf),
        }
    }

    /// The smallest box around some points.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point>) -> Self {
        let mut b = Box3::empty();
        for p in points {
            b.grow(p);
        }
        b
    }

    /// Makes room for one more point.
    #[inline]
    pub fn grow(&mut self, p: &Point) {
        self.min = self.min.inf(p);
        self.max = self.max.sup(p);
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(&self, other: &Box3) -> Box3 {
        Box3 {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }

    /// True when no point lies inside.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Edge lengths, mm; zero for the empty box.
    pub fn size(&self) -> Vector {
        if self.is_empty() {
            Vector::zeros()
        } else {
            self.max - self.min
        }
    }

    /// Middle of the box.
    pub fn center(&self) -> Point {
        nalgebra::center(&self.min, &self.max)
    }
}
