//! A block against the machine's state: everything that can be wrong is found here, so that carrying it out cannot fail.
//!
//! Crosses the border: a [`State`] (unchanged) and a [`Block`] in; a [`Plan`] out, all in mm, mm/min and work coordinates. The
//! checks stand in the firmware's order: a block with two mistakes gets the same complaint here as there.

use super::arc;
use super::block::{AXES, Block};
use super::codes::{AxisUser, Group, Letters, NonModal, Path, ToolLength};
use super::cycle::{self, Holes, Series};
use super::dialect::Dialect;
use super::error::{Code, Complaint, Fault};
use super::event::{Arc, MotionKind, Plane};
use super::rules::{OffsetTwenty, RuleComplaint, Rules, TOOL_TABLE, ToolWord};
use super::state::{Distance, FeedMode, MotionMode, Probe, State, Units};
use crate::geom::{Point, Vector};
use crate::units::{MmPerMin, Rpm, Seconds};

/// GRBL's highest line number.
const MAX_LINE_NUMBER: f64 = 10_000_000.0;

/// What the block moves. Points are in the work coordinates that hold behind the block's own offset changes, but before G92.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Move {
    None,
    Straight {
        kind: MotionKind,
        to: Point,
        machine: bool,
    },
    Arc {
        to: Point,
        arc: Arc,
    },
    Probe {
        to: Point,
        probe: Probe,
    },
    /// G28, G30: a rapid to `through`, then one to the stored place.
    Home {
        through: Option<Point>,
        to: Point,
    },
    Holes(Holes),
}

/// What the block does to offsets and stored places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Offsets {
    Keep,
    /// G10.
    Work {
        index: usize,
        origin: Vector,
    },
    /// G92, G52 (`local`): the new offset, and the place that the tool now has.
    Shift {
        g92: Vector,
        position: Point,
        local: bool,
    },
    ClearShift,
    /// G92.2, G92.3: the offset in force from here on, the one to restore kept.
    SwitchShift {
        g92: Vector,
    },
    StoreHome,
    StoreSecondHome,
}

/// A block proven sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    pub feed_mode: FeedMode,
    /// As it is carried on: mm/min, 1/min in G93, mm a turn in G95.
    pub feed: MmPerMin,
    /// Of this block's motion: mm/min, 1/min in G93.
    pub rate: MmPerMin,
    pub rapid_feed: MmPerMin,
    pub speed: Rpm,
    pub tool: u32,
    pub change: bool,
    pub dwell: Option<Seconds>,
    pub plane: Plane,
    pub units: Units,
    pub motion: MotionMode,
    pub work_offset: usize,
    pub tlo: f64,
    pub offsets: Offsets,
    pub series: Option<Series>,
    pub action: Move,
}

/// What kind of line the block came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Line {
    Program,
    /// `$J=`
    Jog,
}

/// Value words that the block has and nothing has used yet.
struct Unused(Letters);

impl Unused {
    fn take(&mut self, letters: &'static [u8]) {
        self.0 = self.0.without(Letters::of(letters));
    }
}

