//! What most dialects share: RS-274 as NIST wrote it down (NISTIR 6556) and as the controls of the industry take it.

use super::Meaning::*;
use super::{
    ArcMiss, BlockDelete, Entry, LineLength, OffsetTwenty, Parentheses, Rules, Semicolon, ToolWord,
    Unit,
};
use crate::gcode::codes::{Coolant, Group, Letters, NonModal, Path, Stop, ToolLength};
use crate::gcode::cycle::Cycle;
use crate::gcode::event::Plane;
use crate::gcode::state::{Distance, FeedMode, MotionMode, Probe, Retract, Units};

pub(super) const NONE: Letters = Letters::of(b"");

pub(super) const COMPENSATION: &str = "cutter compensation moves the path by a radius that stands in the control's table; post the path of the tool centre and use G40";
pub(super) const POLAR: &str =
    "polar coordinates turn X and Y into radius and angle; post plain coordinates";
pub(super) const ROTATION: &str =
    "it turns the coordinate system; post the path as it shall be cut";
pub(super) const SCALING: &str = "it scales the path; post the path as it shall be cut";
pub(super) const MIRROR: &str = "it mirrors the path; post the path as it shall be cut";
pub(super) const TAPPING: &str = "tapping ties the feed to the turning spindle, which cannot be shown as plain moves; tap by other means";
pub(super) const BACK_BORING: &str =
    "this boring cycle orients the spindle and shifts the tool; write its moves out";
pub(super) const MANUAL_BORING: &str =
    "this boring cycle waits for a retract by hand; write its moves out";
pub(super) const THREADING: &str =
    "threading ties the feed to the turning spindle; it is no milling move";
pub(super) const SPLINE: &str = "splines are not supported; post lines or arcs";
pub(super) const SURFACE_SPEED: &str = "constant surface speed is for lathes; use G97 and S";
pub(super) const TOOL_POINT: &str = "tool centre point control needs rotary axes; use G43 H";
pub(super) const MINUS_LENGTH: &str =
    "it applies the tool length downward, which is hardly ever meant; use G43 H";
pub(super) const FROM_HOME: &str =
    "it returns from the reference point by way of a point stored earlier; name the way by G0";
pub(super) const SKIP: &str = "the skip move ends where a signal comes, which cannot be foreseen";
pub(super) const PORTS: &str =
    "it switches an output or waits for an input; what that does is not known here";
pub(super) const STATE_STACK: &str =
    "it saves or restores modes behind the program's back; name the modes in the program";
pub(super) const SET_TOOL: &str =
    "it renames the tool in the spindle without a change; use T and M6";
pub(super) const REFERENCE: &str = "here it homes the machine (elsewhere it stores a position); home before the program, not in it";
pub(super) const HOMING: &str = "here it homes the machine by its switches, without an intermediate point (elsewhere it goes to a stored place); home before the program, not in it";
pub(super) const DELETES_FILE: &str =
    "here it deletes a file (elsewhere it ends the program); remove it";
pub(super) const EXTRUDER: &str = "it moves an extruder, and a mill has none; remove it";
pub(super) const RETRACTS_FILAMENT: &str =
    "here it retracts filament (elsewhere it sets offsets); remove it";
pub(super) const NO_D: &str =
    "D names a cutter radius, and compensation is not supported; remove it";

/// M functions that builders (Fanuc, Haas, ...) or users (macros of Mach, UCCNC, ...) make.
pub(super) const BUILDERS_M: Option<&str> =
    Some("what it does on this machine is not known here; remove it, or write out what it does");
pub(super) const TILTED: &str =
    "it tilts the plane of work, which needs rotary axes; post the program for three axes";
pub(in crate::gcode) const TOOL_TABLE: &str =
    "it writes lengths or radii into the control's tool table; set them at the control";

