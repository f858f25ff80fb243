//! Marlin, Smoothieware, RepRapFirmware: firmwares that come from 3D printers, with codes that mean something else elsewhere.

use super::Meaning::*;
use super::common::*;
use super::{
    ArcMiss, BlockDelete, Entry, LineLength, OffsetTwenty, Parentheses, Rules, ToolWord, Unit,
};
use crate::gcode::codes::{Group, Letters};

const LEVELLING: &str = "here it measures the bed; do that before the program";
const FAN: &str = "here it is a fan (some wire a spindle to it); use M3 and M5";
const MOTORS: &str = "it lets go of the motors, and the position is lost; remove it";
const HEAT: &str = "it heats, and a mill has nothing to heat; remove it";
const TUNING: &str = "it changes how the machine moves; set that at the machine";
const MESSAGE: &str = "it shows a text, which is not read; write it as a comment behind ;";
/// The firmwares have hundreds of these, for printing, settings and questions.
const NO_MILLING: Option<&str> = Some(
    "what it does is not read here (printing, settings, questions to the firmware); remove it",
);
const NO_CYCLES: &str = "drilling cycles are not built in here; write the moves out";

const PRINTER: &[Entry] = &[
    (2800, Refused(HOMING)),
    (2900, Refused(LEVELLING)),
    (1100, Refused(RETRACTS_FILAMENT)),
    (8100, Refused(NO_CYCLES)),
    (8200, Refused(NO_CYCLES)),
    (8300, Refused(NO_CYCLES)),
    (7300, Refused(NO_CYCLES)),
];

const PRINTER_M: &[Entry] = &[
    (3000, Refused(DELETES_FILE)),
    (1700, Nothing(Group::Motors, NONE, "motors on")),
    (1800, Refused(MOTORS)),
    (8400, Refused(MOTORS)),
    (8200, Refused(EXTRUDER)),
    (8300, Refused(EXTRUDER)),
    (9200, Refused(TUNING)),
    (10400, Refused(HEAT)),
    (10900, Refused(HEAT)),
    (10600, Refused(FAN)),
    (10700, Refused(FAN)),
    (14000, Refused(HEAT)),
    (19000, Refused(HEAT)),
    (20100, Refused(TUNING)),
    (20300, Refused(TUNING)),
    (20400, Refused(TUNING)),
    (20500, Refused(TUNING)),
    (22000, Refused(TUNING)),
    (22100, Refused(TUNING)),
    (40000, Wait),
    (
        11000,
        Nothing(Group::Data, NONE, "sets the number of the line"),
    ),
    (11700, Refused(MESSAGE)),
    (11800, Refused(MESSAGE)),
];

const E: (u8, &str) = (b'E', EXTRUDER);

/// The codes are those of a plain build: what is an option there (inches, planes, coordinate systems) is refused, since a firmware without
/// the option reads on and moves elsewhere.
const MARLIN_OWN: &[Entry] = &[
    (500, Refused(SPLINE)),
    (1000, Refused(RETRACTS_FILAMENT)),
    (1200, Refused("it cleans a nozzle; remove it")),
    (
        1800,
        Refused(
            "planes are an option of the build, and a firmware without it cuts the arc in X and Y; use lines",
        ),
    ),
    (
        1900,
        Refused(
            "planes are an option of the build, and a firmware without it cuts the arc in X and Y; use lines",
        ),
    ),
    (
        2000,
        Refused(
            "inches are an option of the build, and a firmware without it takes them for millimetres; post in millimetres",
        ),
    ),
    (2700, Refused("it parks by the firmware's settings; use G0")),
    (
        3000,
        Refused(
            "here it probes the bed at one point (elsewhere it goes to a stored place); remove it",
        ),
    ),
    (3500, Refused(LEVELLING)),
    (
        5300,
        Refused("coordinate systems are an option of the build; post in work coordinates"),
    ),
    (
        5500,
        Refused("coordinate systems are an option of the build; use G92"),
    ),
    (
        5600,
        Refused("coordinate systems are an option of the build; use G92"),
    ),
    (
        5700,
        Refused("coordinate systems are an option of the build; use G92"),
    ),
    (
        5800,
        Refused("coordinate systems are an option of the build; use G92"),
    ),
    (
        5900,
        Refused("coordinate systems are an option of the build; use G92"),
    ),
    (6000, Refused("it stores a position; remove it")),
    (
        6100,
        Refused("here it returns to a stored position (elsewhere it means exact stop); remove it"),
    ),
    (9200, NonModal(crate::gcode::codes::NonModal::Shift)),
];

pub(super) static MARLIN: Rules = Rules {
    title: "Marlin 2",
    source: "Marlin documentation (marlinfw.org, G-code index) and Configuration_adv.h",
    assumed: &[
        "a plain build: no inches, no planes but XY, no work offsets beyond the first, no parentheses as comments",
        "G54 stands for the coordinate system in force",
        "G0 runs at the F in force, as G1 does",
    ],
    g: &[MARLIN_OWN, PRINTER, BASE, RADIUS, MOTION_OFF],
    m: &[
        &[
            (100, Stop(crate::gcode::codes::Stop::Pause)),
            (
                200,
                Refused(
                    "Marlin has no end of program; switch off by M5 and M9 and let the file end",
                ),
            ),
            (
                600,
                Refused("tools are changed by the machine's own script here; pause by M0"),
            ),
        ],
        PRINTER_M,
        M_BASE,
        &[M_MIST],
    ],
    letters: Letters::of(b"FIJNPRSXYZ"),
    refused: &[
        E,
        (
            b'T',
            "here it switches to another extruder at once; pause by M0 for a tool change",
        ),
    ],
    length: LineLength::BeforeComment(95),
    parentheses: Parentheses::No,
    block_delete: BlockDelete::No,
    checksum: true,
    dwell: &[(b'P', Unit::Milliseconds), (b'S', Unit::Seconds)],
    dwell_words: "P (milliseconds) or S (seconds)",
    whole_circle: true,
    twenty: OffsetTwenty::No,
    other_m: NO_MILLING,
    ..PLAIN
};

