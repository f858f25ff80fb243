//! A block against the machine's state: everything that can be wrong is found here, so that carrying it out cannot fail.
//!
//! Crosses the border: a [`State`] (unchanged) and a [`Block`] in; a [`Plan`] out, all in mm, mm/min and work coordinates. The
//! checks stand in the firmware's order: a block with two mistakes gets the same complaint here as there.

use super::arc;
use super::block::{AXES, Block};
use super::codes::{AxisUser, Group, Letters, NonModal, Path, ToolLength};
use super::dialect::Dialect;
use super::error::{Complaint, Fault};
use super::event::{Arc, MotionKind, Plane};
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
    /// G92: the new offset, and the place that the tool now has.
    Shift {
        g92: Vector,
        position: Point,
    },
    ClearShift,
    StoreHome,
    StoreSecondHome,
}

/// A block proven sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    pub feed_mode: FeedMode,
    pub feed: MmPerMin,
    pub speed: Rpm,
    pub tool: u32,
    pub dwell: Option<Seconds>,
    pub plane: Plane,
    pub units: Units,
    pub motion: MotionMode,
    pub work_offset: usize,
    pub tlo: f64,
    pub offsets: Offsets,
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
    let jog = line == Line::Jog;
    let axes = block.letters.and(AXES);
    let at = |letter, complaint| Err(Fault::at(block.at(letter), complaint));
    let at_group = |group, complaint| Err(Fault::at(block.group_at(group), complaint));
    let mut unused = Unused(block.letters);
    unused.take(if jog { b"FN" } else { b"FNST" });

    if block.value(b'N') > MAX_LINE_NUMBER && dialect == Dialect::Grbl {
        return at(b'N', Complaint::LineNumber);
    }

    // Bare axis words continue the motion in force.
    let user = match block.axis_user {
        AxisUser::Nobody if axes.any() => AxisUser::Motion,
        other => other,
    };
    let motion = match line {
        Line::Jog => MotionMode::Linear,
        Line::Program => block.motion.unwrap_or(state.motion),
    };

    // Feed: in G93 the number holds for its own block only, so nothing is carried over into, within or out of it.
    let units = block.units.unwrap_or(state.units);
    let mm = units.mm();
    let mut feed_mode = block.feed_mode.unwrap_or(state.feed_mode);
    if jog {
        feed_mode = FeedMode::PerMinute;
        if block.value(b'F') == 0.0 {
            return Err(Fault::at(block.start, Complaint::FeedMissing));
        }
    } else if feed_mode == FeedMode::InverseTime
        && user == AxisUser::Motion
        && !matches!(motion, MotionMode::Rapid | MotionMode::None)
        && !block.has(b'F')
    {
        return Err(Fault::at(block.start, Complaint::FeedMissing));
    }
    let feed = match (feed_mode, block.get(b'F')) {
        (FeedMode::PerMinute, Some(f)) => f * mm,
        (FeedMode::PerMinute, None) if state.feed_mode == FeedMode::PerMinute => state.feed.0,
        (FeedMode::InverseTime, Some(f)) => f,
        (_, None) => 0.0,
    };

    let mut dwell = None;
    if block.non_modal == Some(NonModal::Dwell) {
        let Some(p) = block.get(b'P') else {
            let (command, word) = ("G4", "P (seconds)");
            return at_group(Group::NonModal, Complaint::ValueMissing { command, word });
        };
        dwell = Some(Seconds(p));
        unused.take(b"P");
    }

    let plane = block.plane.unwrap_or(state.plane);
    let tlo = tool_length(state, block, axes, mm, &mut unused)?;
    if dialect == Dialect::LinuxCnc && block.path == Some(Path::Blend) {
        unused.take(b"PQ");
    }
    let work_offset = block.work_offset.unwrap_or(state.work_offset);

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
            offsets = set_offset(state, block, axes, mm, work_offset, tlo)?;
            unused.take(b"LP");
        }
        Some(NonModal::Shift) => {
            if !axes.any() {
                let command = "G92";
                return at_group(Group::NonModal, Complaint::AxisWordsMissing { command });
            }
            let (mut g92, mut position) = (state.g92, start);
            for (i, letter) in (b'X'..=b'Z').enumerate() {
                if let Some(v) = block.get(letter) {
                    // machine = work + rest + g92 stays, work becomes v.
                    g92[i] += start[i] - v * mm;
                    position[i] = v * mm;
                }
            }
            offsets = Offsets::Shift { g92, position };
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
    let strict = dialect == Dialect::Grbl || user == AxisUser::Motion;
    if motion == MotionMode::None && axes.any() && strict {
        let first = (b'X'..=b'Z').find(|&l| block.has(l)).unwrap_or(b'X');
        return at(first, Complaint::AxisWordsWithoutMotion);
    }

    let distance = block.distance.unwrap_or(state.distance);
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
    match block.non_modal {
        Some(go @ (NonModal::GoHome | NonModal::GoSecondHome)) => {
            let stored = match go {
                NonModal::GoHome => state.g28,
                _ => state.g30,
            } - offset;
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
        _ if user == AxisUser::Motion || jog => {
            action = motion_of(Course {
                state,
                block,
                motion,
                feed,
                plane,
                start: &start,
                to: &to,
                machine,
                moves: axes.any() || jog,
                unused: &mut unused,
            })?;
        }
        _ => {}
    }

    if user != AxisUser::Nobody {
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
        speed: block.get(b'S').map_or(state.speed, Rpm),
        tool: match (block.get(b'T'), dialect) {
            (Some(t), _) => t as u32,
            // GRBL forgets the tool with the next block that has no T.
            (None, Dialect::Grbl) => 0,
            (None, _) => state.tool,
        },
        dwell,
        plane,
        units,
        motion,
        work_offset,
        tlo,
        offsets,
        action,
    })
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
            let h = block.value(b'H');
            if h.fract() != 0.0 || h > 1e6 {
                let (letter, least) = ('H', 0);
                return fault(Some(b'H'), Complaint::WholeNumber { letter, least });
            }
            unused.take(b"H");
            state.tlo
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
    let number = block.value(b'P').trunc();
    if number > 6.0 {
        return Err(Fault::at(block.at(b'P'), Complaint::WorkOffset { number }));
    }
    let l = block.value(b'L').trunc();
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
        MotionMode::None => return Ok(Move::None),
        MotionMode::Rapid => MotionKind::Rapid,
        _ => MotionKind::Feed,
    };
    if kind == MotionKind::Feed && feed == 0.0 {
        return here(Complaint::FeedMissing);
    }
    match motion {
        MotionMode::None | MotionMode::Rapid | MotionMode::Linear if !moves => Ok(Move::None),
        MotionMode::None | MotionMode::Rapid | MotionMode::Linear => {
            Ok(Move::Straight { kind, to, machine })
        }
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
            let linuxcnc = state.dialect == Dialect::LinuxCnc;
            let (axis_names, words) = arc::names(plane);
            let [a, b, _] = plane.axes();
            let in_plane = |first: u8| block.has(first + a as u8) || block.has(first + b as u8);
            // LinuxCNC takes a full circle without an end point.
            let whole = linuxcnc && in_plane(b'I') && !block.has(b'R');
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
                    Ok(None) if !linuxcnc => {
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
                match arc::by_center(state.dialect, plane, start, &to, &center, clockwise) {
                    Ok(arc) => arc,
                    Err(complaint) => return here(complaint),
                }
            };
            let mut arc = arc;
            if linuxcnc && let Some(turns) = block.get(b'P') {
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
