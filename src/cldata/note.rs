//! What was tolerated while reading, and where.

/// A difference of dialect that changes nothing, or that was read in one of its meanings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Note {
    /// The line it was first seen on, from 1.
    pub line: usize,
    /// How often it was seen.
    pub times: u64,
    /// What it is.
    pub kind: NoteKind,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}: {}", self.line, self.kind)?;
        match self.times {
            0 | 1 => Ok(()),
            n => write!(f, " ({n} times in all)"),
        }
    }
}

/// What was tolerated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoteKind {
    /// A statement that moves and switches nothing here.
    #[error("{0} changes nothing here and was passed over")]
    Harmless(&'static str),
    /// Words or numbers behind those that are used.
    #[error("{0}: only what it begins with is used, the rest was passed over")]
    Rest(&'static str),
    /// Text behind the `$` that carries a statement on.
    #[error("what stands behind $ was taken for a remark, as APT has it")]
    BehindDollar,
    /// No UNITS before the first length.
    #[error("no UNITS before this line: lengths are taken as {0}")]
    UnitsUnsaid(&'static str),
    /// `MULTAX/ON`.
    #[error("MULTAX is on: the tool axis is checked to be 0, 0, 1 at every point")]
    MultiAxis,
    /// A feed per revolution.
    #[error("a feed per revolution was made one per minute with the spindle's speed")]
    PerRevolution,
    /// FEDRAT between RAPID and the motion.
    #[error("FEDRAT behind RAPID takes the RAPID back: the move goes at feed")]
    RapidTakenBack,
    /// RAPID with a feed.
    #[error("RAPID with a feed: the next move goes at that feed")]
    RapidAtFeed,
    /// `COOLNT/ON`.
    #[error("COOLNT/ON was taken as flood")]
    CoolantOn,
    /// A dwell in revolutions.
    #[error("a dwell in revolutions was made one in seconds with the spindle's speed")]
    DwellTurns,
    /// The first cut after a tool change is no rapid.
    #[error(
        "the first move after a tool change goes at feed, from wherever the change leaves the tool"
    )]
    FeedAfterTool,
    /// A cut straight from FROM's place.
    #[error(
        "the first move is a cut from the place that FROM names: the program makes sure of it by a rapid to there"
    )]
    FromFirst,
    /// RETRCT at or over the clearance height.
    #[error("RETRCT moves nothing here: the tool is at the clearance height or over it")]
    RetractNothing,
    /// CIRCLE of seven numbers.
    #[error(
        "CIRCLE of 7 numbers is read as Creo writes it: right hand about its axis, the points behind it lie on the arc"
    )]
    CircleOfSeven,
    /// CIRCLE of eleven numbers.
    #[error(
        "CIRCLE of 11 numbers is read as NX writes it: clockwise about its axis, one GOTO ends the arc"
    )]
    CircleOfEleven,
    /// An arc too small to turn.
    #[error("an arc that turns by nothing was made a straight line")]
    ArcVanished,
    /// `GOHOME` with a place.
    #[error("GOHOME with a place was taken as a GOTO")]
    GoHome,
    /// No END.
    #[error("the file has no END: the program ends with it")]
    EndMissing,
    /// No FINI.
    #[error("the file ends without FINI: see that it is whole")]
    FiniMissing,
}

/// Notes so far. Of one kind the first is kept and the rest counted, so that there are never many.
#[derive(Clone, Debug, Default)]
pub(super) struct Notes {
    list: Vec<Note>,
}

impl Notes {
    pub fn add(&mut self, line: usize, kind: NoteKind) {
        match self.list.iter_mut().find(|n| n.kind == kind) {
            Some(n) => n.times += 1,
            None => self.list.push(Note {
                line,
                times: 1,
                kind,
            }),
        }
    }

    /// By rising line of the first of each kind.
    pub fn list(&self) -> &[Note] {
        &self.list
    }
}
