//! A controller with all that is done to it: faults on its cable, hands on its pins, a pen that notes where its axes go.
//!
//! Crosses the border: bytes and seconds in, bytes out, as with the [`Controller`] itself; time is turned by hand, and nothing here does
//! I/O. The fronts ([`super::front`]) turn it by the clock; tests turn it in virtual time.

use super::fault::{Faults, Side};
use super::fault_plan::Deed;
use super::intake::Intake;
use super::rehearsal::{Drive, PartPlace, Recorder};
use super::script::Script;
use super::{Controller, Memory, Pins, SAME_MOMENT};
use crate::wire::{Lines, Reply};

/// What is done to a controller. The default is nothing.
#[derive(Clone, Debug, Default)]
pub struct RigOptions {
    /// What goes wrong on purpose.
    pub faults: Faults,
    /// What is done to the pins.
    pub script: Script,
    /// Note the way of the axes.
    pub record: bool,
}

/// How long a power cycle keeps it off, s.
const OFF: f64 = 1.0;
/// Most bytes kept for a host that does not take them: older ones are dropped, as on a cable nobody listens to.
const BACKLOG: usize = 1 << 20;

/// The controller and all that is done to it.
#[derive(Clone, Debug)]
pub struct Rig {
    controller: Controller,
    faults: Faults,
    script: Script,
    pins: Pins,
    recorder: Option<Recorder>,
    now: f64,
    /// Switched off until then.
    off_until: Option<f64>,
    out: Vec<u8>,
    said: Lines,
    programs_ended: usize,
}

impl From<Controller> for Rig {
    fn from(controller: Controller) -> Rig {
        Rig::new(controller, RigOptions::default())
    }
}

impl Rig {
    /// Puts a controller that was just switched on into the rig. Time begins here.
    pub fn new(controller: Controller, options: RigOptions) -> Rig {
        let mut rig = Rig {
            recorder: options.record.then(|| Recorder::new(&controller)),
            pins: controller.pins(),
            controller,
            faults: options.faults,
            script: options.script,
            now: 0.0,
            off_until: None,
            out: Vec::new(),
            said: Lines::default(),
            programs_ended: 0,
        };
        rig.spoil();
        rig.settle();
        rig
    }

    /// Faults that sit in the controller itself.
    fn spoil(&mut self) {
        let plan = self.faults.plan();
        if plan.eeprom_loss {
            self.controller.build.quirks.eeprom_byte_loss = true;
        }
        if let Some(bytes) = plan.rx_bytes {
            self.controller.intake = Intake::new(bytes);
        }
    }

    /// Bytes from the host.
    pub fn feed(&mut self, bytes: &[u8]) {
        self.faults.send(Side::Controller, bytes, self.now);
        self.settle();
    }

    /// Lets machine time pass.
    pub fn advance(&mut self, seconds: f64) {
        let end = self.now + seconds.max(0.0);
        // Time goes on with every step, be it by less than anything can tell apart.
        loop {
            let next = self.next_change().filter(|t| *t < end).unwrap_or(end);
            let step = (next - self.now).max(SAME_MOMENT);
            if self.off_until.is_none() {
                self.controller.advance(step);
            }
            self.now = (self.now + step).max(next);
            self.settle();
            if self.now >= end {
                return;
            }
        }
    }

    /// What has arrived at the host since the last call.
    pub fn output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// Something has arrived at the host and was not taken yet.
    pub fn has_output(&self) -> bool {
        !self.out.is_empty()
    }

    /// Time since it was put into the rig, s.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// When something happens by itself next; `None` when everything rests.
    pub fn next_change(&self) -> Option<f64> {
        let controller = match self.off_until {
            Some(t) => Some(t),
            // Its own clock begins anew with each restart.
            None => self
                .controller
                .next_change()
                .map(|t| self.now + (t - self.controller.now()).max(0.0)),
        };
        [controller, self.faults.next(), self.script.next()]
            .into_iter()
            .flatten()
            .map(|t| t.max(self.now))
            .reduce(f64::min)
    }

    /// The controller waits for something that the host can do nothing about: see [`Controller::is_busy`].
    pub fn is_busy(&self) -> bool {
        match self.off_until {
            Some(_) => true,
            None => {
                // Bytes on their way need nobody's help either.
                let cable = &self.controller.cable;
                let travelling = cable.next_arrival().is_some() || cable.quiet_at().is_some();
                self.controller.is_busy() || travelling || self.faults.is_carrying()
            }
        }
    }

