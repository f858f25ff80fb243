//! What can be wrong with a line, and where.
//!
//! A [`Complaint`] is precise enough that the far end of the cable can answer with GRBL's own number; the numbers themselves
//! live in `wire`. Each variant's text says what is wrong and what to do next.

use super::expression::ExpressionComplaint;
use super::heidenhain::complaint::HeidenhainComplaint;
use super::program::FlowComplaint;
use super::rules::RuleComplaint;
use super::siemens::complaint::SiemensComplaint;
use super::word::MAX_COLUMN;

/// A mistake in a program: line and column (characters, both from 1) and what is wrong there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column} {}", shortened(complaint))]
pub struct InterpretError {
    /// Line of the program, from 1.
    pub line: usize,
    /// Column of the word that is to blame, in characters from 1.
    pub column: usize,
    /// What is wrong.
    pub complaint: Complaint,
}

/// Characters of a complaint that are shown: far more than any of ours has, unless it repeats a name as long as a book.
const LONGEST_SHOWN: usize = 1000;

/// A complaint's text without the middle that nobody would read: what is wrong and what to do stand at its ends.
fn shortened(complaint: &Complaint) -> String {
    let text = complaint.to_string();
    let end = |n: usize| text.char_indices().nth(n).map(|(at, _)| at);
    let half = LONGEST_SHOWN / 2;
    let tail = text.char_indices().nth_back(half - 1).map(|(at, _)| at);
    match (end(LONGEST_SHOWN), end(half), tail) {
        (Some(_), Some(head), Some(tail)) => {
            let (head, tail) = (text.get(..head), text.get(tail..));
            format!(
                "{} ... {}",
                head.unwrap_or_default(),
                tail.unwrap_or_default()
            )
        }
        _ => text,
    }
}

/// A word's code as written: `G` 38.2, `M` 6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code {
    /// `G`, `M` or a word's letter, upper case.
    pub letter: char,
    /// The number behind it.
    pub number: f64,
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.letter, self.number)
    }
}

/// What to do about a character that opens no word.
fn stray(found: char) -> &'static str {
    match found {
        '/' => "a slash that skips the line stands at its very front; move or remove it",
        '$' => "lines of $ are for the console and not for programs; remove the line",
        '?' | '!' | '~' => "it is for the console and not for programs; remove it",
        '{' => "braces (JSON, expressions) are not read; keep the plain G-code alone",
        '#' => "variables are not read in this dialect; write the numbers",
        '[' => "expressions are not read in this dialect; write the numbers",
        _ => "remove it",
    }
}