/// Checks everything. Nothing is changed.
pub(super) fn check(state: &State, block: &Block, line: Line) -> Result<Plan, Fault> {
    let dialect = state.dialect;
    let rules = dialect.rules();
    let jog = line == Line::Jog;
    let mut axes = block.letters.and(AXES);
    let at = |letter, complaint| Err(Fault::at(block.at(letter), complaint));
    let at_group = |group, complaint| Err(Fault::at(block.group_at(group), complaint));
    let mut unused = Unused(block.letters);
    unused.take(if jog { b"FN" } else { b"FNST" });
    unused.0 = unused.0.without(block.idle);

    if block.value(b'N') > MAX_LINE_NUMBER && rules.firmware {
        return at(b'N', Complaint::LineNumber);
    }
    if block.has(b'O')
        && !block.has_codes_beyond(&[])
        && !block.letters.without(Letters::of(b"NO")).any()
    {
        // The name of the program.
        unused.take(b"O");
    }
    if rules.firmware && lacks_feed(state, block, jog) {
        return Err(Fault::at(block.start, Complaint::FeedMissing));
    }
    // The letter that tells a dwell's time tells nothing else: no feed, no speed, no axis.
    let waits = match block.non_modal == Some(NonModal::Dwell) {
        true => Some(dwell_of(block, rules)?),
        false => None,
    };
    let dwell_letter = waits.map(|(letter, _)| letter);
    let word = |letter: u8| block.get(letter).filter(|_| dwell_letter != Some(letter));
    // Where X can be a dwell's time, no axis word moves anything in a dwell's block.
    let still = waits.is_some() && rules.dwell.iter().any(|(l, _)| *l == b'X');
    if still {
        axes = Letters::default();
    }

    // Bare axis words continue the motion in force.
    let user = match block.axis_user {
        AxisUser::Nobody if axes.any() => AxisUser::Motion,
        other => other,
    };
    let motion = match line {
        // Other motions are looked through before they are refused.
        Line::Jog => block.motion.unwrap_or(MotionMode::Linear),
        Line::Program => block.motion.unwrap_or(match state.motion {
            MotionMode::Cycle(_) if block.cycle_off => MotionMode::None,
            other => other,
        }),
    };

    // Feed: in G93 the number holds for its own block only, so nothing is carried over into, within or out of it.
    let units = block.units.unwrap_or(state.units);
    let mm = units.mm();
    let mut feed_mode = block.feed_mode.unwrap_or(state.feed_mode);
    if jog {
        feed_mode = FeedMode::PerMinute;
        if !block.has(b'F') {
            return Err(Fault::at(block.start, Complaint::FeedMissing));
        }
    } else if feed_mode == FeedMode::InverseTime
        && user == AxisUser::Motion
        && !matches!(motion, MotionMode::Rapid | MotionMode::None)
        && word(b'F').is_none()
    {
        return Err(Fault::at(block.start, Complaint::FeedMissing));
    }
    let speed = word(b'S').map_or(state.speed, Rpm);
    let f = word(b'F');
    // LinuxCNC, Order of Execution: the feed is set before the units of its own line.
    let feed_mm = match state.dialect {
        Dialect::LinuxCnc => state.units.mm(),
        _ => mm,
    };
    let rapid_f = rules.rapid_feed_apart && motion == MotionMode::Rapid;
    let feed = match (feed_mode, f.filter(|_| !rapid_f)) {
        (FeedMode::InverseTime, Some(f)) => f,
        (_, Some(f)) => f * feed_mm,
        (FeedMode::InverseTime, None) => 0.0,
        (mode, None) if mode == state.feed_mode => state.feed.0,
        (_, None) => 0.0,
    };
    let rate = match feed_mode {
        FeedMode::PerTurn => feed * speed.0,
        _ => feed,
    };
    let rapid_feed = match f {
        _ if !rules.rapid_feed_apart => rate,
        Some(f) if rapid_f => f * mm,
        _ => state.rapid_feed.0,
    };
    // No tool was ever named: which one the machine would put in is not known.
    if block.tool_change && rules.tool_named && !block.has(b'T') && state.tool == 0 {
        let (command, word) = ("M6", "T (which tool; here or on a line before)");
        return at_group(Group::ToolChange, Complaint::ValueMissing { command, word });
    }
    let dwell = waits.map(|(_, time)| Seconds(time));
    if let Some(letter) = dwell_letter {
        unused.0 = unused.0.without(single(letter));
    }

    let plane = block.plane.unwrap_or(state.plane);
    let tlo = tool_length(state, block, axes, mm, &mut unused)?;
    if block.path == Some(Path::Blend) {
        unused.0 = unused.0.without(rules.blend_words);
    }
    if rules.spindle_p && block.spindle.is_some() && block.has(b'P') && dwell_letter != Some(b'P') {
        if block.value(b'P') != 0.0 {
            let (letter, least, most) = ('P', 0, 0);
            let range = RuleComplaint::Range {
                letter,
                least,
                most,
            };
            return at(b'P', range.into());
        }
        unused.take(b"P");
    }
    let mut work_offset = block.work_offset.unwrap_or(state.work_offset);
    let named = offset_word(block, rules);
    if let Some((letter, base, most)) = named {
        if dwell_letter == Some(letter) || block.idle.has(letter) {
            let letter = char::from(letter);
            return at(letter as u8, RuleComplaint::WantedTwice { letter }.into());
        }
        work_offset = base + whole_from_one(block, letter, most)? - 1;
        unused.0 = unused.0.without(single(letter));
    }

    // The frame behind the block's own changes of G5x and tool length. The machine has not moved.
    let moved = work_offset != state.work_offset || tlo != state.tlo;
    let offset = state.offset_of(work_offset, tlo);
    let start = if moved {
        state.machine_position() - offset
    } else {
        state.position
    };

    let mut offsets = Offsets::Keep;
    match block.non_modal {
        Some(NonModal::SetOffset) => {
            offsets = match rules.firmware {
                true => set_offset(state, block, axes, mm, work_offset, tlo)?,
                false => set_table_offset(state, block, rules, axes, mm, work_offset, tlo)?,
            };
            unused.take(b"LP");
        }
        Some(NonModal::Shift) => {
            if !axes.any() {
                let command = "G92";
                return at_group(Group::NonModal, Complaint::AxisWordsMissing { command });
            }
            if state.local && dialect != Dialect::LinuxCnc && state.g92 != Vector::zeros() {
                return at_group(Group::NonModal, RuleComplaint::TwoShifts.into());
            }
            let (mut g92, mut position) = (state.g92, start);
            for (i, letter) in (b'X'..=b'Z').enumerate() {
                if let Some(v) = block.get(letter) {
                    // machine = work + rest + g92 stays, work becomes v.
                    g92[i] += start[i] - v * mm;
                    position[i] = v * mm;
                }
            }
            let local = false;
            offsets = Offsets::Shift {
                g92,
                position,
                local,
            };
        }
        Some(NonModal::Local) => {
            if !axes.any() {
                let command = "G52";
                return at_group(Group::NonModal, Complaint::AxisWordsMissing { command });
            }
            if !state.local && dialect != Dialect::LinuxCnc && state.g92 != Vector::zeros() {
                return at_group(Group::NonModal, RuleComplaint::TwoShifts.into());
            }
            let mut g92 = state.g92;
            for (i, letter) in (b'X'..=b'Z').enumerate() {
                if let Some(v) = block.get(letter) {
                    g92[i] = v * mm;
                }
            }
            let (position, local) = (start + state.g92 - g92, true);
            offsets = Offsets::Shift {
                g92,
                position,
                local,
            };
        }
        Some(NonModal::ClearShift | NonModal::SuspendShift | NonModal::RestoreShift)
            if !rules.firmware && axes.any() =>
        {
            return at_group(Group::NonModal, RuleComplaint::ShiftBesideMotion.into());
        }
        Some(NonModal::SuspendShift) => {
            let g92 = Vector::zeros();
            offsets = Offsets::SwitchShift { g92 };
        }
        Some(NonModal::RestoreShift) => {
            let g92 = state.g92_kept;
            offsets = Offsets::SwitchShift { g92 };
        }
        Some(NonModal::ClearShift) => offsets = Offsets::ClearShift,
        Some(NonModal::StoreHome) => offsets = Offsets::StoreHome,
        Some(NonModal::StoreSecondHome) => offsets = Offsets::StoreSecondHome,
        _ => {}
    }

    let machine = block.non_modal == Some(NonModal::MachineCoordinates);
    if machine && !matches!(motion, MotionMode::Rapid | MotionMode::Linear) {
        return at_group(Group::NonModal, Complaint::MachineNeedsStraight);
    }
    let strict = rules.firmware || user == AxisUser::Motion;
    if motion == MotionMode::None && axes.any() && strict {
        let first = (b'X'..=b'Z').find(|&l| block.has(l)).unwrap_or(b'X');
        return at(first, Complaint::AxisWordsWithoutMotion);
    }

    let distance = block.distance.unwrap_or(state.distance);
    if machine && dialect == Dialect::LinuxCnc && distance == Distance::Incremental {
        return at_group(Group::NonModal, RuleComplaint::MachineIncremental.into());
    }
    if machine && rules.machine_rapid {
        if motion != MotionMode::Rapid {
            return at_group(Group::NonModal, RuleComplaint::MachineIsRapid.into());
        }
        if distance == Distance::Incremental {
            return at_group(Group::NonModal, RuleComplaint::MachineIncremental.into());
        }
    }
    let drills = user == AxisUser::Motion && matches!(motion, MotionMode::Cycle(_));
    if rules.pointed.any() {
        let repeats = match (drills, rules.cycles) {
            (true, Some(cycles)) => cycles.repeats,
            _ => b"",
        };
        points(block, rules, units, |l| {
            dwell_letter == Some(l) || repeats.contains(&l)
        })?;
    }
    let mut to = start;
    if axes.any() {
        for (i, letter) in (b'X'..=b'Z').enumerate() {
            if let Some(v) = block.get(letter) {
                to[i] = match distance {
                    _ if machine => v * mm - offset[i],
                    Distance::Absolute => v * mm,
                    Distance::Incremental => start[i] + v * mm,
                };
            }
        }
    } else if jog {
        // The firmware's defect: a jog without axis words goes to machine zero.
        to = Point::from(-offset);
    }

    let mut action = Move::None;
    let mut series = state
        .series
        .filter(|_| matches!(motion, MotionMode::Cycle(_)));
    match block.non_modal {
        Some(go @ (NonModal::GoHome | NonModal::GoSecondHome)) => {
            let stored = match go {
                NonModal::GoHome => state.g28,
                _ => state.g30,
            } - offset;
            if rules.home_needs_axes && !axes.any() {
                let command = if go == NonModal::GoHome { "G28" } else { "G30" };
                return at_group(Group::NonModal, Complaint::AxisWordsMissing { command });
            }
            if rules.home_beside_motion && go == NonModal::GoSecondHome && block.has(b'P') {
                if block.value(b'P') != 2.0 {
                    let (letter, least, most) = ('P', 2, 2);
                    let range = RuleComplaint::Range {
                        letter,
                        least,
                        most,
                    };
                    return at(b'P', range.into());
                }
                unused.take(b"P");
            }
            let mut home = stored;
            if axes.any() {
                home = to;
                for (i, letter) in (b'X'..=b'Z').enumerate() {
                    if block.has(letter) {
                        home[i] = stored[i];
                    }
                }
            }
            action = Move::Home {
                through: axes.any().then_some(to),
                to: home,
            };
        }
        _ if drills => {
            let (MotionMode::Cycle(kind), Some(cycles)) = (motion, rules.cycles) else {
                return at_group(Group::Motion, RuleComplaint::OtherLanguage.into());
            };
            let setting = cycle::Setting {
                state,
                block,
                rules: cycles,
                plane,
                distance,
                feed_mode,
                feed: MmPerMin(rate),
                mm,
                start: &start,
                to: &to,
            };
            let (holes, kept, used) = cycle::plan(kind, &setting)?;
            let taken = named.map(|(l, ..)| l).or(dwell_letter);
            if let Some(letter) = taken.filter(|&l| used.has(l)) {
                let letter = char::from(letter);
                return at(letter as u8, RuleComplaint::WantedTwice { letter }.into());
            }
            if feed_mode == FeedMode::PerTurn && feed > 0.0 && rate == 0.0 {
                return at_group(Group::Motion, RuleComplaint::FeedPerTurn.into());
            }
            unused.0 = unused.0.without(used);
            series = Some(kept);
            action = holes.map_or(Move::None, Move::Holes);
        }
        // What no word asks for, the jog without axis words, is not asked for its feed either.
        _ if jog && user == AxisUser::Nobody => {
            action = Move::Straight {
                kind: MotionKind::Feed,
                to,
                machine,
            };
        }
        _ if user == AxisUser::Motion => {
            if feed_mode == FeedMode::PerTurn
                && feed > 0.0
                && rate == 0.0
                && !matches!(motion, MotionMode::Rapid | MotionMode::None)
            {
                return at_group(Group::Motion, RuleComplaint::FeedPerTurn.into());
            }
            action = motion_of(Course {
                state,
                block,
                motion,
                feed,
                plane,
                start: &start,
                to: &to,
                machine,
                moves: axes.any(),
                unused: &mut unused,
            })?;
        }
        _ => {}
    }

    if user != AxisUser::Nobody && !still {
        unused.take(b"XYZ");
    }
    if let Some(letter) = unused.0.iter().min_by_key(|&l| block.at(l)) {
        let complaint = Complaint::Unused {
            letter: char::from(letter),
        };
        return at(letter, complaint);
    }
    if jog {
        let allowed = [Group::Units, Group::Distance];
        let ok = match machine {
            true => !block.has_codes_beyond(&[Group::Units, Group::Distance, Group::NonModal]),
            false => !block.has_codes_beyond(&allowed),
        };
        if !ok {
            return Err(Fault::at(block.start, Complaint::JogWord));
        }
    }

    Ok(Plan {
        feed_mode,
        feed: MmPerMin(feed),
        rate: MmPerMin(rate),
        rapid_feed: MmPerMin(rapid_feed),
        speed,
        tool: match (block.get(b'T'), dialect) {
            (Some(t), _) => t as u32,
            // GRBL forgets the tool with the next block that has no T.
            (None, Dialect::Grbl) => 0,
            (None, _) => state.tool,
        },
        change: block.tool_change || (rules.tool_word == ToolWord::AtOnce && block.has(b'T')),
        dwell,
        plane,
        units,
        motion,
        work_offset,
        tlo,
        offsets,
        series,
        action,
    })
}

