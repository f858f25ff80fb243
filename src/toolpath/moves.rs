//! What we want the machine to do, before any dialect.

use crate::geom::Point;

/// Why the tool moves; decides rapid or feed, and which feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveKind {
    /// In the air, as fast as the machine goes.
    Rapid,
    /// Down into the material, at the plunge feed.
    Plunge,
    /// Along the finished surface, at the cutting feed.
    Cut,
    /// From one pass to the next along the surface, without a retract, at the cutting feed.
    Link,
    /// Up and away from the surface: in the air once the ball has left it, so at rapid speed.
    Retract,
}

/// A straight move of the tool tip to `to`, from wherever the last move ended. Work coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Why it moves.
    pub kind: MoveKind,
    /// Where the tool tip goes.
    pub to: Point,
}

/// A run of moves that belong together, e.g. one feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// A name for the program's comment: ASCII, no parentheses.
    pub name: String,
    /// Index of the first move of this section in [`Toolpath::moves`].
    pub first_move: usize,
}

/// A whole job's moves. The first move is a [`MoveKind::Rapid`] to the safe height above the first plunge: the post raises Z
/// first, then goes to X and Y.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolpath {
    /// All moves in order.
    pub moves: Vec<Move>,
    /// Where features begin, by rising `first_move`.
    pub sections: Vec<Section>,
    /// Height of the tool tip at which any XY rapid is clear of everything, work coordinates, mm.
    pub safe_z: f64,
}
