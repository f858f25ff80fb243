//! The machine in the operator's hands, while no line of a job is under way: before the start, and at a tool change. Jog keys with steps,
//! zero here, home; any errand on the open port.
//!
//! At most one jog line waits for its answer, and no more is queued than one step ahead of the tool: a key let go leaves no motion behind.

use super::board::InHand;
use super::keys::{Hand, LARGEST_Z, STEPS};
use super::listener::{Listener, Press};
use crate::cli::errand::place;
use crate::link::errand::{
    Errand, ErrandError, ErrandOptions, Home, Jog, JogMove, News, Task, Watch, Zero,
};
use crate::link::port::Port;
use crate::link::{Command, Known};
use crate::wire::Reply;
use std::time::Instant;

/// What an errand came to.
pub struct Done<T> {
    /// The task with what it found.
    pub task: T,
    /// How it ended.
    pub result: Result<(), ErrandError>,
    /// The controller at the end.
    pub known: Known,
}

/// Why the operator's hands leave the machine.
#[derive(Debug)]
pub enum Leave {
    /// Begin, or go on.
    GoOn,
    /// Measure the tool, then ask again.
    Measure,
    /// End the job.
    Stop,
    /// The machine or the link would not: what happened.
    Lost(ErrandError),
}

/// What may be done by hand now, beside jogging and setting zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offer {
    /// Before the start: homing; alarms are told and may be mended.
    Start,
    /// At a tool change: measuring. An alarm ends the job.
    ToolChange {
        /// There is something to measure with.
        measure: bool,
    },
}

/// The port, between lines of a job.
pub struct Hands<'a> {
    /// The way to the controller.
    pub port: &'a mut dyn Port,
    /// When it was opened.
    pub start: Instant,
    /// For each errand.
    pub options: ErrandOptions,
    /// Which of [`STEPS`] a jog key goes.
    pub step: usize,
}

/// 1 mm.
pub const FIRST_STEP: usize = 2;

