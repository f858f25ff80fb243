//! A program as the dry run reads it: opened anew for each pass, never held.

use crate::gcode::source::TextReader;
use crate::gcode::{Complaint, FlowComplaint, InterpretError, Reading};
use std::io::{self, Cursor};

/// Opens a program from its beginning.
pub type Open<'a> = dyn Fn() -> io::Result<Box<dyn TextReader + 'a>> + Sync + 'a;

/// How programs are read here: loops are run, but not for ever.
pub(super) const READING: Reading = Reading {
    lines_again: 1_000_000,
    comments: false,
};

/// A program in memory.
pub(super) fn in_memory<'a>(
    text: &'a str,
) -> impl Fn() -> io::Result<Box<dyn TextReader + 'a>> + Sync + 'a {
    move || Ok(Box::new(Cursor::new(text.as_bytes())))
}

/// What the reader says of a file that cannot be read.
pub(super) fn unreadable(e: &io::Error) -> InterpretError {
    InterpretError {
        line: 1,
        column: 1,
        complaint: Complaint::Flow(FlowComplaint::Unreadable { kind: e.kind() }),
    }
}
