//! The status report `<State|MPos:..|..>`: read by the host, written by the controller.

use std::fmt::Write as _;

/// How far a safety-door stop has come (`Door:n`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DoorPhase {
    /// `Door:0`: closed, ready to resume.
    Closed,
    /// `Door:1`: at rest, still ajar.
    Ajar,
    /// `Door:2`: coming to rest.
    Stopping,
    /// `Door:3`: resuming.
    Resuming,
}

/// The machine's state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Nothing moves, and no cycle is in progress. Not the same as "job done": a dwell is Idle too.
    Idle,
    /// Moving.
    Run,
    /// Feed hold: `at_rest` is false for `Hold:1` (still slowing down), true for `Hold:0`.
    Hold {
        /// The motion has come to rest; a reset now costs nothing.
        at_rest: bool,
    },
    /// Jogging.
    Jog,
    /// Homing.
    Home,
    /// Locked after an alarm.
    Alarm,
    /// Check mode: lines are read, nothing moves.
    Check,
    /// Safety door.
    Door(DoorPhase),
    /// Asleep; only a reset wakes it.
    Sleep,
    /// A state this list does not know: never to be taken for ready.
    Other(String),
}

impl State {
    /// Reads `Idle`, `Hold:0`, ... Unknown names and sub-states become `Other`.
    pub fn parse(text: &str) -> State {
        match text {
            "Idle" => State::Idle,
            "Run" => State::Run,
            // A bare `Hold` (older firmwares) does not say whether motion has ended, so it counts as still moving.
            "Hold" | "Hold:1" => State::Hold { at_rest: false },
            "Hold:0" => State::Hold { at_rest: true },
            "Jog" => State::Jog,
            "Home" => State::Home,
            "Alarm" => State::Alarm,
            "Check" => State::Check,
            "Door:0" => State::Door(DoorPhase::Closed),
            "Door:1" => State::Door(DoorPhase::Ajar),
            "Door" | "Door:2" => State::Door(DoorPhase::Stopping),
            "Door:3" => State::Door(DoorPhase::Resuming),
            "Sleep" => State::Sleep,
            // grblHAL adds sub-states of Run and Alarm that change nothing for us.
            _ if text.starts_with("Run:") => State::Run,
            _ if text.starts_with("Alarm:") => State::Alarm,
            _ => State::Other(text.to_string()),
        }
    }

    /// True when no axis moves and none will before a resume, an unlock or a reset: a reset now keeps the position.
    pub fn at_rest(&self) -> bool {
        matches!(
            self,
            State::Idle
                | State::Hold { at_rest: true }
                | State::Alarm
                | State::Check
                | State::Sleep
        ) || matches!(self, State::Door(DoorPhase::Closed | DoorPhase::Ajar))
    }

    /// As GRBL spells it.
    pub fn text(&self) -> &str {
        match self {
            State::Idle => "Idle",
            State::Run => "Run",
            State::Hold { at_rest: true } => "Hold:0",
            State::Hold { at_rest: false } => "Hold:1",
            State::Jog => "Jog",
            State::Home => "Home",
            State::Alarm => "Alarm",
            State::Check => "Check",
            State::Door(DoorPhase::Closed) => "Door:0",
            State::Door(DoorPhase::Ajar) => "Door:1",
            State::Door(DoorPhase::Stopping) => "Door:2",
            State::Door(DoorPhase::Resuming) => "Door:3",
            State::Sleep => "Sleep",
            State::Other(text) => text,
        }
    }
}

/// Where the tool is. The unit is the report's: mm, or inch with `$13=1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// `MPos`.
    Machine([f64; 3]),
    /// `WPos`: machine minus `WCO`.
    Work([f64; 3]),
}

/// `Bf:`, a snapshot of free room: for diagnosis, never for flow control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Buffer {
    /// Free planner blocks.
    pub blocks: usize,
    /// Free bytes of the receive buffer.
    pub bytes: usize,
}

/// `Ov:`, percent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrides {
    /// Feed, 10 to 200.
    pub feed: u16,
    /// Rapids, 25, 50 or 100.
    pub rapid: u16,
    /// Spindle, 10 to 200.
    pub spindle: u16,
}

