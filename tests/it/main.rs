//! Integration tests, one binary; modules in reading order: what they share, the laws of each stage from part to program, the dry run,
//! the cable, what is refused, and the whole story through the binary.

mod chance;
mod common;
mod plans;

mod faces;
mod feature;
mod field;
mod finish;
mod fit;
mod fronts;
mod functions;
mod morse;
mod part;
mod reach;
mod simulate;
mod toolpath;
mod turns;
mod walls;

mod cl;
mod programs;
mod round_trip;
mod translations;

mod campaign;
mod errand;
mod fuzz;
mod hostile;
mod link;
mod looks;
mod machines;
mod recordings;
mod resume;
mod settings;

mod own_files;
mod refusals;
mod repeat;
mod story;
