//! Sinumerik 840D sl, in its own language: a line to what the machine is told.

pub mod complaint;
use super::error::{Complaint, Fault};
use super::event::Event;
use super::flow::{Label, Said};
use super::state::State;

/// What the language remembers beyond [`State`]: R parameters, frames, modal calls.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Memory {}

/// Carries out one line. On an error nothing has changed.
pub(super) fn line(
    _state: &mut State,
    _memory: &mut Memory,
    _text: &str,
    _line: usize,
    _events: &mut Vec<Event>,
) -> Said {
    Err(Fault::at(0, Complaint::ExpectedLetter { found: '?' }))
}

/// The label that a line carries, if it does.
pub(super) fn label(_text: &str) -> Option<Label> {
    None
}
