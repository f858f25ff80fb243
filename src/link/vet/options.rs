//! What a program is vetted against.

use crate::gcode::{Dialect, State};
use crate::link::introduction::Known;
use crate::wire::{Firmware, RX_BYTES};

/// How a program is vetted. Lengths mm.
#[derive(Clone, Debug, PartialEq)]
pub struct VetOptions {
    /// Whose rules hold. The dialect of `start` should be this firmware's.
    pub firmware: Firmware,
    /// Receive buffer, bytes.
    pub rx_bytes: usize,
    /// What the controller remembers before the first line, offsets and position included. The session brings the modes about;
    /// offsets and position are the controller's.
    pub start: State,
    /// Lines to send before the program's (a resume's way back to the cut), vetted as line 0.
    pub entry: Vec<String>,
    /// First line of the program to send, from 1; those before are skipped unread.
    pub first_line: usize,
    /// Where the machine can go.
    pub limits: Limits,
    /// G10, G28.1, G30.1, `$n=value` in the program.
    pub memory_writers: MemoryWriters,
    /// M6 in the program.
    pub tool_changes: ToolChanges,
    /// M1 in the program.
    pub optional_stops: OptionalStops,
    /// Lines that begin with `/`.
    pub block_delete: BlockDelete,
}

impl Default for VetOptions {
    fn default() -> Self {
        VetOptions {
            firmware: Firmware::Grbl11,
            rx_bytes: RX_BYTES,
            start: State::new(Dialect::Grbl),
            entry: Vec::new(),
            first_line: 1,
            limits: Limits::None,
            memory_writers: MemoryWriters::Refuse,
            tool_changes: ToolChanges::Stop,
            optional_stops: OptionalStops::Ignore,
            block_delete: BlockDelete::Refuse,
        }
    }
}

impl VetOptions {
    /// For a controller that has introduced itself; `machine_travel` (mm, of the machine file) stands in for what it does not tell.
    pub fn of(known: &Known, machine_travel: Option<[f64; 3]>) -> VetOptions {
        VetOptions {
            firmware: known.firmware,
            rx_bytes: known.rx_bytes,
            start: known.start(),
            limits: Limits::of(known, machine_travel),
            ..VetOptions::default()
        }
    }
}

/// Where the machine can go, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// Nobody knows.
    None,
    /// Machine coordinates: the machine homes, and the controller told travel, offsets and position.
    Box {
        /// Lowest.
        low: [f64; 3],
        /// Highest.
        high: [f64; 3],
        /// Soft limits are on ($20=1): the controller itself answers ALARM:2.
        soft: bool,
    },
    /// Only how far the program may reach from end to end: where the machine stands is not known.
    Size {
        /// Travel of each axis.
        size: [f64; 3],
        /// Who says so.
        told_by: ToldBy,
    },
}

/// Who named the travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToldBy {
    /// `$130` to `$132`.
    Controller,
    /// The machine file.
    MachineFile,
}

impl Limits {
    /// From `$130`-`$132`, `$22`, `$23`, `$#` and the report where there are any, else from the machine file.
    ///
    /// GRBL 1.1 counts all travel below zero, whatever corner it homes to ($23); builds with the origin forced (OPT letter Z) count
    /// from the home corner, so an axis that homes at its low end has travel above zero.
    pub fn of(known: &Known, machine_travel: Option<[f64; 3]>) -> Limits {
        let told = |i: u16| known.setting(130 + i).filter(|t| *t > 0.0);
        let (Some(x), Some(y), Some(z)) = (told(0), told(1), told(2)) else {
            return machine_travel.map_or(Limits::None, |size| Limits::Size {
                size,
                told_by: ToldBy::MachineFile,
            });
        };
        let size = [x, y, z];
        let on = |n| known.setting(n).is_some_and(|v| v != 0.0);
        let placed = known.machine_position.is_some()
            && known.offsets.g92.is_some()
            && known.offsets.g5x.iter().all(Option::is_some);
        // FluidNC's travel is in its own file; its `$13x` say how long, not where.
        let grbl_frame = matches!(known.firmware, Firmware::Grbl11 | Firmware::GrblHal);
        if !(on(22) && placed && grbl_frame) || known.homed == Some(false) {
            let told_by = ToldBy::Controller;
            return Limits::Size { size, told_by };
        }
        let forced = known.letters.contains('Z');
        let low_home = known.setting(23).map_or(0, |mask| mask as u32);
        let up: [bool; 3] = std::array::from_fn(|i| forced && low_home & (1 << i) != 0);
        Limits::Box {
            low: std::array::from_fn(|i| if up[i] { 0.0 } else { -size[i] }),
            high: std::array::from_fn(|i| if up[i] { size[i] } else { 0.0 }),
            soft: on(20),
        }
    }
}

/// What becomes of commands that write the controller's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryWriters {
    /// Refused by name.
    Refuse,
    /// Sent alone, with all else answered before and a pause behind.
    Barrier,
}

/// What becomes of M6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolChanges {
    /// Refused.
    Refuse,
    /// Taken out: spindle and coolant off, standstill, and a prompt.
    Stop,
}

/// What becomes of M1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OptionalStops {
    /// Sent as it is, which GRBL accepts and does not stop at.
    Ignore,
    /// Sent as M0.
    Stop,
}

/// What becomes of lines that begin with `/`, which GRBL would run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockDelete {
    /// Refused.
    Refuse,
    /// Left out.
    Skip,
    /// Sent without the slash.
    Keep,
}
