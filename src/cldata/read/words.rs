//! The words of the vocabulary that are not carried out: harmless ones, and those that are refused by name.
//!
//! From ISO 4343 and the vocabularies of CATIA's, NX's and Creo's output. A word is harmless when leaving it out changes no motion, no
//! switching and no stop of a program for three axes.

/// Statements that are read.
pub(super) const READ: [&str; 44] = [
    "GOTO", "GODLTA", "FROM", "RAPID", "FEDRAT", "SPINDL", "COOLNT", "LOADTL", "LOAD", "TLDATA",
    "CUTTER", "CIRCLE", "MOVARC", "INDIRV", "INDIRP", "TLON", "UNITS", "MULTAX", "TLAXIS", "MODE",
    "PPRINT", "PARTNO", "REMARK", "TPRINT", "MACHIN", "DELAY", "DWELL", "STOP", "OPSTOP", "END",
    "FINI", "ORIGIN", "TRANS", "TRACUT", "AUXFUN", "CUTCOM", "CYCLE", "CLEARP", "RETRCT", "GOHOME",
    "MSYS", "OPSKIP", "REWIND", "TOOLNO",
];

/// Harmless words: passed over with a note.
pub(super) const HARMLESS: [&str; 26] = [
    // Colours and speeds of the picture on the CAD system's screen.
    "PAINT",
    "DISPLY",
    "TMARK",
    // Listings and numbers of blocks: the post numbers its own.
    "CLPRNT",
    "NOPOST",
    "SEQNO",
    "LEADER",
    "LETTER",
    "PRINT",
    "PUNCH",
    // Tolerances of points that are computed already.
    "INTOL",
    "OUTTOL",
    "TOLER",
    "CUTTOL",
    "LINTOL",
    // Which tool will be wanted later: getting it ready moves no axis.
    "SELECT",
    "SELCTL",
    "SELECTL",
    // How the drive surfaces of the following arc lie; the arc says it itself.
    "AUTOPS",
    "NOPS",
    // Names and ends of operations.
    "END-OF-PATH",
    "ENDOFPATH",
    "OPERATION",
    "START",
    "CATPROCESS",
    "TITLE",
];

/// Words that are refused, and why.
pub(super) const REFUSED: [(&str, &str); 48] = [
    (
        "INSERT",
        "it puts text of one controller into the program, which no other can read: say it in APT words, or remove it and put it into the post's header",
    ),
    (
        "PPFUN",
        "it speaks to one post-processor only: say it in APT words, or remove it",
    ),
    (
        "PREFUN",
        "it is a G code of one controller: say it in APT words, or remove it",
    ),
    (
        "ARC",
        "its numbers mean different things in different systems: output arcs as CIRCLE or MOVARC",
    ),
    (
        "ARCSLP",
        "helices by ARCSLP are not read: output MOVARC and GOTO with the height of its end",
    ),
    (
        "CYLNDR",
        "arcs on a cylinder are not read: output CIRCLE or points",
    ),
    (
        "PSIS",
        "a part surface needs an APT processor: output points or CIRCLE",
    ),
    (
        "GOFWD",
        "drive surfaces need an APT processor: output points, CIRCLE or INDIRV with TLON,GOFWD/(CIRCLE/..),ON,(LINE/..)",
    ),
    (
        "GOBACK",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "GOLFT",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "GORGT",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "GOUP",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "GODOWN",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "GO",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "TLLFT",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "TLRGT",
        "drive surfaces need an APT processor: output points or CIRCLE",
    ),
    (
        "POINT",
        "geometry needs an APT processor: output CL data, not the part program",
    ),
    (
        "LINE",
        "geometry needs an APT processor: output CL data, not the part program",
    ),
    (
        "PLANE",
        "geometry needs an APT processor: output CL data, not the part program",
    ),
    (
        "MATRIX",
        "geometry needs an APT processor: output CL data, not the part program",
    ),
    (
        "LOOPST",
        "loops need an APT processor: output CL data, not the part program",
    ),
    (
        "JUMPTO",
        "jumps need an APT processor: output CL data, not the part program",
    ),
    (
        "IF",
        "jumps need an APT processor: output CL data, not the part program",
    ),
    (
        "MACRO",
        "macros need an APT processor: output CL data, not the part program",
    ),
    (
        "TERMAC",
        "macros need an APT processor: output CL data, not the part program",
    ),
    (
        "CALL",
        "macros need an APT processor: output CL data, not the part program",
    ),
    (
        "COPY",
        "copies of motions are not made here: output each motion",
    ),
    (
        "INDEX",
        "copies of motions are not made here: output each motion",
    ),
    (
        "DNTCUT",
        "it drops motions up to CUT: remove them in the CAM system",
    ),
    (
        "ROTABL",
        "a rotary table turns the part: this is data for more than three axes; output each side as a file of its own",
    ),
    (
        "ROTATE",
        "a rotary axis turns: this is data for more than three axes; output each side as a file of its own",
    ),
    (
        "ROTHED",
        "a head turns: this is data for more than three axes; output each side as a file of its own",
    ),
    (
        "TURRET",
        "turrets are of lathes: this program posts three-axis mills",
    ),
    (
        "HEAD",
        "which head works cannot be posted: output the file for one head",
    ),
    (
        "THREAD",
        "threading needs a spindle that follows: it cannot be posted",
    ),
    (
        "PITCH",
        "threading needs a spindle that follows: it cannot be posted",
    ),
    ("PROBE", "probing cannot be posted: remove it"),
    (
        "SAFPOS",
        "the safe place is the machine's and is not known here: write RAPID and GOTO with its coordinates",
    ),
    (
        "SAFETY",
        "the safe place is not known here: write RAPID and GOTO with its coordinates",
    ),
    (
        "SYN",
        "it gives words other names: write the words themselves",
    ),
    (
        "CLAMP",
        "clamping cannot be posted: remove it, and clamp by hand behind STOP",
    ),
    (
        "UNCLMP",
        "clamping cannot be posted: remove it, and unclamp by hand behind STOP",
    ),
    ("COUPLE", "a coupled spindle cannot be posted"),
    (
        "CSYS",
        "a coordinate system of the part cannot be told apart from the machine's: output points in the machining system",
    ),
    (
        "MCS",
        "a coordinate system of the part cannot be told apart from the machine's: output points in the machining system",
    ),
    (
        "ZERO",
        "a work offset by number means different things in different systems: choose it in the post",
    ),
    (
        "SET",
        "offsets by SET mean different things in different systems: choose them in the post",
    ),
    ("CHECK", "checks by the machine cannot be posted: remove it"),
];

/// Why a word is refused, if it is.
pub(super) fn refused(word: &str) -> Option<&'static str> {
    REFUSED.iter().find(|r| r.0 == word).map(|r| r.1)
}

/// The harmless word as the table has it.
pub(super) fn harmless(word: &str) -> Option<&'static str> {
    HARMLESS.into_iter().find(|h| *h == word)
}

/// Every word with a meaning here, for "did you mean".
pub(super) fn known() -> impl Iterator<Item = &'static str> {
    READ.into_iter()
        .chain(HARMLESS)
        .chain(REFUSED.iter().map(|r| r.0))
}
