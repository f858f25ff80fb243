//! A block: the words of one line, each allowed by itself and beside the others.
//!
//! Crosses the border: one line of text in; a [`Block`] out, in which every code is known, no modal group is named twice, no
//! letter stands twice and at most one command wants the axis words. What the words mean together with the machine's state
//! (missing feeds, impossible arcs, words that nothing uses) is checked by `check`.
//!
//! The order of complaints is the firmware's: word by word, first hit wins.

use super::codes::{AxisUser, Coolant, GROUPS, Group, Letters, NonModal, Path, Stop, ToolLength};
use super::dialect::Dialect;
use super::error::{Code, Complaint, Fault};
use super::event::Plane;
use super::state::{Distance, FeedMode, MotionMode, Probe, Units};
use super::word::{Word, Words, check_comments, significant};

/// Most characters of a line that the controller reads: GRBL without blanks and comments, LinuxCNC with them.
const GRBL_LINE: usize = 79;
const LINUXCNC_LINE: usize = 255;

/// The highest tool number.
fn tool_limit(dialect: Dialect) -> u32 {
    match dialect {
        Dialect::Grbl => 255,
        _ => 99_999,
    }
}

/// X, Y, Z.
pub(super) const AXES: Letters = Letters::of(b"XYZ");

const GRBL_WORDS: Letters = Letters::of(b"FIJKLNPRSTXYZ");
const LINUXCNC_WORDS: Letters = Letters::of(b"FHIJKLNPQRSTXYZ");
const GRBL_POSITIVE: Letters = Letters::of(b"FNPST");
const LINUXCNC_POSITIVE: Letters = Letters::of(b"FHNPQST");

/// The words of one line.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub motion: Option<MotionMode>,
    pub plane: Option<Plane>,
    pub distance: Option<Distance>,
    pub arc_distance: Option<Distance>,
    pub feed_mode: Option<FeedMode>,
    pub units: Option<Units>,
    pub tool_length: Option<ToolLength>,
    pub work_offset: Option<usize>,
    pub path: Option<Path>,
    pub non_modal: Option<NonModal>,
    pub stop: Option<Stop>,
    pub spindle: Option<i8>,
    pub coolant: Option<Coolant>,
    pub tool_change: bool,
    pub axis_user: AxisUser,
    /// Value words present.
    pub letters: Letters,
    /// Byte offset of the first word.
    pub start: u32,
    groups: u16,
    values: [f64; 26],
    letter_at: [u32; 26],
    group_at: [u32; GROUPS],
}

impl Block {
    fn empty() -> Block {
        Block {
            motion: None,
            plane: None,
            distance: None,
            arc_distance: None,
            feed_mode: None,
            units: None,
            tool_length: None,
            work_offset: None,
            path: None,
            non_modal: None,
            stop: None,
            spindle: None,
            coolant: None,
            tool_change: false,
            axis_user: AxisUser::Nobody,
            letters: Letters::default(),
            start: 0,
            groups: 0,
            values: [0.0; 26],
            letter_at: [0; 26],
            group_at: [0; GROUPS],
        }
    }

    /// True if the letter has a value in this block. `letter` is `A` to `Z`.
    #[inline]
    pub fn has(&self, letter: u8) -> bool {
        self.letters.has(letter)
    }

    /// The letter's value, zero if it is not there.
    #[inline]
    pub fn value(&self, letter: u8) -> f64 {
        self.values[usize::from(letter - b'A')]
    }

    /// The letter's value.
    #[inline]
    pub fn get(&self, letter: u8) -> Option<f64> {
        self.has(letter).then(|| self.value(letter))
    }

    /// Where the letter stands.
    #[cold]
    pub fn at(&self, letter: u8) -> u32 {
        self.letter_at[usize::from(letter - b'A')]
    }

    /// Where the group's code stands, or the block's start if it is not in the block.
    #[cold]
    pub fn group_at(&self, group: Group) -> u32 {
        match self.seen(group) {
            true => self.group_at[group as usize],
            false => self.start,
        }
    }

    /// True if the block has a code of this group.
    pub fn seen(&self, group: Group) -> bool {
        self.groups & (1 << group as u16) != 0
    }

