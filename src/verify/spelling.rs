//! How a post writes numbers: what a witness may expect to the last decimal.

use crate::post::{self, Post};

/// Sizes of the last decimals, and what the dialect leaves unsaid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spelling {
    /// Millimetres of one of the program's units of length, and the decimals of a coordinate in it.
    pub length: (f64, u8),
    /// ... of a feed, mm/min.
    pub feed: f64,
    /// ... of a spindle speed, rpm.
    pub speed: f64,
    /// ... of a time, s.
    pub time: f64,
    /// A helix is written by its pole and its angle, so that its end is off by a rounding of each.
    pub polar: bool,
    /// The program's end is written; where it is not, the text's end is that.
    pub ends: bool,
    /// A tool change is written at all.
    pub tools: bool,
}

impl Spelling {
    /// That of a post.
    pub fn of(post: &Post) -> Spelling {
        let unit = |decimals: u8| 0.1_f64.powi(i32::from(decimals));
        Spelling {
            length: (post.units.mm(), post.coordinate_decimals()),
            feed: unit(post.feed_decimals()) * post.units.mm(),
            speed: unit(post.decimals.speed),
            time: unit(post.decimals.seconds),
            polar: post.spelling == post::definition::Spelling::Heidenhain,
            ends: post.program.ends,
            tools: !post.tool.change.is_empty(),
        }
    }

    /// A unit of the last decimal of a coordinate, mm.
    pub fn unit(&self) -> f64 {
        self.length.0 * 0.1_f64.powi(i32::from(self.length.1))
    }

    /// A coordinate as a count of such units: the nearest, a true half away from zero.
    pub fn count(&self, mm: f64) -> i64 {
        let value = (mm / self.length.0).abs();
        let power = 10_f64.powi(i32::from(self.length.1));
        let product = value * power;
        let below = product.floor();
        // Where the product seems to be a half, its own rounding error says on which side of it the value lies.
        let up = match product - below {
            0.5 => value.mul_add(power, -product) >= 0.0,
            over => over > 0.5,
        };
        // `as` saturates, and a coordinate of that size has been refused by the writer.
        let count = below as i64 + i64::from(up);
        if mm < 0.0 { -count } else { count }
    }
}

/// Equal to within half a unit of the last decimal, and a hair for the arithmetic of reading.
pub fn close(a: f64, b: f64, unit: f64) -> bool {
    (a - b).abs() <= 0.5 * unit * (1.0 + 1e-9) + 1e-12 + 4.0 * f64::EPSILON * b.abs()
}
