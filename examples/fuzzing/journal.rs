//! Journals: bytes to what they tell, to zones, to a plan. Every input is read twice: as it is, and with numbers and checksums put right, or
//! nothing spoilt would ever come past them.

use morsemill::link::journal::{
    Begin, FORMAT, History, Offsets, Record, Start, ToolChange, Writer, fingerprint, read,
};
use morsemill::link::resume::{Now, ResumeOptions, Trust, resume, zones};
use std::time::Duration;

/// The program that all journals here are of.
const PROGRAM: &str = "G21 G90\nM3 S8000\nG0 Z10\nG0 X0 Y0\nG1 Z-1 F200\nG1 X20 F800\nG2 X0 Y0 I-10 J0\nG93 G1 X5 F9\nG94 G20 G91\n\
                       X.1 F20\nT2 M6\nM4 S9000\nG92 X0\nX.2 Y.3\nG90 G0 Z1\nM30\n";

/// Words of a journal.
pub const WORDS: [&str; 24] = [
    "\"event\":\"allow\"",
    "\"event\":\"sent\"",
    "\"event\":\"acknowledged\"",
    "\"event\":\"report\"",
    "\"event\":\"hold\"",
    "\"event\":\"resume\"",
    "\"event\":\"override\"",
    "\"event\":\"tool_change\"",
    "\"event\":\"alarm\"",
    "\"event\":\"error\"",
    "\"event\":\"reset\"",
    "\"event\":\"stopping\"",
    "\"event\":\"end\"",
    "\"line\":",
    "\"code\":",
    "\"t\":",
    "\"tlo\":",
    "\"settings\":[[100,",
    "\"g92\":[",
    "null",
    "1e308",
    "-1e308",
    "18446744073709551615",
    "\"resumed\":{\"entry\":3,\"maybe_to\":9}",
];

fn begin() -> Begin {
    let mut offsets = Offsets::default();
    offsets.g5x[0] = [-100.0, -90.0, -60.0];
    Begin {
        format: FORMAT,
        program: "part.nc".into(),
        sha256: fingerprint(PROGRAM.as_bytes()),
        lines: PROGRAM.lines().count(),
        machine: "m".into(),
        firmware: "1.1h".into(),
        dialect: "grbl".into(),
        settings: vec![
            (12, 0.002),
            (32, 0.0),
            (100, 250.0),
            (101, 250.0),
            (102, 250.0),
        ],
        start: Start {
            position: [-1.0, -2.0, -3.0],
            offsets,
            modes: "G0 G54 M5".into(),
        },
        rx_bytes: 128,
        planner_blocks: 15,
        bytes_per_s: 11_520.0,
        boot: Some("b".into()),
        skips_slashed: false,
        resumed: None,
    }
}

/// Journals of jobs that broke in several ways.
pub fn seeds() -> Vec<Vec<u8>> {
    let end = |done| Record::End {
        how: "stopped by the operator".into(),
        done,
        position_kept: true,
        at_rest: true,
        cable_sound: true,
    };
    let stories = [
        vec![
            Record::Allow { line: 9 },
            Record::Sent { line: 8 },
            Record::Acknowledged { line: 6 },
        ],
        vec![
            Record::Allow { line: 16 },
            Record::Sent { line: 14 },
            Record::Acknowledged { line: 12 },
            Record::ToolChange(ToolChange {
                line: 11,
                tool: Some(2),
                offsets: Some(begin().start.offsets),
            }),
            Record::Report {
                state: "Run".into(),
                machine: [-95.0, -90.0, -61.0],
                work_offset: Some([-100.0, -90.0, -60.0]),
            },
            Record::Override {
                feed: 120,
                rapid: 50,
                spindle: 90,
            },
            Record::Hold { why: "key".into() },
            Record::Resume,
            end(false),
        ],
        vec![
            Record::Acknowledged { line: 5 },
            Record::Alarm { code: 1 },
            Record::Error { line: 6, code: 33 },
            Record::Reset,
            Record::Stopping {
                why: "alarm".into(),
            },
            end(true),
        ],
    ];
    stories
        .into_iter()
        .map(|records| {
            let mut w = Writer::new();
            w.note(Record::Begin(Box::new(begin())), Duration::ZERO);
            for (i, r) in records.into_iter().enumerate() {
                w.note(r, Duration::from_millis(90 * i as u64));
            }
            w.take()
        })
        .collect()
}

/// Numbers and checksums put right.
fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let mut parts = line.splitn(3, |b| *b == b' ');
        let json = parts.nth(2).unwrap_or_default();
        let mut text = format!("{number} ").into_bytes();
        text.extend(json);
        let sum = crc32fast::hash(&text);
        out.extend(format!("{number} {sum:08x} ").into_bytes());
        out.extend(json);
        out.push(b'\n');
    }
    out
}

/// Reads a journal and takes up its job as far as it lets.
pub fn read_journal(bytes: &[u8]) -> Result<bool, String> {
    let plain = plan(&read(bytes).map_err(|e| e.to_string())?)?;
    let mended = plan(&read(&mended(bytes)[..]).map_err(|e| e.to_string())?)?;
    Ok(plain || mended)
}

fn plan(history: &History) -> Result<bool, String> {
    let Some(begin) = &history.begin else {
        return Ok(false);
    };
    if let Ok(z) = zones(PROGRAM, begin, history, Some("b"))
        && (z.first == 0 || z.last < z.first || (z.last > begin.lines && z.last > z.first))
    {
        return Err(format!("{z:?} of {} lines", begin.lines));
    }
    let now = Now {
        machine: begin.machine.clone(),
        state: "Idle".into(),
        position: Some([-95.0, -90.0, -61.0]),
        offsets: begin.start.offsets,
        settings: begin.settings.clone(),
        homed: None,
        dialect: begin.dialect.clone(),
        boot: None,
    };
    let mut planned = false;
    for trust in [Trust::Shown, Trust::Operator] {
        let options = ResumeOptions {
            trust,
            ..ResumeOptions::default()
        };
        match resume(PROGRAM, &begin.sha256, history, &now, &options) {
            Ok(plan) => {
                planned = true;
                let text = plan.program(PROGRAM);
                if text.lines().any(|l| l.contains("NaN") || l.contains("inf")) {
                    return Err(format!("a place that is none: {text}"));
                }
                if plan.to_string().is_empty() {
                    return Err("a plan without words".into());
                }
            }
            Err(e) if e.to_string().trim().is_empty() => {
                return Err("refused without a word".into());
            }
            Err(_) => {}
        }
    }
    Ok(planned)
}