/// One letter as a set.
/// GRBL asks for a feed before it asks for a dwell's time: a jog needs an F word, so does each cutting block in G93.
fn lacks_feed(state: &State, block: &Block, jog: bool) -> bool {
    let inverse = block.feed_mode.unwrap_or(state.feed_mode) == FeedMode::InverseTime;
    let motion = block.motion.unwrap_or(state.motion);
    let cuts = !matches!(motion, MotionMode::Rapid | MotionMode::None);
    let moves = match block.axis_user {
        AxisUser::Nobody => block.letters.and(AXES).any(),
        user => user == AxisUser::Motion,
    };
    !block.has(b'F') && (jog || (inverse && cuts && moves))
}

fn single(letter: u8) -> Letters {
    let mut set = Letters::default();
    set.add(letter);
    set
}

/// The word that tells a dwell's time, and the time, s.
fn dwell_of(block: &Block, rules: &Rules) -> Result<(u8, f64), Fault> {
    let here = |complaint| Err(Fault::at(block.group_at(Group::NonModal), complaint));
    let mut found = rules.dwell.iter().filter(|(l, _)| block.has(*l));
    let Some(&(letter, unit)) = found.next() else {
        let (command, word) = ("G4", rules.dwell_words);
        return here(Complaint::ValueMissing { command, word });
    };
    if found.next().is_some() {
        return here(RuleComplaint::TwoDwells.into());
    }
    if block.value(letter) < 0.0 {
        let letter = char::from(letter);
        return Err(Fault::at(
            block.at(letter as u8),
            Complaint::Negative { letter },
        ));
    }
    Ok((letter, cycle::time(block, letter, unit)?))
}

