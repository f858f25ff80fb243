//! What is fuzzed: for each format its seeds, its dictionary, and what must hold of whatever is read. A new format is one more entry.

use super::{corpus, journal, talk};
use morsemill::cldata::{ReadOptions, Reader, Step};
use morsemill::gcode::{Dialect, Event, Interpreter, Reading, State};
use morsemill::machine::Machine;
use morsemill::part::{self, PlaceOptions, Units};
use morsemill::post::Post;
use std::io::Cursor;

/// One thing that reads what people hand it.
pub struct Target {
    /// Its name on the command line.
    pub name: &'static str,
    /// Inputs to spoil, most of them good.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Words of the format.
    pub words: &'static [&'static str],
    /// Reads an input. True when it was accepted. A panic is a finding, and so is an error here: something was accepted that must not be.
    pub read: fn(&[u8]) -> Result<bool, String>,
}

/// All of them.
pub const TARGETS: [Target; 8] = [
    Target {
        name: "stl",
        seeds: corpus::stl,
        words: &corpus::STL_WORDS,
        read: |bytes| read_part("part.stl", bytes),
    },
    Target {
        name: "obj",
        seeds: corpus::obj,
        words: &corpus::OBJ_WORDS,
        read: |bytes| read_part("part.obj", bytes),
    },
    Target {
        name: "gcode",
        seeds: corpus::gcode,
        words: &corpus::GCODE_WORDS,
        read: read_program,
    },
    Target {
        name: "cl",
        seeds: corpus::cl,
        words: &corpus::CL_WORDS,
        read: read_cl,
    },
    Target {
        name: "toml",
        seeds: corpus::toml,
        words: &corpus::TOML_WORDS,
        read: read_data_file,
    },
    Target {
        name: "controller",
        seeds: talk::hosts,
        words: &talk::HOST_WORDS,
        read: talk::controller,
    },
    Target {
        name: "replies",
        seeds: talk::controllers,
        words: &talk::CONTROLLER_WORDS,
        read: talk::replies,
    },
    Target {
        name: "journal",
        seeds: journal::seeds,
        words: &journal::WORDS,
        read: journal::read_journal,
    },
];

/// The target of a name.
pub fn target(name: &str) -> Option<&'static Target> {
    static ALL: [Target; TARGETS.len()] = TARGETS;
    ALL.iter().find(|t| t.name == name)
}

fn read_part(name: &str, bytes: &[u8]) -> Result<bool, String> {
    let loaded = match part::from_bytes(name, bytes, Units::Mm) {
        Ok(loaded) => loaded,
        Err(e) => return refused(&e.to_string()),
    };
    let far = |p: &morsemill::geom::Point| {
        p.iter()
            .any(|v| !v.is_finite() || v.abs() > part::load::FARTHEST_MM)
    };
    if loaded.mesh.triangles.is_empty() {
        return Err("a part without triangles was accepted".into());
    }
    if loaded.mesh.triangles.iter().flatten().any(far) {
        return Err("a coordinate that is no place was accepted".into());
    }
    match part::place(&loaded.mesh, &loaded.soundness, &PlaceOptions::default()) {
        Ok(placed)
            if placed
                .mesh
                .triangles
                .iter()
                .flatten()
                .any(|p| p.iter().any(|v| !v.is_finite())) =>
        {
            Err("a placed part has a coordinate that is no number".into())
        }
        Ok(_) => Ok(true),
        Err(e) => refused(&e.to_string()),
    }
}

/// Reads the program in one dialect, which its first bytes decide: so a finding is read again in the same one.
fn read_program(bytes: &[u8]) -> Result<bool, String> {
    let sum = bytes.iter().take(256).fold(bytes.len(), |s, b| {
        s.wrapping_mul(31).wrapping_add(usize::from(*b))
    });
    let dialect = Dialect::ALL[sum % Dialect::ALL.len()];
    let text = String::from_utf8_lossy(bytes);
    // Loops without end are refused like any others: with less patience than a job gets, there is time for more cases.
    let reading = Reading {
        lines_again: 100_000,
        ..Reading::default()
    };
    let from = Cursor::new(text.as_bytes());
    let mut program = Interpreter::from_state(from, State::new(dialect), reading)
        .map_err(|e| format!("a text in memory cannot be read: {e}"))?;
    let mut events = Vec::new();
    let errors = program.read_all(&mut events);
    for e in &errors {
        refused(&e.to_string())?;
    }
    if !errors.is_empty() {
        return Ok(false);
    }
    let lines = program
        .count_lines()
        .map_err(|e| format!("a text in memory cannot be counted: {e}"))?;
    for event in &events {
        if let Event::Motion(m) = event
            && (m.from.iter().chain(m.to.iter()).any(|v| !v.is_finite()) || m.line > lines)
        {
            return Err(format!(
                "{}: a motion to nowhere was accepted: {m:?}",
                dialect.name()
            ));
        }
    }
    Ok(true)
}

fn read_cl(bytes: &[u8]) -> Result<bool, String> {
    for step in Reader::new(bytes, ReadOptions::default()) {
        match step {
            Err(e) => return refused(&e.to_string()),
            Ok((_, Step::Feed { to, .. })) if to.iter().any(|v| !v.is_finite()) => {
                return Err("a motion to nowhere was accepted".into());
            }
            Ok((_, Step::Rapid { to, .. })) if to.iter().flatten().any(|v| !v.is_finite()) => {
                return Err("a motion to nowhere was accepted".into());
            }
            Ok(_) => {}
        }
    }
    Ok(true)
}

fn read_data_file(bytes: &[u8]) -> Result<bool, String> {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return Ok(false); // Refused before it gets so far.
    };
    let machine = Machine::from_toml("fuzz", text);
    let post = Post::from_toml("fuzz", text);
    match (machine, post) {
        (Ok(_), Ok(_)) => Err("one file was accepted as a machine and as a dialect".into()),
        (Err(a), Err(b)) => {
            refused(&a.to_string())?;
            refused(&b.to_string())
        }
        (Ok(m), Err(_)) => {
            let figures = [
                m.travel.map(|v| v.0),
                m.max_rate.map(|v| v.0),
                m.acceleration.map(|v| v.0),
                m.steps_per_mm,
            ];
            if figures
                .iter()
                .flatten()
                .any(|v| !v.is_finite() || *v <= 0.0)
            {
                return Err("a machine with a figure no machine has was accepted".into());
            }
            Ok(true)
        }
        (Err(_), Ok(_)) => Ok(true),
    }
}

/// A refusal must say something, and not repeat the whole input.
fn refused(message: &str) -> Result<bool, String> {
    if message.trim().is_empty() {
        return Err("refused without a word".into());
    }
    if message.len() > 20_000 {
        return Err(format!("a refusal of {} bytes", message.len()));
    }
    Ok(false)
}
