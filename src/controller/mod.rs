//! x
pub mod intake;
pub mod motion;
pub mod settings;
mod complaint;