/// What is wrong with a block. The doc of each variant names the situation in GRBL's words.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Complaint {
    /// GRBL: expected command letter. Something stands where a word's letter should.
    #[error("found {found:?} where a word (a letter and a number) should begin: {}", stray(*found))]
    ExpectedLetter {
        /// What stands there.
        found: char,
    },
    /// GRBL: bad number format. The letter has no readable number behind it.
    #[error(
        "{letter} has no number: write sign, digits and at most one dot after it (no exponents, variables or expressions)"
    )]
    BadNumber {
        /// The letter.
        letter: char,
    },
    /// GRBL: negative value, for F, N, P, S and T (LinuxCNC: also H and Q).
    #[error("{letter} must not be negative: write a value of zero or more")]
    Negative {
        /// The letter.
        letter: char,
    },
    /// GRBL: line too long (after blanks and comments are taken out).
    #[error("the line has {length} characters, this controller reads at most {limit}: split it")]
    LineTooLong {
        /// Characters that count.
        length: usize,
        /// The most that the controller takes.
        limit: usize,
    },
    /// GRBL: unsupported command, a G or M code that this dialect does not know.
    #[error(
        "{code} is not a command of this controller: remove it, or post the program for this dialect"
    )]
    UnsupportedCode {
        /// The code.
        code: Code,
    },
    /// GRBL: unsupported command, a letter that this dialect does not know (axes beyond X Y Z among them).
    #[error("{letter} is not a word of this controller (three axes, X Y Z): remove it")]
    UnsupportedWord {
        /// The letter.
        letter: char,
    },
    /// GRBL: unsupported command, a G10 with an L that is not 2 or 20.
    #[error("G10 is understood with L2 and L20 only: write one of them")]
    OffsetKind,
    /// GRBL: unsupported command, R in a G10 L2.
    #[error("G10 L2 with R would turn the coordinate system, which is not supported: remove R")]
    OffsetRotation,
    /// GRBL: modal group violation. Two codes of one group in one block.
    #[error(
        "{code} and an earlier word of this line belong to the same group ({group}): keep one of them"
    )]
    SameGroup {
        /// The second code.
        code: Code,
        /// What the group sets.
        group: &'static str,
    },
    /// GRBL: undefined feed rate. A cutting motion with no feed yet, or G93 without F in the block.
    #[error(
        "this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)"
    )]
    FeedMissing,
    /// GRBL: command value not an integer, as in G1.5 or M3.1.
    #[error(
        "{code} is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect"
    )]
    Fraction {
        /// The code.
        code: Code,
    },
    /// GRBL: two commands that use the axis words in one block.
    #[error(
        "{code} and an earlier word of this line both use the axis words: put them on two lines"
    )]
    TwoAxisCommands {
        /// The second one.
        code: Code,
    },
    /// GRBL: repeated word.
    #[error("{letter} stands twice in this line: keep one")]
    Repeated {
        /// The letter.
        letter: char,
    },
    /// GRBL: no axis words, though the command needs some.
    #[error("{command} needs at least one of X Y Z: add it")]
    AxisWordsMissing {
        /// The command.
        command: &'static str,
    },
    /// GRBL: line number out of range.
    #[error("the line number is above 10000000: use a smaller N, or none")]
    LineNumber,
    /// GRBL: missing value word (P of a dwell; P or L of G10).
    #[error("{command} needs a {word} word: add it")]
    ValueMissing {
        /// The command.
        command: &'static str,
        /// The word it needs.
        word: &'static str,
    },
    /// GRBL: work coordinate system not supported (P above 6 in G10).
    #[error(
        "G10 P{number} names no work offset: use P1 (G54) to P6 (G59), or P0 for the active one"
    )]
    WorkOffset {
        /// The P word.
        number: f64,
    },
    /// GRBL: G53 only with G0 or G1.
    #[error("G53 works with straight moves only: put G0 or G1 on this line")]
    MachineNeedsStraight,
    /// GRBL: axis words, but motion mode is G80.
    #[error("axis words while no motion mode is active (G80): put G0, G1, G2 or G3 on this line")]
    AxisWordsWithoutMotion,
    /// GRBL: arc without an axis word in its plane.
    #[error("the arc has no end point in its plane: give one of {axes}")]
    ArcAxisMissing {
        /// The plane's axes.
        axes: &'static str,
    },
    /// GRBL: invalid target, an arc by radius that ends where it starts.
    #[error("an arc by R cannot end where it starts: give the centre by I J K for a full circle")]
    ArcNowhere,
    /// GRBL: invalid target, the arc's two radii differ by too much.
    #[error(
        "the arc starts {start:.4} mm from its centre but ends {end:.4} mm from it: correct I J K or the end point"
    )]
    ArcRadiiDiffer {
        /// Distance of the start from the centre, mm.
        start: f64,
        /// Distance of the end from the centre, mm.
        end: f64,
    },
    /// GRBL: invalid target, a probe to where the tool already is.
    #[error("the probe move goes nowhere: give it an end point away from the tool")]
    ProbeNowhere,
    /// GRBL: arc radius impossible.
    #[error(
        "no circle of radius {radius:.4} mm joins points {distance:.4} mm apart: R must be at least half of that"
    )]
    ArcRadius {
        /// The R word, mm.
        radius: f64,
        /// Distance from start to end in the plane, mm.
        distance: f64,
    },
    /// GRBL: arc without I, J or K in its plane.
    #[error("the arc has no centre: give {words}, or R")]
    ArcCenterMissing {
        /// The plane's offset words.
        words: &'static str,
    },
    /// GRBL: unused value words in the block.
    #[error("nothing in this line uses {letter}: remove it, or add the command it belongs to")]
    Unused {
        /// The letter.
        letter: char,
    },
    /// GRBL: G43.1 offset not on the tool length axis.
    #[error("G43.1 takes Z and nothing else: write G43.1 Z and the length")]
    ToolLengthAxis,
    /// GRBL: tool number above the maximum.
    #[error("tool number {number} is above {limit}: use a smaller one")]
    ToolNumber {
        /// The T word.
        number: f64,
        /// The highest number allowed.
        limit: u32,
    },
    /// GRBL: invalid jog command, a G or M word that a jog line must not have.
    #[error("a jog line takes axis words, F, G20 G21 G90 G91 and G53 only: remove the rest")]
    JogWord,
    /// LinuxCNC only: the arc's centre is its start.
    #[error("the arc's centre is its start: give the centre by I J K, not zero")]
    ArcRadiusZero,
    /// LinuxCNC only: a comment is not closed.
    #[error("the comment is not closed: put ) before the end of the line")]
    CommentOpen,
    /// LinuxCNC only: a comment inside a comment.
    #[error("a comment inside a comment: remove the inner parentheses")]
    CommentNested,
    /// LinuxCNC only: a whole number was expected (turns of an arc, H).
    #[error("{letter} must be a whole number of {least} or more")]
    WholeNumber {
        /// The letter.
        letter: char,
        /// The least value.
        least: u32,
    },
    /// A comma between digits. GRBL: expected command letter.
    #[error("a comma stands in a number: write decimals with a dot")]
    DecimalComma,
    /// The order of lines: calls, jumps, loops, ends.
    #[error(transparent)]
    Flow(FlowComplaint),
    /// Variables and expressions.
    #[error(transparent)]
    Expression(ExpressionComplaint),
    /// Other dialects than GRBL only.
    #[error(transparent)]
    Rule(#[from] RuleComplaint),
    /// A mistake in a conversational block.
    #[error(transparent)]
    Heidenhain(HeidenhainComplaint),
    /// A mistake in a Sinumerik block.
    #[error(transparent)]
    Siemens(SiemensComplaint),
}

/// A complaint with its place as a byte offset in the line; the caller turns that into a line and a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    pub offset: u32,
    pub complaint: Complaint,
}

impl Fault {
    #[cold]
    pub fn at(offset: u32, complaint: Complaint) -> Fault {
        Fault { offset, complaint }
    }

    /// Line and column as a person counts them.
    #[cold]
    pub fn locate(self, text: &str, line: usize) -> InterpretError {
        let column = text
            .char_indices()
            .take(MAX_COLUMN)
            .take_while(|&(i, _)| i < self.offset as usize)
            .count()
            + 1;
        InterpretError {
            line,
            column,
            complaint: self.complaint,
        }
    }
}
