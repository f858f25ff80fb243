//! `morsemill ports`: the serial ports of this computer.

use super::output::say;
use crate::link::port;
use std::io::Write;

/// Lists the ports, one a line: path, then what it is. Returns the exit code: 0 (also when there are none), or 2.
pub fn run(out: &mut dyn Write) -> u8 {
    let ports = match port::list() {
        Ok(ports) => ports,
        Err(e) => {
            say(&format!("error: {e}"));
            return 2;
        }
    };
    if ports.is_empty() {
        say("no serial ports: plug the controller in, or use `--port sim`");
    }
    let width = ports.iter().map(|p| p.path.len()).max().unwrap_or(0);
    for p in &ports {
        if writeln!(out, "{:width$}  {}", p.path, p.title).is_err() {
            return 2;
        }
    }
    0
}
