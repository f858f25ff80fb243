//! A block: the words of one line, each allowed by itself and beside the others.
//!
//! Crosses the border: one line of text in; a [`Block`] out, in which every code is known, no modal group is named twice, no
//! letter stands twice and at most one command wants the axis words. What the words mean together with the machine's state
//! (missing feeds, impossible arcs, words that nothing uses) is checked by `check`.
//!
//! The order of complaints is the firmware's: word by word, first hit wins.

use super::codes::{AxisUser, Coolant, GROUPS, Group, Letters, NonModal, Path, Stop, ToolLength};
use super::dialect::Dialect;
use super::envelope;
use super::error::{Code, Complaint, Fault};
use super::event::Plane;
use super::rules::{Meaning, RuleComplaint, Rules};
use super::single::{leading, read_single};
use super::state::{Distance, FeedMode, MotionMode, Retract, Units};
use super::word::{Word, Words};

/// X, Y, Z.
pub(super) const AXES: Letters = Letters::of(b"XYZ");

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
    pub retract: Option<Retract>,
    /// G80 where it is no motion mode: it ends a cycle and leaves G0 and G1 as they are.
    pub cycle_off: bool,
    /// A code without further meaning that waits for standstill.
    pub wait: bool,
    /// The word that names the work offset, the first offset it names, how many.
    pub offset_word: Option<(u8, usize, u32)>,
    pub axis_user: AxisUser,
    /// Value words present.
    pub letters: Letters,
    /// Those of them written with a decimal point.
    pub pointed: Letters,
    /// Words that belong to a code which leaves the path as it is.
    pub idle: Letters,
    /// Byte offset of the first word.
    pub start: u32,
    groups: u32,
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
            retract: None,
            cycle_off: false,
            wait: false,
            offset_word: None,
            axis_user: AxisUser::Nobody,
            letters: Letters::default(),
            pointed: Letters::default(),
            idle: Letters::default(),
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

    /// Takes the values of lengths and speeds as the firmware does, in single precision. `text` is the line the block came from.
    pub fn take_single(&mut self, text: &str) {
        for letter in self.letters.and(Letters::of(b"FIJKRSXYZ")).iter() {
            let i = usize::from(letter - b'A');
            let at = self.letter_at[i] as usize + 1;
            if let Some(rest) = text.get(at..) {
                self.values[i] = read_single(&leading(rest));
            }
        }
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
        self.groups & (1 << group as u32) != 0
    }

    /// True if the block has any G or M code outside these groups.
    pub fn has_codes_beyond(&self, groups: &[Group]) -> bool {
        let allowed = groups.iter().fold(0u32, |m, &g| m | 1 << g as u32);
        self.groups & !allowed != 0
    }
}

/// A G or M number taken apart as the firmware does: the whole part wraps at 256, the rest is in hundredths.
fn parts(value: f64) -> (u8, i64) {
    let whole = (value.trunc() as i64 & 0xff) as u8;
    (whole, ((value - f64::from(whole)) * 100.0).round() as i64)
}

/// A G or M number in hundredths; `None` for what no code is.
fn hundredths_of(value: f64) -> Option<u32> {
    let hundredths = (value * 100.0).round();
    let near = (value * 100.0 - hundredths).abs() < 1e-6;
    (near && (0.0..1e8).contains(&hundredths)).then_some(hundredths as u32)
}

/// Reads the words of one line. `None` for a line without any.
pub(super) fn gather(text: &str, dialect: Dialect) -> Result<Option<Block>, Fault> {
    let rules = dialect.rules();
    if !rules.letters.any() {
        return Err(Fault::at(0, RuleComplaint::OtherLanguage.into()));
    }
    let text = envelope::open(text, rules)?;
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
            b'G' => block.g(&word, rules)?,
            b'M' => block.m(&word, rules)?,
            _ => block.letter(&word, rules)?,
        }
    }
    Ok(any.then_some(block))
}

/// G codes that have relatives with a fraction, so that an unknown fraction is an unknown code.
const FAMILIES: [u8; 10] = [5, 28, 30, 38, 43, 61, 64, 90, 91, 92];

/// The firmware's own view of who wants the axis words, which it takes before it looks whether it knows the code.
fn firmware_user(whole: u8, hundredths: i64) -> AxisUser {
    match whole {
        0..=3 | 38 => AxisUser::Motion,
        10 => AxisUser::NonModal,
        28 | 30 | 92 if hundredths == 0 => AxisUser::NonModal,
        43 | 49 => AxisUser::ToolLength,
        _ => AxisUser::Nobody,
    }
}