/// The word that names the block's work offset: letter, first offset, how many.
fn offset_word(block: &Block, rules: &Rules) -> Option<(u8, usize, u32)> {
    let by_p = || {
        let (code, base, most) = rules.offset_p?;
        let here = block.work_offset == Some(code) && block.has(b'P');
        let free = !matches!(
            block.non_modal,
            Some(NonModal::Dwell | NonModal::SetOffset | NonModal::GoSecondHome)
        );
        (here && free).then_some((b'P', base, most))
    };
    block.offset_word.or_else(by_p)
}

/// The letter's value, a whole number from 1 to `most`.
fn whole_from_one(block: &Block, letter: u8, most: u32) -> Result<usize, Fault> {
    let value = block.value(letter);
    if value.fract() == 0.0 && (1.0..=f64::from(most)).contains(&value) {
        return Ok(value as usize);
    }
    let offset = match block.has(letter) {
        true => block.at(letter),
        false => block.group_at(Group::WorkOffset),
    };
    let (letter, least) = (char::from(letter), 1);
    let range = RuleComplaint::Range {
        letter,
        least,
        most,
    };
    Err(Fault::at(offset, range.into()))
}

/// Words that must be written with a decimal point are.
fn points(
    block: &Block,
    rules: &Rules,
    units: Units,
    exempt: impl Fn(u8) -> bool,
) -> Result<(), Fault> {
    let mut need = rules.pointed;
    if units == Units::Inch {
        // In millimetres a plain F is mm/min everywhere; in inches it may count hundredths.
        need.add(b'F');
    }
    let without = block.letters.and(need).without(block.pointed);
    if !without.any() {
        return Ok(());
    }
    let bad = without
        .without(block.idle)
        .iter()
        .filter(|&l| block.value(l) != 0.0 && !exempt(l))
        .min_by_key(|&l| block.at(l));
    match bad {
        None => Ok(()),
        Some(letter) => {
            let offset = block.at(letter);
            let letter = char::from(letter);
            Err(Fault::at(
                offset,
                RuleComplaint::PointMissing { letter }.into(),
            ))
        }
    }
}

