//! The dry run's result, as people and machines read it. Names carry the units; serialised names are stable.

use crate::kinematics::{LinkDemand, MotionQuality, SharpTurn};
use crate::sweep::{CuspMap, FinishStats};
use rayon::prelude::*;
use serde::Serialize;

/// What a dry run found out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DryRun {
    /// The text in figures.
    pub program: ProgramFigures,
    /// How long it takes.
    pub time_s: TimeFigures,
    /// How well it moves.
    pub motion: MotionFigures,
    /// What it needs of the link; `None` for a machine that is not fed over one, or a text that cannot be read.
    pub link_demand: Option<LinkDemand>,
    /// Where the tool tip goes.
    pub extents: Extents,
    /// The surface left; `None` when no part was given.
    pub finish: Option<FinishStats>,
    /// Acceptable or not.
    pub verdict: Verdict,
    /// Why not; empty when it passed.
    pub problems: Vec<Problem>,
    /// What is worth knowing but no reason to refuse.
    pub warnings: Vec<Problem>,
    /// What this verdict says nothing about.
    pub not_modelled: Vec<String>,
    /// Cusp by cell, for pictures.
    #[serde(skip)]
    pub map: Option<CuspMap>,
}

impl DryRun {
    /// True when nothing speaks against running the program.
    pub fn passed(&self) -> bool {
        self.verdict == Verdict::Pass
    }
}

/// The verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No problem found in what was judged.
    Pass,
    /// At least one problem.
    Fail,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "fail",
        })
    }
}

/// What sort of problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The text cannot be read.
    Syntax,
    /// Beyond what the machine can do.
    Limit,
    /// Spindle not turning, or at a speed it has not.
    Spindle,
    /// Cut into the part.
    Gouge,
    /// A rapid move through standing stock.
    Collision,
    /// Cusps higher than asked for.
    Scallop,
    /// Ground not cut.
    Uncut,
    /// Feed faster than the machine goes.
    Feed,
    /// Lines come slower than the machine goes.
    Link,
    /// Nothing in the text moves, or nothing could be judged.
    Nothing,
}

impl Kind {
    /// Something was hit: the part, or stock that the move could not cut.
    pub fn is_crash(self) -> bool {
        matches!(self, Kind::Gouge | Kind::Collision)
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Kind::Syntax => "syntax",
            Kind::Limit => "limit",
            Kind::Spindle => "spindle",
            Kind::Gouge => "gouge",
            Kind::Collision => "collision",
            Kind::Scallop => "scallop",
            Kind::Uncut => "uncut",
            Kind::Feed => "feed",
            Kind::Link => "link",
            Kind::Nothing => "nothing",
        })
    }
}

/// One reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// What sort.
    pub kind: Kind,
    /// Line of the program, from 1; `None` when no single line is to blame.
    pub line: Option<usize>,
    /// A sentence for people: what, how much, what to do.
    pub text: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "{} (line {line}): {}", self.kind, self.text),
            None => write!(f, "{}: {}", self.kind, self.text),
        }
    }
}

/// The text in figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ProgramFigures {
    /// Lines of text.
    pub lines: usize,
    /// Bytes of text.
    pub bytes: usize,
    /// Way at feed, mm.
    pub cut_mm: f64,
    /// Way at rapid speed, mm. The way from the unknown start to the first place is not in it.
    pub rapid_mm: f64,
    /// How often the tool leaves the work by a rapid move upwards.
    pub retracts: usize,
}

/// Machine time, s, for a machine that is never kept waiting for a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimeFigures {
    /// All of it: the sum of the others.
    pub total: f64,
    /// Moves at feed.
    pub cutting: f64,
    /// Rapid moves.
    pub air: f64,
    /// Commanded pauses.
    pub dwell: f64,
    /// The firmware's settling after standstills.
    pub idle: f64,
}

/// How well the machine is moved; what each figure is made of stands in [`crate::kinematics::quality`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MotionFigures {
    /// Root of the mean square of the tool's vertical acceleration while cutting (feed moves, plunges not): second differences of
    /// its height every 10 ms along the planner's speeds, within stretches without a rapid, a plunge or a standstill.
    pub vertical_acceleration_rms_mm_s2: f64,
    /// The same of its vertical speed: first differences.
    pub vertical_speed_rms_mm_s: f64,
    /// Largest turn between two consecutive cutting moves (0: straight on, 180: back), moves below 5 um taken with the next one; with a
    /// part, but for corners of the part.
    pub largest_turn_deg: f64,
    /// Line that begins with it, from 1; `None` without turns.
    pub largest_turn_line: Option<usize>,
    /// Turns of more than 30 degrees; with a part, but for corners of the part.
    pub turns_over_30: usize,
    /// Turns of more than 30 degrees where the part itself turns: a crease under the ball, across which the way goes straight.
    pub part_corners: usize,
    /// The largest turn at one of them.
    pub largest_part_corner_deg: f64,
    /// Time in the air and in plunges: feed moves straight up or down that begin or end in the air. The text does not tell links
    /// along the surface from passes.
    pub non_cutting_s: f64,
    /// The same as a share of the whole time.
    pub non_cutting_percent: f64,
}

impl From<&MotionQuality> for MotionFigures {
    fn from(q: &MotionQuality) -> MotionFigures {
        MotionFigures {
            vertical_acceleration_rms_mm_s2: q.vertical_acceleration_rms,
            vertical_speed_rms_mm_s: q.vertical_speed_rms,
            largest_turn_deg: q.largest_turn,
            largest_turn_line: q.largest_turn_at,
            turns_over_30: q.turns_over_30,
            part_corners: 0,
            largest_part_corner_deg: 0.0,
            non_cutting_s: q.non_cutting(),
            non_cutting_percent: q.non_cutting_percent(),
        }
    }
}

impl MotionFigures {
    /// With the corners of the part told apart: `own` finds what is left of a turn without the part's crease, rad. `sharp` are the turns
    /// over 30 degrees that were kept.
    pub fn judged(
        self,
        q: &MotionQuality,
        sharp: &[SharpTurn],
        own: impl Fn(&SharpTurn) -> f64 + Sync,
    ) -> MotionFigures {
        let mut out = self;
        let limit = 30f64.to_radians();
        let corner: Vec<bool> = sharp.par_iter().map(|t| own(t) <= limit).collect();
        let turn = |t: &SharpTurn| {
            t.before
                .cross(&t.after)
                .norm()
                .atan2(t.before.dot(&t.after))
                .to_degrees()
        };
        let corners = sharp.iter().zip(&corner).filter(|c| *c.1);
        out.part_corners = corners.clone().count();
        out.largest_part_corner_deg = corners.map(|c| turn(c.0)).fold(0.0, f64::max);
        out.turns_over_30 = q.turns_over_30.saturating_sub(out.part_corners);
        if sharp.len() == q.turns_over_30 {
            // None was left out: the largest is one of these, or none of them.
            let gentle = (q.largest_gentle_turn, q.largest_gentle_turn_at);
            (out.largest_turn_deg, out.largest_turn_line) = sharp
                .iter()
                .zip(&corner)
                .filter(|c| !*c.1)
                .map(|c| (turn(c.0), Some(c.0.line)))
                .fold(gentle, |a, b| if b.0 > a.0 { b } else { a });
        }
        out
    }
}

/// Box around all places of the tool tip in work coordinates, mm; the unknown start is left out. `None`: nothing moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Extents {
    /// Lowest x, y, z.
    pub min: Option<[f64; 3]>,
    /// Highest x, y, z.
    pub max: Option<[f64; 3]>,
}
