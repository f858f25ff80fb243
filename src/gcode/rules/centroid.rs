//! Centroid CNC12, mill.

use super::Meaning::*;
use super::common::*;
use super::{Entry, OffsetTwenty, Rules, Unit};
use crate::gcode::codes::{Letters, NonModal};
use crate::gcode::cycle::CycleRules;

const OWN: &[Entry] = &[
    (
        1000,
        Refused("here it writes the control's own tables and parameters; set them at the control"),
    ),
    (1210, Refused(POLAR)),
    (2800, NonModal(NonModal::GoHome)),
    (3000, NonModal(NonModal::GoSecondHome)),
    (9200, NonModal(NonModal::Shift)),
    (5200, NonModal(NonModal::Local)),
    (
        11700,
        Refused("it sets a turned plane; post the path in G17"),
    ),
    (
        11800,
        Refused("it sets a turned plane; post the path in G18"),
    ),
    (
        11900,
        Refused("it sets a turned plane; post the path in G19"),
    ),
];

const OWN_M: &[Entry] = &[
    (1000, Refused(PORTS)),
    (1100, Refused(PORTS)),
    (
        2500,
        Refused(
            "here it moves Z to its home, the first return point (elsewhere it does something else or nothing); use G53 or G28",
        ),
    ),
    (
        2600,
        Refused("it sets an axis to its home; do that at the control"),
    ),
    (9100, Refused(REFERENCE)),
    (9200, Refused(REFERENCE)),
    (9400, Refused(PORTS)),
    (9500, Refused(PORTS)),
    (
        10000,
        Refused("it waits for an input, which cannot be foreseen"),
    ),
    (
        10100,
        Refused("it waits for an input, which cannot be foreseen"),
    ),
];

/// Parameters 77 (G73) and 82 (G83) of the control.
static CYCLE_RULES: CycleRules = CycleRules {
    back: 1.27,
    repeats: b"",
    dwell: Unit::Seconds,
    ..CycleRules::INDUSTRY
};

pub(super) static CENTROID: Rules = Rules {
    title: "Centroid CNC12 Mill",
    source: "Centroid CNC12 Mill Operator's Manual, chapters 12 and 13 (G-codes, M-functions)",
    assumed: &[
        "M7 and M8 may run together (the PLC program as delivered lets each switch the other off)",
        "a rapid goes straight (the control moves Z by itself, first when it goes up, last when it goes down)",
        "G73 and G83 back off by 1.27 mm",
        "G28 and G30 go to machine zero (the return points of the control's setup)",
        "T of the same line is the tool that M6 puts in",
    ],
    g: &[
        OWN,
        BASE,
        RADIUS,
        CYCLE_OFF,
        TABLE_LENGTH,
        PLAIN_PATHS,
        RETRACTS,
        &[G73, G81, G82, G83, G85, G89],
        OTHER_CYCLES,
        &[INVERSE_TIME],
        INDUSTRY,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, M_ORIENT, OWN_M],
    letters: Letters::of(b"FHIJKLNOPQRSTXYZ"),
    tool_limit: 200,
    home_beside_motion: true,
    length_needs_h: true,
    dwell: &[(b'P', Unit::Seconds), (b'X', Unit::Seconds)],
    dwell_words: "P or X (seconds)",
    twenty: OffsetTwenty::No,
    cycles: Some(&CYCLE_RULES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};
