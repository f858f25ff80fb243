//! What goes wrong on purpose: noise on the cable, lost acknowledgements, a pulled plug, resets; all from one seed.
//!
//! Crosses the border: bytes of either direction with the moment they were sent (s) in; what of them arrives, and when, out. No clock
//! and no I/O: the same seed, plan, bytes and moments give the same faults, however the bytes were cut into pieces. [`super::Rig`] puts
//! one between a controller and whoever talks to it; a test may use it alone.

use super::fault_plan::{Deed, FaultPlan, Noise, When};
use std::collections::VecDeque;

/// Random numbers that are the same on every machine and forever: SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom
/// number generators", 2014).
#[derive(Clone, Debug, PartialEq)]
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// True with probability `p`. Nothing is drawn when it can only be false.
    fn hit(&mut self, p: f64) -> bool {
        p > 0.0 && ((self.next() >> 11) as f64) < p * (1u64 << 53) as f64
    }
}

/// Where bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// To the controller.
    Controller,
    /// To the host.
    Host,
}

/// What has been done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes dropped.
    pub dropped: usize,
    /// Bytes that arrived twice.
    pub duplicated: usize,
    /// Bytes that arrived with a wrong bit.
    pub flipped: usize,
    /// Acknowledgements lost.
    pub oks_lost: usize,
    /// Bytes that vanished while the plug was out.
    pub vanished: usize,
    /// Resets and power cycles.
    pub restarts: usize,
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} bytes dropped, {} duplicated, {} flipped, {} acknowledgements lost, {} bytes into a pulled plug, {} restarts",
            self.dropped,
            self.duplicated,
            self.flipped,
            self.oks_lost,
            self.vanished,
            self.restarts
        )
    }
}

/// One direction of the cable.
#[derive(Clone, Debug, PartialEq)]
struct Lane {
    noise: Noise,
    random: Random,
    /// Bytes under way and when they arrive.
    under_way: VecDeque<(f64, u8)>,
}

impl Lane {
    fn send(&mut self, byte: u8, due: f64, tally: &mut Tally) {
        let r = &mut self.random;
        // Each is drawn for each byte, so that what befalls a byte does not depend on what befell it otherwise.
        let dropped = r.hit(self.noise.drop);
        let twice = r.hit(self.noise.duplicate);
        let flipped = r.hit(self.noise.flip);
        let mut byte = byte;
        if flipped {
            byte ^= 1 << (r.next() % 8);
        }
        if dropped {
            tally.dropped += 1;
            return;
        }
        tally.flipped += usize::from(flipped);
        tally.duplicated += usize::from(twice);
        self.under_way.push_back((due, byte));
        if twice {
            self.under_way.push_back((due, byte));
        }
    }
}

/// Both directions of a cable that misbehaves as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Faults {
    plan: FaultPlan,
    seed: u64,
    to_controller: Lane,
    to_host: Lane,
    losing: Random,
    /// Bytes of a line that may become an `ok`; `None` in the middle of another line.
    maybe_ok: Option<Vec<u8>>,
    /// Line ends that have reached the controller.
    lines: usize,
    plugged: bool,
    /// Deeds that wait for their time or line.
    planned: Vec<(When, Deed)>,
    /// Deeds for the controller to suffer, now.
    due: VecDeque<Deed>,
    tally: Tally,
}

/// Bytes under way to the controller (a long delay, a host that does not wait for answers) at which the host is made to wait.
const CHOKED: usize = 1 << 16;

/// What the controller says to a line it has taken.
const OK: &[u8] = b"ok\r\n";

impl Default for Faults {
    /// A sound cable.
    fn default() -> Faults {
        Faults::new(0, FaultPlan::default())
    }
}

impl Faults {
    /// Faults of a plan; `seed` decides which bytes are hit.
    pub fn new(seed: u64, plan: FaultPlan) -> Faults {
        let mut mother = Random(seed);
        let mut lane = |noise: Noise| Lane {
            noise,
            random: Random(mother.next()),
            under_way: VecDeque::new(),
        };
        let (to_controller, to_host) = (lane(plan.to_controller), lane(plan.to_host));
        Faults {
            seed,
            to_controller,
            to_host,
            losing: Random(mother.next()),
            maybe_ok: Some(Vec::new()),
            lines: 0,
            plugged: true,
            planned: plan.deeds.clone(),
            due: VecDeque::new(),
            tally: Tally::default(),
            plan,
        }
    }

    /// What is planned.
    pub fn plan(&self) -> &FaultPlan {
        &self.plan
    }

    /// The seed that replays it.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// What has been done so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The plug is in.
    pub fn plugged(&self) -> bool {
        self.plugged
    }

    /// Bytes leave for `to`, `now` seconds after the start.
    pub fn send(&mut self, to: Side, bytes: &[u8], now: f64) {
        for &byte in bytes {
            match to {
                Side::Controller => self.put(to, byte, now),
                Side::Host => self.say(byte, now),
            }
        }
    }

