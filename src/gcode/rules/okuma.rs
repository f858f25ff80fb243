//! Okuma OSP, machining centre: Fanuc's letters with meanings of their own.

use super::Meaning::*;
use super::common::*;
use super::{BlockDelete, Entry, OffsetTwenty, Rules, Semicolon, Unit};
use crate::gcode::codes::{Group, Letters, ToolLength};

const AXIS_LENGTH: &str = "here it is a tool length offset on another axis (elsewhere a work offset); work offsets are G15 H";
const LEVELS: &str = "here cycles return to the level of G71 and M53; write the moves out";
const ONE_LINE: &str =
    "here it takes a work offset for one line (elsewhere polar coordinates); use G15 H";

const OWN: &[Entry] = &[
    (
        1500,
        WorkOffsetBy {
            letter: b'H',
            base: 0,
            most: 200,
        },
    ),
    (1600, Refused(ONE_LINE)),
    (5300, ToolLength(ToolLength::Cancel)),
    (5400, Refused(AXIS_LENGTH)),
    (5500, Refused(AXIS_LENGTH)),
    (5600, ToolLength(ToolLength::Table)),
    (5700, Refused(AXIS_LENGTH)),
    (5800, Refused(AXIS_LENGTH)),
    (5900, Refused(AXIS_LENGTH)),
    (
        1000,
        Nothing(
            Group::Rotation,
            NONE,
            "parallel shift and rotation off (G11)",
        ),
    ),
    (1100, Refused(ROTATION)),
    (
        2800,
        Refused(
            "here it cancels a chamfer or a corner (elsewhere it goes home); use G30 P at the control's home positions",
        ),
    ),
    (
        3000,
        Refused(
            "here it goes to home position P of the control (elsewhere to a stored place by way of a point); its place is not known here",
        ),
    ),
    (
        4300,
        Refused(
            "here it cancels a 3D offset (elsewhere it is a tool length); tool length here is G56 H",
        ),
    ),
    (
        4400,
        Refused("here it is a 3D offset (elsewhere a tool length); tool length here is G56 H"),
    ),
    (
        4900,
        Refused("tool length here is cancelled by G53; write that"),
    ),
    (
        5200,
        Refused("here it is no local coordinate system; use G15 H"),
    ),
    (
        9200,
        Refused("here it shifts the work zero in the control's table; use G15 H"),
    ),
    (7100, Refused(LEVELS)),
    (7300, Refused(LEVELS)),
    (7400, Refused(TAPPING)),
    (7600, Refused(BACK_BORING)),
    (8100, Refused(LEVELS)),
    (8200, Refused(LEVELS)),
    (8300, Refused(LEVELS)),
    (8400, Refused(TAPPING)),
    (8500, Refused(LEVELS)),
    (8600, Refused(LEVELS)),
    (8700, Refused(BACK_BORING)),
    (8900, Refused(LEVELS)),
    (
        900,
        Nothing(Group::ExactStop, NONE, "exact stop in this line"),
    ),
    (5000, Nothing(Group::Scaling, NONE, "scaling off")),
    (5100, Refused(SCALING)),
    (6200, Refused(MIRROR)),
    (6100, Path(crate::gcode::codes::Path::Stop)),
    (
        6400,
        Nothing(
            Group::Path,
            NONE,
            "cutting mode, corners as the control likes",
        ),
    ),
    (
        4000,
        Nothing(Group::CutterRadius, NONE, "cutter compensation off"),
    ),
    PER_TURN,
];

const NO_PROGRAMS: &str = "subprograms are called by CALL and end with RTS here, which is not read; write their moves out";

const OWN_M: &[Entry] = &[
    (9800, Refused(NO_PROGRAMS)),
    (9900, Refused(NO_PROGRAMS)),
    (5200, Refused(LEVELS)),
    (5300, Refused(LEVELS)),
    (5400, Refused(LEVELS)),
    (
        13000,
        Refused("it lets the axes move while the spindle stands; start the spindle"),
    ),
    (
        700,
        Refused("what it switches is the machine builder's; remove it or use M8"),
    ),
];

pub(super) static OKUMA: Rules = Rules {
    title: "Okuma OSP, machining centre",
    source: "lists of OSP codes and open posts for Okuma (the maker's manual was not to be had in full)",
    assumed: &[
        "numbers of X Y Z I J K R F without a decimal point are refused: by a parameter they count whole units or the smallest steps",
        "dwells need a decimal point for the same reason",
        "T of the same line is the tool that M6 puts in",
    ],
    g: &[OWN, BASE, RADIUS, CYCLE_OFF],
    m: &[M_BASE, &[M_CHANGE], M_OVERRIDES, M_ORIENT, OWN_M],
    letters: Letters::of(b"FHIJKNOPQRSTXYZ"),
    pointed: Letters::of(b"XYZIJKRF"),
    tool_limit: 9999,
    semicolon: Semicolon::EndOfBlock,
    block_delete: BlockDelete::Levels,
    dwell: &[(b'F', Unit::Pointed), (b'P', Unit::Pointed)],
    dwell_words: "F or P (seconds, with a point)",
    length_needs_h: true,
    twenty: OffsetTwenty::No,
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};