/// Straight lines, arcs, planes, units, distances, G54 to G59, path of the tool centre.
pub(super) const BASE: &[Entry] = &[
    (0, Motion(MotionMode::Rapid)),
    (100, Motion(MotionMode::Linear)),
    (200, Motion(MotionMode::ArcClockwise)),
    (300, Motion(MotionMode::ArcCounterclockwise)),
    (400, NonModal(NonModal::Dwell)),
    (1700, Plane(Plane::Xy)),
    (1800, Plane(Plane::Zx)),
    (1900, Plane(Plane::Yz)),
    (2000, Units(Units::Inch)),
    (2100, Units(Units::Mm)),
    (
        4000,
        Nothing(Group::CutterRadius, NONE, "cutter compensation off"),
    ),
    (5300, NonModal(NonModal::MachineCoordinates)),
    (5400, WorkOffset(0)),
    (5500, WorkOffset(1)),
    (5600, WorkOffset(2)),
    (5700, WorkOffset(3)),
    (5800, WorkOffset(4)),
    (5900, WorkOffset(5)),
    (9000, Distance(Distance::Absolute)),
    (9100, Distance(Distance::Incremental)),
    (9400, FeedMode(FeedMode::PerMinute)),
];

pub(super) const RADIUS: &[Entry] = &[(4100, Refused(COMPENSATION)), (4200, Refused(COMPENSATION))];

pub(super) const INVERSE_TIME: Entry = (9300, FeedMode(FeedMode::InverseTime));
pub(super) const PER_TURN: Entry = (9500, FeedMode(FeedMode::PerTurn));

/// G80 among the motions, as NIST has it.
pub(super) const MOTION_OFF: &[Entry] = &[(8000, Motion(MotionMode::None))];
/// G80 in a group of its own.
pub(super) const CYCLE_OFF: &[Entry] = &[(8000, CycleOff)];

pub(super) const PROBES: &[Entry] = &[
    (
        3820,
        Motion(MotionMode::Probe(Probe {
            away: false,
            strict: true,
        })),
    ),
    (
        3830,
        Motion(MotionMode::Probe(Probe {
            away: false,
            strict: false,
        })),
    ),
    (
        3840,
        Motion(MotionMode::Probe(Probe {
            away: true,
            strict: true,
        })),
    ),
    (
        3850,
        Motion(MotionMode::Probe(Probe {
            away: true,
            strict: false,
        })),
    ),
];

/// G10, G28, G30, G92.
pub(super) const OFFSETS: &[Entry] = &[
    (1000, NonModal(NonModal::SetOffset)),
    (2800, NonModal(NonModal::GoHome)),
    (3000, NonModal(NonModal::GoSecondHome)),
    (9200, NonModal(NonModal::Shift)),
];

pub(super) const STORED_HOMES: &[Entry] = &[
    (2810, NonModal(NonModal::StoreHome)),
    (3010, NonModal(NonModal::StoreSecondHome)),
];

pub(super) const CLEAR_SHIFT: Entry = (9210, NonModal(NonModal::ClearShift));
/// G92.1, G92.2, G92.3.
pub(super) const SHIFTS: &[Entry] = &[
    CLEAR_SHIFT,
    (9220, NonModal(NonModal::SuspendShift)),
    (9230, NonModal(NonModal::RestoreShift)),
];

pub(super) const LOCAL: Entry = (5200, NonModal(NonModal::Local));

/// G59.1 to G59.3.
pub(super) const NINE_OFFSETS: &[Entry] = &[
    (5910, WorkOffset(6)),
    (5920, WorkOffset(7)),
    (5930, WorkOffset(8)),
];

pub(super) const ARC_CENTERS: &[Entry] = &[
    (9010, ArcDistance(Distance::Absolute)),
    (9110, ArcDistance(Distance::Incremental)),
];

pub(super) const DYNAMIC_LENGTH: &[Entry] = &[
    (4310, ToolLength(ToolLength::Dynamic)),
    (4900, ToolLength(ToolLength::Cancel)),
];

