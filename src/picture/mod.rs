//! Pictures for people: the part shaded, the passes over it, the cusp as a heat map. PNG bytes out, the same on every run.
//!
//! Crosses the border: plain rasters, polylines, markers and words, in work coordinates and mm (cusps in whatever unit the caller
//! names). Knows nothing of paths, machines or verdicts: whoever draws converts. Opens no files.
//!
//! ```text
//! Raster + labels -> relief (view, z-buffer, light) -> Canvas (lines, markers, legend, words) -> PNG
//! ```

pub mod canvas;
pub mod close_up;
pub mod color;
pub mod heat;
mod panel;
pub mod raster;
pub mod relief;
pub mod scene;
pub mod surface;
mod text;

pub use canvas::Canvas;
pub use close_up::{CloseUp, Pane, TurnMark, close_up};
pub use heat::{Gouge, HeatMap, heat_map};
pub use raster::Raster;
pub use relief::View;
pub use scene::{Line, LineKind, Marker, MarkerKind, Scene, passes, shaded};
pub use surface::{SurfaceScene, surface_map};

/// Why no picture was made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// A raster without a single value.
    #[error("nothing to draw: the {0} raster has no values")]
    Nothing(&'static str),
    /// A raster whose values do not fill its grid, or whose step is not above zero.
    #[error(
        "the {0} raster is inconsistent: its values do not fill its nodes, or its step is not above zero"
    )]
    Raster(&'static str),
    /// A size that cannot be drawn.
    #[error("a picture of {0} x {1} pixels cannot be made: ask for a width of 400 to 4000")]
    Size(u32, u32),
    /// The PNG writer refused.
    #[error("the PNG could not be written: {0}")]
    Png(String),
}
