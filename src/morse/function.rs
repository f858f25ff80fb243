//! The Morse functions by name.

/// A scalar whose critical points features grow from. Each is defined on the tool-centre grid and on raw meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MorseFunction {
    /// Height of the point the ball touches, or of the mesh's vertex. Depends on what is up.
    Height,
    /// Mean of the two principal curvatures, positive where the part bulges out. Stays the same when the part is turned.
    MeanCurvature,
    /// Mean of the geodesic distances to all points of the surface: small in the middle of the part, large at its tips. Stays the
    /// same when the part is turned.
    Geodesic,
    /// Signed distance to the plane that fits the surface best. Turns with the part.
    Projection,
}

impl MorseFunction {
    /// All of them.
    pub const ALL: [MorseFunction; 4] = [
        MorseFunction::Height,
        MorseFunction::MeanCurvature,
        MorseFunction::Geodesic,
        MorseFunction::Projection,
    ];

    /// The word used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            MorseFunction::Height => "height",
            MorseFunction::MeanCurvature => "mean-curvature",
            MorseFunction::Geodesic => "geodesic",
            MorseFunction::Projection => "projection",
        }
    }

    /// The unit of its values, and of their persistence.
    pub fn unit(self) -> &'static str {
        match self {
            MorseFunction::MeanCurvature => "1/mm",
            _ => "mm",
        }
    }
}