/// G43, G43.1, G49: the tool length offset behind the block.
fn tool_length(
    state: &State,
    block: &Block,
    axes: Letters,
    mm: f64,
    unused: &mut Unused,
) -> Result<f64, Fault> {
    let fault = |letter: Option<u8>, complaint| {
        let offset = match letter {
            Some(l) => block.at(l),
            None => block.group_at(Group::ToolLength),
        };
        Err(Fault::at(offset, complaint))
    };
    Ok(match block.tool_length {
        None => state.tlo,
        Some(ToolLength::Cancel) => 0.0,
        Some(ToolLength::Dynamic) => {
            if axes != Letters::of(b"Z") {
                return fault(None, Complaint::ToolLengthAxis);
            }
            block.value(b'Z') * mm
        }
        Some(ToolLength::Table) => {
            if state.dialect.rules().length_needs_h && !block.has(b'H') {
                let (command, word) = ("the tool length", "H (which length)");
                return fault(None, Complaint::ValueMissing { command, word });
            }
            let h = block.value(b'H');
            if h.fract() != 0.0 || h > 1e6 {
                let (letter, least) = ('H', 0);
                return fault(Some(b'H'), Complaint::WholeNumber { letter, least });
            }
            unused.take(b"H");
            // The table's length takes the place of a length given by its value; the program's Z is then the tool's tip.
            0.0
        }
    })
}

