//! Drilling cycles: one block to the moves that the control makes of it.
//!
//! Crosses the border: a block and the words that earlier blocks of the series left, work coordinates, mm and s, in; [`Holes`] out, and
//! from these the motions, dwells and spindle stops, in order. G17 only. Sources: LinuxCNC manual, G-Code Reference, Canned Cycles; NISTIR
//! 6556, 3.5.16; Fanuc Operator's Manual, Machining Center, Canned Cycle for Drilling; grblHAL, motion_control.c.
//!
//! ```text
//!   start ----- rapid ----> o  initial level (G98 returns here)
//!                           : rapid
//!                           o  R level       (G99 returns here)
//!                           | feed, in pecks of Q
//!                           o  bottom, Z     dwell P
//! ```

use super::block::Block;
use super::codes::Letters;
use super::dialect::Dialect;
use super::error::{Complaint, Fault};
use super::event::{Event, Motion, MotionKind, Plane};
use super::rules::{RuleComplaint, Unit};
use super::state::{Distance, FeedMode, Retract, State};
use crate::geom::{Point, Vector};
use crate::units::{MmPerMin, Seconds};

/// Which cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// G73: pecks of Q, backing off a little after each.
    ChipBreak,
    /// G81.
    Drill,
    /// G82: dwell at the bottom.
    DrillDwell,
    /// G83: pecks of Q, out to R after each.
    Peck,
    /// G85: feed out.
    Bore,
    /// G86: the spindle stops for the way out.
    BoreStop,
    /// G89: dwell at the bottom, feed out.
    BoreDwell,
}

/// What a series of cycles keeps from block to block. Lengths mm, as programmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// The cycle in force.
    pub cycle: Cycle,
    /// Level that the series started from, work coordinates.
    pub initial: f64,
    /// How Z and R were meant.
    pub distance: Distance,
    /// Z word.
    pub z: Option<f64>,
    /// R word.
    pub r: Option<f64>,
    /// Q word.
    pub q: Option<f64>,
    /// P word.
    pub dwell: Option<Seconds>,
}

/// How pecks are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pecking {
    /// G83: rapid to R, rapid back to `back` above the last depth, feed on.
    Return,
    /// A dwell behind every peck; G83 feeds all the way down again, from where G98 and G99 return to.
    GrblHal { wait: f64 },
}

/// A family's way with cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct CycleRules {
    /// NIST's way: a tool below R is lifted first, words hold for one cycle only, an axis word is needed. Otherwise the industry's: words hold
    /// until G80, a block without X Y Z R keeps its words and drills nothing.
    pub nist: bool,
    /// LinuxCNC's way with levels: all are counted from the one that the series started from. The tool is lifted first where *that* level
    /// is below R; the way to the next hole goes straight to the higher of where the tool stands and where it shall return to, so it
    /// slants where R was raised within a series (seen on the interpreter itself, 2.10).
    pub from_series: bool,
    pub pecking: Pecking,
    /// How far G73 and G83 back off, mm.
    pub back: f64,
    /// Words that repeat the hole.
    pub repeats: &'static [u8],
    /// What P counts.
    pub dwell: Unit,
}

impl CycleRules {
    pub const NIST: CycleRules = CycleRules {
        nist: true,
        from_series: false,
        pecking: Pecking::Return,
        back: 0.254,
        repeats: b"L",
        dwell: Unit::Seconds,
    };
    pub const INDUSTRY: CycleRules = CycleRules {
        nist: false,
        from_series: false,
        pecking: Pecking::Return,
        back: 1.0,
        repeats: b"K",
        dwell: Unit::Milliseconds,
    };
}

/// Most pecks of one block.
const MAX_PECKS: f64 = 100_000.0;

/// Holes to drill, all of one shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Holes {
    cycle: Cycle,
    first: Point,
    /// X and Y from hole to hole.
    step: Vector,
    count: u32,
    /// Level to lift to before anything else.
    lift: Option<f64>,
    /// Level of the way to the first hole.
    level: f64,
    clear: f64,
    r: f64,
    bottom: f64,
    pecks: u32,
    q: f64,
    dwell: f64,
    feed: MmPerMin,
    rules: &'static CycleRules,
}

