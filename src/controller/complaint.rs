//! The interpreter's complaints as GRBL's error numbers: `wire` has the table, for both ends of the cable.

pub use crate::wire::error_number;
