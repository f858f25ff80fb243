//! The cutter. Knows nothing of parts, machines or paths.

use std::str::FromStr;

/// A ball-end mill. The *tool tip* is the lowest point of the ball; the *centre* of the ball is one radius above the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// Radius of the ball and of the shank above it, mm; finite and above zero.
    pub radius: f64,
}

/// Why a tool was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToolError {
    /// Not of the form `ball:DIAMETER`.
    #[error("tool \"{0}\" is not understood: write ball:DIAMETER in mm, e.g. ball:6")]
    Form(String),
    /// A diameter that no cutter has.
    #[error(
        "tool \"{0}\": the diameter must be a finite number of mm above 0.01 and below 1000, e.g. ball:6"
    )]
    Diameter(String),
}

impl FromStr for Tool {
    type Err = ToolError;

    /// Reads `ball:6` (a ball-end mill of 6 mm diameter).
    fn from_str(text: &str) -> Result<Self, ToolError> {
        let form = || ToolError::Form(text.to_string());
        let (kind, size) = text.split_once(':').ok_or_else(form)?;
        if !kind.trim().eq_ignore_ascii_case("ball") {
            return Err(form());
        }
        let d: f64 = size.trim().parse().map_err(|_| form())?;
        if !d.is_finite() || d <= 0.01 || d >= 1000.0 {
            return Err(ToolError::Diameter(text.to_string()));
        }
        Ok(Tool { radius: d / 2.0 })
    }
}

impl std::fmt::Display for Tool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ball:{}", self.radius * 2.0)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn reads_balls_and_refuses_the_rest() {
        assert_eq!("ball:6".parse::<Tool>().unwrap().radius, 3.0);
        for bad in ["ball", "flat:6", "ball:", "ball:x", "6"] {
            assert!(
                matches!(bad.parse::<Tool>(), Err(ToolError::Form(_))),
                "{bad}"
            );
        }
        for bad in ["ball:0", "ball:-6", "ball:NaN", "ball:inf", "ball:1e9"] {
            assert!(
                matches!(bad.parse::<Tool>(), Err(ToolError::Diameter(_))),
                "{bad}"
            );
        }
    }
}
