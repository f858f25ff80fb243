//! A plan in words, to be shown before anything is sent.

use super::check::Evidence;
use super::plan::Plan;
use crate::gcode::{Distance, FeedMode, Plane, Units};
use std::fmt;

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(z) = &self.zones {
            writeln!(f, "zones, lines of {}:", z.lines)?;
            match z.first {
                1 => writeln!(f, "  surely cut       none")?,
                n => writeln!(f, "  surely cut       1 to {}", n - 1)?,
            }
            writeln!(f, "  maybe cut        {} to {}", z.first, z.last)?;
            match z.last < z.lines {
                true => writeln!(f, "  not sent         {} to {}", z.last + 1, z.lines)?,
                false => writeln!(f, "  not sent         none")?,
            }
        }
        if let Some(evidence) = self.evidence {
            let why = match evidence {
                Evidence::OnPath => {
                    "the machine stands on the path of these lines, and nothing happened that loses steps"
                }
                Evidence::Homed => "the machine is homed",
                Evidence::Operator => "on your word (--trust-position)",
            };
            writeln!(f, "position trusted:  {why}")?;
        }
        let [x, y, z] = self.place;
        writeln!(
            f,
            "entry:             line {} `{}`, {:.3} mm of cut path again",
            self.entry.line, self.entry.text, self.entry.overlap_mm
        )?;
        writeln!(f, "way in (machine coordinates):")?;
        writeln!(f, "  lift to          Z{:.3}", self.way.safe_z)?;
        writeln!(f, "  go over          X{x:.3} Y{y:.3}")?;
        let s = &self.entry.state;
        match s.spindle {
            0 => writeln!(f, "  spindle          off")?,
            d if self.way.laser => writeln!(
                f,
                "  laser            {} S{}, last of all",
                if d > 0 { "M3" } else { "M4" },
                s.speed.0
            )?,
            d => writeln!(
                f,
                "  spindle          {} {} rpm, {} s to come to speed",
                if d > 0 { "M3" } else { "M4" },
                s.speed.0,
                self.way.spin_up_s
            )?,
        }
        writeln!(
            f,
            "  coolant          {}",
            match (s.flood, s.mist) {
                (true, true) => "flood and mist",
                (true, false) => "flood",
                (false, true) => "mist",
                (false, false) => "off",
            }
        )?;
        match self.way.laser {
            true => writeln!(f, "  down to          Z{z:.3}")?,
            false => writeln!(
                f,
                "  plunge to        Z{z:.3} at {:.0} mm/min",
                self.way.plunge
            )?,
        }
        write!(f, "modes:            ")?;
        let plane = match s.plane {
            Plane::Xy => "G17",
            Plane::Zx => "G18",
            Plane::Yz => "G19",
        };
        let units = match s.units {
            Units::Mm => "G21",
            Units::Inch => "G20",
        };
        let distance = match s.distance {
            Distance::Absolute => "G90",
            Distance::Incremental => "G91",
        };
        write!(f, " G{} {plane} {units} {distance}", 54 + s.work_offset)?;
        match s.feed_mode {
            FeedMode::InverseTime => write!(f, " G93")?,
            _ => write!(f, " G94 F{:.1} mm/min", s.feed.0)?,
        }
        if s.g92.norm() != 0.0 {
            let g = s.g92;
            write!(
                f,
                ", G92 offset X{:.3} Y{:.3} Z{:.3} set again",
                g.x, g.y, g.z
            )?;
        }
        if s.tlo != 0.0 {
            write!(f, ", tool length {:.3} set again", s.tlo)?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "proof:             {} lines from the entry to the end do the same as in the straight run ({:.1} mm of cut, within {:.5} mm)",
            self.proof.lines, self.proof.cut_mm, self.proof.deviation_mm
        )?;
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        Ok(())
    }
}