pub(super) const TABLE_LENGTH: &[Entry] = &[
    (4300, ToolLength(ToolLength::Table)),
    (4900, ToolLength(ToolLength::Cancel)),
];

pub(super) const PATHS: &[Entry] = &[
    (6100, Path(Path::Exact)),
    (6110, Path(Path::Stop)),
    (6400, Path(Path::Blend)),
];

/// G61, G64 without words.
pub(super) const PLAIN_PATHS: &[Entry] = &[
    (6100, Path(Path::Stop)),
    (
        6400,
        Nothing(
            Group::Path,
            NONE,
            "cutting mode, corners as the control likes",
        ),
    ),
];

pub(super) const RETRACTS: &[Entry] = &[
    (9800, Retract(Retract::Initial)),
    (9900, Retract(Retract::R)),
];

pub(super) const G73: Entry = (7300, Motion(MotionMode::Cycle(Cycle::ChipBreak)));
pub(super) const G81: Entry = (8100, Motion(MotionMode::Cycle(Cycle::Drill)));
pub(super) const G82: Entry = (8200, Motion(MotionMode::Cycle(Cycle::DrillDwell)));
pub(super) const G83: Entry = (8300, Motion(MotionMode::Cycle(Cycle::Peck)));
pub(super) const G85: Entry = (8500, Motion(MotionMode::Cycle(Cycle::Bore)));
pub(super) const G86: Entry = (8600, Motion(MotionMode::Cycle(Cycle::BoreStop)));
pub(super) const G89: Entry = (8900, Motion(MotionMode::Cycle(Cycle::BoreDwell)));

pub(super) const CYCLES: &[Entry] = &[G73, G81, G82, G83, G85, G86, G89];

/// Cycles that no plain moves can stand for.
pub(super) const OTHER_CYCLES: &[Entry] = &[
    (7400, Refused(TAPPING)),
    (7600, Refused(BACK_BORING)),
    (8400, Refused(TAPPING)),
    (8700, Refused(BACK_BORING)),
    (8800, Refused(MANUAL_BORING)),
];

/// What the industry's controls cancel in the first line of every program, and what is refused because it would move the path.
pub(super) const INDUSTRY: &[Entry] = &[
    (
        900,
        Nothing(Group::ExactStop, NONE, "exact stop in this line"),
    ),
    (1500, Nothing(Group::Polar, NONE, "polar coordinates off")),
    (1600, Refused(POLAR)),
    (1700, Plane(Plane::Xy)),
    (
        2300,
        Nothing(Group::Stroke, NONE, "stored stroke check off"),
    ),
    (
        2200,
        Refused("it sets a forbidden zone by axis words; set it at the control"),
    ),
    (
        2700,
        Refused("it checks the reference point and stops if the tool is elsewhere; use G28"),
    ),
    (2900, Refused(FROM_HOME)),
    (3100, Refused(SKIP)),
    (3300, Refused(THREADING)),
    (4400, Refused(MINUS_LENGTH)),
    (
        4310,
        Refused(
            "here it steers the tool axis or is an option (elsewhere it sets a length by Z); use G43 H",
        ),
    ),
    (4340, Refused(TOOL_POINT)),
    (4350, Refused(TOOL_POINT)),
    (
        4500,
        Refused("it lengthens the move by an offset; post plain coordinates"),
    ),
    (
        4600,
        Refused("it shortens the move by an offset; post plain coordinates"),
    ),
    (
        4700,
        Refused("it lengthens the move by an offset; post plain coordinates"),
    ),
    (
        4800,
        Refused("it shortens the move by an offset; post plain coordinates"),
    ),
    (5000, Nothing(Group::Scaling, NONE, "scaling off")),
    (5010, Nothing(Group::Mirror, NONE, "mirror image off")),
    (5100, Refused(SCALING)),
    (5110, Refused(MIRROR)),
    (
        6000,
        Refused("it approaches from one side by an amount set at the control; use G0"),
    ),
    (6200, Nothing(Group::Path, NONE, "corner override")),
    (6300, Refused(TAPPING)),
    (
        6600,
        Refused("modal macro calls run a program behind every move; call it by G65"),
    ),
    (6700, Nothing(Group::Macro, NONE, "modal macro call off")),
    (5310, Refused(TILTED)),
    (6800, Refused(ROTATION)),
    (6820, Refused(TILTED)),
    (6830, Refused(TILTED)),
    (6900, Nothing(Group::Rotation, NONE, "rotation off")),
    (6910, Nothing(Group::Rotation, NONE, "rotation off")),
    (9600, Refused(SURFACE_SPEED)),
    (
        9700,
        Nothing(
            Group::SpindleMode,
            NONE,
            "spindle speed in turns per minute",
        ),
    ),
];

