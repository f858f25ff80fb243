//! What can be wrong with an APT file, and where.

/// A mistake in an APT file: line and column (characters, both from 1) and what is wrong there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column} {problem}")]
pub struct ClError {
    /// Line of the file, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong and what to do.
    pub problem: ClProblem,
}

/// What is wrong. Lengths are mm, feeds mm/min, angles degrees, whatever the units of the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClProblem {
    /// The source stopped answering.
    #[error("the file cannot be read on: {0}")]
    Unreadable(String),
    /// More text than any statement has.
    #[error("this statement is longer than 1 MiB: is this an APT file?")]
    TooLong,
    /// `$` on the last line.
    #[error(
        "the file ends inside a statement that $ carries on: it is not whole, write it out again"
    )]
    Unfinished,
    /// A deck of cards whose sequence numbers break off.
    #[error(
        "columns 73 to 80 hold rising sequence numbers up to here, and not on this line: is the deck whole and in order?"
    )]
    Card,
    /// A character that no statement has at this place.
    #[error("found {found:?} where {wanted} should stand")]
    Unexpected {
        /// What stands there.
        found: char,
        /// What should.
        wanted: &'static str,
    },
    /// The statement breaks off.
    #[error("the statement ends where {wanted} should stand")]
    Ends {
        /// What is missing.
        wanted: &'static str,
    },
    /// Not a number, or one that is no finite length.
    #[error("this number cannot be read: write digits with one dot, as 12.5 or 1.25E+01")]
    BadNumber,
    /// Brackets within brackets, deeper than any system writes.
    #[error("brackets stand more than 8 deep here: this is no cutter-location data")]
    TooDeep,
    /// A word that is neither read, nor harmless, nor refused by name.
    #[error("{word} is not known{}: remove the line if it moves and switches nothing, or write it in words of ISO 4343", did_you_mean(.nearest))]
    UnknownWord {
        /// The word, upper case.
        word: String,
        /// The closest known word, when one is close.
        nearest: Option<String>,
    },
    /// A word that means something this program cannot post.
    #[error("{word} is refused: {why}")]
    Refused {
        /// The word, upper case.
        word: String,
        /// Why, and what to do.
        why: &'static str,
    },
    /// A word behind the slash that this statement does not take.
    #[error("{word} does not take {minor}{}: it takes {takes}", did_you_mean(.nearest))]
    Minor {
        /// The statement.
        word: &'static str,
        /// What stands there.
        minor: String,
        /// The closest known word, when one is close.
        nearest: Option<String>,
        /// What it takes.
        takes: &'static str,
    },
    /// Too few or too many numbers.
    #[error("{word} has {found} numbers here and takes {takes}")]
    Count {
        /// The statement.
        word: &'static str,
        /// How many stand there.
        found: usize,
        /// What it takes.
        takes: &'static str,
    },
    /// A number that cannot be right.
    #[error("{word}: {value} {rule}")]
    Value {
        /// The statement.
        word: &'static str,
        /// The number as read.
        value: f64,
        /// What it must be, and what to do.
        rule: &'static str,
    },
    /// A coordinate beyond any machine.
    #[error(
        "{value} mm lies beyond 1000 m: no machine is so large, check the number and the UNITS"
    )]
    TooFar {
        /// The coordinate, mm.
        value: f64,
    },
    /// The tool leans.
    #[error(
        "the tool axis is {i}, {j}, {k}: this is 5-axis data, and only 0, 0, 1 (three axes) can be posted; output the operation with a fixed Z axis"
    )]
    FiveAxis {
        /// X of the axis.
        i: f64,
        /// Y of the axis.
        j: f64,
        /// Z of the axis.
        k: f64,
    },
    /// A motion from nowhere.
    #[error(
        "{word} stands before any place is known: put FROM/x,y,z (where the tool stands) or RAPID and a GOTO before it"
    )]
    NoPlace {
        /// The statement.
        word: &'static str,
    },
    /// A cut without feed.
    #[error("this move has no feed: put FEDRAT/ with a feed, or RAPID, before it")]
    FeedMissing,
    /// A feed per revolution of a spindle that does not turn.
    #[error(
        "the feed (line {line}) is per revolution and the spindle's speed is not known here: put SPINDL/ before this move, or give the feed per minute"
    )]
    PerRevolution {
        /// Line of the FEDRAT.
        line: usize,
    },
    /// A tool change stopped the spindle.
    #[error(
        "the spindle turned until the tool change on line {line} and nothing starts it again before this cut: put SPINDL/ behind it"
    )]
    SpindleStopped {
        /// Line of the LOADTL.
        line: usize,
    },
    /// TOOLNO alone is a change of tools to some and none to others.
    #[error(
        "TOOLNO/{number} on line {line} names another tool than the one in the spindle, and no LOADTL/{number} puts it in before this move: write LOADTL/{number}"
    )]
    ToolNotLoaded {
        /// The tool.
        number: u32,
        /// Line of the TOOLNO.
        line: usize,
    },
    /// The spindle is started with no speed.
    #[error("the spindle is to start and its speed was never told: write SPINDL/RPM,n,CLW")]
    SpeedUnknown,
    /// The points are those of the ball's centre.
    #[error(
        "the points are said to be the tool's centre: output the tool tip (its lowest point) in the CAM system"
    )]
    ToolCenter,
    /// An arc about an axis that is none of the machine's.
    #[error(
        "the arc's axis is {i}, {j}, {k}: arcs about X, Y or Z can be posted; output points instead"
    )]
    ArcAxis {
        /// X of the axis.
        i: f64,
        /// Y of the axis.
        j: f64,
        /// Z of the axis.
        k: f64,
    },
    /// A point that is not on its circle.
    #[error(
        "the arc's {end} is {distance:.4} mm from its centre and its radius is {radius:.4} mm: correct one of them"
    )]
    ArcRadius {
        /// "start" or "end".
        end: &'static str,
        /// Distance of the point from the centre, mm.
        distance: f64,
        /// The radius as told, mm.
        radius: f64,
    },
    /// The angle says something else than the points.
    #[error(
        "ANGLE is {told:.4} degrees, and from start to end the arc turns by {found:.4} degrees about its axis (right hand): turn the axis, or correct the angle"
    )]
    ArcAngle {
        /// As told, degrees.
        told: f64,
        /// As the points say, degrees.
        found: f64,
    },
    /// An arc after which no GOTO came.
    #[error("the arc on line {line} has no end: a GOTO must follow it")]
    ArcEnd {
        /// Line of the arc.
        line: usize,
    },
    /// An arc in rapid motion.
    #[error("RAPID stands before an arc: controllers have arcs at feed only, remove RAPID")]
    ArcRapid,
    /// An arc right behind a tool change.
    #[error(
        "the arc follows the tool change on line {line}: bring the tool to its start by a GOTO first"
    )]
    ArcAfterTool {
        /// Line of the LOADTL.
        line: usize,
    },
    /// The points of a CIRCLE may be an arc or a straight line.
    #[error(
        "this point lies on the circle of line {line} but {turn:.1} degrees on: it may end the arc or a straight line across it; write a CIRCLE for each arc, or its points closer together"
    )]
    ArcOrLine {
        /// Line of the CIRCLE.
        line: usize,
        /// Degrees from the point before.
        turn: f64,
    },
    /// Turns of a helix that do not end above its start.
    #[error(
        "TIMES,{times} with an end that is not over the start is read differently by different systems: write the turns as arcs of their own"
    )]
    ArcTimes {
        /// As told.
        times: f64,
    },
    /// Start and end nearly one.
    #[error(
        "start and end of this arc are {apart:.5} mm apart: it may be once round or nothing at all; give both the same digits, or leave it out"
    )]
    ArcNothing {
        /// Distance, mm.
        apart: f64,
    },
    /// The direction does not run along the circle.
    #[error("the direction given before does not run along this circle at its start: correct it")]
    ArcTangent,
    /// No direction stands before `TLON,GOFWD`.
    #[error("no INDIRV or INDIRP stands before this arc: its direction is not known")]
    ArcDirection,
    /// The line that should end the arc does not meet the circle.
    #[error("the line does not cross the circle: the arc has no end")]
    ArcLine,
    /// The line's end is not where the arc ends.
    #[error(
        "the arc ends at X{x:.4} Y{y:.4} by the crossing it names, and not at the line's second point: write 2,INTOF behind ON where the arc passes the line once"
    )]
    ArcCrossing {
        /// Where the arc ends, mm.
        x: f64,
        /// Where the arc ends, mm.
        y: f64,
    },
    /// Heights of start and end differ where the form cannot say so.
    #[error(
        "start and end of this arc are not at one height, which this form cannot say: use CIRCLE or MOVARC with GOTO"
    )]
    ArcHeight,
    /// Something stands behind the end.
    #[error("{word} stands behind {end} (line {line}): one file is one program, cut it there")]
    AfterEnd {
        /// What stands there.
        word: String,
        /// END or FINI.
        end: &'static str,
        /// Its line.
        line: usize,
    },
    /// The frame changes within the file.
    #[error(
        "the machining coordinate system changes here: post each system's operations as a file of their own"
    )]
    Frame,
}

/// A nearest word as a question.
fn did_you_mean(nearest: &Option<String>) -> String {
    (nearest.as_ref())
        .map(|n| format!(" (did you mean {n}?)"))
        .unwrap_or_default()
}

/// A problem at a byte of a statement's text, before its line and column are looked up.
pub(super) type Fault = (usize, ClProblem);
