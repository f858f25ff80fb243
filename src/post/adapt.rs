//! Steps as a post will carry them out: what its controller cannot take is said otherwise, if that is allowed, and what a post does
//! of its own accord (up before a tool change, spindle off) is said as steps.
//!
//! Steps in, steps out, one job from its start; the writer runs one of these itself. Run one beforehand and compare its steps with
//! what is read back: nothing changes when adapted steps are adapted again. What is not allowed to be rewritten passes unchanged,
//! and the writer refuses it.
//!
//! | step | becomes |
//! |---|---|
//! | spindle or coolant off just before the end | nothing: the last lines switch off everything |
//! | end | retract, where the post has one; end |
//! | tool | spindle off, coolant off, retract, tool; coolant on again with the spindle, or before the next cut |
//! | one coolant after another | off, then that one; both together come on top of what runs |
//! | pause | spindle off, coolant off, pause, where a pause stops both; they come back before the next move |
//! | spindle | without its spin-up time where the controller waits by itself |
//! | an arc that turns too far at once | arcs, exactly ([`Rewrite::halves`]) |
//! | an arc that cannot be written | lines within a tolerance ([`Rewrite::lines_within`]) |

use super::definition::{Fit, Post, Shape};
use super::error::Refusal;
use super::options::Rewrite;
use crate::cldata::{Bow, Coolant, Place, Step};
use crate::geom::Point;
use crate::units::{Mm, MmPerMin, Rpm, Seconds};

/// Most lines that one arc may become.
const MOST_LINES: f64 = 100_000.0;

/// Turns steps into those that a post will carry out. Constant memory.
#[derive(Clone, Debug)]
pub struct Adapter<'a> {
    post: &'a Post,
    rewrite: Rewrite,
    at: Place,
    /// The step that turned the spindle on, while it turns.
    turning: Option<Step>,
    /// The same, while a pause has stopped it.
    stopped: Option<Step>,
    coolant: Coolant,
    /// Coolant that a tool change or a pause has interrupted.
    owed: Coolant,
    /// Offs that wait for what comes next, in order.
    held: Vec<Step>,
    /// The tool that is in.
    tool: Option<u32>,
    /// Height in machine coordinates, while it is known.
    height: Option<f64>,
    deviation: f64,
}

impl<'a> Adapter<'a> {
    /// One for the start of a job.
    pub fn new(post: &'a Post, rewrite: Rewrite) -> Self {
        Adapter {
            post,
            rewrite,
            at: [None; 3],
            turning: None,
            stopped: None,
            coolant: Coolant::Off,
            owed: Coolant::Off,
            held: Vec::new(),
            tool: None,
            height: None,
            deviation: 0.0,
        }
    }

    /// The furthest that any adapted path so far leaves the one that was meant.
    pub fn deviation(&self) -> Mm {
        Mm(self.deviation)
    }

    /// Hands on what a step becomes, in order. Spindle and coolant offs are handed on with the step that follows them.
    pub fn step<E: From<Refusal>>(
        &mut self,
        step: &Step,
        to: &mut impl FnMut(&Step) -> Result<(), E>,
    ) -> Result<(), E> {
        match step {
            Step::Spindle { direction: 0, .. } | Step::Coolant(Coolant::Off) => {
                // A long run of offs says no more than a short one.
                if self.held.len() < 16 {
                    self.held.push(step.clone());
                }
                return Ok(());
            }
            Step::End => {
                self.held.clear();
                self.retract(self.post.program.retract_z, to)?;
                return to(step);
            }
            _ => self.release(to)?,
        }
        match step {
            Step::Tool { number } => self.change(*number, step, to),
            Step::Spindle {
                direction,
                speed,
                spin_up,
            } => {
                let waits = self.post.spindle.waits;
                let turn = Step::Spindle {
                    direction: *direction,
                    speed: *speed,
                    spin_up: if waits { Seconds(0.0) } else { *spin_up },
                };
                to(&turn)?;
                (self.turning, self.stopped) = (Some(turn), None);
                self.pay(to)
            }
            Step::Pause { .. } if self.post.pause_stops_spindle => {
                let stopped = self.stop(to)?;
                self.stopped = stopped.or(self.stopped.take());
                to(step)
            }
            Step::Coolant(kind) => {
                // The words for one leave the other running, which is right for both.
                let other = self.coolant != Coolant::Off && self.coolant != *kind;
                if other && *kind != Coolant::Both {
                    to(&Step::Coolant(Coolant::Off))?;
                }
                self.coolant = *kind;
                self.owed = Coolant::Off;
                to(step)
            }
            Step::WorkOffset(_) => {
                self.at = [None; 3];
                to(step)
            }
            Step::Rapid { to: place } => {
                self.resume(to)?;
                self.moved(place);
                to(step)
            }
            Step::MachineRapid { to: place } => {
                for (at, told) in self.at.iter_mut().zip(place) {
                    if told.is_some() {
                        *at = None;
                    }
                }
                self.height = place[2].or(self.height);
                to(step)
            }
            Step::Feed { to: end, bow, feed } => {
                self.resume(to)?;
                self.pay(to)?;
                let start = self.at;
                self.moved(&[Some(end.x), Some(end.y), Some(end.z)]);
                match (bow, start) {
                    (Some(bow), [Some(x), Some(y), Some(z)]) => {
                        self.arc(&Point::new(x, y, z), end, bow, *feed, step, to)
                    }
                    _ => to(step),
                }
            }
            _ => to(step),
        }
    }