    /// True if the block has any G or M code outside these groups.
    pub fn has_codes_beyond(&self, groups: &[Group]) -> bool {
        let allowed = groups.iter().fold(0u16, |m, &g| m | 1 << g as u16);
        self.groups & !allowed != 0
    }
}

/// A G or M number taken apart as the firmware does: the whole part wraps at 256, the rest is in hundredths.
fn parts(value: f64) -> (u8, i64) {
    let whole = (value.trunc() as i64 & 0xff) as u8;
    (whole, ((value - f64::from(whole)) * 100.0).round() as i64)
}

/// Reads the words of one line. `None` for a line without any.
pub(super) fn gather(text: &str, dialect: Dialect) -> Result<Option<Block>, Fault> {
    let (length, limit) = match dialect {
        Dialect::Grbl if text.len() > GRBL_LINE => (significant(text), GRBL_LINE),
        Dialect::LinuxCnc if text.len() > LINUXCNC_LINE => {
            (text.trim_end().chars().count(), LINUXCNC_LINE)
        }
        _ => (0, 0),
    };
    if length > limit {
        return Err(Fault::at(0, Complaint::LineTooLong { length, limit }));
    }
    if dialect == Dialect::LinuxCnc && text.as_bytes().contains(&b'(') {
        check_comments(text)?;
    }
    let mut words = Words::new(text, dialect);
    let mut block = Block::empty();
    let mut any = false;
    while let Some(word) = words.read() {
        let word = word?;
        if !any {
            block.start = word.start;
            any = true;
        }
        match word.letter {
            b'G' => block.g(&word, dialect)?,
            b'M' => block.m(&word, dialect)?,
            _ => block.letter(&word, dialect)?,
        }
    }
    Ok(any.then_some(block))
}

impl Block {
    /// A G word.
    fn g(&mut self, word: &Word, dialect: Dialect) -> Result<(), Fault> {
        let code = Code {
            letter: 'G',
            number: word.value,
        };
        let fault = |complaint| Err(Fault::at(word.start, complaint));
        let unsupported = Complaint::UnsupportedCode { code };
        let linuxcnc = dialect == Dialect::LinuxCnc;
        let (whole, hundredths) = parts(word.value);
        // LinuxCNC's G43, G43.1 and G49 leave the axis words to the motion, except that G43.1 reads them as lengths.
        let user = match whole {
            0..=3 | 38 => AxisUser::Motion,
            10 => AxisUser::NonModal,
            28 | 30 | 92 if hundredths == 0 => AxisUser::NonModal,
            43 | 49 if !linuxcnc => AxisUser::ToolLength,
            43 if hundredths == 10 => AxisUser::ToolLength,
            _ => AxisUser::Nobody,
        };
        if user != AxisUser::Nobody {
            if self.axis_user != AxisUser::Nobody {
                return fault(Complaint::TwoAxisCommands { code });
            }
            self.axis_user = user;
        }
        // `plain`: the code has no fraction of its own, so any fraction is a mistake.
        let mut plain = true;
        let group = match whole {
            0..=3 => {
                self.motion = Some(match whole {
                    0 => MotionMode::Rapid,
                    1 => MotionMode::Linear,
                    2 => MotionMode::ArcClockwise,
                    _ => MotionMode::ArcCounterclockwise,
                });
                Group::Motion
            }
            38 => {
                plain = false;
                let (away, strict) = match hundredths {
                    20 => (false, true),
                    30 => (false, false),
                    40 => (true, true),
                    50 => (true, false),
                    _ => return fault(unsupported),
                };
                self.motion = Some(MotionMode::Probe(Probe { away, strict }));
                Group::Motion
            }
            80 => {
                self.motion = Some(MotionMode::None);
                Group::Motion
            }
            4 | 10 | 53 => {
                self.non_modal = Some(match whole {
                    4 => NonModal::Dwell,
                    10 => NonModal::SetOffset,
                    _ => NonModal::MachineCoordinates,
                });
                Group::NonModal
            }
            28 | 30 | 92 => {
                plain = false;
                self.non_modal = Some(match (whole, hundredths) {
                    (28, 0) => NonModal::GoHome,
                    (28, 10) => NonModal::StoreHome,
                    (30, 0) => NonModal::GoSecondHome,
                    (30, 10) => NonModal::StoreSecondHome,
                    (92, 0) => NonModal::Shift,
                    (92, 10) => NonModal::ClearShift,
                    _ => return fault(unsupported),
                });
                Group::NonModal
            }
            17..=19 => {
                self.plane = Some(match whole {
                    17 => Plane::Xy,
                    18 => Plane::Zx,
                    _ => Plane::Yz,
                });
                Group::Plane
            }
            90 | 91 => {
                let distance = match whole {
                    90 => Distance::Absolute,
                    _ => Distance::Incremental,
                };
                plain = false;
                match hundredths {
                    0 => {
                        self.distance = Some(distance);
                        Group::Distance
                    }
                    10 if whole == 91 || linuxcnc => {
                        self.arc_distance = Some(distance);
                        Group::ArcDistance
                    }
                    _ => return fault(unsupported),
                }
            }
            93 | 94 => {
                self.feed_mode = Some(match whole {
                    93 => FeedMode::InverseTime,
                    _ => FeedMode::PerMinute,
                });
                Group::FeedMode
            }
            20 | 21 => {
                self.units = Some(match whole {
                    20 => Units::Inch,
                    _ => Units::Mm,
                });
                Group::Units
            }
            40 => Group::CutterRadius,
            43 | 49 => {
                plain = linuxcnc && whole == 49;
                self.tool_length = Some(match (whole, hundredths) {
                    (49, _) => ToolLength::Cancel,
                    (_, 10) => ToolLength::Dynamic,
                    (_, 0) if linuxcnc => ToolLength::Table,
                    _ => return fault(unsupported),
                });
                Group::ToolLength
            }
            54..=59 => {
                self.work_offset = Some(usize::from(whole - 54));
                Group::WorkOffset
            }
            61 | 64 => {
                plain = false;
                self.path = Some(match (whole, hundredths) {
                    (61, 0) => Path::Exact,
                    (61, 10) if linuxcnc => Path::Stop,
                    (64, 0) if linuxcnc => Path::Blend,
                    _ => return fault(unsupported),
                });
                Group::Path
            }
            _ => return fault(unsupported),
        };
        if plain && hundredths != 0 {
            return fault(Complaint::Fraction { code });
        }
        self.claim(group, code, word)
    }

