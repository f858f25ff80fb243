//! x
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SiemensComplaint { 
#[error("x")] X }