    /// More bytes are on their way than a driver takes ahead of its line: a host would have to wait.
    pub fn is_choked(&self) -> bool {
        self.controller.cable.is_choked() || self.faults.is_choked()
    }

    /// Axes move or a queue waits to.
    pub fn is_moving(&self) -> bool {
        self.off_until.is_none() && self.controller.is_moving()
    }

    /// The controller, to be looked at.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// What survives when it is switched off.
    pub fn memory(&self) -> Memory {
        self.controller.memory()
    }

    /// The cable.
    pub fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Ends of programs (M2, M30) so far.
    pub fn programs_ended(&self) -> usize {
        self.programs_ended
    }

    /// Says where the part lies that the way is noted over.
    pub fn lay_part(&mut self, part: PartPlace) {
        if let Some(recorder) = &mut self.recorder {
            recorder.part = part;
        }
    }

    /// The way driven since the last call. Empty without [`RigOptions::record`].
    pub fn take_drive(&mut self) -> Drive {
        self.recorder
            .as_mut()
            .map_or_else(Drive::default, Recorder::take)
    }

    /// Nothing was driven since the way was last taken.
    pub fn is_drive_empty(&self) -> bool {
        self.recorder.as_ref().is_none_or(Recorder::is_empty)
    }

    /// The controller starts anew: a reset button, DTR, the supply.
    pub fn power_cycle(&mut self) {
        self.restart();
        self.settle();
    }

    fn restart(&mut self) {
        let before = self.controller.position();
        self.controller.power_cycle();
        self.spoil();
        // Hands on the buttons stay where they are.
        self.controller.set_pins(self.pins);
        self.said.clear();
        if let Some(recorder) = &mut self.recorder {
            recorder.restarted(&self.controller, before);
        }
    }

    /// All that happens at this moment.
    fn settle(&mut self) {
        // Deeds at lines are done between the lines; no more of them than were planned.
        loop {
            if let Some(recorder) = &mut self.recorder {
                recorder.look(&self.controller, self.now);
            }
            self.hear_controller();
            if self.off_until.is_some_and(|t| self.now >= t) {
                self.off_until = None;
                self.restart();
            }
            while let Some(deed) = self.faults.deed(self.now) {
                match deed {
                    Deed::Reset if self.off_until.is_none() => self.restart(),
                    Deed::PowerCycle => self.off_until = Some(self.now + OFF),
                    // Pressing reset while it is off does nothing; the plug is the cable's affair.
                    Deed::Reset | Deed::Plug | Deed::Unplug => {}
                }
            }
            let place = self.controller.position();
            if self.script.play(self.now, &place, &mut self.pins) && self.off_until.is_none() {
                self.controller.set_pins(self.pins);
            }
            let arrived = self.faults.arrive(Side::Controller, self.now);
            if arrived.is_empty() {
                break;
            }
            if self.off_until.is_none() {
                self.controller.feed(&arrived);
            }
        }
        self.hear_controller();
        let heard = self.faults.arrive(Side::Host, self.now);
        self.out.extend(heard);
        if self.out.len() > BACKLOG {
            self.out.drain(..self.out.len() - BACKLOG);
        }
    }

