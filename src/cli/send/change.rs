//! A tool change: up before anybody is asked, the old tool measured if there is a sensor, the prompt, the new tool measured or touched off
//! by hand, the difference shown and confirmed, every work offset moved by it, and back to where the program believes the tool to be.

use super::hands::{Done, Hands, Leave, Offer, loses_the_job};
use super::listener::Listener;
use crate::link::Known;
use crate::link::errand::{
    Down, ErrandError, GoTo, NO_DIFFERENCE, Probe, ProbeOptions, Retract, Rise, ToolLength, Watch,
};
use crate::link::journal::Offsets;
use crate::link::{Progress, Prompt};

/// Feed of the way back down to where the program left off, mm/min.
const BACK_DOWN: f64 = 300.0;
/// Feed of the first touch of a sensor, mm/min: the whole way from the top is looked at.
const LOOK: f64 = 200.0;
/// Above the program's highest place, when the machine's top is not known, mm.
const NO_HIGHEST: f64 = 10.0;

/// How a new tool is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Gauge {
    /// By the operator, who jogs and sets work Z.
    #[default]
    Hand,
    /// On a plate of this thickness, mm, that lies on work Z zero below the tool.
    Plate(f64),
    /// On a fixed sensor at this place in machine coordinates, mm: only the difference to the tool before counts.
    Sensor([f64; 2]),
}

/// What a tool change needs to know.
#[derive(Clone, Debug, Default)]
pub struct Changer {
    /// How a new tool is measured.
    pub gauge: Gauge,
    /// Lowest and highest work Z of the program, mm.
    pub range: Option<[f64; 2]>,
    /// The difference that a sensor measured needs no second word.
    pub yes: bool,
    /// Machine Z at which the tool in the spindle touched the sensor, mm.
    pub reference: Option<f64>,
}

/// How a tool change ended.
#[derive(Debug)]
pub enum Changed {
    /// The program goes on with these offsets; `None`: as they were.
    GoOn(Option<Box<Offsets>>),
    /// The operator ends the job.
    Stop,
    /// The job cannot go on, and why.
    Lost(String),
}

/// One tool change under way.
struct Change {
    /// Before it.
    before: Known,
    /// Where the program believes the tool to be, work coordinates, mm.
    left: Option<[f64; 3]>,
    /// How far it was lifted, mm.
    lifted: f64,
    /// The tool was measured: the difference, mm, or the new Z of the active work offset.
    measured: Option<f64>,
}

impl Changer {
    fn top(&self) -> Retract {
        Retract::TopOr(self.range.map_or(NO_HIGHEST, |r| r[1]))
    }

    /// The whole tool change. The session rests: everything was answered and the controller is Idle.
    pub fn change(
        &mut self,
        prompt: &Prompt,
        hands: &mut Hands<'_>,
        listener: &mut Listener,
    ) -> Changed {
        let up = hands.afresh(Rise::new(self.top()), listener);
        let before = up.known.clone();
        let mut change = Change {
            left: up.task.from,
            lifted: up.task.by,
            before,
            measured: None,
        };
        if up.task.by > 0.0 && up.result.is_ok() {
            listener.note(&format!(
                "lifted by {:.3} mm for the tool change",
                up.task.by
            ));
        }
        if let Err(e) = self.survived(up.result, "the tool was not lifted", listener) {
            return Changed::Lost(e);
        }
        if matches!(self.gauge, Gauge::Sensor(_)) && self.reference.is_none() {
            listener.note("measuring the tool in the spindle, before it is taken out");
            match self.touch(hands, listener) {
                Ok(Some(touch)) => self.reference = Some(touch),
                Ok(None) => {
                    return Changed::Lost(
                        "the old tool was not measured, so that nobody could tell how much longer the new one is: see to the sensor, then begin again with --resume".to_string(),
                    );
                }
                Err(why) => return Changed::Lost(why),
            }
        }
        let at = hands.start.elapsed();
        listener.hear(&Progress::Prompt(prompt.clone()), at);
        if !listener.can_answer() {
            return Changed::Lost(format!(
                "line {}: the tool has to be changed, and nobody can answer here: run it on a terminal, or write `resume` to standard input with --events",
                prompt.source
            ));
        }
        self.confirmed(prompt.to_string(), &mut change, hands, listener)
    }

