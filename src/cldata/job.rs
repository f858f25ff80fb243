//! What a job needs beyond its moves.

use crate::units::{Mm, MmPerMin, Rpm, Seconds};

/// Coolant during the job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coolant {
    /// None.
    #[default]
    Off,
    /// M8.
    Flood,
    /// M7.
    Mist,
    /// Flood and mist together, M7 and M8.
    Both,
}

impl Coolant {
    /// In words: what runs.
    pub fn words(self) -> &'static str {
        match self {
            Coolant::Off => "no coolant",
            Coolant::Flood => "flood",
            Coolant::Mist => "mist",
            Coolant::Both => "flood and mist together",
        }
    }
}

/// What a program needs beyond its moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Comment lines for the top of the program: part, tool, stock assumption, tolerances, error budget. Any text: it is made
    /// harmless for the dialect and split where it is too long.
    pub header: Vec<String>,
    /// Feed of [`crate::toolpath::MoveKind::Cut`] and [`crate::toolpath::MoveKind::Link`] that have no lower one of their own; above zero.
    pub feed: MmPerMin,
    /// Feed of [`crate::toolpath::MoveKind::Plunge`]; above zero.
    pub plunge: MmPerMin,
    /// Spindle speed. Zero leaves the spindle to the operator: no spindle words but the final M5.
    pub speed: Rpm,
    /// Tool number, where the dialect has tools.
    pub tool_number: u32,
    /// Time to wait for the spindle to reach its speed; zero for none.
    pub spin_up: Seconds,
    /// Coolant.
    pub coolant: Coolant,
    /// How far the controller may leave the path when it blends segments; `None` for the dialect's own figure.
    pub path_tolerance: Option<Mm>,
}
