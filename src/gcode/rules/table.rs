//! What a dialect understands, for people: made of the very constants that the reader goes by.
//!
//! Crosses the border: a [`Dialect`] in; lines of text out, not yet laid out.

use super::{BlockDelete, Entry, LineLength, Meaning, Parentheses, Semicolon, ToolWord};
use crate::gcode::codes::{Coolant, Letters, NonModal, Path, Stop, ToolLength};
use crate::gcode::cycle::{Cycle, Pecking};
use crate::gcode::dialect::Dialect;
use crate::gcode::event::Plane;
use crate::gcode::state::{Distance, FeedMode, MotionMode, Retract, Units};

/// A code and what it does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// As it is written: `G54.1 P1..300`.
    pub code: String,
    /// What it does, or why it is refused.
    pub text: String,
    /// False: refused by name.
    pub understood: bool,
}

/// A dialect, as it is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The controller.
    pub title: &'static str,
    /// Where the rules come from.
    pub source: &'static str,
    /// What is assumed where the controller goes by a setting.
    pub assumed: &'static [&'static str],
    /// G codes, then M codes, by number.
    pub codes: Vec<Row>,
    /// Value words.
    pub letters: String,
    /// Letters refused by name.
    pub refused_letters: Vec<Row>,
    /// What a line may hold besides.
    pub lines: Vec<String>,
}

/// What this dialect understands. Codes not in it are refused as unknown.
pub fn table(dialect: Dialect) -> Table {
    let rules = dialect.rules();
    let mut codes = rows('G', rules.g);
    codes.extend(rows('M', rules.m));
    let refused = |&(letter, why): &(u8, &str)| Row {
        code: char::from(letter).to_string(),
        text: why.into(),
        understood: false,
    };
    let mut table = Table {
        title: rules.title,
        source: rules.source,
        assumed: rules.assumed,
        codes,
        letters: spaced(rules.letters),
        refused_letters: rules.refused.iter().map(refused).collect(),
        lines: Vec::new(),
    };
    if rules.letters.any() {
        table.lines = lines(dialect);
    }
    table
}

fn lines(dialect: Dialect) -> Vec<String> {
    let rules = dialect.rules();
    let mut out = vec![match rules.length {
        LineLength::Any => "lines of any length".into(),
        LineLength::Significant(n) => {
            format!("lines of {n} characters, blanks and comments not counted")
        }
        LineLength::All(n) => format!("lines of {n} characters"),
        LineLength::BeforeComment(n) => format!("lines of {n} characters in front of a ;"),
    }];
    out.push(
        match (rules.parentheses, rules.semicolon) {
            (Parentheses::No, _) => "comments: ; to the end of the line; ( ) is refused",
            (Parentheses::Last, _) => "comments: ; and ( ), with nothing behind them",
            (_, Semicolon::EndOfBlock) => "comments: ( ); a ; ends the block",
            _ => "comments: ( ) and ;",
        }
        .into(),
    );
    match rules.block_delete {
        BlockDelete::No => {}
        BlockDelete::Ignored => out.push("/ is dropped wherever it stands".into()),
        BlockDelete::Switch => out.push("block delete: / in front of a line".into()),
        BlockDelete::Levels => out.push("block delete: / and /1 to /9 in front of a line".into()),
    }
    if rules.checksum {
        out.push("checksums: *nn behind the words, proven".into());
    }
    out.push(format!("G4 takes {}", rules.dwell_words));
    if rules.pointed.any() {
        let pointed = spaced(rules.pointed);
        out.push(format!(
            "a decimal point is needed in {pointed} (not in zero), and in F when in inches"
        ));
    }
    out.push(match rules.tool_word {
        ToolWord::Select => format!("tools up to T{}; M6 changes", rules.tool_limit),
        ToolWord::AtOnce => format!("tools up to T{}; T changes at once", rules.tool_limit),
    });
    if let Some(cycles) = rules.cycles {
        let back = cycles.back;
        out.push(format!("G73 and G83 back off by {back} mm"));
        if let Pecking::GrblHal { wait } = cycles.pecking {
            out.push(format!("pecks wait {wait} s at their bottom"));
        }
        for letter in cycles.repeats {
            out.push(format!("cycles repeat by {}", char::from(*letter)));
        }
    }
    out
}

fn spaced(letters: Letters) -> String {
    let all: Vec<String> = letters.iter().map(|l| char::from(l).to_string()).collect();
    all.join(" ")
}

fn rows(letter: char, tables: &[&[Entry]]) -> Vec<Row> {
    let mut seen: Vec<Entry> = Vec::new();
    for entry in tables.iter().flat_map(|t| t.iter()) {
        if !seen.iter().any(|(code, _)| *code == entry.0) {
            seen.push(*entry);
        }
    }
    seen.sort_by_key(|(code, _)| *code);
    seen.iter()
        .map(|&(code, meaning)| Row {
            code: format!("{letter}{}{}", f64::from(code) / 100.0, words(meaning)),
            text: says(meaning),
            understood: !matches!(meaning, Meaning::Refused(_)),
        })
        .collect()
}