    /// Asks, measures, shows and asks again until the operator goes on with what was shown.
    fn confirmed(
        &mut self,
        asked: String,
        change: &mut Change,
        hands: &mut Hands<'_>,
        listener: &mut Listener,
    ) -> Changed {
        let offer = Offer::ToolChange {
            measure: self.gauge != Gauge::Hand,
        };
        let mut shown: Option<f64> = None;
        let mut known = change.before.clone();
        listener.board.attention = Some(asked);
        loop {
            let measure = match hands.by_hand(known.clone(), listener, offer) {
                Leave::GoOn => change.measured.is_none() && self.gauge != Gauge::Hand,
                Leave::Measure => true,
                Leave::Stop => return Changed::Stop,
                Leave::Lost(e) => return Changed::Lost(e.to_string()),
            };
            if measure {
                match self.measure(change, hands, listener) {
                    Ok(true) => shown = None,
                    Ok(false) => continue,
                    Err(why) => return Changed::Lost(why),
                }
            }
            // The offsets as they are now, whoever set them.
            let now = hands.afresh(Watch { quit: true }, listener);
            known = now.known;
            if let Err(e) = now.result {
                return Changed::Lost(e.to_string());
            }
            if volatile(&known) != volatile(&change.before) {
                return Changed::Lost(
                    "a reset at the tool change cost G92 or the tool length (G43.1) that the program counts on: begin again with --resume".to_string(),
                );
            }
            let (by, but) = self.difference(change, &known);
            let told = self.told(by, change, &known);
            let same = shown.is_some_and(|s| (s - by).abs() < NO_DIFFERENCE);
            let unattended = !listener.has_keys() && change.measured.is_none();
            // A plate has to be taken away first, whatever was said before.
            let yes = self.yes && !matches!(self.gauge, Gauge::Plate(_));
            if same || yes || unattended {
                if !same {
                    listener.note(&told);
                }
                return self.carry_out(ToolLength::new(by, but), change, hands, listener);
            }
            shown = Some(by);
            let again = match self.gauge {
                Gauge::Hand => "",
                _ => ", p measures again",
            };
            let question = format!("{told}: r goes on with it{again}, x stops");
            listener.confirm(&question);
        }
    }

    /// How much longer the new tool is, mm, and the work offset that is right already: the one that a plate or the operator's hand set.
    fn difference(&self, change: &Change, now: &Known) -> (f64, Option<usize>) {
        let by_hand = z_of(now) - z_of(&change.before);
        match (self.gauge, change.measured, self.reference) {
            (Gauge::Sensor(_), Some(touch), Some(reference)) if by_hand.abs() < NO_DIFFERENCE => {
                (touch - reference, None)
            }
            _ => (
                by_hand,
                Some(change.before.modes.work_offset().unwrap_or(0)),
            ),
        }
    }

    fn told(&self, by: f64, change: &Change, now: &Known) -> String {
        let system = 54 + now.modes.work_offset().unwrap_or(0);
        let mut text = match (by.abs() < NO_DIFFERENCE, self.gauge) {
            (true, Gauge::Hand) => format!(
                "work Z zero of G{system} is as before: the new tool must be exactly as long as the old one"
            ),
            (true, _) => "the new tool is as long as the old one".to_string(),
            (false, _) => format!(
                "the new tool is {:.3} mm {} than the old one",
                by.abs(),
                if by > 0.0 { "longer" } else { "shorter" }
            ),
        };
        if matches!(self.gauge, Gauge::Plate(_)) && change.measured.is_some() {
            text += ". Take the plate and its clip away";
        }
        if let Some(left) = change.left.filter(|_| change.lifted > 0.0) {
            text += &format!(
                ". Then over X{:.3} Y{:.3} and down to Z{:.3}, where the program left off, with the spindle off",
                left[0] + 0.0,
                left[1] + 0.0,
                left[2] + 0.0
            );
        }
        let room = crate::link::errand::room_of_z(now);
        let zero = z_of(&change.before) + by;
        if let (Some([low, high]), Some((lowest, highest))) = (self.range, room) {
            if low + zero < lowest - 0.001 {
                text += &format!(
                    ". The program's lowest place would be {:.3} mm below the machine's travel",
                    lowest - low - zero
                );
            } else if high + zero > highest + 0.001 {
                text += &format!(
                    ". The program's highest place would be {:.3} mm above the machine's travel",
                    high + zero - highest
                );
            }
        }
        text
    }

