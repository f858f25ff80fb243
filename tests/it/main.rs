//! Integration tests, one binary.
mod part;
