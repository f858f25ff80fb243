//! An arc as it will be written: rounded like its words, and still the arc that was meant.
//!
//! Crosses the border: an arc in mm, and where the tool is; its words' figures in units of the last decimal out, or why it cannot be
//! written. Never writes.

use super::scribe::Scribe;
use crate::cldata::Bow;
use crate::geom::{Plane, Point};
use crate::post::definition::{Fit, Shape};
use crate::post::error::Refusal;
use crate::post::number;
use std::io::Write;

/// Radii of start and end that differ by more than this, mm, are not written: LinuxCNC takes 1.27 um or 0.1 %, GRBL 5 um.
const RADII_DIFFER: f64 = 0.0012;
/// An arc's turn and its ends must agree to this, mm along the circle, and a thousandth of its radius.
const ENDS_DIFFER: f64 = 0.002;

/// An arc as it is written.
pub(super) struct Circle {
    pub plane: Plane,
    /// Centre along the plane's two axes, in units of the last decimal.
    pub center: [i64; 2],
    /// Start along the plane's two axes, likewise.
    pub start: [i64; 2],
    /// Mean radius, likewise.
    pub radius: i64,
    /// Signed turn, rad.
    pub sweep: f64,
}

impl<W: Write> Scribe<'_, W> {
    /// An arc as it is written; `None` where it rounds to less than a unit of the last decimal and a straight line says the same.
    pub(super) fn circle(
        &self,
        bow: &Bow,
        to: &Point,
        counts: [Option<i64>; 3],
    ) -> Result<Option<Circle>, Refusal> {
        let [u, v, w] = bow.plane.axes();
        let letters = ['X', 'Y', 'Z'];
        let center = [
            self.length(letters[u], bow.center[u])?,
            self.length(letters[v], bow.center[v])?,
        ];
        let refuse = |problem| Refusal::ArcRounding {
            plane: bow.plane,
            center: [bow.center[u], bow.center[v]],
            decimals: self.decimals,
            problem,
        };
        let ([Some(ex), Some(ey), Some(ez)], [Some(x), Some(y)], [Some(tx), Some(ty)]) =
            (self.exact, [self.at[u], self.at[v]], [counts[u], counts[v]])
        else {
            return Err(refuse("it has no start"));
        };
        if !(bow.sweep.is_finite() && bow.sweep != 0.0) {
            return Err(refuse("its turn is no angle"));
        }
        let from = Point::new(ex, ey, ez);
        let hub = {
            let mut hub = bow.center;
            hub[w] = from[w];
            hub
        };
        let shape = Shape::new(bow.plane, &from, to, &hub, bow.sweep);
        let arcs = &self.post.arcs;
        if arcs.fit(&shape) != Fit::Good {
            let (what, takes) = arcs.complaint(&shape);
            return Err(Refusal::Arc {
                what,
                takes,
                remedy: match arcs.fit(&shape) {
                    Fit::TurnsTooFar => "let it be split into arcs (--split-circles)",
                    _ => "let it be written as lines within a tolerance (--arcs-to-lines 0.005)",
                },
            });
        }
        // The ends and the turn must tell the same arc.
        let angle = |p: &Point| (p[v] - bow.center[v]).atan2(p[u] - bow.center[u]);
        let off = (angle(to) - angle(&from) - bow.sweep).rem_euclid(std::f64::consts::TAU);
        let off = off.min(std::f64::consts::TAU - off) * shape.radius;
        if off > ENDS_DIFFER + 0.001 * shape.radius {
            return Err(refuse("its turn does not lead from its start to its end"));
        }
        if [x, y] == [tx, ty] && bow.sweep.abs() < std::f64::consts::PI {
            return Ok(None);
        }
        let unit = self.units.mm() * 0.1_f64.powi(i32::from(self.decimals));
        let spoke = |a: i64, b: i64| {
            let (a, b) = (a - center[0], b - center[1]);
            [a as f64 * unit, b as f64 * unit]
        };
        let (start, end) = (spoke(x, y), spoke(tx, ty));
        let (rs, re) = (start[0].hypot(start[1]), end[0].hypot(end[1]));
        if rs == 0.0 || re == 0.0 {
            return Err(refuse("its radius becomes zero"));
        }
        if (rs - re).abs() > RADII_DIFFER.max(0.001 * rs.min(re)) {
            return Err(refuse("the radii at its start and end differ"));
        }
        // The turn that a controller will find: the right way round, never zero, once round when the ends are one.
        let between =
            (start[0] * end[1] - start[1] * end[0]).atan2(start[0] * end[0] + start[1] * end[1]);
        let found = match bow.sweep < 0.0 {
            true if between >= 0.0 => between - std::f64::consts::TAU,
            false if between <= 0.0 => between + std::f64::consts::TAU,
            _ => between,
        };
        if (found - bow.sweep).abs() > std::f64::consts::PI {
            return Err(refuse(
                "a sliver of it becomes a whole turn, or the other way round",
            ));
        }
        let radius = number::round(shape.radius / self.units.mm(), self.decimals);
        Ok(Some(Circle {
            plane: bow.plane,
            center,
            start: [x, y],
            radius: radius.ok_or_else(|| refuse("its radius has too many digits"))?,
            sweep: bow.sweep,
        }))
    }
}