fn words(meaning: Meaning) -> String {
    match meaning {
        Meaning::WorkOffsetBy { letter, most, .. } => format!(" {}1..{most}", char::from(letter)),
        _ => String::new(),
    }
}

fn says(meaning: Meaning) -> String {
    match meaning {
        Meaning::Motion(motion) => motion_says(motion),
        Meaning::CycleOff => "no drilling cycle",
        Meaning::NonModal(n) => match n {
            NonModal::Dwell => "dwell",
            NonModal::SetOffset => "work offset from the program (L2, and L20 where it is there)",
            NonModal::GoHome => "rapid to the reference point, by way of the named point",
            NonModal::GoSecondHome => {
                "rapid to the second reference point, by way of the named point"
            }
            NonModal::StoreHome => "store the place that G28 goes to",
            NonModal::StoreSecondHome => "store the place that G30 goes to",
            NonModal::MachineCoordinates => "machine coordinates in this line",
            NonModal::Shift => "call the place where the tool is so",
            NonModal::ClearShift => "clear G92",
            NonModal::SuspendShift => "suspend G92",
            NonModal::RestoreShift => "restore G92",
            NonModal::Local => "local coordinate system",
        },
        Meaning::Plane(Plane::Xy) => "plane XY",
        Meaning::Plane(Plane::Zx) => "plane ZX",
        Meaning::Plane(Plane::Yz) => "plane YZ",
        Meaning::Distance(Distance::Absolute) => "absolute",
        Meaning::Distance(Distance::Incremental) => "incremental",
        Meaning::ArcDistance(Distance::Absolute) => "arc centres absolute",
        Meaning::ArcDistance(Distance::Incremental) => "arc centres from the start",
        Meaning::FeedMode(FeedMode::PerMinute) => "feed per minute",
        Meaning::FeedMode(FeedMode::InverseTime) => "inverse time feed",
        Meaning::FeedMode(FeedMode::PerTurn) => "feed per turn",
        Meaning::Units(Units::Mm) => "millimetres",
        Meaning::Units(Units::Inch) => "inches",
        Meaning::Retract(Retract::Initial) => "cycles return to the initial level",
        Meaning::Retract(Retract::R) => "cycles return to R",
        Meaning::ToolLength(ToolLength::Table) => "tool length from the table, H",
        Meaning::ToolLength(ToolLength::Dynamic) => "tool length from the program, Z",
        Meaning::ToolLength(ToolLength::Cancel) => "tool length off",
        Meaning::WorkOffset(n) => return format!("work offset {}", n + 1),
        Meaning::WorkOffsetBy { base, .. } => return format!("work offset {} on", base + 1),
        Meaning::Path(Path::Exact) => "exact path",
        Meaning::Path(Path::Stop) => "exact stop",
        Meaning::Path(Path::Blend) => "blended path (P: tolerance)",
        Meaning::Stop(Stop::Pause) => "pause",
        Meaning::Stop(Stop::OptionalPause) => "optional pause",
        Meaning::Stop(Stop::End) => "end of program",
        Meaning::Spindle(1) => "spindle clockwise",
        Meaning::Spindle(-1) => "spindle counter-clockwise",
        Meaning::Spindle(_) => "spindle off",
        Meaning::Coolant(Coolant::Mist) => "mist",
        Meaning::Coolant(Coolant::Flood) => "flood",
        Meaning::Coolant(Coolant::Off) => "coolant off",
        Meaning::ToolChange => "tool change",
        Meaning::Wait => "wait for standstill",
        Meaning::Nothing(_, _, text) => return format!("{text} (accepted, moves nothing)"),
        Meaning::Refused(why) => why,
    }
    .into()
}

fn motion_says(motion: MotionMode) -> &'static str {
    match motion {
        MotionMode::Rapid => "rapid",
        MotionMode::Linear => "straight feed",
        MotionMode::ArcClockwise => "arc clockwise",
        MotionMode::ArcCounterclockwise => "arc counter-clockwise",
        MotionMode::Probe(_) => "probe",
        MotionMode::None => "no motion mode",
        MotionMode::Cycle(cycle) => match cycle {
            Cycle::ChipBreak => "drilling in pecks, backing off",
            Cycle::Drill => "drilling",
            Cycle::DrillDwell => "drilling with a dwell",
            Cycle::Peck => "drilling in pecks, out each time",
            Cycle::Bore => "boring, feed out",
            Cycle::BoreStop => "boring, spindle stop, rapid out",
            Cycle::BoreDwell => "boring with a dwell, feed out",
        },
    }
}