/// Which command a meaning makes of the axis words. LinuxCNC's way: G43 and G49 leave them to the motion, G43.1 reads them as lengths.
fn user(meaning: Option<Meaning>) -> AxisUser {
    match meaning {
        Some(Meaning::Motion(MotionMode::None)) => AxisUser::Nobody,
        Some(Meaning::Motion(_)) => AxisUser::Motion,
        Some(Meaning::ToolLength(ToolLength::Dynamic)) => AxisUser::ToolLength,
        Some(Meaning::NonModal(
            NonModal::SetOffset
            | NonModal::GoHome
            | NonModal::GoSecondHome
            | NonModal::Shift
            | NonModal::Local,
        )) => AxisUser::NonModal,
        _ => AxisUser::Nobody,
    }
}

impl Block {
    /// A G word.
    fn g(&mut self, word: &Word, rules: &Rules) -> Result<(), Fault> {
        let code = Code {
            letter: 'G',
            number: word.value,
        };
        let fault = |complaint| Err(Fault::at(word.start, complaint));
        let (whole, hundredths) = parts(word.value);
        let key = match (rules.firmware, whole) {
            // GRBL does not look at the fraction of G49.
            (true, 49) => Some(4900),
            (true, _) => u32::try_from((i64::from(whole) * 100).saturating_add(hundredths)).ok(),
            (false, _) => hundredths_of(word.value),
        };
        let meaning = key.and_then(|k| rules.g(k));
        let wants = match rules.firmware {
            true => firmware_user(whole, hundredths),
            false => user(meaning),
        };
        if wants != AxisUser::Nobody {
            let home = |m| matches!(m, Some(NonModal::GoHome | NonModal::GoSecondHome));
            let now_home = matches!(meaning, Some(Meaning::NonModal(n)) if home(Some(n)));
            let straight = |m| matches!(m, Some(MotionMode::Rapid | MotionMode::Linear));
            let now_straight = matches!(meaning, Some(Meaning::Motion(m)) if straight(Some(m)));
            self.axis_user = match self.axis_user {
                AxisUser::Nobody => wants,
                AxisUser::Motion
                    if rules.home_beside_motion && now_home && straight(self.motion) =>
                {
                    wants
                }
                AxisUser::NonModal
                    if rules.home_beside_motion && now_straight && home(self.non_modal) =>
                {
                    AxisUser::NonModal
                }
                _ => return fault(Complaint::TwoAxisCommands { code }),
            };
        }
        let Some(meaning) = meaning else {
            let plain = !FAMILIES.contains(&whole) && hundredths != 0;
            let family = u32::from(whole) * 100;
            return fault(match rules.g(family) {
                Some(_) if plain => Complaint::Fraction { code },
                _ => Complaint::UnsupportedCode { code },
            });
        };
        let group = match meaning {
            Meaning::Motion(motion) => {
                self.motion = Some(motion);
                match motion {
                    // Where G80 has a group of its own, the cycles are in it: G0 G80 is no mistake, G80 G81 is.
                    MotionMode::Cycle(_) if self.seen(Group::Cycle) => Group::Cycle,
                    _ => Group::Motion,
                }
            }
            Meaning::CycleOff => {
                if matches!(self.motion, Some(MotionMode::Cycle(_))) {
                    let group = Group::Cycle.name();
                    return fault(Complaint::SameGroup { code, group });
                }
                self.cycle_off = true;
                Group::Cycle
            }
            Meaning::NonModal(non_modal) => {
                self.non_modal = Some(non_modal);
                Group::NonModal
            }
            Meaning::Plane(plane) => {
                self.plane = Some(plane);
                Group::Plane
            }
            Meaning::Distance(distance) => {
                self.distance = Some(distance);
                Group::Distance
            }
            Meaning::ArcDistance(distance) => {
                self.arc_distance = Some(distance);
                Group::ArcDistance
            }
            Meaning::FeedMode(mode) => {
                self.feed_mode = Some(mode);
                Group::FeedMode
            }
            Meaning::Units(units) => {
                self.units = Some(units);
                Group::Units
            }
            Meaning::Retract(retract) => {
                self.retract = Some(retract);
                Group::Retract
            }
            Meaning::ToolLength(length) => {
                self.tool_length = Some(length);
                Group::ToolLength
            }
            Meaning::WorkOffset(index) => {
                self.work_offset = Some(index);
                Group::WorkOffset
            }
            Meaning::WorkOffsetBy { letter, base, most } => {
                self.offset_word = Some((letter, base, most));
                Group::WorkOffset
            }
            Meaning::Path(path) => {
                self.path = Some(path);
                Group::Path
            }
            Meaning::Nothing(group, letters, _) => {
                self.idle = self.idle.or(letters);
                group
            }
            Meaning::Refused(why) => {
                return fault(RuleComplaint::Refused { code, why }.into());
            }
            // These stand in tables of M codes only.
            Meaning::Stop(_)
            | Meaning::Spindle(_)
            | Meaning::Coolant(_)
            | Meaning::ToolChange
            | Meaning::Wait => return fault(Complaint::UnsupportedCode { code }),
        };
        self.claim(group, code, word)
    }