/// G10 L2, L20.
fn set_offset(
    state: &State,
    block: &Block,
    axes: Letters,
    mm: f64,
    active: usize,
    tlo: f64,
) -> Result<Offsets, Fault> {
    let here = |complaint| Err(Fault::at(block.group_at(Group::NonModal), complaint));
    if !axes.any() {
        return here(Complaint::AxisWordsMissing { command: "G10" });
    }
    if !block.has(b'P') && !block.has(b'L') {
        let (command, word) = ("G10", "P (which offset) and an L (2 or 20)");
        return here(Complaint::ValueMissing { command, word });
    }
    // The firmware keeps both numbers in a byte, which wraps.
    let whole = |letter| match state.dialect.rules().firmware {
        true => f64::from(block.value(letter) as u64 as u8),
        false => block.value(letter).trunc(),
    };
    let number = whole(b'P');
    if number > 6.0 {
        return Err(Fault::at(block.at(b'P'), Complaint::WorkOffset { number }));
    }
    let l = whole(b'L');
    if l != 2.0 && l != 20.0 {
        return here(Complaint::OffsetKind);
    }
    if l == 2.0 && block.has(b'R') {
        return Err(Fault::at(block.at(b'R'), Complaint::OffsetRotation));
    }
    let index = match number as usize {
        0 => active,
        p => p - 1,
    };
    let mut origin = state.g5x.get(index).copied().unwrap_or_default();
    let machine = state.machine_position();
    for (i, letter) in (b'X'..=b'Z').enumerate() {
        if let Some(v) = block.get(letter) {
            origin[i] = if l == 2.0 {
                v * mm
            } else {
                let length = if i == 2 { tlo } else { 0.0 };
                machine[i] - state.g92[i] - length - v * mm
            };
        }
    }
    Ok(Offsets::Work { index, origin })
}

