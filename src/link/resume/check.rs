//! Is this the same program on the same machine, and does the machine stand where its controller believes it stands?

use super::refusal::Refusal;
use super::text::ProgramText;
use super::walk::{Program, Walk, lines};
use super::zones::Zones;
use crate::gcode::State;
use crate::geom::{Point, Vector, nearest_on_segment};
use crate::kinematics::chords;
use crate::link::Known;
use crate::link::journal::{Begin, History, Offsets};
use crate::units::Mm;

/// What the controller says of itself now, and this computer. Lengths mm, machine coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Now {
    /// Name of the machine, as the machine file has it.
    pub machine: String,
    /// State as the controller spells it.
    pub state: String,
    /// Machine position.
    pub position: Option<[f64; 3]>,
    /// `$#`.
    pub offsets: Offsets,
    /// `$$`.
    pub settings: Vec<(u16, f64)>,
    /// What the controller itself says of homing, if it does (grblHAL).
    pub homed: Option<bool>,
    /// Name of the dialect that it reads.
    pub dialect: String,
    /// This computer's boot, as in [`Begin::boot`].
    pub boot: Option<String>,
}

impl Offsets {
    /// What `$#` told; what it did not tell counts as zero, as the session takes it.
    pub fn of(known: &crate::link::Offsets) -> Offsets {
        let or_zero = |v: Option<[f64; 3]>| v.unwrap_or_default();
        Offsets {
            g5x: known.g5x.map(or_zero),
            g28: or_zero(known.g28),
            g30: or_zero(known.g30),
            g92: or_zero(known.g92),
            tlo: known.tlo.unwrap_or_default(),
        }
    }

    fn named(&self) -> impl Iterator<Item = (String, [f64; 3])> + '_ {
        let work = self.g5x.iter().enumerate();
        work.map(|(i, v)| (format!("G{}", 54 + i), *v))
            .chain([("G28".to_string(), self.g28), ("G30".to_string(), self.g30)])
    }

    /// The stored offsets of a state.
    fn stored(state: &State) -> Offsets {
        Offsets {
            g5x: state.g5x.map(|v| [v.x, v.y, v.z]),
            g28: [state.g28.x, state.g28.y, state.g28.z],
            g30: [state.g30.x, state.g30.y, state.g30.z],
            ..Offsets::default()
        }
    }
}

impl Now {
    /// By what an introduction found.
    pub fn of(known: &Known, machine: &str, boot: Option<String>) -> Now {
        Now {
            machine: machine.to_string(),
            state: known.state.text().to_string(),
            position: known.machine_position,
            offsets: Offsets::of(&known.offsets),
            settings: known.settings.clone(),
            homed: known.homed,
            dialect: known.dialect().name().to_string(),
            boot,
        }
    }

    pub(super) fn setting(&self, number: u16) -> Option<f64> {
        self.settings.iter().find(|s| s.0 == number).map(|s| s.1)
    }

    /// Where a homed GRBL stands when it has just homed (GRBL v1.1 Settings, $23 and $27): off the switches by $27, at the far end of the
    /// travel for axes in $23's mask.
    fn home(&self) -> Option<[f64; 3]> {
        if self.setting(22)? == 0.0 {
            return None;
        }
        let (mask, off) = (self.setting(23)? as u32, self.setting(27)?);
        let mut home = [0.0; 3];
        for (a, place) in home.iter_mut().enumerate() {
            let travel = self.setting(130 + a as u16)?;
            *place = match mask >> a & 1 {
                1 => off - travel,
                _ => -off,
            };
        }
        Some(home)
    }
}

/// Whose word the position has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// What journal and controller show.
    #[default]
    Shown,
    /// The operator's: position, work zero and part were looked at.
    Operator,
}

/// Why the position is trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// The machine stands where the job can have stopped, and nothing happened to make it lose steps.
    OnPath,
    /// It has just been homed.
    Homed,
    /// The operator says so.
    Operator,
}

