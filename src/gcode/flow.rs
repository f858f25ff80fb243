//! What a line asks of the order of lines. Each language's line reader says it; `program` carries it out.

use super::error::Fault;

/// A place in the program that a line can name: as its language writes it, without blanks, upper case (`O100`, `N50`, `LBL1`).
pub(super) type Label = Box<str>;

/// Where reading goes on behind a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Flow {
    /// With the next line.
    Next,
    /// Behind the line that carries the label, wherever it stands: `times` times over, until a [`Flow::Return`] or the program's end; then
    /// behind the call.
    Call {
        /// Where to.
        label: Label,
        /// How often; never zero.
        times: u32,
    },
    /// From the line that carries the label to this one again, `times` times.
    Repeat {
        /// From where.
        label: Label,
        /// How often; never zero.
        times: u32,
    },
    /// At the line that carries the label.
    Goto {
        /// Where to.
        label: Label,
        /// Only lines behind this one are looked at (true), or only lines before it; `None`: behind it first, then from the top.
        forward: Option<bool>,
    },
    /// Behind the call. At the top level: the program is over.
    Return,
    /// Nothing more is read.
    End,
}

/// What one line came to.
pub(super) type Said = Result<Flow, Fault>;
