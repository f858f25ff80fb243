//! Whether a ball is clear of the part, with all that stands above it.
//!
//! ```text
//!        | |                  on a steep side the ball rests far above where it is, and has only a little to go sideways: what it is
//!     ___|o|   <- rests       deep in is the shorter way. (Round a solid the touched place tells neither: the part goes on bulging
//!    (     \.                 below it.)
//!     \     )o <- is
//! ```
//!
//! Crosses the border: places of the ball's centre in, lengths out; work coordinates, mm.

use super::drop::{DropCutter, Hint};
use crate::geom::{Point, Vector};

/// What rests and what is out of the part is told to, mm.
const HAIR: f64 = 1e-6;
/// Steps of a way out.
const STEPS: usize = 4;

impl DropCutter {
    /// Length (mm) of a way out of the part for a ball `low` mm below where it rests with this normal: at most `low`, straight up. So
    /// deep it is in the part at most, and its shank too. No shorter way is looked for once one is no longer than `enough`. Up to eight
    /// drops.
    pub fn way_out(
        &self,
        center: &Point,
        normal: &Vector,
        low: f64,
        enough: f64,
        hint: &mut Hint,
    ) -> f64 {
        // Out of the plane it touches, and of the next one met.
        let mut length = low * normal.z;
        let mut way = normal * length;
        let mut found = low;
        for _ in 0..STEPS {
            let Some((left, n)) = self.below_rest(&(center + way), hint) else {
                found = length.min(low);
                break;
            };
            way += n * (left * n.z + HAIR);
            length = way.norm();
            if length >= low {
                break;
            }
        }
        if found <= enough {
            return found;
        }
        // Beside an edge, and where the part bends away, that is further than it must be.
        let mut way = *normal;
        for _ in 0..STEPS {
            let Some(aside) = way.try_normalize(1e-9) else {
                break;
            };
            match self.below_rest(&(center + aside * enough), hint) {
                None => return enough,
                Some((_, n)) => way = aside + n,
            }
        }
        found
    }

    /// How far below where it rests the ball is, and the normal there; `None` where it is free.
    fn below_rest(&self, center: &Point, hint: &mut Hint) -> Option<(f64, Vector)> {
        let c = self.drop_near(center.x, center.y, hint)?;
        let low = c.center.z - center.z;
        (low > HAIR).then(|| (low, (c.center - c.point) / self.radius()))
    }

    /// Is the ball no deeper than `most` mm in the part? Never a wrong yes. One drop where it is free or rests.
    pub fn is_clear(&self, center: &Point, most: f64, hint: &mut Hint) -> bool {
        self.below_rest(center, hint).is_none_or(|(low, normal)| {
            low <= most || self.way_out(center, &normal, low, most, hint) <= most
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;

    /// A ball of 10 mm as a mesh; its triangles hardly differ from it.
    fn ball() -> DropCutter {
        let n = 400;
        let at = |i: usize, j: usize| {
            let (a, b) = (
                std::f64::consts::PI * i as f64 / n as f64,
                std::f64::consts::TAU * j as f64 / n as f64,
            );
            Point::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos()) * 10.0
        };
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.push([a, b, c]);
                triangles.push([a, c, d]);
            }
        }
        DropCutter::new(&Mesh { triangles }, 3.0)
    }

    /// Beside the equator, above it and below: as deep as the place is in plan, whatever lies straight above it.
    #[test]
    fn beside_a_solid_it_is_the_way_sideways_that_counts() {
        let cutter = ball();
        let mut hint = Hint::default();
        for deep in [0.003, 0.01, 0.03] {
            for z in [0.9, 0.4, 0.0, -0.4] {
                // Of the ball above the equator, of the shank below it.
                let across = f64::sqrt(13.0 * 13.0 - f64::max(z, 0.0).powi(2));
                let q = Point::new(across - deep, 0.0, z);
                assert!(!cutter.is_clear(&q, 0.7 * deep, &mut hint), "{deep} at {z}");
                assert!(
                    cutter.is_clear(&q, 1.05 * deep + 0.001, &mut hint),
                    "{deep} at {z}"
                );
            }
        }
        assert!(cutter.is_clear(&Point::new(13.001, 0.0, -5.0), 0.0, &mut hint));
        // Deep inside nothing is near the ball's skin.
        assert!(!cutter.is_clear(&Point::new(0.1, 0.0, -2.0), 0.01, &mut hint));
    }
}
