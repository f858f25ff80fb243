//! The pass that asks where: the program from a start whose untold places are unknown, through the limits and as the way of the ball.

use super::limits::{LimitWatch, Limits};
use super::material::Move;
use super::program::{Open, READING};
use super::report::ProgramFigures;
use super::start::{Places, Start, start};
use super::way::Way;
use crate::gcode::{Dialect, Event, Interpreter};
use crate::machine::Machine;

/// What the pass found.
pub struct Shape {
    /// What the limits say.
    pub limits: Limits,
    /// The way in figures; lines and bytes are not in them.
    pub figures: ProgramFigures,
    /// Moves whose place is known.
    pub moves: usize,
    /// What is in the program.
    pub seen: Seen,
    /// Where it was read from.
    pub start: Start,
}

impl Shape {
    /// The moves again.
    pub fn again(&self, open: &Open, radius: f64, hear: &mut dyn FnMut(&Move)) {
        let mut way = Way::new(radius);
        let mut places = Places::default();
        let from = self.start.state.clone();
        if let Ok(mut program) =
            open().and_then(|text| Interpreter::from_state(text, from, READING))
        {
            program.tell_all(&mut |event| {
                if let Some(followed) = &places.follow(event) {
                    way.motion(followed, &mut |m| hear(&m));
                }
            });
        }
    }
}

/// Things that a program may hold.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Anything at all.
    pub anything: bool,
    /// M6.
    pub tool_change: bool,
    /// M0, M1.
    pub pause: bool,
    /// G38.
    pub probe: bool,
}

/// Reads a program that reads from zero. `moves` gets each move whose place is known, in order, for a ball of this radius, mm. Memory
/// does not grow with the program's length, but for what `moves` keeps.
pub fn shape(
    open: &Open,
    dialect: Dialect,
    machine: &Machine,
    radius: f64,
    moves: &mut dyn FnMut(Told),
) -> Shape {
    let from = start(open, dialect);
    let zero = from.assumed == [true; 3];
    let (shape, sound) = pass(open, from, machine, radius, moves);
    if sound || zero {
        return shape;
    }
    // What does not read from unknown places reads from zero.
    moves(Told::Afresh);
    pass(open, Start::zero(dialect), machine, radius, moves).0
}

/// What [`shape`] tells.
pub enum Told {
    /// The next move.
    Move(Move),
    /// Forget all of them: it begins again.
    Afresh,
}

/// What was seen, and whether all of it could be read: behind a mistake it goes on with the next line.
fn pass(
    open: &Open,
    from: Start,
    machine: &Machine,
    radius: f64,
    moves: &mut dyn FnMut(Told),
) -> (Shape, bool) {
    let mut limits = LimitWatch::new(machine);
    let mut way = Way::new(radius);
    let mut seen = Seen::default();
    let mut places = Places::default();
    let state = from.state.clone();
    let program = open().and_then(|text| Interpreter::from_state(text, state, READING));
    let sound = program.is_ok_and(|mut program| {
        let errors = program.tell_all(&mut |event| {
            seen.event(event);
            let followed = places.follow(event);
            limits.hear(event, followed.as_ref());
            if let Some(followed) = &followed {
                way.motion(followed, &mut |m| moves(Told::Move(m)));
            }
        });
        errors.is_empty()
    });
    let shape = Shape {
        limits: limits.finish(),
        figures: way.figures,
        moves: way.moves,
        seen,
        start: from,
    };
    (shape, sound)
}

impl Seen {
    fn event(&mut self, event: &Event) {
        self.anything = true;
        match event {
            Event::ToolChange { .. } => self.tool_change = true,
            Event::Pause { .. } => self.pause = true,
            Event::Probe { .. } => self.probe = true,
            _ => {}
        }
    }
}
