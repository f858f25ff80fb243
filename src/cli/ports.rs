//! `morsemill ports`: the serial ports of this computer, and which of them look like a GRBL board.

use super::output::{say, write_json};
use crate::link::port::inquiry::{Found, Inquiry};
use crate::link::port::{self, PortEntry};
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `morsemill ports`.
#[derive(Clone, Debug, clap::Args)]
pub struct PortsArgs {
    /// Open each port that looks like a GRBL board, or the one named, and ask what answers there. Opening restarts most boards: not while
    /// a machine runs
    #[arg(long, value_name = "PORT|tcp://HOST:PORT", num_args = 0..=1, default_missing_value = "")]
    pub probe: Option<String>,
    /// Baud rate to ask at
    #[arg(long, default_value_t = 115_200, value_name = "BAUD", value_parser = clap::value_parser!(u32).range(300..=12_000_000))]
    pub baud: u32,
    /// Write the list as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// One port, as `--json` has it.
#[derive(Debug, Serialize)]
struct Row {
    /// What to give to `--port`.
    port: String,
    /// Maker and product, or the kind of port.
    title: String,
    /// USB numbers, four hexadecimal digits each, and the serial number.
    usb: Option<UsbRow>,
    /// What board it may be, by its USB chip.
    board: Option<&'static str>,
    /// What of GRBL's family runs on such boards.
    may_run: Option<&'static str>,
    /// A name that stays the same wherever it is plugged in; as good for `--port`.
    stable_name: Option<String>,
    /// What answered; absent when it was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    probe: Option<Answer>,
}

#[derive(Debug, Serialize)]
struct UsbRow {
    vendor: String,
    product: String,
    serial: Option<String>,
}

#[derive(Debug, Serialize)]
struct Answer {
    /// It speaks GRBL's language.
    grbl: bool,
    greeting: Option<String>,
    version: Option<String>,
    state: Option<String>,
    /// The same for people, or why it could not be asked.
    message: String,
}

/// Lists the ports, one a line: path, what it is, what it looks like, what answered. Returns the exit code: 0 (also when there are
/// none), or 2.
pub fn run(args: &PortsArgs, out: &mut dyn Write) -> u8 {
    match ports(args, out) {
        Ok(()) => 0,
        Err(message) => {
            say(&format!("error: {message}"));
            2
        }
    }
}

fn ports(args: &PortsArgs, out: &mut dyn Write) -> Result<(), String> {
    let named = args.probe.as_deref().filter(|n| !n.is_empty());
    let mut entries = port::list().map_err(|e| e.to_string())?;
    if let Some(name) = named
        && !entries.iter().any(|e| e.is_at(name))
    {
        entries.push(PortEntry {
            path: name.to_string(),
            title: "named by you".to_string(),
            usb: None,
            stable: None,
        });
    }
    if entries.is_empty() {
        say("no serial ports: plug the controller in, or use `--port sim`");
    }
    let rows: Vec<Row> = entries
        .iter()
        .map(|entry| {
            let wanted = match named {
                Some(name) => entry.is_at(name),
                None => args.probe.is_some() && entry.board().is_some(),
            };
            row(entry, wanted.then(|| ask(&entry.path, args.baud)))
        })
        .collect();
    if args.probe.is_some() && rows.iter().all(|r| r.probe.is_none()) {
        say("no port looks like a GRBL board: name one to be asked, --probe PORT");
    }
    if let Some(file) = &args.json {
        write_json(file, &rows).map_err(|e| match e {
            super::Failure::Rejected(text) | super::Failure::Failed(text) => text,
        })?;
    }
    match print(&rows, out) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(format!("standard output: {e}"))
        }
        _ => Ok(()),
    }
}

fn row(entry: &PortEntry, probe: Option<Answer>) -> Row {
    let board = entry.board();
    Row {
        port: entry.path.clone(),
        title: entry.title.clone(),
        usb: entry.usb.as_ref().map(|u| UsbRow {
            vendor: format!("{:04x}", u.vendor),
            product: format!("{:04x}", u.product),
            serial: u.serial.clone(),
        }),
        board: board.map(|b| b.title),
        may_run: board.map(|b| b.runs),
        stable_name: entry.stable.clone(),
        probe,
    }
}

