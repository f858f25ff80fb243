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

/// Differences of a function that mean nothing, in its unit: of average distance one percent of its mean, which is what it is good to;
/// of curvature a twentieth of its range or eight times its roughness, whichever is more; of heights eight times their roughness.
pub fn noise(
    function: MorseFunction,
    values: impl Iterator<Item = f64> + Clone,
    roughness: f64,
) -> f64 {
    let (lo, hi) = values
        .clone()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(v), hi.max(v))
        });
    let range = (hi - lo).max(0.0);
    let own = match function {
        MorseFunction::Height | MorseFunction::Projection => 8.0 * roughness,
        MorseFunction::MeanCurvature => (0.05 * range).max(8.0 * roughness),
        MorseFunction::Geodesic => {
            0.01 * values.clone().sum::<f64>() / values.count().max(1) as f64
        }
    };
    // Ties are noise in any unit.
    own.max(1e-9)
}