/// One status report. Fields the controller left out are `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// State.
    pub state: State,
    /// Position, if the report has one.
    pub position: Option<Position>,
    /// Free buffers (`$10` bit 1).
    pub buffer: Option<Buffer>,
    /// Line number being executed (only builds with line numbers).
    pub line: Option<u32>,
    /// Speed along the path now, report units per minute.
    pub feed: Option<f64>,
    /// Spindle speed, rpm.
    pub speed: Option<f64>,
    /// Active pins, letters of `XYZPDHRS`.
    pub pins: String,
    /// Work coordinate offset, report units.
    pub work_offset: Option<[f64; 3]>,
    /// Overrides.
    pub overrides: Option<Overrides>,
    /// What is switched on (`S`, `C`, `F`, `M`), said only beside `Ov`.
    pub accessories: String,
    /// `H:1` or `H:0`, said by grblHAL: the machine has been homed.
    pub homed: Option<bool>,
}

impl Status {
    /// A report that says only the state.
    pub fn new(state: State) -> Status {
        Status {
            state,
            position: None,
            buffer: None,
            line: None,
            feed: None,
            speed: None,
            pins: String::new(),
            work_offset: None,
            overrides: None,
            accessories: String::new(),
            homed: None,
        }
    }

    /// Reads a whole report with its angle brackets; `None` when it is not one (cut short, or no state). Unknown and unreadable
    /// fields are skipped: a damaged field must not pass for a position.
    pub fn parse(line: &str) -> Option<Status> {
        let body = line.strip_prefix('<')?.strip_suffix('>')?;
        let mut fields = body.split('|');
        let state = fields.next().filter(|s| !s.is_empty())?;
        let mut status = Status::new(State::parse(state));
        for field in fields {
            let Some((name, value)) = field.split_once(':') else {
                continue;
            };
            match name {
                "MPos" => {
                    status.position = triple(value).map(Position::Machine).or(status.position)
                }
                "WPos" => status.position = triple(value).map(Position::Work).or(status.position),
                "WCO" => status.work_offset = triple(value),
                "Bf" => {
                    if let Some((blocks, bytes)) = value.split_once(',')
                        && let (Ok(blocks), Ok(bytes)) = (blocks.parse(), bytes.parse())
                    {
                        status.buffer = Some(Buffer { blocks, bytes });
                    }
                }
                "Ln" => status.line = value.parse().ok(),
                "FS" => {
                    let mut parts = value.split(',');
                    status.feed = parts.next().and_then(number);
                    status.speed = parts.next().and_then(number);
                }
                "F" => status.feed = number(value),
                "Pn" => status.pins = value.to_string(),
                "Ov" => {
                    let parts: Vec<u16> = value.split(',').filter_map(|p| p.parse().ok()).collect();
                    if let [feed, rapid, spindle] = parts[..] {
                        status.overrides = Some(Overrides {
                            feed,
                            rapid,
                            spindle,
                        });
                    }
                }
                "A" => status.accessories = value.to_string(),
                // grblHAL writes `H:1` or `H:1,mask`.
                "H" => status.homed = value.split(',').next().map(|v| v == "1"),
                _ => {}
            }
        }
        Some(status)
    }

    /// Writes the report as GRBL 1.1h does, in its order of fields: 3 decimals and whole feeds in mm, 4 and 1 in inch.
    pub fn write(&self, inches: bool) -> String {
        let (places, feed_places) = if inches { (4, 1) } else { (3, 0) };
        let list = |v: &[f64; 3]| {
            format!(
                "{:.places$},{:.places$},{:.places$}",
                zero(v[0]),
                zero(v[1]),
                zero(v[2])
            )
        };
        let mut out = format!("<{}", self.state.text());
        // Writing into a String cannot fail.
        match &self.position {
            Some(Position::Machine(p)) => _ = write!(out, "|MPos:{}", list(p)),
            Some(Position::Work(p)) => _ = write!(out, "|WPos:{}", list(p)),
            None => {}
        }
        if let Some(b) = self.buffer {
            _ = write!(out, "|Bf:{},{}", b.blocks, b.bytes);
        }
        if let Some(n) = self.line {
            _ = write!(out, "|Ln:{n}");
        }
        match (self.feed, self.speed) {
            (Some(f), Some(s)) => _ = write!(out, "|FS:{f:.feed_places$},{s:.0}"),
            (Some(f), None) => _ = write!(out, "|F:{f:.feed_places$}"),
            _ => {}
        }
        if !self.pins.is_empty() {
            _ = write!(out, "|Pn:{}", self.pins);
        }
        if let Some(o) = &self.work_offset {
            _ = write!(out, "|WCO:{}", list(o));
        }
        if let Some(o) = self.overrides {
            _ = write!(out, "|Ov:{},{},{}", o.feed, o.rapid, o.spindle);
            if !self.accessories.is_empty() {
                _ = write!(out, "|A:{}", self.accessories);
            }
        }
        out.push('>');
        out
    }
}