    /// An M word.
    fn m(&mut self, word: &Word, dialect: Dialect) -> Result<(), Fault> {
        let code = Code {
            letter: 'M',
            number: word.value,
        };
        let linuxcnc = dialect == Dialect::LinuxCnc;
        let (whole, hundredths) = parts(word.value);
        if hundredths != 0 {
            return Err(Fault::at(word.start, Complaint::Fraction { code }));
        }
        let group = match whole {
            0 | 1 | 2 | 30 => {
                self.stop = Some(match whole {
                    0 => Stop::Pause,
                    1 => Stop::OptionalPause,
                    _ => Stop::End,
                });
                Group::Stop
            }
            3..=5 => {
                self.spindle = Some(match whole {
                    3 => 1,
                    4 => -1,
                    _ => 0,
                });
                Group::Spindle
            }
            6 if linuxcnc => {
                self.tool_change = true;
                Group::ToolChange
            }
            7 if linuxcnc => {
                self.coolant = Some(Coolant::Mist);
                Group::Coolant
            }
            8 | 9 => {
                self.coolant = Some(match whole {
                    8 => Coolant::Flood,
                    _ => Coolant::Off,
                });
                Group::Coolant
            }
            _ => {
                let complaint = Complaint::UnsupportedCode { code };
                return Err(Fault::at(word.start, complaint));
            }
        };
        self.claim(group, code, word)
    }

    fn claim(&mut self, group: Group, code: Code, word: &Word) -> Result<(), Fault> {
        if self.seen(group) {
            let group = group.name();
            return Err(Fault::at(word.start, Complaint::SameGroup { code, group }));
        }
        self.groups |= 1 << group as u16;
        self.group_at[group as usize] = word.start;
        Ok(())
    }

