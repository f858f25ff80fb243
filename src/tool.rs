//! The cutter. Knows nothing of parts, machines or paths.

use std::str::FromStr;

/// A ball-end mill. The *tool tip* is the lowest point of the ball; the *centre* of the ball is one radius above the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// Radius of the ball and of the shank above it, mm; finite and above zero.
    pub radius: f64,
    /// Length of the flutes from the tip, mm; `None` when not told.
    pub flute: Option<f64>,
}

/// Flutes are taken to be this many diameters long when nobody says: most ball-end mills have at least so much.
const USUAL_FLUTE: f64 = 3.0;

impl Tool {
    /// How deep the flutes cut, mm: as told, else three diameters.
    pub fn flute_length(&self) -> f64 {
        self.flute.unwrap_or(2.0 * USUAL_FLUTE * self.radius)
    }
}

/// Why a tool was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToolError {
    /// Not of the form `ball:DIAMETER`.
    #[error(
        "tool \"{0}\" is not understood: write ball:DIAMETER in mm, e.g. ball:6, and if you like the length of its flutes, e.g. ball:6,flute:20"
    )]
    Form(String),
    /// A diameter that no cutter has.
    #[error(
        "tool \"{0}\": the diameter must be a finite number of mm above 0.01 and below 1000, e.g. ball:6"
    )]
    Diameter(String),
    /// Flutes shorter than the ball is high, or longer than any.
    #[error(
        "tool \"{0}\": the flutes must be at least as long as the radius of the ball and shorter than 1000 mm, measured from the tip, e.g. ball:6,flute:20"
    )]
    Flute(String),
}

impl FromStr for Tool {
    type Err = ToolError;

    /// Reads `ball:6` (a ball-end mill of 6 mm diameter) or `ball:6,flute:20` (with flutes of 20 mm).
    fn from_str(text: &str) -> Result<Self, ToolError> {
        let form = || ToolError::Form(text.to_string());
        let (ball, flute) = match text.split_once(',') {
            Some((ball, flute)) => (ball, Some(flute)),
            None => (text, None),
        };
        let (kind, size) = ball.split_once(':').ok_or_else(form)?;
        if !kind.trim().eq_ignore_ascii_case("ball") {
            return Err(form());
        }
        let d: f64 = size.trim().parse().map_err(|_| form())?;
        if !d.is_finite() || d <= 0.01 || d >= 1000.0 {
            return Err(ToolError::Diameter(text.to_string()));
        }
        let flute = match flute {
            None => None,
            Some(f) => {
                let (name, length) = f.split_once(':').ok_or_else(form)?;
                if !name.trim().eq_ignore_ascii_case("flute") {
                    return Err(form());
                }
                let l: f64 = length.trim().parse().map_err(|_| form())?;
                if !l.is_finite() || l < d / 2.0 || l >= 1000.0 {
                    return Err(ToolError::Flute(text.to_string()));
                }
                Some(l)
            }
        };
        Ok(Tool {
            radius: d / 2.0,
            flute,
        })
    }
}

impl std::fmt::Display for Tool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ball:{}", self.radius * 2.0)?;
        match self.flute {
            Some(l) => write!(f, ",flute:{l}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn reads_balls_and_refuses_the_rest() {
        assert_eq!("ball:6".parse::<Tool>().unwrap().radius, 3.0);
        let long = "ball:6,flute:20".parse::<Tool>().unwrap();
        assert_eq!((long.radius, long.flute_length()), (3.0, 20.0));
        assert_eq!(long.to_string(), "ball:6,flute:20");
        assert_eq!("ball:6".parse::<Tool>().unwrap().flute_length(), 18.0);
        for bad in ["ball:6,flute:2.9", "ball:6,flute:NaN", "ball:6,flute:1e4"] {
            assert!(
                matches!(bad.parse::<Tool>(), Err(ToolError::Flute(_))),
                "{bad}"
            );
        }
        for bad in [
            "ball",
            "flat:6",
            "ball:",
            "ball:x",
            "6",
            "ball:6,",
            "ball:6,20",
            "ball:6,shank:20",
            "ball:6,flute:",
        ] {
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
