//! Both ends of the cable together: the session against the simulated controller, first on a clock turned by hand over a pipe that
//! delays and cuts as it likes, then over a real pseudo-terminal.
#![allow(clippy::unwrap_used)]

mod bench;
mod cable;

mod faults;
mod jobs;
mod operator;
mod stalls;
mod terminal;
mod throughput;