    /// Any other word.
    #[inline]
    fn letter(&mut self, word: &Word, dialect: Dialect) -> Result<(), Fault> {
        let (known, positive) = match dialect {
            Dialect::Grbl => (GRBL_WORDS, GRBL_POSITIVE),
            _ => (LINUXCNC_WORDS, LINUXCNC_POSITIVE),
        };
        let letter = char::from(word.letter);
        let fault = |complaint| Err(Fault::at(word.start, complaint));
        if !known.has(word.letter) {
            return fault(Complaint::UnsupportedWord { letter });
        }
        let limit = tool_limit(dialect);
        if word.letter == b'T' && word.value > f64::from(limit) {
            let number = word.value;
            return fault(Complaint::ToolNumber { number, limit });
        }
        if self.letters.has(word.letter) {
            return fault(Complaint::Repeated { letter });
        }
        if positive.has(word.letter) && word.value < 0.0 {
            return fault(Complaint::Negative { letter });
        }
        let i = usize::from(word.letter - b'A');
        self.letters.add(word.letter);
        self.values[i] = word.value;
        self.letter_at[i] = word.start;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn complaint(text: &str, dialect: Dialect) -> (u32, String) {
        let f = gather(text, dialect).unwrap_err();
        let name = format!("{:?}", f.complaint);
        let name = name.split([' ', '{']).next().unwrap().to_string();
        (f.offset, name)
    }

    #[test]
    fn one_complaint_for_each_bad_block_at_the_word_to_blame() {
        use Dialect::*;
        for (dialect, text, offset, name) in [
            (Grbl, "G0 G1 X1", 3, "TwoAxisCommands"),
            (Grbl, "G17 G18", 4, "SameGroup"),
            (Grbl, "G59.1", 0, "Fraction"),
            (Grbl, "G1.5 X1", 0, "Fraction"),
            (Grbl, "M3.1", 0, "Fraction"),
            (Grbl, "M-1", 0, "Fraction"),
            (Grbl, "G43 H1", 0, "UnsupportedCode"),
            (Grbl, "G64 P0.01", 0, "UnsupportedCode"),
            (Grbl, "M6 T1", 0, "UnsupportedCode"),
            (Grbl, "M7", 0, "UnsupportedCode"),
            (Grbl, "G38.6", 0, "UnsupportedCode"),
            (Grbl, "G90.1", 0, "UnsupportedCode"),
            (Grbl, "G28.2", 0, "UnsupportedCode"),
            (Grbl, "G0 X1 A2", 6, "UnsupportedWord"),
            (Grbl, "X1 Y2 X3", 6, "Repeated"),
            (Grbl, "T256", 0, "ToolNumber"),
            (Grbl, "F-1", 0, "Negative"),
            (Grbl, "G54 G54", 4, "SameGroup"),
            (Grbl, "G28 G92 X0", 4, "TwoAxisCommands"),
            (Grbl, "G49 G0", 4, "TwoAxisCommands"),
            (LinuxCnc, "G81 X1", 0, "UnsupportedCode"),
            (LinuxCnc, "G0 X1 (open", 6, "CommentOpen"),
            (LinuxCnc, "(a (b))", 3, "CommentNested"),
            (LinuxCnc, "T100000", 0, "ToolNumber"),
            (LinuxCnc, "H-1", 0, "Negative"),
        ] {
            assert_eq!(complaint(text, dialect), (offset, name.into()), "{text}");
        }
        for text in [
            "G43 H1 G0 Z5",
            "G49 G0",
            "G64 P0.01 Q0.02",
            "M6 T1",
            "M7",
            "G90.1",
        ] {
            assert!(gather(text, LinuxCnc).unwrap().is_some(), "{text}");
        }
        for text in ["G17.001", "G000", "G49Z1", "G92.1X1", "G53G0G54X1"] {
            assert!(gather(text, Grbl).unwrap().is_some(), "{text}");
        }
        assert!(gather(" (nothing) ", Grbl).unwrap().is_none());
    }

    #[test]
    fn long_lines_are_counted_without_blanks_and_comments() {
        let long = format!("G1X{}1", "0".repeat(76));
        assert_eq!(complaint(&long, Dialect::Grbl).1, "LineTooLong");
        assert!(gather(&long[..79], Dialect::Grbl).is_ok());
        let blank = format!("G1 X1{}(and a comment)", " ".repeat(100));
        assert!(gather(&blank, Dialect::Grbl).is_ok());
    }
}