const SMOOTHIE_OWN: &[Entry] = &[
    (1000, NonModal(crate::gcode::codes::NonModal::SetOffset)),
    (
        3000,
        Refused(
            "here it probes the bed at one point (elsewhere it goes to a stored place); remove it",
        ),
    ),
    (2810, Refused(HOMING)),
    (2820, Refused(HOMING)),
    (3100, Refused(LEVELLING)),
    (3200, Refused(LEVELLING)),
    (9200, NonModal(crate::gcode::codes::NonModal::Shift)),
    CLEAR_SHIFT,
];

pub(super) static SMOOTHIE: Rules = Rules {
    title: "Smoothieware, CNC build",
    source: "Smoothieware documentation (Supported G-codes, G-code sender compatibility), Robot.cpp, GcodeDispatch.cpp",
    assumed: &[
        "G4 takes S only: P is seconds in grbl mode and milliseconds else",
        "F of a G0 line is the speed of rapids alone",
        "full circles in G18 turn as G2 and G3 say (the firmware runs them the other way round)",
    ],
    g: &[
        SMOOTHIE_OWN,
        PRINTER,
        BASE,
        RADIUS,
        NINE_OFFSETS,
        PROBES,
        MOTION_OFF,
        DYNAMIC_LENGTH,
    ],
    m: &[
        &[(
            600,
            Refused("tools are changed by an option of the build here; pause by M0"),
        )],
        PRINTER_M,
        M_BASE,
        &[M_MIST],
    ],
    letters: Letters::of(b"FIJKLNPSXYZ"),
    refused: &[
        E,
        (
            b'R',
            "this firmware does not read it, so that the arc would run elsewhere; give the centre by I, J, K",
        ),
        (
            b'T',
            "here it switches to another extruder at once; pause by M0 for a tool change",
        ),
    ],
    length: LineLength::BeforeComment(131),
    parentheses: Parentheses::Last,
    block_delete: BlockDelete::No,
    checksum: true,
    dwell: &[(b'S', Unit::WholeSeconds)],
    dwell_words: "S (whole seconds; P depends on the mode)",
    arc_miss: ArcMiss::Grbl,
    offsets: 9,
    rapid_feed_apart: true,
    other_m: NO_MILLING,
    ..PLAIN
};

const REPRAP_OWN: &[Entry] = &[
    (1000, NonModal(crate::gcode::codes::NonModal::SetOffset)),
    (
        3000,
        Refused(
            "here it probes the bed at one point (elsewhere it goes to a stored place); remove it",
        ),
    ),
    (3800, Refused("name the probe move by G38.2 to G38.5")),
    (6000, Refused("it stores a position; remove it")),
    (6100, Refused("here it is no exact stop; remove it")),
    (6800, Refused(ROTATION)),
    (6900, Nothing(Group::Rotation, NONE, "rotation off")),
    (9200, NonModal(crate::gcode::codes::NonModal::Shift)),
    INVERSE_TIME,
];

pub(super) static REPRAP: Rules = Rules {
    title: "RepRapFirmware 3, CNC mode",
    source: "Duet3D documentation (GCode dictionary), CNC mode (M453)",
    assumed: &[
        "G0 moves as fast as the machine goes in CNC mode; its F does not touch the feed of G1",
        "M0 ends the job here, and so it is read",
    ],
    g: &[
        REPRAP_OWN,
        PRINTER,
        BASE,
        RADIUS,
        NINE_OFFSETS,
        PROBES,
        MOTION_OFF,
    ],
    m: &[
        &[
            (0, Stop(crate::gcode::codes::Stop::End)),
            (
                100,
                Refused(
                    "here it ends the job and sleeps (elsewhere an optional stop); use M226 or M0",
                ),
            ),
            (22600, Stop(crate::gcode::codes::Stop::Pause)),
            (
                600,
                Refused("a T word changes the tool at once here; write T"),
            ),
            (
                98_00,
                Refused(
                    "macro files lie on the machine and cannot be read here; write out what they do",
                ),
            ),
            (
                45300,
                Nothing(Group::Motors, Letters::of(b"PRST"), "CNC mode"),
            ),
        ],
        PRINTER_M,
        M_BASE,
        &[M_MIST],
    ],
    letters: Letters::of(b"FHIJKLNPRSTXYZ"),
    refused: &[E],
    tool_limit: 49,
    tool_word: ToolWord::AtOnce,
    length: LineLength::BeforeComment(255),
    parentheses: Parentheses::Strict,
    block_delete: BlockDelete::No,
    checksum: true,
    dwell: &[(b'P', Unit::Milliseconds), (b'S', Unit::Seconds)],
    dwell_words: "P (milliseconds) or S (seconds)",
    offsets: 9,
    spindle_p: true,
    rapid_feed_apart: true,
    other_m: NO_MILLING,
    ..PLAIN
};