impl PartialEq for CycleRules {
    fn eq(&self, other: &CycleRules) -> bool {
        std::ptr::eq(self, other)
    }
}

/// What a block of a cycle is read against.
pub(super) struct Setting<'a> {
    pub state: &'a State,
    pub block: &'a Block,
    pub rules: &'static CycleRules,
    pub plane: Plane,
    pub distance: Distance,
    pub feed_mode: FeedMode,
    pub feed: MmPerMin,
    /// mm in a unit.
    pub mm: f64,
    pub start: &'a Point,
    /// Where X and Y go.
    pub to: &'a Point,
}

/// The time that a P word of a cycle or a dwell word means.
pub(super) fn time(block: &Block, letter: u8, unit: Unit) -> Result<f64, Fault> {
    let value = block.value(letter);
    let point = block.pointed.has(letter);
    let name = char::from(letter);
    Ok(match unit {
        Unit::Seconds => value,
        Unit::Milliseconds => value / 1000.0,
        Unit::ByPoint if point => value,
        Unit::ByPoint => value / 1000.0,
        Unit::Pointed if point || value == 0.0 => value,
        Unit::Pointed => {
            let complaint = RuleComplaint::PointMissing { letter: name };
            return Err(Fault::at(block.at(letter), complaint.into()));
        }
        Unit::WholeSeconds if value.fract() == 0.0 => value,
        Unit::WholeSeconds => {
            let complaint = Complaint::WholeNumber {
                letter: name,
                least: 0,
            };
            return Err(Fault::at(block.at(letter), complaint));
        }
    })
}