    /// Moves the other work offsets, and goes back to where the program left off.
    fn carry_out(
        &mut self,
        length: ToolLength,
        change: &Change,
        hands: &mut Hands<'_>,
        listener: &mut Listener,
    ) -> Changed {
        let by = length.by;
        let done = hands.afresh(length, listener);
        if let Err(e) = done.result {
            return Changed::Lost(format!("the tool's length could not be written: {e}"));
        }
        if !done.task.moved.is_empty() {
            let list: Vec<String> = done
                .task
                .moved
                .iter()
                .map(|(i, z)| format!("G{} Z{:.3}", 54 + i, z + 0.0))
                .collect();
            listener.note(&format!(
                "written to the controller (G10 L2), by the same difference: {}",
                list.join(", ")
            ));
        }
        self.reference = match self.gauge {
            Gauge::Sensor(_) => change.measured,
            _ => None,
        };
        let Some(left) = change.left else {
            return Changed::Lost("the controller reports no work position".to_string());
        };
        let mut now = hands.afresh(Watch { quit: true }, listener);
        let here = now.known.work_position();
        let back = here.is_none_or(|h| (0..3).any(|i| (h[i] - left[i]).abs() > 0.002));
        if back {
            listener.note(&format!(
                "back to where the program left off: X{:.3} Y{:.3} Z{:.3}",
                left[0] + 0.0,
                left[1] + 0.0,
                left[2] + 0.0
            ));
            let task = GoTo::place(self.top(), left, Down::Feed(BACK_DOWN));
            let went: Done<GoTo> = hands.afresh(task, listener);
            if let Err(e) = went.result {
                return Changed::Lost(format!("the way back to the program's place: {e}"));
            }
            now = hands.afresh(Watch { quit: true }, listener);
        }
        if let Err(e) = now.result {
            return Changed::Lost(e.to_string());
        }
        let changed =
            by.abs() >= NO_DIFFERENCE || now.known.offsets.g5x != change.before.offsets.g5x;
        Changed::GoOn(changed.then(|| Box::new(Offsets::of(&now.known.offsets))))
    }

    /// Measures the new tool; `false`: it did not work, and the operator may try again.
    fn measure(
        &mut self,
        change: &mut Change,
        hands: &mut Hands<'_>,
        listener: &mut Listener,
    ) -> Result<bool, String> {
        listener.note("measuring the new tool: any key but r stops it");
        if let Gauge::Plate(plate) = self.gauge {
            let task = Probe::new(ProbeOptions {
                plate,
                ..ProbeOptions::default()
            });
            let done = hands.afresh(task, listener);
            change.measured = done.task.origin.or(change.measured);
            return self.survived(done.result, "the tool was not measured", listener);
        }
        let touch = self.touch(hands, listener)?;
        change.measured = touch.or(change.measured);
        Ok(touch.is_some())
    }

    /// Drives over the sensor and touches it: machine Z, mm; `None` if it did not work and may be tried again.
    fn touch(
        &mut self,
        hands: &mut Hands<'_>,
        listener: &mut Listener,
    ) -> Result<Option<f64>, String> {
        let Gauge::Sensor(at) = self.gauge else {
            return Ok(None);
        };
        let what = "the tool was not measured";
        let over = hands.afresh(GoTo::above(Retract::MachineTop, at), listener);
        let known = over.known.clone();
        if !self.survived(over.result, what, listener)? {
            return Ok(None);
        }
        let (Some((low, _)), Some(here)) = (
            crate::link::errand::room_of_z(&known),
            known.machine_position,
        ) else {
            return Ok(None);
        };
        let task = Probe::new(ProbeOptions {
            distance: (here[2] - low).clamp(0.1, 500.0),
            feed: LOOK,
            retract: ProbeOptions::default().lift,
            set_zero: false,
            ..ProbeOptions::default()
        });
        let done = hands.afresh(task, listener);
        let touch = done.task.touch.map(|t| t.second);
        if !self.survived(done.result, what, listener)? {
            return Ok(None);
        }
        let up = hands.afresh(Rise::new(Retract::MachineTop), listener);
        self.survived(up.result, "the tool was not lifted", listener)?;
        Ok(touch)
    }

    /// False when an errand failed but nothing is lost; an error when the job cannot go on.
    fn survived(
        &self,
        result: Result<(), ErrandError>,
        what: &str,
        listener: &mut Listener,
    ) -> Result<bool, String> {
        match result {
            Ok(()) => Ok(true),
            Err(e) if loses_the_job(&e) => Err(format!("{what}: {e}")),
            Err(e) => {
                listener.note(&format!("{what}: {e}"));
                Ok(false)
            }
        }
    }
}

/// Machine Z of the active work offset, mm.
fn z_of(known: &Known) -> f64 {
    let active = known.modes.work_offset().unwrap_or(0);
    let g5x = known.offsets.g5x.get(active).copied().flatten();
    g5x.map_or(0.0, |o| o[2])
}

/// What a reset makes a controller forget, in thousandths.
fn volatile(known: &Known) -> [i64; 4] {
    let g92 = known.offsets.g92.unwrap_or_default();
    let tlo = known.offsets.tlo.unwrap_or_default();
    [g92[0], g92[1], g92[2], tlo].map(|v| (v * 1e3).round() as i64)
}

/// The lowest and highest Z that a program goes to, in work coordinates, mm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Range(pub Option<[f64; 2]>);

impl Range {
    /// Takes in what the program tells the machine.
    pub fn hear(&mut self, event: &crate::gcode::Event) {
        if let crate::gcode::Event::Motion(m) = event
            && !m.machine_coordinates
        {
            let [low, high] = self.0.unwrap_or([m.to.z, m.to.z]);
            self.0 = Some([low.min(m.to.z), high.max(m.to.z)]);
        }
    }
}
