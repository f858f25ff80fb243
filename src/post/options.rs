//! What one program is to be, beyond its post.

use super::definition::Units;
use crate::units::Mm;

/// How one program is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Units in place of the post's own.
    pub units: Option<Units>,
    /// Program name, where the dialect has one; `None` for `MORSEMILL`.
    pub name: Option<String>,
    /// Program number, where the dialect has one; `None` for 1001, or the nearest the post allows.
    pub number: Option<u32>,
    /// How far the controller may leave the path when it blends segments; `None` for the post's own figure.
    pub path_tolerance: Option<Mm>,
    /// What may be said otherwise where the controller cannot take it as it is.
    pub rewrite: Rewrite,
}

/// What may be said otherwise where the controller cannot take it as it is. What may not is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rewrite {
    /// Arcs and helices that cannot be written become lines that leave them by no more than this.
    pub lines_within: Option<Mm>,
    /// Full circles and further turns of helices become two or more arcs each. Exact.
    pub halves: bool,
    /// Long comments become several.
    pub comments: bool,
}

impl Default for Rewrite {
    /// Only comments are split.
    fn default() -> Self {
        Rewrite {
            lines_within: None,
            halves: false,
            comments: true,
        }
    }
}