impl Hands<'_> {
    /// An errand that asks the controller who and where it is first.
    pub fn afresh<T: Task>(&mut self, task: T, listener: &mut Listener) -> Done<T> {
        let errand = Errand::again(task, self.options, self.start.elapsed());
        self.perform(errand, listener, &mut stopped_by_any_key())
    }

    /// Runs an errand to its end; `on` hears what is pressed.
    fn perform<T: Task>(
        &mut self,
        mut errand: Errand<T>,
        listener: &mut Listener,
        on: &mut dyn FnMut(&mut Errand<T>, Press, std::time::Duration),
    ) -> Done<T> {
        let mut buffer = [0u8; 512];
        let result = loop {
            let now = self.start.elapsed();
            while let Some(press) = listener.press() {
                on(&mut errand, press, now);
            }
            errand.tick(now);
            for news in errand.news() {
                match news {
                    News::Note(text) | News::Stopping(text) => listener.note(&text),
                    News::Said(_, reply) => {
                        if let Reply::Message(text) = &*reply {
                            listener.note(&format!("controller: {text}"));
                        }
                    }
                    News::Report(status, known) => listener.look(&status, &known, now),
                    News::Connected(_) | News::Sent(_) => {}
                }
            }
            listener.show(now);
            let out = errand.output();
            if !out.is_empty()
                && let Err(e) = self.port.write(&out)
            {
                errand.broken(e.to_string(), now);
            }
            if let Some(result) = errand.result() {
                break result;
            }
            match self.port.read(&mut buffer) {
                Ok(n) => errand.receive(buffer.get(..n).unwrap_or_default(), self.start.elapsed()),
                Err(e) => errand.broken(e.to_string(), self.start.elapsed()),
            }
        };
        let known = errand.known().clone();
        Done {
            task: errand.task,
            result,
            known,
        }
    }

    /// Jogs, zeros and homes by keys until the operator goes on or stops.
    pub fn by_hand(&mut self, known: Known, listener: &mut Listener, offer: Offer) -> Leave {
        let before = listener.board.attention.clone();
        let leave = self.keys(known, listener, offer);
        listener.board.hand = None;
        listener.board.attention = before.filter(|_| matches!(leave, Leave::GoOn));
        leave
    }

    fn keys(&mut self, mut known: Known, listener: &mut Listener, offer: Offer) -> Leave {
        let asked = listener.board.attention.clone();
        let mut question: Option<Hand> = None;
        loop {
            if listener.has_keys() {
                listener.board.hand = Some(InHand { step: self.step() });
            }
            let mut pressed = None;
            let watch = Errand::knowing(
                Watch::default(),
                self.options,
                known.clone(),
                self.start.elapsed(),
            );
            let watched = self.perform(watch, listener, &mut |errand, press, _| {
                if pressed.is_none() {
                    pressed = Some(press);
                    errand.task.quit = true;
                }
            });
            known = watched.known;
            if let Err(e) = watched.result {
                return Leave::Lost(e);
            }
            let hand = match pressed {
                None => continue,
                Some(Press::Hand(hand)) => hand,
                Some(Press::Wish(Command::Resume)) => Hand::GoOn,
                Some(Press::Wish(Command::Stop | Command::ResetNow)) => Hand::Stop,
                Some(Press::Wish(_)) => {
                    listener.note("only resume and stop mean anything now");
                    continue;
                }
            };
            listener.board.attention.clone_from(&asked);
            let answered = question.take().filter(|_| hand == Hand::Yes);
            let result = match answered.unwrap_or(hand) {
                Hand::GoOn => return Leave::GoOn,
                Hand::Stop | Hand::Interrupt => return Leave::Stop,
                Hand::Measure if offer == (Offer::ToolChange { measure: true }) => {
                    return Leave::Measure;
                }
                Hand::Finer => {
                    self.step = self.step.saturating_sub(1);
                    continue;
                }
                Hand::Coarser => {
                    self.step = (self.step + 1).min(STEPS.len() - 1);
                    continue;
                }
                Hand::Jog { axis, plus } => self.jog(axis, plus, self.step(), &mut known, listener),
                what @ (Hand::Zero(_) | Hand::Home) if answered.is_none() => {
                    if what == Hand::Home && offer != Offer::Start {
                        listener.note("homing is offered only before the start: it may move the work zero by some steps");
                        continue;
                    }
                    let text = match what {
                        Hand::Zero(axis) => {
                            format!("set work {} zero here?", ["X", "Y", "Z"][axis])
                        }
                        _ => "home the machine? It drives to its switches".to_string(),
                    };
                    listener.board.attention =
                        Some(format!("{text} y does it, any other key does not"));
                    question = Some(what);
                    continue;
                }
                Hand::Zero(axis) => self.zero(axis, &mut known, listener),
                Hand::Home => {
                    let done = self.afresh(Home::default(), listener);
                    known = done.known;
                    if let Some(p) = done.task.position {
                        listener.note(&format!("homed: machine {}", place(p)));
                    }
                    done.result
                }
                Hand::Measure => {
                    listener.note("there is nothing to measure with: --tool-plate names it");
                    continue;
                }
                Hand::Yes | Hand::Halt | Hand::Other => continue,
            };
            let Err(e) = result else { continue };
            match (&e, offer) {
                (
                    ErrandError::Cancelled {
                        position_kept: true,
                    },
                    _,
                ) => {}
                (ErrandError::Broken { .. } | ErrandError::Silent { .. }, _) => {
                    return Leave::Lost(e);
                }
                (_, Offer::ToolChange { .. }) if loses_the_job(&e) => return Leave::Lost(e),
                _ => listener.note(&e.to_string()),
            }
        }
    }

    /// mm.
    fn step(&self) -> f64 {
        STEPS.get(self.step).copied().unwrap_or(1.0)
    }

    fn jog(
        &mut self,
        axis: usize,
        plus: bool,
        step: f64,
        known: &mut Known,
        listener: &mut Listener,
    ) -> Result<(), ErrandError> {
        let fastest = u16::try_from(axis)
            .ok()
            .and_then(|n| known.setting(110 + n))
            .filter(|v| *v > 0.0)
            .unwrap_or(500.0);
        let length = move |axis: usize| if axis == 2 { step.min(LARGEST_Z) } else { step };
        let feed = (length(axis) * 600.0).max(60.0).min(fastest / 2.0);
        let one = move |axis: usize, plus: bool| {
            let mut axes = [None; 3];
            let way = if plus { length(axis) } else { -length(axis) };
            if let Some(slot) = axes.get_mut(axis) {
                *slot = Some(way);
            }
            JogMove {
                axes,
                feed,
                ..JogMove::default()
            }
        };
        let errand = Errand::knowing(
            Jog::new(vec![one(axis, plus)]).quietly(),
            self.options,
            known.clone(),
            self.start.elapsed(),
        );
        let (mut presses, mut finer, mut coarser) = (0, 0, 0);
        let done = self.perform(errand, listener, &mut |errand, press, now| match press {
            // A held key repeats: the same way goes on, one step ahead at most.
            Press::Hand(Hand::Jog { axis: a, plus: p }) if (a, p) == (axis, plus) => {
                errand.task.push(one(a, p));
            }
            Press::Hand(Hand::Interrupt) => {
                presses += 1;
                match presses {
                    1 => errand.cancel(now),
                    _ => errand.reset_now(now),
                }
            }
            Press::Hand(Hand::Finer) => finer += 1,
            Press::Hand(Hand::Coarser) => coarser += 1,
            _ => errand.cancel(now),
        });
        self.step = (self.step + coarser)
            .saturating_sub(finer)
            .min(STEPS.len() - 1);
        *known = done.known;
        done.result
    }

    fn zero(
        &mut self,
        axis: usize,
        known: &mut Known,
        listener: &mut Listener,
    ) -> Result<(), ErrandError> {
        let mut axes = [None; 3];
        if let Some(slot) = axes.get_mut(axis) {
            *slot = Some(0.0);
        }
        let done = self.afresh(Zero::new(axes), listener);
        *known = done.known;
        if let (Ok(()), Some(origin)) = (&done.result, done.task.origin) {
            listener.note(&format!("work zero is at machine {} now", place(origin)));
        }
        done.result
    }
}

/// After this nobody knows where the tool is, or what the controller remembers.
pub fn loses_the_job(e: &ErrandError) -> bool {
    matches!(
        e,
        ErrandError::Cancelled {
            position_kept: false
        } | ErrandError::Alarm { .. }
            | ErrandError::ControllerReset
            | ErrandError::Locked
            | ErrandError::Broken { .. }
            | ErrandError::Silent { .. }
            | ErrandError::LostReply(_)
            | ErrandError::ReadBack { .. }
            | ErrandError::Unknown(_)
    )
}

/// Any key stops what moves, Ctrl-C a second time resets at once.
fn stopped_by_any_key<T: Task>() -> impl FnMut(&mut Errand<T>, Press, std::time::Duration) {
    let mut presses = 0;
    move |errand, press, now| match press {
        // A key that repeats late is no wish to stop.
        Press::Wish(Command::Resume) | Press::Hand(Hand::GoOn | Hand::Jog { .. }) => {}
        Press::Hand(Hand::Interrupt) => {
            presses += 1;
            match presses {
                1 => errand.cancel(now),
                _ => errand.reset_now(now),
            }
        }
        Press::Wish(Command::ResetNow) => errand.reset_now(now),
        _ => errand.cancel(now),
    }
}