/// Checks a block of a cycle. The letters are those it has used; no holes where the block only keeps words.
pub(super) fn plan(
    cycle: Cycle,
    setting: &Setting,
) -> Result<(Option<Holes>, Series, Letters), Fault> {
    let Setting {
        state,
        block,
        rules,
        mm,
        ..
    } = *setting;
    let here = |complaint: RuleComplaint| Err(Fault::at(block.start, complaint.into()));
    let at = |letter, complaint: RuleComplaint| Err(Fault::at(block.at(letter), complaint.into()));
    if setting.plane != Plane::Xy {
        return here(RuleComplaint::CyclePlane);
    }
    if setting.feed_mode == FeedMode::InverseTime {
        return here(RuleComplaint::CycleInverseTime);
    }
    let mut used = Letters::of(b"XYZR");
    let kept = state.series.filter(|s| !rules.nist || s.cycle == cycle);
    let fresh = |word: Option<f64>, old: Option<f64>| word.map(|v| v * mm).or(old);
    let mut series = Series {
        cycle,
        initial: state.series.map_or(setting.start.z, |s| s.initial),
        distance: setting.distance,
        z: fresh(block.get(b'Z'), kept.and_then(|s| s.z)),
        r: fresh(block.get(b'R'), kept.and_then(|s| s.r)),
        q: kept.and_then(|s| s.q),
        dwell: kept.and_then(|s| s.dwell),
    };
    let pecks = matches!(cycle, Cycle::ChipBreak | Cycle::Peck);
    if pecks {
        used.add(b'Q');
        series.q = fresh(block.get(b'Q'), series.q);
    }
    let waits = match cycle {
        Cycle::DrillDwell | Cycle::BoreDwell => true,
        Cycle::BoreStop => rules.nist,
        _ => false,
    };
    if waits {
        used.add(b'P');
        if block.has(b'P') {
            series.dwell = Some(Seconds(time(block, b'P', rules.dwell)?));
        }
    }
    let mut count = 1;
    if let Some(&letter) = rules.repeats.iter().find(|l| block.has(**l)) {
        used.add(letter);
        let value = block.value(letter);
        let least = u32::from(rules.nist);
        if value.fract() != 0.0 || !(f64::from(least)..=9999.0).contains(&value) {
            let (letter, most) = (char::from(letter), 9999);
            let complaint = RuleComplaint::Range {
                letter,
                least,
                most,
            };
            return at(letter as u8, complaint);
        }
        count = value as u32;
        if count == 0 && (block.has(b'X') || block.has(b'Y')) {
            return at(letter, RuleComplaint::CycleNoHole);
        }
    }
    let place = b"XYZR".iter().any(|&l| block.has(l));
    if !place && rules.nist {
        return here(RuleComplaint::CycleWord {
            word: "an X, Y or Z word",
        });
    }
    if !place || count == 0 {
        return Ok((None, series, used));
    }
    let missing = |word| Fault::at(block.start, RuleComplaint::CycleWord { word }.into());
    let z = series
        .z
        .ok_or_else(|| missing("Z (the bottom of the hole)"))?;
    let r = series
        .r
        .ok_or_else(|| missing("R (the level where feeding begins)"))?;
    let turned = state.series.is_some_and(|s| s.distance != setting.distance);
    if turned && !(block.has(b'Z') && block.has(b'R')) {
        return here(RuleComplaint::CycleWord {
            word: "Z and R anew, since G90 and G91 changed",
        });
    }
    if pecks && state.dialect == Dialect::Haas {
        // Haas Mill Operator's Manual, G73 and G83: I J K instead of Q.
        if let Some(&letter) = b"IJK".iter().find(|&&l| block.has(l)) {
            let why = "pecks that grow smaller (I J K) are not read; give one depth by Q";
            let letter = char::from(letter);
            return at(letter as u8, RuleComplaint::RefusedWord { letter, why });
        }
    }
    let q = match pecks {
        true => series.q.ok_or_else(|| missing("Q (the depth of a peck)"))?,
        false => 0.0,
    };
    if pecks && q <= 0.0 {
        let word = "a Q above zero";
        let q_at = if block.has(b'Q') {
            block.at(b'Q')
        } else {
            block.start
        };
        return Err(Fault::at(q_at, RuleComplaint::CycleWord { word }.into()));
    }
    if waits && rules.nist && series.dwell.is_none() {
        return Err(missing("P (seconds)"));
    }
    if setting.feed.0 == 0.0 {
        return Err(Fault::at(block.start, Complaint::FeedMissing));
    }
    let spindle = block.spindle.unwrap_or(state.spindle);
    if cycle == Cycle::BoreStop && spindle == 0 {
        return here(RuleComplaint::CycleSpindle);
    }

    let start = setting.start;
    if matches!(rules.pecking, Pecking::GrblHal { .. }) {
        series.initial = start.z;
    }
    let from = match rules.nist && !rules.from_series {
        true => start.z,
        false => series.initial,
    };
    let (r, bottom) = match setting.distance {
        Distance::Absolute => (r, z),
        Distance::Incremental => (from + r, from + r + z),
    };
    if bottom > r {
        return here(RuleComplaint::CycleUpward { bottom, r });
    }
    let mut level = start.z;
    let mut lift = None;
    if rules.from_series {
        if series.initial < r {
            (lift, level) = (Some(r), r);
        }
    } else if level < r - 1e-9 {
        if !rules.nist {
            return here(RuleComplaint::CycleLevel { r, level });
        }
        (lift, level) = (Some(r), r);
    }
    let number = if pecks {
        let number = ((r - bottom) / q - 1e-9).ceil().max(1.0);
        if number.is_nan() || number * f64::from(count) > MAX_PECKS {
            return Err(Fault::at(
                if block.has(b'Q') {
                    block.at(b'Q')
                } else {
                    block.start
                },
                RuleComplaint::Pecks {
                    pecks: number * f64::from(count),
                }
                .into(),
            ));
        }
        number as u32
    } else {
        1
    };
    let step = match setting.distance {
        Distance::Absolute => Vector::zeros(),
        Distance::Incremental => Vector::new(setting.to.x - start.x, setting.to.y - start.y, 0.0),
    };
    let clear = match block.retract.unwrap_or(state.retract) {
        Retract::Initial => series.initial.max(r),
        Retract::R => r,
    };
    if rules.from_series {
        level = level.max(clear);
    }
    let holes = Holes {
        cycle,
        first: Point::new(setting.to.x, setting.to.y, level),
        step,
        count,
        lift,
        level,
        clear,
        r,
        bottom,
        pecks: number,
        q,
        dwell: series.dwell.map_or(0.0, |t| t.0),
        feed: setting.feed,
        rules,
    };
    Ok((Some(holes), series, used))
}