    /// The tool goes somewhere in work coordinates.
    fn moved(&mut self, place: &Place) {
        for (at, told) in self.at.iter_mut().zip(place) {
            *at = told.or(*at);
        }
        if place[2].is_some() {
            self.height = None;
        }
    }

    /// Hands on what waited.
    fn release<E>(&mut self, to: &mut impl FnMut(&Step) -> Result<(), E>) -> Result<(), E> {
        for step in std::mem::take(&mut self.held) {
            match step {
                Step::Spindle { .. } => (self.turning, self.stopped) = (None, None),
                _ => (self.coolant, self.owed) = (Coolant::Off, Coolant::Off),
            }
            to(&step)?;
        }
        Ok(())
    }

    /// Spindle and coolant off, if they are on; the coolant is owed then. Returns what turned the spindle on.
    fn stop<E>(&mut self, to: &mut impl FnMut(&Step) -> Result<(), E>) -> Result<Option<Step>, E> {
        let turning = self.turning.take();
        if turning.is_some() {
            to(&Step::Spindle {
                direction: 0,
                speed: Rpm(0.0),
                spin_up: Seconds(0.0),
            })?;
        }
        if self.coolant != Coolant::Off {
            self.owed = std::mem::take(&mut self.coolant);
            to(&Step::Coolant(Coolant::Off))?;
        }
        Ok(turning)
    }

    /// The spindle that a pause has stopped turns again.
    fn resume<E>(&mut self, to: &mut impl FnMut(&Step) -> Result<(), E>) -> Result<(), E> {
        let Some(turn) = self.stopped.take() else {
            return Ok(());
        };
        to(&turn)?;
        self.turning = Some(turn);
        self.pay(to)
    }

    /// Coolant that a tool change or a pause has interrupted comes back.
    fn pay<E>(&mut self, to: &mut impl FnMut(&Step) -> Result<(), E>) -> Result<(), E> {
        if self.owed == Coolant::Off {
            return Ok(());
        }
        self.coolant = std::mem::take(&mut self.owed);
        to(&Step::Coolant(self.coolant))
    }

    fn retract<E>(
        &mut self,
        height: Option<Mm>,
        to: &mut impl FnMut(&Step) -> Result<(), E>,
    ) -> Result<(), E> {
        let Some(z) = height.filter(|z| self.height != Some(z.0)) else {
            return Ok(());
        };
        self.height = Some(z.0);
        self.at[2] = None;
        to(&Step::MachineRapid {
            to: [None, None, Some(z.0)],
        })
    }

    fn change<E>(
        &mut self,
        number: u32,
        step: &Step,
        to: &mut impl FnMut(&Step) -> Result<(), E>,
    ) -> Result<(), E> {
        let changes = !self.post.tool.change.is_empty();
        if self.tool.is_some_and(|t| t != number) || changes {
            self.stop(to)?;
            self.stopped = None;
            self.retract(self.post.tool.retract_z, to)?;
            self.at = [None; 3];
        }
        self.tool = Some(number);
        to(step)
    }

