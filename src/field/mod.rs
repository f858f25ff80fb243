//! Distance fields over the tool-centre grid: rulers, fast marching, level curves.
//!
//! Crosses the border: a [`crate::reach::ToolCentreGrid`] in; a [`Metric`] (squared length per step, so that one unit is one pass),
//! arrival values per node and level curves in plan (mm) out. Knows nothing of features.

pub mod level;
pub mod march;
pub mod ruler;

pub use level::{LevelCurve, level_curves};
pub use march::{Front, MarchOptions, march};
pub use ruler::{Metric, Ruler};