/// The tool on its way through a cycle.
struct Drill<'a> {
    state: &'a mut State,
    events: &'a mut Vec<Event>,
    shift: Vector,
    feed: MmPerMin,
    line: usize,
}

impl Drill<'_> {
    fn go(&mut self, kind: MotionKind, x: f64, y: f64, z: f64) {
        let to = Point::new(x, y, z) + self.shift;
        if to == self.state.position {
            return;
        }
        let from = std::mem::replace(&mut self.state.position, to);
        let feed = match kind {
            MotionKind::Rapid => self.state.rapid_feed,
            MotionKind::Feed => self.feed,
        };
        self.events.push(Event::Motion(Motion {
            kind,
            from,
            to,
            arc: None,
            feed,
            inverse_time: false,
            machine_coordinates: false,
            line: self.line,
        }));
    }

    fn wait(&mut self, seconds: f64) {
        let (time, line) = (Seconds(seconds), self.line);
        if seconds > 0.0 {
            self.events.push(Event::Dwell { time, line });
        }
    }

    fn spindle(&mut self, direction: i8) {
        let (speed, line) = (self.state.speed, self.line);
        self.events.push(Event::Spindle {
            direction,
            speed,
            line,
        });
    }
}

/// Makes the moves. Cannot fail. `shift` is what the work coordinates gain by the block's own G92.1.
pub(super) fn drill(
    holes: &Holes,
    state: &mut State,
    shift: Vector,
    line: usize,
    events: &mut Vec<Event>,
) {
    use MotionKind::{Feed, Rapid};
    let Holes {
        r,
        bottom,
        clear,
        q,
        rules,
        ..
    } = *holes;
    let before = state.position - shift;
    let mut d = Drill {
        state,
        events,
        shift,
        feed: holes.feed,
        line,
    };
    if let Some(lift) = holes.lift {
        d.go(Rapid, before.x, before.y, lift);
    }
    let mut level = holes.level;
    for n in 0..holes.count {
        let at = holes.first + holes.step * f64::from(n);
        let (x, y) = (at.x, at.y);
        d.go(Rapid, x, y, level);
        d.go(Rapid, x, y, r);
        for peck in 1..=holes.pecks {
            let last = peck == holes.pecks;
            let depth = if last {
                bottom
            } else {
                r - q * f64::from(peck)
            };
            d.go(Feed, x, y, depth);
            if let (Pecking::GrblHal { wait }, true) = (rules.pecking, holes.q > 0.0) {
                d.wait(wait);
            }
            match (holes.cycle, rules.pecking) {
                _ if last => {}
                (Cycle::ChipBreak, _) => d.go(Rapid, x, y, depth + rules.back),
                (_, Pecking::Return) => {
                    d.go(Rapid, x, y, r);
                    d.go(Rapid, x, y, depth + rules.back);
                }
                (_, Pecking::GrblHal { .. }) => d.go(Rapid, x, y, clear),
            }
        }
        d.way_out(holes, x, y);
        level = clear;
    }
}

impl Drill<'_> {
    /// From the bottom to where G98 or G99 ends.
    fn way_out(&mut self, holes: &Holes, x: f64, y: f64) {
        use MotionKind::{Feed, Rapid};
        let Holes {
            r, clear, rules, ..
        } = *holes;
        // LinuxCNC feeds out of G89 all the way, out of G85 to R only; grblHAL all the way in both.
        let grblhal = matches!(rules.pecking, Pecking::GrblHal { .. });
        let out = match holes.cycle {
            Cycle::Bore if grblhal => clear,
            Cycle::BoreDwell if rules.nist => clear,
            _ => r,
        };
        match holes.cycle {
            Cycle::DrillDwell => self.wait(holes.dwell),
            Cycle::Bore => self.go(Feed, x, y, out),
            Cycle::BoreDwell => {
                self.wait(holes.dwell);
                self.go(Feed, x, y, out);
            }
            Cycle::BoreStop => {
                self.wait(holes.dwell);
                let direction = self.state.spindle;
                self.spindle(0);
                self.go(Rapid, x, y, clear);
                self.spindle(direction);
            }
            Cycle::Drill | Cycle::ChipBreak | Cycle::Peck => {}
        }
        self.go(Rapid, x, y, clear);
    }
}
