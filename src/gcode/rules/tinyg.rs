//! TinyG and g2core.

use super::Meaning::*;
use super::common::*;
use super::{ArcMiss, BlockDelete, Entry, LineLength, OffsetTwenty, Parentheses, Rules};
use crate::gcode::codes::Letters;

const NO_CYCLES: &str = "drilling cycles are not built in here; write the moves out";

const OWN: &[Entry] = &[
    INVERSE_TIME,
    (2820, Refused(REFERENCE)),
    (
        2830,
        Refused("it renames the place where the machine stands in machine coordinates; use G92"),
    ),
    (2840, Refused(REFERENCE)),
    (3020, Refused(REFERENCE)),
    (
        4300,
        Refused("only g2core has it, TinyG reads on without; set the length by G10 L2 Z"),
    ),
    (9500, Refused("feed per turn is not built in here; use G94")),
    (7300, Refused(NO_CYCLES)),
    (8100, Refused(NO_CYCLES)),
    (8200, Refused(NO_CYCLES)),
    (8300, Refused(NO_CYCLES)),
    (
        9110,
        ArcDistance(crate::gcode::state::Distance::Incremental),
    ),
    (
        9010,
        Refused("absolute arc centres are read by g2core only; use G91.1"),
    ),
];

pub(super) static TINYG: Rules = Rules {
    title: "TinyG and g2core",
    source: "Synthetos wikis: TinyG Gcode Support, g2 Gcode Support",
    assumed: &["only what both firmwares read the same way is understood"],
    g: &[
        OWN,
        BASE,
        RADIUS,
        MOTION_OFF,
        &PROBE_STRICT,
        OFFSETS,
        STORED_HOMES,
        PATHS,
        SHIFTS,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, M_PALLET],
    letters: Letters::of(b"FIJKLNPRSTXYZ"),
    length: LineLength::All(254),
    parentheses: Parentheses::Last,
    block_delete: BlockDelete::No,
    arc_miss: ArcMiss::Grbl,
    whole_circle: false,
    twenty: OffsetTwenty::No,
    ..PLAIN
};

const PROBE_STRICT: [Entry; 1] = [PROBES[0]];
