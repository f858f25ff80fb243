//! Both ends of the cable, fed with bytes and time: the controller with what a host might send, a session with what a controller might
//! answer.
//!
//! An input is read as pieces: how many bytes (one byte, modulo 64), how long to wait behind them (one byte: its square in units of
//! 0.1 ms), and the bytes. Whatever it is, it can be read so.

use morsemill::controller::{Controller, FaultPlan, Faults, Memory, Rig, RigOptions};
use morsemill::link::{Job, Progress, Session, SessionOptions};
use std::time::Duration;

/// Pieces played at most: more would take longer than an input may.
const PIECES: usize = 300;

/// Pieces of an input and the seconds behind them.
fn pieces(mut input: &[u8]) -> Vec<(&[u8], f64)> {
    let mut out = Vec::new();
    while let [n, wait, rest @ ..] = input {
        let (piece, rest) = rest.split_at(usize::from(n % 64).min(rest.len()));
        out.push((piece, f64::from(*wait).powi(2) * 1e-4));
        input = rest;
        if out.len() == PIECES {
            break;
        }
    }
    out
}

/// The input that is read as these pieces; waits in the units of the input.
fn input(talk: &[(&str, u8)]) -> Vec<u8> {
    let mut out = Vec::new();
    for (text, wait) in talk {
        for piece in text.as_bytes().chunks(63) {
            out.extend([piece.len() as u8, *wait]);
            out.extend_from_slice(piece);
        }
    }
    out
}

/// Conversations of a host.
pub fn hosts() -> Vec<Vec<u8>> {
    [
        &[
            ("G21G90\nG1X5F600\n?G2X10I2.5\n", 100),
            ("!", 50),
            ("?~", 60),
            ("G4P0.1\nM3S500\nM30\n", 255),
        ][..],
        &[
            ("$$\n$#\n$G\n$I\n$N\n", 10),
            ("$22=1\n$130=50\n$H\n", 255),
            ("?", 255),
            ("$20=1\nG0X-10\nG0X10\n", 255),
            ("\x18", 100),
            ("$X\n", 10),
        ],
        &[
            ("$J=X10F500\n", 20),
            ("\u{85}", 50),
            ("$J=G91Y-1F100\n", 100),
            ("$C\nG1X1F1\n$C\n", 20),
            ("$SLP\n", 10),
            ("\x18$X\n", 90),
        ],
        &[
            ("G38.2Z-3F50\n", 255),
            ("$X\nG10L20P1X0Y0Z0\nG54\nG92X1\nG28\nG53G0X0\n", 200),
            ("$N0=G20\n$RST=*\n", 90),
        ],
        &[
            ("G17G2X1Y1R0.1\r\nG20(a;b)\n/G0X1;c\n%\n", 10),
            ("G93G1X1F0.5\nG0X1e3\nT255M6\nS-1\n", 50),
        ],
    ]
    .map(input)
    .into()
}

/// Words of a host.
pub const HOST_WORDS: [&str; 24] = [
    "G0X",
    "G1X1F100\n",
    "G2X1I1F100\n",
    "G4P1\n",
    "G10L2P1X",
    "G28\n",
    "G38.2Z-1F10\n",
    "G92X0\n",
    "M0\n",
    "M30\n",
    "$H\n",
    "$X\n",
    "$C\n",
    "$$\n",
    "$J=X1F100\n",
    "$SLP\n",
    "$N0=",
    "$RST=*\n",
    "$22=1\n",
    "$21=1\n",
    "?",
    "!",
    "~",
    "\x18",
];

/// A controller, once on a sound cable and once on a bad one: it must go on answering, and a reset must bring it back.
pub fn controller(bytes: &[u8]) -> Result<bool, String> {
    let mut plan = FaultPlan::default();
    for fault in [
        "flip:0.02",
        "drop:0.02",
        "duplicate:0.02",
        "lose-ok:0.05",
        "reset-at-line:9",
    ] {
        plan.add(fault).map_err(|e| e.to_string())?;
    }
    let mut accepted = true;
    for faults in [Faults::default(), Faults::new(1, plan)] {
        let mut rig = Rig::new(
            Controller::new(Memory::default()),
            RigOptions {
                faults,
                record: true,
                ..RigOptions::default()
            },
        );
        let mut said = Vec::new();
        for (piece, wait) in pieces(bytes) {
            rig.feed(piece);
            rig.advance(wait);
            said.extend(rig.output());
        }
        let p = rig.controller().position();
        if p.iter().any(|v| !v.is_finite()) {
            return Err(format!("the axes are nowhere: {p:?}"));
        }
        accepted &= !String::from_utf8_lossy(&said).contains("error:");
        // The first may fall into the half second of deafness behind an alarm. On the bad cable it may get lost.
        said.clear();
        for _ in 0..10 {
            rig.feed(&[0x18]);
            rig.advance(2.0);
            said.extend(rig.output());
        }
        if !String::from_utf8_lossy(&said).contains("Grbl 1") {
            return Err(format!(
                "resets do not bring it back: {:?}",
                String::from_utf8_lossy(&said)
            ));
        }
    }
    Ok(accepted)
}