/// How near a reported place must be, mm: rounding of reports and of whole steps, and arcs cut as chords.
pub(super) const NEAR: f64 = 0.05;
/// How well offsets must agree, mm: reports have three decimals, four in inch.
const SAME: f64 = 0.002;

/// The program is the one in the journal.
pub(super) fn program(
    text: &dyn ProgramText,
    bytes_sha256: &str,
    begin: &Begin,
) -> Result<(), Refusal> {
    let changed = |what: String| Err(Refusal::ProgramChanged { what });
    let lines = lines(text)?;
    if lines != begin.lines {
        return changed(format!("{lines} lines now, {} then", begin.lines));
    }
    if bytes_sha256 != begin.sha256 {
        return changed("as many lines, but other bytes".to_string());
    }
    Ok(())
}

/// The machine is the one in the journal, and ready.
pub(super) fn machine(begin: &Begin, now: &Now) -> Result<[f64; 3], Refusal> {
    if begin.machine != now.machine {
        return Err(Refusal::OtherMachine {
            journal: begin.machine.clone(),
            now: now.machine.clone(),
        });
    }
    let place = ready(now)?;
    for (number, journal) in &begin.settings {
        // Steps per mm, directions, laser mode: what changes where a line leads or what it does there.
        if !matches!(number, 3 | 32 | 100..=102) {
            continue;
        }
        let Some(value) = now.setting(*number) else {
            continue;
        };
        if (value - journal).abs() > 1e-6 * journal.abs() + 1e-9 {
            return Err(Refusal::Setting {
                number: *number,
                journal: *journal,
                now: value,
            });
        }
    }
    Ok(place)
}

/// The controller is Idle and says where it is.
pub(super) fn ready(now: &Now) -> Result<[f64; 3], Refusal> {
    let advice = match now.state.as_str() {
        "Idle" => {
            return now
                .position
                .filter(|p| p.iter().all(|c| c.is_finite()))
                .ok_or(Refusal::NoPosition);
        }
        "Alarm" => {
            "home it (`morsemill home`), or unlock it (`morsemill unlock`) if you know that it stands where it believes"
        }
        "Run" | "Jog" | "Home" => "wait until it stands still",
        "Check" => "leave check mode with $C",
        _ => "end its hold, door or sleep, so that it is Idle",
    };
    Err(Refusal::NotIdle {
        state: now.state.clone(),
        advice,
    })
}

/// The position may be trusted, and why.
pub(super) fn position(
    text: &dyn ProgramText,
    begin: &Begin,
    history: &History,
    zones: &Zones,
    now: &Now,
    trust: Trust,
) -> Result<Evidence, Refusal> {
    let place = now.position.ok_or(Refusal::NoPosition)?;
    if trust == Trust::Operator {
        return Ok(Evidence::Operator);
    }
    let near = |home: [f64; 3]| (0..3).all(|a| (home[a] - place[a]).abs() <= NEAR);
    // Zero pull-off is where a controller stands that was just switched on.
    let at_home = now.setting(27).is_some_and(|off| off > NEAR) && now.home().is_some_and(near);
    let homed = at_home || now.homed == Some(true);
    let doubts = history.all_doubts();
    let open = doubts.iter().find(|d| !(homed && d.ends_with_homing()));
    if let Some(doubt) = open {
        let advice = match (doubt.ends_with_homing(), now.setting(22)) {
            (false, _) => "If the part is sound, say --trust-position",
            (true, Some(on)) if on != 0.0 => {
                "Home the machine (`morsemill home`), leave it there, and resume"
            }
            (true, _) => {
                "This machine has no homing: set the zero on the part again and say --trust-position"
            }
        };
        return Err(Refusal::NotTrusted {
            doubt: doubt.clone(),
            advice,
        });
    }
    if homed {
        return Ok(Evidence::Homed);
    }
    let mut distance = from_path(text, begin, history, zones, &Point::from(place))?;
    if let Some(rest) = history.rest() {
        // It was seen to stop: there it stands, or it was moved.
        distance = distance.max((Point::from(rest.machine) - Point::from(place)).norm());
    }
    if distance > NEAR {
        return Err(Refusal::Elsewhere { place, distance });
    }
    match place == [0.0; 3] {
        true => Err(Refusal::PowerOn),
        false => Ok(Evidence::OnPath),
    }
}