    /// An arc as it is, in parts, or as lines.
    fn arc<E: From<Refusal>>(
        &mut self,
        start: &Point,
        end: &Point,
        bow: &Bow,
        feed: MmPerMin,
        step: &Step,
        to: &mut impl FnMut(&Step) -> Result<(), E>,
    ) -> Result<(), E> {
        let figures = [bow.sweep, bow.center.x, bow.center.y, bow.center.z];
        let ends = start.iter().chain(end.iter());
        if !figures.iter().chain(ends).all(|v| v.is_finite()) {
            return to(step);
        }
        let shape = Shape::new(bow.plane, start, end, &bow.center, bow.sweep);
        let arcs = &self.post.arcs;
        let curve = Curve::new(start, end, bow);
        match (
            arcs.fit(&shape),
            self.rewrite.halves,
            self.rewrite.lines_within,
        ) {
            (Fit::TurnsTooFar, true, _) => {
                let parts = (bow.sweep.abs() / arcs.most_turn() - 1e-9).ceil().max(1.0);
                if parts > MOST_LINES {
                    return Err(curve.too_many(parts, arcs.most_turn()).into());
                }
                let part = Bow {
                    sweep: bow.sweep / parts,
                    ..*bow
                };
                curve.run(parts as u32, |point| {
                    to(&Step::Feed {
                        to: point,
                        bow: Some(part),
                        feed,
                    })
                })
            }
            (Fit::Good, ..) | (_, _, None) => to(step),
            (_, _, Some(within)) => {
                let (parts, deviation) = curve.lines(within)?;
                self.deviation = self.deviation.max(deviation);
                curve.run(parts, |point| {
                    to(&Step::Feed {
                        to: point,
                        bow: None,
                        feed,
                    })
                })
            }
        }
    }
}

/// A helix from one place to another.
struct Curve<'p> {
    end: &'p Point,
    bow: &'p Bow,
    start: &'p Point,
    /// Radius and angle at the start, radius at the end.
    radius: [f64; 2],
    angle: f64,
}

impl<'p> Curve<'p> {
    fn new(start: &'p Point, end: &'p Point, bow: &'p Bow) -> Self {
        let [u, v, _] = bow.plane.axes();
        let spoke = |p: &Point| (p[u] - bow.center[u], p[v] - bow.center[v]);
        let ((a, b), (c, d)) = (spoke(start), spoke(end));
        Curve {
            end,
            bow,
            start,
            radius: [a.hypot(b), c.hypot(d)],
            angle: b.atan2(a),
        }
    }

    /// The place after a share of the way, from 0 to 1.
    fn at(&self, share: f64) -> Point {
        let [u, v, w] = self.bow.plane.axes();
        let radius = self.radius[0] + (self.radius[1] - self.radius[0]) * share;
        let angle = self.angle + self.bow.sweep * share;
        let mut p = *self.start;
        p[u] = self.bow.center[u] + radius * angle.cos();
        p[v] = self.bow.center[v] + radius * angle.sin();
        p[w] += (self.end[w] - self.start[w]) * share;
        p
    }

    /// How many lines stay within a tolerance, and how far they leave the helix at most, mm. A chord of a curve leaves it by no
    /// more than an eighth of the square of the parameter's step times its second derivative, which is the radius here.
    fn lines(&self, within: Mm) -> Result<(u32, f64), Refusal> {
        if !(within.0.is_finite() && within.0 > 0.0) {
            return Err(Refusal::Figure {
                what: "the tolerance for lines in place of arcs, in mm,",
                value: within.0,
                must: "above zero",
            });
        }
        let radius = self.radius[0].max(self.radius[1]);
        let step = (8.0 * within.0 / radius)
            .sqrt()
            .min(std::f64::consts::FRAC_PI_2);
        let parts = (self.bow.sweep.abs() / step).ceil().max(1.0);
        if parts.is_nan() || parts > MOST_LINES {
            return Err(self.too_many(parts, within.0));
        }
        let each = self.bow.sweep.abs() / parts;
        Ok((parts as u32, radius * each * each / 8.0))
    }

    fn too_many(&self, lines: f64, tolerance: f64) -> Refusal {
        Refusal::TooManyLines {
            radius: self.radius[0],
            lines,
            tolerance,
        }
    }

    /// The ends of equal parts, in order; the last is the end itself.
    fn run<E>(&self, parts: u32, mut each: impl FnMut(Point) -> Result<(), E>) -> Result<(), E> {
        for i in 1..parts {
            each(self.at(f64::from(i) / f64::from(parts)))?;
        }
        each(*self.end)
    }
}

#[cfg(test)]
mod tests;