/// G10 of every dialect but GRBL's own.
fn set_table_offset(
    state: &State,
    block: &Block,
    rules: &Rules,
    axes: Letters,
    mm: f64,
    active: usize,
    tlo: f64,
) -> Result<Offsets, Fault> {
    let here = |complaint| Err(Fault::at(block.group_at(Group::NonModal), complaint));
    if !axes.any() {
        // Fanuc and its kin: tool lengths and radii, by R.
        if rules.offsets_add && block.has(b'R') {
            let (letter, why) = ('G', TOOL_TABLE);
            let number = 10.0;
            let code = Code { letter, number };
            return here(RuleComplaint::Refused { code, why }.into());
        }
        return here(Complaint::AxisWordsMissing { command: "G10" });
    }
    if !block.has(b'P') || !block.has(b'L') {
        let (command, word) = ("G10", "P (which offset) and an L (2 or 20)");
        return here(Complaint::ValueMissing { command, word });
    }
    if block.has(b'R') {
        return Err(Fault::at(block.at(b'R'), Complaint::OffsetRotation));
    }
    let twenty = match block.value(b'L') {
        2.0 => false,
        20.0 => true,
        _ => return here(Complaint::OffsetKind),
    };
    // P0 is the active offset to NIST's children, all offsets together to Fanuc.
    let industry = rules.offsets_add;
    let (base, most) = match (twenty, rules.twenty) {
        (true, OffsetTwenty::Further(most)) => (6, most),
        (true, OffsetTwenty::No) => {
            let why = "G10 L20 is not there on this control; use L2";
            let complaint = RuleComplaint::RefusedWord { letter: 'L', why };
            return Err(Fault::at(block.at(b'L'), complaint.into()));
        }
        _ => (0, rules.offsets as u32),
    };
    let index = match block.value(b'P') {
        0.0 if !industry => active,
        _ => base + whole_from_one(block, b'P', most)? - 1,
    };
    let measured = twenty && rules.twenty == OffsetTwenty::Measured;
    let distance = block.distance.unwrap_or(state.distance);
    let mut origin = state.origin_of(index);
    let machine = state.machine_position();
    for (i, letter) in (b'X'..=b'Z').enumerate() {
        let Some(v) = block.get(letter) else { continue };
        let length = if i == 2 { tlo } else { 0.0 };
        origin[i] = match distance {
            _ if measured => machine[i] - state.g92[i] - length - v * mm,
            Distance::Incremental if industry => origin[i] + v * mm,
            _ => v * mm,
        };
    }
    Ok(Offsets::Work { index, origin })
}

/// A motion command with what it needs.
struct Course<'a> {
    state: &'a State,
    block: &'a Block,
    motion: MotionMode,
    feed: f64,
    plane: Plane,
    start: &'a Point,
    to: &'a Point,
    machine: bool,
    /// The block has axis words.
    moves: bool,
    unused: &'a mut Unused,
}

