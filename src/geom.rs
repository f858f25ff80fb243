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

/// The plane of an arc, with its normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// G17, normal Z.
    Xy,
    /// G18, normal Y.
    Zx,
    /// G19, normal X.
    Yz,
}

impl Plane {
    /// The plane's first and second axis and its normal, as indices of X, Y, Z: a counter-clockwise turn goes from the first to
    /// the second.
    pub fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// The table-plane part of a place.
#[inline]
pub fn xy(p: &Point) -> Point2 {
    Point2::new(p.x, p.y)
}

/// Steps to the eight neighbours on a square lattice, counter-clockwise from +X: each and the next make a triangle with the middle.
pub const RING: [(i32, i32); 8] = [
    (1, 0),
    (1, 1),
    (0, 1),
    (-1, 1),
    (-1, 0),
    (-1, -1),
    (0, -1),
    (1, -1),
];

/// Eight directions of unit length, counter-clockwise from +X.
pub fn compass() -> [Vector2; 8] {
    RING.map(|(x, y)| {
        let share = if x != 0 && y != 0 {
            std::f64::consts::FRAC_1_SQRT_2
        } else {
            1.0
        };
        Vector2::new(share * f64::from(x), share * f64::from(y))
    })
}

/// The place nearest to `p` on the straight way from `a` to `b`; `a` where both are one. In the plane or in space.
#[inline]
pub fn nearest_on_segment<const D: usize>(
    p: &nalgebra::OPoint<f64, nalgebra::Const<D>>,
    a: &nalgebra::OPoint<f64, nalgebra::Const<D>>,
    b: &nalgebra::OPoint<f64, nalgebra::Const<D>>,
) -> nalgebra::OPoint<f64, nalgebra::Const<D>> {
    let e = b - a;
    let l2 = e.norm_squared();
    let s = if l2 > 0.0 {
        ((p - a).dot(&e) / l2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    a + e * s
}

/// The place nearest to `c` on a triangle, degenerate ones included.
pub fn nearest_on_triangle(t: &[Point; 3], c: &Point) -> Point {
    if let Some(n) = (t[1] - t[0]).cross(&(t[2] - t[0])).try_normalize(1e-12) {
        let q = c - n * (c - t[0]).dot(&n);
        let side = |i: usize| (t[(i + 1) % 3] - t[i]).cross(&(q - t[i])).dot(&n);
        if (0..3).all(|i| side(i) >= 0.0) {
            return q;
        }
    }
    let mut best = (f64::INFINITY, t[0]);
    for i in 0..3 {
        let q = nearest_on_segment(c, &t[i], &t[(i + 1) % 3]);
        let d = (c - q).norm_squared();
        if d < best.0 {
            best = (d, q);
        }
    }
    best.1
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
