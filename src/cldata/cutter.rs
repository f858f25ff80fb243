//! The cutter as CL files tell it.

/// A cutter's shape, mm and degrees. The seven numbers of APT's `CUTTER/d,r,e,f,a,b,h` (ANSI X3.37); NX's `TLDATA/MILL` has the first two, a
/// length, and two angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cutter {
    /// Diameter, mm.
    pub diameter: f64,
    /// Corner radius, mm; half the diameter is a ball.
    pub corner_radius: f64,
    /// Distance of the corner's centre from the axis and from the tip, mm, where told (`CUTTER` only).
    pub corner_at: Option<[f64; 2]>,
    /// Angles of the bottom and of the side, degrees, where told.
    pub angles: Option<[f64; 2]>,
    /// Length, mm, where told.
    pub length: Option<f64>,
}

impl Cutter {
    /// A ball-end mill.
    pub fn ball(radius: f64) -> Cutter {
        Cutter {
            diameter: 2.0 * radius,
            corner_radius: radius,
            ..Cutter::default()
        }
    }
}
