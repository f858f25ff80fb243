//! What the two languages that are not plain word addresses ([`super::heidenhain`], [`super::siemens`]) have in common: reading a line
//! from left to right, names inside messages, circles, and telling the machine.
//!
//! Crosses the border: text and numbers in mm, work coordinates; [`super::event::Event`]s out. Never knows a language's words.

pub(super) mod circle;
pub(super) mod desk;
pub(super) mod name;
pub(super) mod scan;

#[cfg(test)]
pub(super) mod driver;