/// Conversations of a controller.
pub fn controllers() -> Vec<Vec<u8>> {
    const HELLO: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";
    const IDLE: &str = "<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\r\n";
    const I: &str = "[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\nok\r\n";
    const SETTINGS: &str =
        "$10=1\r\n$13=0\r\n$20=0\r\n$22=0\r\n$110=500.000\r\n$132=200.000\r\nok\r\n";
    const OFFSETS: &str = "[G54:0.000,0.000,0.000]\r\n[G92:0.000,0.000,0.000]\r\n[TLO:0.000]\r\n[PRB:0.000,0.000,0.000:0]\r\nok\r\n";
    const MODES: &str = "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]\r\nok\r\n";
    const RUN: &str = "<Run|MPos:1.868,0.000,0.000|Bf:14,128|FS:600,0|Ov:100,100,100|A:S>\r\n";
    let start = [
        (HELLO, 20),
        (IDLE, 20),
        (I, 20),
        (SETTINGS, 20),
        (OFFSETS, 20),
        (MODES, 20),
    ];
    [
        &[
            ("ok\r\nok\r\n", 60),
            (RUN, 60),
            ("ok\r\nok\r\nok\r\n", 60),
            (IDLE, 100),
            (IDLE, 100),
        ][..],
        &[
            ("ok\r\n", 50),
            ("error:20\r\n", 50),
            ("<Hold:1|MPos:1,0,0|FS:10,0>\r\n", 50),
            ("<Hold:0|MPos:1,0,0|FS:0,0>\r\n", 50),
            (HELLO, 50),
            (IDLE, 90),
        ],
        &[
            ("ok\r\nALARM:1\r\n[MSG:Reset to continue]\r\n", 90),
            (HELLO, 60),
            ("[MSG:'$H'|'$X' to unlock]\r\n", 60),
        ],
        &[("ok\r\n", 60), (HELLO, 90), (IDLE, 90)],
        &[
            ("<Door:2|WPos:0.1,0,0>\r\n", 60),
            ("<Tool|MPos:0,0,0|DTG:1,2,3>\r\nok ok\r\n>G20:ok\r\n", 90),
            ("<Idle|MPos:0,0,0", 200),
        ],
    ]
    .map(|rest| input(&[&start[..], rest].concat()))
    .into()
}

/// Words of a controller.
pub const CONTROLLER_WORDS: [&str; 20] = [
    "ok\r\n",
    "error:9\r\n",
    "ALARM:3\r\n",
    "Grbl 1.1h ['$' for help]\r\n",
    "<Idle|MPos:",
    "<Run|MPos:",
    "<Hold:0|",
    "<Hold:1|",
    "<Alarm|",
    "<Door:3|",
    "|WCO:",
    "|Ov:",
    "|Bf:",
    "|Pn:",
    "|FS:",
    ">\r\n",
    "[PRB:",
    "[GC:",
    "$13=1\r\n",
    "[OPT:V,15,128]\r\n",
];

/// A session with whatever answers: it must end, or be waiting for more; it may not send more than the controller can hold.
pub fn replies(bytes: &[u8]) -> Result<bool, String> {
    let job = Job::vet("G21 G90\nM3 S500\nG0 X1\nG1 Z-1 F100\nG4 P0.1\nX5\nM5\nM30\n")
        .map_err(|e| format!("the job is refused: {e:?}"))?;
    let mut session = Session::new(job, SessionOptions::default());
    let (mut now, mut started) = (Duration::ZERO, false);
    for (piece, wait) in pieces(bytes) {
        session.receive(piece, now);
        // A tick now and then, as the loop around it does.
        let end = now + Duration::from_secs_f64(wait);
        loop {
            session.tick(now);
            session.output();
            started |= session
                .news()
                .iter()
                .any(|n| matches!(n, Progress::Started { .. }));
            if now >= end {
                break;
            }
            now = (now + Duration::from_millis(100)).min(end);
        }
    }
    // Silence from here on: it must not wait for ever.
    for _ in 0..6000 {
        if session.outcome().is_some() {
            return Ok(started);
        }
        now += Duration::from_millis(100);
        session.tick(now);
        session.output();
    }
    // Paused by the machine itself (a hold, a door) a session waits for its operator.
    Ok(started)
}
