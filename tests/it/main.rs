//! Integration tests, one binary.
mod part;
mod simulate;