/// M0, M1, M2, M30, M3 to M5, M8, M9.
pub(super) const M_BASE: &[Entry] = &[
    (0, Stop(Stop::Pause)),
    (100, Stop(Stop::OptionalPause)),
    (200, Stop(Stop::End)),
    (3000, Stop(Stop::End)),
    (300, Spindle(1)),
    (400, Spindle(-1)),
    (500, Spindle(0)),
    (800, Coolant(Coolant::Flood)),
    (900, Coolant(Coolant::Off)),
];

pub(super) const M_MIST: Entry = (700, Coolant(Coolant::Mist));
pub(super) const M_CHANGE: Entry = (600, ToolChange);
/// M6 and M7.
pub(super) const M_TOOLED: &[Entry] = &[M_CHANGE, M_MIST];
pub(super) const M_OVERRIDES: &[Entry] = &[
    (4800, Nothing(Group::Override, NONE, "overrides allowed")),
    (4900, Nothing(Group::Override, NONE, "overrides locked")),
];
pub(super) const M_ORIENT: &[Entry] = &[(1900, Spindle(0))];
pub(super) const M_PALLET: &[Entry] = &[(6000, Stop(Stop::Pause))];

pub(super) const P_SECONDS: &[(u8, Unit)] = &[(b'P', Unit::Seconds)];

/// The plainest dialect: everything else says where it differs.
pub(super) const PLAIN: Rules = Rules {
    title: "",
    source: "",
    assumed: &[],
    g: &[],
    m: &[],
    other_m: None,
    letters: Letters::of(b"FHIJKLNPQRSTXYZ"),
    refused: &[(b'D', NO_D)],
    positive: Letters::of(b"FHNPQST"),
    pointed: NONE,
    pointless: NONE,
    tool_limit: 99_999,
    tool_word: ToolWord::Select,
    tool_named: false,
    length: LineLength::Any,
    digits: 18,
    parentheses: Parentheses::Strict,
    semicolon: Semicolon::Comment,
    block_delete: BlockDelete::Switch,
    checksum: false,
    firmware: false,
    dwell: P_SECONDS,
    dwell_words: "P (seconds)",
    arc_miss: ArcMiss::LinuxCnc,
    whole_circle: true,
    blend_words: NONE,
    turns: false,
    machine_rapid: false,
    home_beside_motion: false,
    home_needs_axes: false,
    length_needs_h: false,
    twenty: OffsetTwenty::Measured,
    offsets_add: false,
    offsets: 6,
    offset_p: None,
    spindle_p: false,
    rapid_feed_apart: false,
    cycles: None,
};

const ELSEWHERE: Rules = Rules {
    letters: NONE,
    refused: &[],
    dwell: &[],
    ..PLAIN
};

pub(super) static SIEMENS: Rules = Rules {
    title: "Sinumerik 840D sl: read as a language of its own",
    ..ELSEWHERE
};

pub(super) static HEIDENHAIN: Rules = Rules {
    title: "Heidenhain TNC: read as a language of its own",
    ..ELSEWHERE
};