    fn hear_controller(&mut self) {
        if !self.controller.has_output() {
            return;
        }
        let said = self.controller.output();
        for line in self.said.feed(&said) {
            let ended = matches!(Reply::parse(&line), Reply::Message(m) if m == "Pgm End");
            self.programs_ended += usize::from(ended);
        }
        if self.off_until.is_none() {
            self.faults.send(Side::Host, &said, self.now);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::fault_plan::FaultPlan;
    use super::*;
    use proptest::prelude::*;

    fn rig(seed: u64, faults: &[&str]) -> Rig {
        let mut plan = FaultPlan::default();
        for f in faults {
            plan.add(f).unwrap();
        }
        Rig::new(
            Controller::new(Memory::default()),
            RigOptions {
                faults: Faults::new(seed, plan),
                ..RigOptions::default()
            },
        )
    }

    fn said(rig: &mut Rig) -> String {
        String::from_utf8_lossy(&rig.output()).into_owned()
    }

    const WELCOME: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";

    #[test]
    fn without_faults_it_is_the_controller() {
        let (mut r, mut c) = (rig(1, &[]), Controller::new(Memory::default()));
        let mut clock = 0.0;
        for piece in ["G1X1F60\n", "?", "G0Y2\n$$\n", "!", "?", "~"] {
            r.feed(piece.as_bytes());
            c.feed(piece.as_bytes());
            r.advance(0.4);
            c.advance(0.4);
            clock += 0.4;
            assert_eq!(r.output(), c.output(), "after {piece:?}");
            assert!((r.now() - clock).abs() < 1e-6);
        }
        assert!((r.controller().position() - c.position()).norm() < 1e-6);
    }

    #[test]
    fn a_reset_at_a_line_greets_in_the_middle_of_the_job() {
        let mut r = rig(1, &["reset-at-line:2"]);
        assert_eq!(said(&mut r), WELCOME);
        r.feed(b"G21\nG90\nG94\n");
        assert_eq!(said(&mut r), format!("ok\r\nok\r\n{WELCOME}ok\r\n"));
    }

    #[test]
    fn a_power_cycle_is_deaf_for_a_second_and_forgets() {
        let mut r = rig(1, &["power-cycle-at:2s"]);
        r.feed(b"G1X1F60\n");
        r.advance(1.9);
        assert!(r.controller().position().x > 0.5);
        r.advance(0.5);
        said(&mut r);
        r.feed(b"?");
        assert_eq!(said(&mut r), "");
        r.advance(1.0);
        assert_eq!(said(&mut r), WELCOME);
        assert_eq!(r.controller().position().x, 0.0);
    }

    #[test]
    fn a_pulled_plug_leaves_the_job_running() {
        let mut r = rig(1, &["unplug-at:0.5s", "plug-at:5s"]);
        r.feed(b"G1X1F60\n");
        r.advance(0.6);
        said(&mut r);
        r.feed(b"?");
        r.advance(5.0);
        assert_eq!(said(&mut r), "");
        r.feed(b"?");
        assert!(said(&mut r).starts_with("<Idle|MPos:1.000,"));
    }

    #[test]
    fn a_small_buffer_loses_what_its_size_does_not_promise() {
        let mut r = rig(1, &["rx-bytes:16"]);
        r.feed(b"$I\n");
        assert!(said(&mut r).contains("[OPT:V,15,128]"));
        r.feed(b"G4P1\nG0X1\nG0X2\nG0X3\nG0X4\n");
        assert!(r.controller().bytes_lost() > 0);
    }

    #[test]
    fn pins_follow_their_script() {
        let script = Script::read("p", "1s probe on\nat X>2 door on").unwrap();
        let mut r = Rig::new(
            Controller::new(Memory::default()),
            RigOptions {
                script,
                ..RigOptions::default()
            },
        );
        r.feed(b"G1X3F300\n");
        r.advance(0.9);
        assert!(!r.controller().pins().probe);
        r.advance(0.2);
        assert!(r.controller().pins().probe);
        r.advance(2.0);
        assert!(r.controller().pins().door);
        r.power_cycle();
        assert!(r.controller().pins().probe, "the hand is still on it");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The same seed, bytes and moments give the same answers at the same moments.
        #[test]
        fn one_seed_replays_the_conversation(
            seed: u64,
            talk in proptest::collection::vec(("(G1X[0-9]F[1-9]00\n|\\?|!|~|\\$\\$\n|\\$X\n|G4P0\\.[0-9]\n)", 0.0f64..0.5), 1..30),
        ) {
            let faults = ["drop:0.02", "duplicate:0.02", "flip:0.02", "lose-ok:0.2", "delay:7ms", "reset-at-line:5", "unplug-at:2s", "plug-at:2.5s",
                "power-cycle-at:4s"];
            let run = || {
                let mut r = rig(seed, &faults);
                let mut log = Vec::new();
                for (bytes, wait) in &talk {
                    r.feed(bytes.as_bytes());
                    r.advance(*wait);
                    log.push((r.output(), r.now().to_bits(), r.controller().position()));
                }
                (log, r.faults().tally())
            };
            prop_assert_eq!(run(), run());
        }

        /// Hostile bytes, with and without noise, crash nothing, and a reset brings it back.
        #[test]
        fn hostile_bytes(
            talk in proptest::collection::vec((proptest::collection::vec(any::<u8>(), 0..300), 0.0f64..3.0), 1..20), seed: u64,
        ) {
            let mut r = rig(seed, &["flip:0.1", "drop:0.1", "duplicate:0.1"]);
            for (bytes, wait) in &talk {
                r.feed(bytes);
                r.advance(*wait);
            }
            let mut sound = rig(seed, &[]);
            for (bytes, wait) in &talk {
                sound.feed(bytes);
                sound.advance(*wait);
            }
            sound.output();
            // Deafness after an alarm may swallow the first; a homing cycle ends.
            for _ in 0..3 {
                sound.feed(&[0x18]);
                sound.advance(2.0);
            }
            prop_assert!(said(&mut sound).contains("Grbl 1.1h"));
        }
    }
}
