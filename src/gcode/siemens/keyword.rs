//! Words of more than one letter: those that set a mode, those without effect on three axes, and those that are refused by name.

/// What a keyword without arguments does in a block of words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Keyword {
    /// Nothing that the path shows.
    Nothing,
    /// SUPA: no frames in this block.
    Suppress,
    /// COMPON, COMPCURV, COMPCAD, COMPSURF (true), COMPOF.
    Compressor(bool),
    /// STOPRE.
    StopPreprocessing,
}

/// What is said of smoothing, jerk, feed at arcs and dynamics, which changes times and not places, and of what is off anyway.
const NOTHING: [&str; 28] = [
    "SOFT",
    "BRISK",
    "DRIVE",
    "FFWON",
    "FFWOF",
    "CFC",
    "CFTCP",
    "CFIN",
    "TRAFOOF",
    "RTLION",
    "KONT",
    "KONTC",
    "KONTT",
    "NORM",
    "DIAMOF",
    "FNORM",
    "DYNNORM",
    "DYNROUGH",
    "DYNSEMIFIN",
    "DYNFINISH",
    "DYNPOS",
    "DYNPREC",
    "SPATH",
    "UPATH",
    "CUT2D",
    "CUT2DF",
    "WALIMON",
    "WALIMOF",
];

/// A keyword of a block, upper case.
pub(super) fn known(name: &str) -> Option<Keyword> {
    Some(match name {
        "SUPA" => Keyword::Suppress,
        "COMPON" | "COMPCURV" | "COMPCAD" | "COMPSURF" => Keyword::Compressor(true),
        "COMPOF" => Keyword::Compressor(false),
        "STOPRE" => Keyword::StopPreprocessing,
        _ if NOTHING.contains(&name) => Keyword::Nothing,
        _ => return None,
    })
}

/// Why a keyword is refused, upper case.
pub(super) fn refused(name: &str) -> Option<&'static str> {
    Some(match name {
        "TRAORI" | "TRANSMIT" | "TRACYL" | "TRAANG" | "CYCLE800" | "ORIWKS" | "ORIMKS"
        | "ORIAXES" | "ORIVECT" | "TOROT" | "TOFRAME" | "PAROT" => {
            "it turns the tool or the part, and this machine has three axes; remove it"
        }
        "RTLIOF" => "each axis would rapid at its own pace, off the straight line; write RTLION",
        "CIP" | "CT" => "write the arc as G2 or G3 with I J K or CR",
        "ASPLINE" | "BSPLINE" | "CSPLINE" | "POLY" => "post the curve as G1, G2 and G3",
        "CHF" | "CHR" | "RND" | "RNDM" | "FRC" | "FRCM" => "post the corner as G1, G2 or G3",
        "DIAMON" | "DIAM90" => "X would be read as a diameter; write DIAMOF",
        "FLIN" | "FCUB" | "FPO" => "the feed would change along the path; write FNORM",
        "FZ" => "write the feed in mm/min with G94 and F",
        "FB" => "write the feed of the block with F",
        "FGROUP" | "FGREF" | "FL" => {
            "the feed would hold for other axes than X, Y and Z together; remove it"
        }
        "ANG" => "post the point as X Y Z",
        "INVCW" | "INVCCW" => "post the curve as G1, G2 and G3",
        "AP" | "RP" => "post the point as X Y Z",
        "SPOS" | "SPOSA" | "SETMS" => "the spindle is only switched here; remove it",
        "CYCLE83" | "CYCLE84" | "CYCLE840" | "CYCLE85" | "CYCLE86" | "CYCLE87" | "CYCLE88"
        | "CYCLE89" | "HOLES1" | "HOLES2" | "POCKET3" | "POCKET4" | "SLOT1" | "SLOT2"
        | "LONGHOLE" | "CYCLE71" | "CYCLE72" | "CYCLE76" | "CYCLE77" | "CYCLE90" | "CYCLE61"
        | "CYCLE62" | "CYCLE63" | "CYCLE64" | "CYCLE801" | "CYCLE802" => {
            "this reader carries out CYCLE81 and CYCLE82; post the motions themselves"
        }
        "CALL" | "PCALL" | "EXTCALL" | "ISOCALL" | "EXTERN" => {
            "another file is not read; put the subprogram into this archive and call it by its name"
        }
        "SETAL" | "WRITE" | "READ" | "DELETE" | "MEAS" | "MEAW" | "STOPFIFO" | "STARTFIFO"
        | "WHEN" | "WHENEVER" | "EVERY" | "DO" | "IDS" | "ID" | "SAVE" | "CFINE" | "CTRANS"
        | "MEAFRAME" => "this reader does not carry it out; remove it",
        _ => return None,
    })
}

/// A name that can be a subprogram's: two letters at its front, and nothing that is refused or known.
pub(super) fn is_name(word: &str) -> bool {
    let letters = |b: u8| b.is_ascii_alphabetic() || b == b'_';
    word.len() >= 2
        && word.len() <= 31
        && word.bytes().take(2).all(letters)
        && known(word).is_none()
        && refused(word).is_none()
}
