//! The command line: the only place that prints, asks or names files.

pub mod controller;
pub mod machines;
pub mod ports;
pub mod posts;
pub mod send;

/// Runs the program; the exit code is 0 clean, 1 not acceptable, 2 could not be carried out.
pub fn main() -> std::process::ExitCode {
    std::process::ExitCode::from(2)
}
