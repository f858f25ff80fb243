//! The part after a broken and resumed job, against the part after a whole one: height maps by the sweep that dry runs use.

use super::bench::Spot;
use super::jobs::Corner;
use morsemill::geom::{Point, Point2, Vector};
use morsemill::sweep::{Lattice, Segment, Swept};

/// Radius of the ball, mm.
const RADIUS: f64 = 1.5;
/// A ball so much smaller must take away no more than the other run's ball, mm: places differ by steps, and the rim of a ball is upright.
const SMALLER: f64 = 0.05;
/// Cells, mm.
const CELL: f64 = 0.3;

/// Pieces cut at feed, by the tip.
pub type Cuts = Vec<(Point, Point)>;

/// What a run cut.
pub fn cuts_of(start: Point, spots: &[Spot]) -> Cuts {
    let before = std::iter::once(start).chain(spots.iter().map(|s| s.at));
    before
        .zip(spots)
        .filter(|(_, s)| !s.rapid)
        .map(|(from, s)| (from, s.at))
        .collect()
}

/// Where a program cuts, or, with `rapids`, where the tool is at all: there is no material to lose there either.
pub fn cuts_of_way(corners: &[Corner], rapids: bool) -> Cuts {
    corners
        .windows(2)
        .filter(|w| rapids || !w[1].rapid)
        .map(|w| (w[0].to, w[1].to))
        .collect()
}

fn heights(cuts: &Cuts, radius: f64, lattice: &Lattice) -> Vec<f64> {
    let up = Vector::new(0.0, 0.0, radius);
    let segments: Vec<Segment> = cuts
        .iter()
        .map(|(from, to)| Segment {
            from: from + up,
            to: to + up,
        })
        .collect();
    let mut swept = Swept::new(*lattice);
    swept.cut_alone(&segments, radius);
    swept.z
}

/// Compares what a whole run and one in pieces cut; `passed`: where the tool of the whole run was. `Err` says where they differ.
pub fn same_part(whole: &Cuts, passed: &Cuts, pieced: &Cuts) -> Result<(), String> {
    let points = || whole.iter().flat_map(|(a, b)| [a, b]);
    let Some(first) = points().next() else {
        return Ok(());
    };
    let (mut low, mut high) = (*first, *first);
    for p in points() {
        (low, high) = (low.inf(p), high.sup(p));
    }
    let lattice = Lattice::covering(
        Point2::new(low.x - RADIUS, low.y - RADIUS),
        Point2::new(high.x + RADIUS, high.y + RADIUS),
        CELL,
    );
    let compare = |small: &Cuts, large: &Cuts, what: &str| {
        let inner = heights(small, RADIUS - SMALLER, &lattice);
        let outer = heights(large, RADIUS, &lattice);
        match inner
            .iter()
            .zip(&outer)
            .position(|(i, o)| i.is_finite() && *o > i + SMALLER)
        {
            None => Ok(()),
            Some(cell) => {
                let at = lattice.center_at(cell);
                Err(format!(
                    "(d) {what} at {:.3} {:.3}: {:.3} instead of {:.3} mm",
                    at.x, at.y, outer[cell], inner[cell]
                ))
            }
        }
    };
    compare(whole, pieced, "material was left")?;
    compare(pieced, passed, "too much was cut")
}
