//! What a verdict says nothing about, in words.

use super::shape::Seen;
use crate::gcode::State;

/// All that decides on it.
pub struct Missing<'a> {
    /// There is a part.
    pub part: bool,
    /// There are moves named in machine coordinates.
    pub machine_moves: bool,
    /// X, Y, Z is taken to start at zero.
    pub assumed: [bool; 3],
    /// What is in the program.
    pub seen: Seen,
    /// What the machine remembers behind it.
    pub end: &'a State,
}

impl Missing<'_> {
    /// A sentence for each thing.
    pub fn say(&self, out: &mut Vec<String>) {
        let mut say = |text: &str| out.push(text.to_string());
        if self.part {
            say(
                "the way from where the tool stands at the start to the first commanded place (and after moves in machine coordinates or probing)",
            );
            say(
                "stock beside the part, clamps, the holder, deflection and runout; the shank counts as thick as the ball",
            );
        } else {
            say(
                "no part given: gouges, cusps, uncut ground and rapids into stock were not judged (add --part, --tool and --scallop)",
            );
        }
        say(
            "where work zero lies on the table: travels are compared with the program's length only",
        );
        say("feed and spindle overrides, and a controller kept waiting for lines");
        if self.machine_moves {
            say(
                "moves in machine coordinates (G53, G28, G30): only their ends are compared with the travels",
            );
        }
        for (axis, assumed) in ["X", "Y", "Z"].iter().zip(self.assumed) {
            if assumed {
                say(&format!(
                    "{axis} is not told before the first cut: it is taken to start at 0"
                ));
            }
        }
        if self.end.work_offset != 0 || self.end.offset().norm() != 0.0 {
            say(
                "changes of the work offset (G55 to G59, G10, G92, G43.1): all places are taken as if in one system",
            );
        }
        if self.seen.tool_change {
            say("tool changes: the same ball is assumed throughout, and M6 takes no time");
        }
        if self.seen.pause {
            say("operator stops (M0, M1): they take no time here");
        }
        if self.seen.probe {
            say("probing: where contact is made is not in the text");
        }
    }
}
