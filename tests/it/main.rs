//! Integration tests, one binary; modules in reading order.

mod link;
mod recordings;
