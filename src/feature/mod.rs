//! Freeform machining features: regions grown from critical points to their closest saddles, and what is left between them; the whole
//! part as one; or faces, which walls and sharp edges part.
//!
//! Crosses the border: critical points, a ruler and the grid in; [`Regions`] out, each [`Feature`] with its own field and the levels
//! to cut. Leaves the cutter to `reach`, and knows nothing of machines or moves.

pub mod faces;
pub mod ground;
pub mod grow;
pub mod leftover;
pub mod region;
pub mod source;
pub mod whole;

pub use faces::{FaceOptions, Faces, faces};
pub use ground::GrowOptions;
pub use grow::grow;
pub use region::{Feature, FeatureKind, Regions, Window};
pub use source::{FieldSource, Metrics, refield};
pub use whole::{Source, farthest, sources, whole};