/// How far a machine position is from where the job can have stopped, mm: from the path of the middle zone when the sender saw it come to
/// rest; otherwise from the ends of those lines that can have been the last to arrive, since the machine did all it had. (An alarm that
/// nobody saw stops it between two ends.)
fn from_path(
    text: &dyn ProgramText,
    begin: &Begin,
    history: &History,
    zones: &Zones,
    place: &Point,
) -> Result<f64, Refusal> {
    let mut walk = Program::of(text, history, begin).walk();
    let mut nearest = f64::INFINITY;
    while let Some(step) = walk.step() {
        let line = step.map_err(Refusal::Unreadable)?;
        if line > zones.last {
            break;
        }
        if !history.at_rest {
            if line >= history.acknowledged {
                let end = walk.state().machine_position();
                nearest = nearest.min((end - place).norm());
            }
            continue;
        }
        // Where the line before the zone ends is a place to stop at too; a motion's start covers it.
        if line < zones.first {
            continue;
        }
        nearest = nearest.min(near_way(&walk, place));
    }
    Ok(nearest)
}

/// How far a machine position is from the way of the line read last, mm; of one that does not move, from where the machine stands then.
pub(super) fn near_way(walk: &Walk, place: &Point) -> f64 {
    let (motions, shift) = walk.motions();
    let mut nearest = f64::INFINITY;
    for m in motions {
        let mut from = m.from + shift;
        let mut go = |to: Point| {
            let d = (nearest_on_segment(place, &from, &to) - place).norm();
            nearest = nearest.min(d);
            from = to;
        };
        match &m.arc {
            None => go(m.to + shift),
            Some(arc) => chords(&m.from, &m.to, arc, Mm(NEAR / 10.0)).for_each(|p| go(p + shift)),
        }
    }
    match nearest.is_finite() {
        true => nearest,
        false => (walk.state().machine_position() - place).norm(),
    }
}

/// The stored offsets are those that the job had where it broke, or the operator answers for them; how far each work zero was moved since.
pub(super) fn offsets(
    text: &dyn ProgramText,
    begin: &Begin,
    history: &History,
    zones: &Zones,
    now: &Now,
    trust: Trust,
) -> Result<[Vector; 6], Refusal> {
    let mut walk = Program::of(text, history, begin).walk();
    let mut before = Offsets::stored(walk.state());
    while let Some(step) = walk.step() {
        let line = step.map_err(Refusal::Unreadable)?;
        if line > zones.last {
            break;
        }
        let stored = Offsets::stored(walk.state());
        if stored != before && zones.is_maybe(line) {
            return Err(Refusal::OffsetWritten {
                first: zones.first,
                last: zones.last,
            });
        }
        before = stored;
    }
    for ((name, then), (_, value)) in before.named().zip(now.offsets.named()) {
        let differs = (0..3).any(|a| (then[a] - value[a]).abs() > SAME);
        if differs && trust == Trust::Shown {
            return Err(Refusal::Offset {
                name,
                journal: then,
                now: value,
            });
        }
    }
    let vector = |v: [f64; 3]| Vector::from(v);
    Ok(std::array::from_fn(|i| {
        let then = before.g5x.get(i).copied().unwrap_or_default();
        let value = now.offsets.g5x.get(i).copied().unwrap_or_default();
        let moved = vector(value) - vector(then);
        // What lies within the rounding of reports is no new zero.
        match moved.amax() <= SAME {
            true => Vector::zeros(),
            false => moved,
        }
    }))
}