fn print(rows: &[Row], out: &mut dyn Write) -> std::io::Result<()> {
    let width = |of: fn(&Row) -> usize| rows.iter().map(of).max().unwrap_or(0);
    let (path, title) = (
        width(|r| r.port.chars().count()),
        width(|r| r.title.chars().count()),
    );
    for r in rows {
        let guess = match (r.board, r.may_run) {
            (Some(board), Some(runs)) => format!("{board}: may run {runs}"),
            _ if r.usb.is_some() => "no chip of a GRBL board".to_string(),
            _ => String::new(),
        };
        let line = format!("{:path$}  {:title$}  {guess}", r.port, r.title);
        writeln!(out, "{}", line.trim_end())?;
        if let Some(name) = &r.stable_name {
            writeln!(out, "{:path$}  always: {name}", "")?;
        }
        if let Some(answer) = &r.probe {
            writeln!(out, "{:path$}  answer: {}", "", answer.message)?;
        }
    }
    out.flush()
}

/// Opens a port and asks what answers there.
fn ask(path: &str, baud: u32) -> Answer {
    say(&format!("asking {path} ..."));
    match inquire(path, baud) {
        Ok(found) => Answer {
            grbl: found.is_grbl(),
            message: found.to_string(),
            greeting: found.greeting,
            version: found.version,
            state: found.state.map(|s| s.text().to_string()),
        },
        Err(e) => Answer {
            grbl: false,
            greeting: None,
            version: None,
            state: None,
            message: e.to_string(),
        },
    }
}

fn inquire(path: &str, baud: u32) -> Result<Found, port::PortError> {
    let mut port = port::open(path, baud)?;
    let mut inquiry = Inquiry::default();
    let mut buffer = [0u8; 256];
    let start = Instant::now();
    loop {
        let n = port.read(&mut buffer)?;
        let now = start.elapsed().as_secs_f64();
        inquiry.receive(buffer.get(..n).unwrap_or_default(), now);
        inquiry.tick(now);
        port.write(&inquiry.output())?;
        if let Some(found) = inquiry.finished() {
            return Ok(found.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::port::list::Usb;

    #[test]
    fn the_table_says_what_may_be_a_board() {
        let usb = |vendor, product| Usb {
            vendor,
            product,
            ..Usb::default()
        };
        let rows = [
            row(
                &PortEntry {
                    stable: Some("/dev/serial/by-id/usb-Arduino-if00".into()),
                    ..PortEntry::of_usb("/dev/ttyACM0".into(), usb(0x2341, 0x43))
                },
                Some(Answer {
                    grbl: true,
                    greeting: None,
                    version: None,
                    state: None,
                    message: "Grbl 1.1h, Idle".into(),
                }),
            ),
            row(
                &PortEntry::of_usb("/dev/ttyUSB12".into(), usb(0x1234, 0x5678)),
                None,
            ),
            row(
                &PortEntry {
                    path: "/dev/ttyS0".into(),
                    title: "built in".into(),
                    usb: None,
                    stable: None,
                },
                None,
            ),
        ];
        let mut out = Vec::new();
        print(&rows, &mut out).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "/dev/ttyACM0   USB 2341:0043  Arduino Uno R3: may run GRBL\n\
             \u{20}              always: /dev/serial/by-id/usb-Arduino-if00\n\
             \u{20}              answer: Grbl 1.1h, Idle\n\
             /dev/ttyUSB12  USB 1234:5678  no chip of a GRBL board\n\
             /dev/ttyS0     built in\n"
        );
        let json = serde_json::to_value(&rows).unwrap();
        assert_eq!(json[0]["usb"]["vendor"], "2341");
        assert_eq!(json[0]["probe"]["grbl"], true);
        assert_eq!(json[0]["stable_name"], "/dev/serial/by-id/usb-Arduino-if00");
        assert_eq!(json[1]["board"], serde_json::Value::Null);
        assert!(json[1].get("probe").is_none());
    }

    #[test]
    fn a_port_that_cannot_be_asked_is_said_and_is_no_failure() {
        let dir = tempfile::tempdir().unwrap();
        let json = dir.path().join("ports.json");
        let args = PortsArgs {
            probe: Some("/dev/no-such-port".into()),
            baud: 115_200,
            json: Some(json.clone()),
        };
        let mut out = Vec::new();
        assert_eq!(run(&args, &mut out), 0);
        let text = String::from_utf8(out).unwrap();
        assert!(
            text.contains("answer: /dev/no-such-port: cannot open the port:"),
            "{text}"
        );
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
        let last = json.as_array().unwrap().last().unwrap();
        assert_eq!(last["port"], "/dev/no-such-port");
        assert_eq!(last["probe"]["grbl"], false);
    }
}
