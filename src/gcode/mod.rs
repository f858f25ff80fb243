//! Text to what the machine is told: words and blocks (nom), modal state, interpreter, events.
//!
//! Crosses the border: program text in; [`Event`]s in work coordinates, mm and mm/min, out. No I/O, no machine limits, and
//! never any knowledge of `post`: the two are each other's witness.
//!
//! ```text
//! word -> block -> check -> execute -> event        interpret: all of it, for a line or a program in memory
//! letters  one      against  carried    what the
//! numbers  line     state    out        machine is told
//!
//! source -> program (expression, parameter, flow)   programs of any length: order of lines, calls, loops, variables
//! ```
//!
//! ```
//! use morsemill::gcode::{Dialect, interpret};
//!
//! let program = interpret("G21 G90\nG0 Z5\nG1 Z-1 F300\nX10\n", Dialect::Grbl).unwrap();
//! assert_eq!(program.events.len(), 3);
//!
//! let mistakes = interpret("G1 X10\n", Dialect::Grbl).unwrap_err();
//! assert!(mistakes[0].to_string().starts_with("1:1 this move has no feed rate"));
//! ```

mod arc;
mod block;
mod check;
mod codes;
pub mod cycle;
pub mod dialect;
mod envelope;
pub mod error;
pub mod event;
mod execute;
mod expression;
mod expression_complaint;
mod expression_function;
mod flow;
mod heidenhain;
pub mod interpret;
mod parameter;
pub mod program;
pub mod rules;
mod siemens;
pub mod single;
pub mod source;
pub mod state;
mod tongue;
mod word;

pub use dialect::Dialect;
pub use error::{Code, Complaint, InterpretError};
pub use event::{Arc, Event, Motion, MotionKind, Plane};
pub use expression::ExpressionComplaint;
pub use heidenhain::complaint::HeidenhainComplaint;
pub use interpret::{
    MAX_ERRORS, Program, interpret, interpret_from, interpret_jog, interpret_line, lines,
};
pub use program::{Comment, FlowComplaint, Interpreter, Reading};
pub use siemens::complaint::SiemensComplaint;
pub use state::{Distance, FeedMode, MotionMode, PathMode, Probe, Retract, State, Units};
