//! Morse functions, their critical points and which of them are noise: on the tool-centre surface and on raw meshes.
//!
//! Crosses the border: a [`crate::reach::ToolCentreGrid`] or a [`crate::part::Mesh`] in, a scalar per node or vertex and critical
//! points with their persistence out. Knows nothing of fields, features or passes.
//!
//! | function | on the grid | on a mesh | unit |
//! |---|---|---|---|
//! | height | of the contact ([`height`]) | z of the vertex | mm |
//! | mean curvature | normals against contacts ([`curvature`]) | area gradients over a radius | 1/mm |
//! | average geodesic distance | over the contacts ([`average`]) | over the triangles | mm |
//! | distance to the best plane ([`plane`]) | of the contact | of the vertex | mm |

pub mod average;
pub mod cancel;
pub mod critical;
pub mod curvature;
pub mod euler;
pub mod field;
pub mod function;
pub mod geodesic;
pub mod height;
pub mod mesh;
pub mod plane;
mod refine;
pub mod resample;
pub mod select;
pub mod surface;
pub mod table;

pub use average::{AverageOptions, average_distance};
pub use critical::{CriticalKind, CriticalPoint};
pub use euler::Euler;
pub use field::{FieldOptions, GridField, GridMorse, MorseOptions, critical_points};
pub use function::{MorseFunction, noise};
pub use height::HeightField;
pub use mesh::{Cell, MeshMorse, MeshOptions};
pub use plane::Plane;
pub use surface::Surface;
