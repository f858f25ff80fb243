//! The way really driven against the way of the program: passed in order, nothing twice, nothing left out.

use super::bench::Spot;
use super::jobs::Corner;

/// How near the axes keep to the way, mm: two steps and rounding.
const NEAR: f64 = 0.01;
/// Slack of places along the way, mm.
pub const ALONG: f64 = 0.025;

/// A way being followed.
struct Follower<'a> {
    corners: &'a [Corner],
    /// The piece that ends at this corner is under way...
    next: usize,
    /// ... and so much of it is driven, mm.
    part: f64,
}

impl Follower<'_> {
    /// Goes on to a place; it must lie ahead, on the way.
    fn go(&mut self, spot: &Spot) -> Result<(), String> {
        loop {
            let [Some(a), Some(b)] = [self.corners.get(self.next - 1), self.corners.get(self.next)]
            else {
                let end = self.corners[self.corners.len() - 1].to;
                if (spot.at - end).norm() <= NEAR {
                    return Ok(());
                }
                return Err(format!(
                    "{:?} at {:.4} s lies beyond the end of the way",
                    spot.at, spot.t
                ));
            };
            let (along, length) = (b.to - a.to, (b.to - a.to).norm());
            let t = ((spot.at - a.to).dot(&along) / length).clamp(self.part, length);
            let off = (a.to + along * (t / length) - spot.at).norm();
            if off <= NEAR {
                self.part = t;
                if spot.rapid != b.rapid && t > 2.0 * NEAR && length - t > 2.0 * NEAR {
                    return Err(format!(
                        "line {} was driven {}",
                        b.line,
                        if spot.rapid { "rapidly" } else { "at feed" }
                    ));
                }
                return Ok(());
            }
            if length - self.part > ALONG {
                return Err(format!(
                    "{:?} at {:.4} s is {off:.4} mm off line {}",
                    spot.at, spot.t, b.line
                ));
            }
            (self.next, self.part) = (self.next + 1, 0.0);
        }
    }

    fn way(&self, ends: &[f64]) -> f64 {
        ends[(self.next - 1).min(ends.len() - 1)] + self.part
    }
}

/// Way up to each corner, mm.
pub fn lengths(corners: &[Corner]) -> Vec<f64> {
    let mut sum = 0.0;
    let pieces = corners.windows(2).map(|w| (w[1].to - w[0].to).norm());
    std::iter::once(0.0)
        .chain(pieces.map(|l| {
            sum += l;
            sum
        }))
        .collect()
}

/// How far along the way the axes came, all in order, mm.
pub fn follow(corners: &[Corner], spots: &[Spot]) -> Result<f64, String> {
    let mut f = Follower {
        corners,
        next: 1,
        part: 0.0,
    };
    for spot in spots {
        f.go(spot)?;
    }
    Ok(f.way(&lengths(corners)))
}

/// Way up to the end of a line, mm.
pub fn way_of(corners: &[Corner], ends: &[f64], line: usize) -> f64 {
    let last = corners.iter().rposition(|c| c.line <= line);
    last.map_or(0.0, |i| ends[i])
}