    /// A byte of the controller's: acknowledgements may get lost whole.
    fn say(&mut self, byte: u8, now: f64) {
        if self.plan.lose_ok <= 0.0 {
            return self.put(Side::Host, byte, now);
        }
        let Some(held) = &mut self.maybe_ok else {
            if byte == b'\n' {
                self.maybe_ok = Some(Vec::new());
            }
            return self.put(Side::Host, byte, now);
        };
        held.push(byte);
        if held == OK {
            held.clear();
            if self.losing.hit(self.plan.lose_ok) {
                self.tally.oks_lost += 1;
                return;
            }
            for &b in OK {
                self.put(Side::Host, b, now);
            }
        } else if !OK.starts_with(held) {
            let held = std::mem::take(held);
            if byte != b'\n' {
                self.maybe_ok = None;
            }
            for b in held {
                self.put(Side::Host, b, now);
            }
        }
    }

    fn put(&mut self, to: Side, byte: u8, now: f64) {
        if !self.plugged {
            self.tally.vanished += 1;
            return;
        }
        let due = now + self.plan.delay;
        let lane = match to {
            Side::Controller => &mut self.to_controller,
            Side::Host => &mut self.to_host,
        };
        lane.send(byte, due, &mut self.tally);
    }

    /// What has arrived at `at` by `now`. At the controller the bytes end behind a line that something is planned for: look at
    /// [`Faults::deed`], then ask again.
    pub fn arrive(&mut self, at: Side, now: f64) -> Vec<u8> {
        let lane = match at {
            Side::Controller => &mut self.to_controller,
            Side::Host => &mut self.to_host,
        };
        let mut bytes = Vec::new();
        while let Some(&(_, byte)) = lane.under_way.front().filter(|b| b.0 <= now) {
            lane.under_way.pop_front();
            bytes.push(byte);
            if at == Side::Controller && byte == b'\n' {
                self.lines += 1;
                let line = self.lines;
                if self.planned.iter().any(|p| p.0 == When::Line(line)) {
                    self.make_due(|when| when == When::Line(line));
                    break;
                }
            }
        }
        bytes
    }

    /// The next deed due by `now` that the controller has to suffer; what befalls the cable alone is done here.
    pub fn deed(&mut self, now: f64) -> Option<Deed> {
        self.make_due(|when| matches!(when, When::At(t) if t <= now));
        while let Some(deed) = self.due.pop_front() {
            match deed {
                Deed::Unplug => {
                    self.plugged = false;
                    self.empty();
                }
                Deed::Plug => self.plugged = true,
                Deed::Reset | Deed::PowerCycle => {
                    self.tally.restarts += 1;
                    return Some(deed);
                }
            }
        }
        None
    }

    fn make_due(&mut self, is_due: impl Fn(When) -> bool) {
        let (due, planned) = self.planned.iter().partition(|p| is_due(p.0));
        self.planned = planned;
        let mut due: Vec<(When, Deed)> = due;
        due.sort_by(|a, b| a.0.time().total_cmp(&b.0.time()));
        self.due.extend(due.into_iter().map(|p| p.1));
    }

    /// Whatever is under way is lost: the plug was pulled, or the controller's chip for the cable went dark.
    pub fn empty(&mut self) {
        for lane in [&mut self.to_controller, &mut self.to_host] {
            self.tally.vanished += lane.under_way.len();
            lane.under_way.clear();
        }
        self.maybe_ok = Some(Vec::new());
    }

    /// Bytes are under way.
    pub fn is_carrying(&self) -> bool {
        [&self.to_controller, &self.to_host]
            .iter()
            .any(|l| !l.under_way.is_empty())
    }

    /// So many bytes are under way to the controller that the host should wait before it puts more.
    pub fn is_choked(&self) -> bool {
        self.to_controller.under_way.len() >= CHOKED
    }