/// GRBL counts steps, so it never prints a negative zero.
fn zero(x: f64) -> f64 {
    if x.abs() < 5e-5 { 0.0 } else { x }
}

/// A plain finite decimal; `inf` and `nan` are damage, not numbers.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|v| v.is_finite())
}

/// The first three of at least three numbers (other firmwares may have more axes).
pub(super) fn triple(text: &str) -> Option<[f64; 3]> {
    let mut parts = text.split(',').map(number);
    let (x, y, z) = (parts.next()??, parts.next()??, parts.next()??);
    parts.all(|p| p.is_some()).then_some([x, y, z])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_what_the_firmware_sent() {
        let s =
            Status::parse("<Run|MPos:1.868,0.000,-2.5|Bf:14,128|FS:600,0|WCO:0.000,0.000,1.000>")
                .unwrap();
        assert_eq!(s.state, State::Run);
        assert_eq!(s.position, Some(Position::Machine([1.868, 0.0, -2.5])));
        assert_eq!(
            s.buffer,
            Some(Buffer {
                blocks: 14,
                bytes: 128
            })
        );
        assert_eq!((s.feed, s.speed), (Some(600.0), Some(0.0)));
        assert_eq!(s.work_offset, Some([0.0, 0.0, 1.0]));
        let s = Status::parse("<Hold:0|MPos:2.400,0.000,0.000|FS:0,500|Pn:P|Ov:120,100,90|A:SF>")
            .unwrap();
        assert!(s.state.at_rest());
        assert_eq!(
            s.overrides,
            Some(Overrides {
                feed: 120,
                rapid: 100,
                spindle: 90
            })
        );
        assert_eq!((s.pins.as_str(), s.accessories.as_str()), ("P", "SF"));
    }

    #[test]
    fn strangers_are_not_ready_and_damage_is_not_a_position() {
        assert!(!Status::parse("<Tool|MPos:0,0,0>").unwrap().state.at_rest());
        assert!(!Status::parse("<Hold|MPos:0,0,0>").unwrap().state.at_rest());
        assert_eq!(
            Status::parse("<Idle|MPos:0.0,nan,0.0>").unwrap().position,
            None
        );
        assert_eq!(Status::parse("<Idle|MPos:0.0,1.0>").unwrap().position, None);
        assert_eq!(
            Status::parse("<Idle|DTG:1,2,3|WCS:G54|FS:1,2,3>")
                .unwrap()
                .feed,
            Some(1.0)
        );
        assert_eq!(Status::parse("<Idle|MPos:0,0,0"), None);
        assert_eq!(Status::parse("<>"), None);
    }

    fn state() -> impl Strategy<Value = State> {
        proptest::sample::select(vec![
            State::Idle,
            State::Run,
            State::Hold { at_rest: true },
            State::Hold { at_rest: false },
            State::Jog,
            State::Home,
            State::Alarm,
            State::Check,
            State::Door(DoorPhase::Closed),
            State::Door(DoorPhase::Ajar),
            State::Door(DoorPhase::Stopping),
            State::Door(DoorPhase::Resuming),
            State::Sleep,
        ])
    }

    proptest! {
        /// What the controller writes, the host reads.
        #[test]
        fn reads_back_what_it_writes(
            state in state(), p in proptest::array::uniform3(-9_999_999i32..9_999_999), feed in 0u32..20_000, inches: bool,
            blocks in proptest::option::of(0usize..16), wco in proptest::option::of(proptest::array::uniform3(-999_999i32..999_999)),
        ) {
            let unit = if inches { 1e4 } else { 1e3 };
            let mm = |v: [i32; 3]| v.map(|c| f64::from(c) / unit);
            let mut s = Status::new(state);
            s.position = Some(Position::Machine(mm(p)));
            s.feed = Some(f64::from(feed));
            s.speed = Some(0.0);
            s.buffer = blocks.map(|blocks| Buffer { blocks, bytes: 128 });
            s.work_offset = wco.map(mm);
            prop_assert_eq!(Status::parse(&s.write(inches)), Some(s));
        }

        #[test]
        fn never_panics(text in "\\PC{0,80}") {
            let _ = Status::parse(&text);
            let _ = Status::parse(&format!("<{text}>"));
        }
    }
}