    /// An M word.
    fn m(&mut self, word: &Word, rules: &Rules) -> Result<(), Fault> {
        let code = Code {
            letter: 'M',
            number: word.value,
        };
        let fault = |complaint| Err(Fault::at(word.start, complaint));
        let key = match rules.firmware {
            true => {
                let (whole, hundredths) = parts(word.value);
                if hundredths != 0 {
                    return fault(Complaint::Fraction { code });
                }
                Some(u32::from(whole) * 100)
            }
            false => hundredths_of(word.value),
        };
        let Some(meaning) = key.and_then(|k| rules.m(k)) else {
            return fault(match (word.value.fract() != 0.0, rules.other_m) {
                (true, _) => Complaint::Fraction { code },
                (false, Some(why)) => RuleComplaint::Refused { code, why }.into(),
                (false, None) => Complaint::UnsupportedCode { code },
            });
        };
        let group = match meaning {
            Meaning::Stop(stop) => {
                self.stop = Some(stop);
                Group::Stop
            }
            Meaning::Spindle(direction) => {
                self.spindle = Some(direction);
                Group::Spindle
            }
            Meaning::Coolant(coolant) => {
                self.coolant = Some(coolant);
                Group::Coolant
            }
            Meaning::ToolChange => {
                self.tool_change = true;
                Group::ToolChange
            }
            Meaning::Wait => {
                self.wait = true;
                Group::Wait
            }
            Meaning::Nothing(group, letters, _) => {
                self.idle = self.idle.or(letters);
                group
            }
            Meaning::Refused(why) => return fault(RuleComplaint::Refused { code, why }.into()),
            _ => return fault(Complaint::UnsupportedCode { code }),
        };
        self.claim(group, code, word)
    }

    fn claim(&mut self, group: Group, code: Code, word: &Word) -> Result<(), Fault> {
        if self.seen(group) {
            let group = group.name();
            return Err(Fault::at(word.start, Complaint::SameGroup { code, group }));
        }
        self.groups |= 1 << group as u32;
        self.group_at[group as usize] = word.start;
        Ok(())
    }

    /// Any other word.
    #[inline]
    fn letter(&mut self, word: &Word, rules: &Rules) -> Result<(), Fault> {
        let letter = char::from(word.letter);
        let fault = |complaint| Err(Fault::at(word.start, complaint));
        if !rules.letters.has(word.letter) {
            return fault(
                match rules.refused.iter().find(|(l, _)| *l == word.letter) {
                    Some(&(_, why)) => RuleComplaint::RefusedWord { letter, why }.into(),
                    None => Complaint::UnsupportedWord { letter },
                },
            );
        }
        let limit = rules.tool_limit;
        if word.letter == b'T' && word.value > f64::from(limit) {
            let number = word.value;
            return fault(Complaint::ToolNumber { number, limit });
        }
        if self.letters.has(word.letter) {
            return fault(Complaint::Repeated { letter });
        }
        if word.value < 0.0 && rules.positive.has(word.letter) {
            return fault(Complaint::Negative { letter });
        }
        if word.point {
            if rules.pointless.has(word.letter) {
                return fault(RuleComplaint::PointForbidden { letter }.into());
            }
            self.pointed.add(word.letter);
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
            (Grbl, "G91.2", 0, "UnsupportedCode"),
            (Grbl, "G28.2", 0, "UnsupportedCode"),
            (Grbl, "G0 X1 A2", 6, "UnsupportedWord"),
            (Grbl, "X1 Y2 X3", 6, "Repeated"),
            (Grbl, "T256", 0, "ToolNumber"),
            (Grbl, "F-1", 0, "Negative"),
            (Grbl, "G54 G54", 4, "SameGroup"),
            (Grbl, "G28 G92 X0", 4, "TwoAxisCommands"),
            (Grbl, "G49 G0", 4, "TwoAxisCommands"),
            (LinuxCnc, "G84 X1", 0, "Rule(Refused"),
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