    /// When something happens by itself next, s: bytes arrive, or a deed is due.
    pub fn next(&self) -> Option<f64> {
        let bytes = [&self.to_controller, &self.to_host]
            .into_iter()
            .filter_map(|l| l.under_way.front().map(|b| b.0));
        let deeds = self.planned.iter().filter_map(|p| match p.0 {
            When::At(t) => Some(t),
            When::Line(_) => None,
        });
        bytes.chain(deeds).reduce(f64::min)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn plan(specs: &[&str]) -> FaultPlan {
        let mut plan = FaultPlan::default();
        for s in specs {
            plan.add(s).unwrap();
        }
        plan
    }

    #[test]
    fn a_sound_cable_changes_nothing() {
        let mut f = Faults::default();
        f.send(Side::Controller, b"G1X1\n", 1.0);
        f.send(Side::Host, b"ok\r\n", 1.0);
        assert_eq!(f.arrive(Side::Controller, 1.0), b"G1X1\n");
        assert_eq!(f.arrive(Side::Host, 1.0), b"ok\r\n");
        assert_eq!(f.tally(), Tally::default());
    }

    #[test]
    fn only_whole_acknowledgements_get_lost() {
        let mut f = Faults::new(1, plan(&["lose-ok:1"]));
        let said = b"\r\nGrbl 1.1h ['$' for help]\r\nok\r\n[MSG:ok]\r\nok\r\nokay\r\nerror:2\r\n>G20:ok\r\n";
        for byte in said {
            f.send(Side::Host, &[*byte], 0.0);
        }
        assert_eq!(
            String::from_utf8(f.arrive(Side::Host, 0.0)).unwrap(),
            "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:ok]\r\nokay\r\nerror:2\r\n>G20:ok\r\n"
        );
        assert_eq!(f.tally().oks_lost, 2);
    }

    #[test]
    fn a_delay_keeps_the_order() {
        let mut f = Faults::new(1, plan(&["delay:20ms"]));
        f.send(Side::Controller, b"a", 0.0);
        f.send(Side::Controller, b"b", 0.01);
        assert_eq!(f.next(), Some(0.02));
        assert_eq!(f.arrive(Side::Controller, 0.019), b"");
        assert_eq!(f.arrive(Side::Controller, 0.02), b"a");
        assert_eq!(f.arrive(Side::Controller, 1.0), b"b");
    }

    #[test]
    fn a_pulled_plug_swallows_both_ways_until_it_is_in_again() {
        let mut f = Faults::new(1, plan(&["unplug-at:1s", "plug-at:2s", "delay:100ms"]));
        f.send(Side::Controller, b"lost on the way", 0.95);
        assert_eq!(f.next(), Some(1.0));
        assert_eq!(f.deed(1.0), None);
        assert!(!f.plugged());
        f.send(Side::Host, b"lost", 1.5);
        assert_eq!(f.deed(2.0), None);
        f.send(Side::Host, b"heard", 2.0);
        assert_eq!(f.arrive(Side::Host, 9.0), b"heard");
        assert_eq!(f.arrive(Side::Controller, 9.0), b"");
        assert_eq!(f.tally().vanished, 19);
    }

    #[test]
    fn a_reset_waits_for_its_line() {
        let mut f = Faults::new(1, plan(&["reset-at-line:2"]));
        f.send(Side::Controller, b"1\n2\n3\n", 0.0);
        assert_eq!(f.deed(0.0), None);
        assert_eq!(f.arrive(Side::Controller, 0.0), b"1\n2\n");
        assert_eq!(f.deed(0.0), Some(Deed::Reset));
        assert_eq!(f.deed(0.0), None);
        assert_eq!(f.arrive(Side::Controller, 0.0), b"3\n");
    }

    #[test]
    fn rates_are_what_they_say() {
        let mut f = Faults::new(7, plan(&["drop:0.01", "duplicate:0.02", "flip:0.05"]));
        f.send(Side::Controller, &[0; 100_000], 0.0);
        let t = f.tally();
        // Five standard deviations of a count of n p.
        for (count, p) in [
            (t.dropped, 0.01),
            (t.duplicated, 0.0198),
            (t.flipped, 0.0495),
        ] {
            let mean = 100_000.0 * p;
            assert!(
                (count as f64 - mean).abs() < 5.0 * f64::sqrt(mean),
                "{count} of {mean}"
            );
        }
        let got = f.arrive(Side::Controller, 0.0);
        assert_eq!(got.len(), 100_000 - t.dropped + t.duplicated);
        assert!(got.iter().all(|b| b.count_ones() <= 1));
    }

    proptest! {
        /// The same seed and bytes give the same faults, however the bytes were cut; another seed gives others.
        #[test]
        fn one_seed_replays_it(seed: u64, cuts in proptest::collection::vec(1usize..50, 1..40)) {
            let specs = ["drop:0.05", "duplicate:0.05", "flip:0.05", "lose-ok:0.3", "delay:3ms"];
            let text = b"ok\r\nerror:20\r\nok\r\n<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\nok\r\nok\r\n".repeat(6);
            let run = |seed: u64, cuts: &[usize]| {
                let mut f = Faults::new(seed, plan(&specs));
                let mut rest = &text[..];
                let mut turn = 0;
                while !rest.is_empty() {
                    let n = cuts[turn % cuts.len()].min(rest.len());
                    turn += 1;
                    f.send(Side::Host, &rest[..n], 0.0);
                    f.send(Side::Controller, &rest[..n], 0.0);
                    rest = &rest[n..];
                }
                (f.arrive(Side::Host, 1.0), f.arrive(Side::Controller, 1.0), f.tally())
            };
            let whole = run(seed, &[10_000]);
            prop_assert_eq!(run(seed, &cuts), whole.clone());
            prop_assert_ne!(run(seed ^ 1, &cuts), whole);
        }
    }
}