/// G0 to G3 and G38.x, in the order of the firmware's complaints.
fn motion_of(course: Course) -> Result<Move, Fault> {
    let Course {
        state,
        block,
        motion,
        feed,
        plane,
        start,
        to,
        machine,
        moves,
        unused,
    } = course;
    let here = |complaint| Err(Fault::at(block.group_at(Group::Motion), complaint));
    let to = *to;
    let kind = match motion {
        MotionMode::None | MotionMode::Cycle(_) => return Ok(Move::None),
        MotionMode::Rapid => MotionKind::Rapid,
        _ => MotionKind::Feed,
    };
    if kind == MotionKind::Feed && feed == 0.0 {
        return here(Complaint::FeedMissing);
    }
    match motion {
        MotionMode::None | MotionMode::Cycle(_) => Ok(Move::None),
        MotionMode::Rapid | MotionMode::Linear if !moves => Ok(Move::None),
        MotionMode::Rapid | MotionMode::Linear => Ok(Move::Straight { kind, to, machine }),
        MotionMode::Probe(probe) => {
            if !moves {
                return here(Complaint::AxisWordsMissing { command: "G38" });
            }
            if to == *start {
                return here(Complaint::ProbeNowhere);
            }
            Ok(Move::Probe { to, probe })
        }
        MotionMode::ArcClockwise | MotionMode::ArcCounterclockwise => {
            let clockwise = motion == MotionMode::ArcClockwise;
            let rules = state.dialect.rules();
            let (axis_names, words) = arc::names(plane);
            let [a, b, _] = plane.axes();
            let in_plane = |first: u8| block.has(first + a as u8) || block.has(first + b as u8);
            let whole = rules.whole_circle && in_plane(b'I') && !block.has(b'R');
            if !moves && !whole {
                return here(Complaint::AxisWordsMissing {
                    command: if clockwise { "G2" } else { "G3" },
                });
            }
            if !in_plane(b'X') && !whole {
                return here(Complaint::ArcAxisMissing { axes: axis_names });
            }
            let mm = block.units.unwrap_or(state.units).mm();
            let arc = if let Some(r) = block.get(b'R') {
                unused.take(b"R");
                match arc::by_radius(plane, start, &to, r * mm, clockwise) {
                    Ok(Some(arc)) => arc,
                    // No centre exists. The firmware, in the build that was seen, goes straight there.
                    Ok(None) if rules.firmware => {
                        return Ok(Move::Straight { kind, to, machine });
                    }
                    Ok(None) => return here(Complaint::ArcNowhere),
                    Err(complaint) => return Err(Fault::at(block.at(b'R'), complaint)),
                }
            } else {
                if !in_plane(b'I') {
                    return here(Complaint::ArcCenterMissing { words });
                }
                unused.take(b"IJK");
                let arc_distance = block.arc_distance.unwrap_or(state.arc_distance);
                let mut center = *start;
                for (i, letter) in (b'I'..=b'K').enumerate() {
                    if let Some(v) = block.get(letter) {
                        center[i] = match arc_distance {
                            Distance::Incremental => start[i] + v * mm,
                            Distance::Absolute => v * mm,
                        };
                    }
                }
                match arc::by_center(rules, plane, start, &to, &center, clockwise) {
                    Ok(arc) => arc,
                    Err(complaint) => return here(complaint),
                }
            };
            let mut arc = arc;
            if rules.turns
                && let Some(turns) = block.get(b'P')
            {
                let whole_turns = turns.fract() == 0.0 && (1.0..=1e6).contains(&turns);
                if !whole_turns && block.non_modal != Some(NonModal::Dwell) {
                    let (letter, least) = ('P', 1);
                    let complaint = Complaint::WholeNumber { letter, least };
                    return Err(Fault::at(block.at(b'P'), complaint));
                }
                if whole_turns && block.non_modal != Some(NonModal::Dwell) {
                    unused.take(b"P");
                    arc.sweep += (turns - 1.0) * std::f64::consts::TAU * arc.sweep.signum();
                }
            }
            Ok(Move::Arc { to, arc })
        }
    }
}
