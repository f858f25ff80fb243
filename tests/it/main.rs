//! Integration tests, one binary; modules in reading order: shared tools, then the chain from part to program (laws of each stage),
//! the dry run, the cable, and the whole story through the binary.

mod common;

mod part;
mod reach;
mod morse;

mod link;
mod recordings;
mod simulate;
