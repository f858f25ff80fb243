//! The triangle soup.

use crate::geom::{Box3, Point, Vector};

/// Triangles as they came: no welding, no order, any orientation; holes, overlaps and slivers are allowed.
/// All coordinates are finite. Units mm. Memory: 72 bytes a triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners of each triangle, counter-clockwise from outside where the file was right about it.
    pub triangles: Vec<[Point; 3]>,
}

impl Mesh {
    /// The smallest axis-aligned box around all triangles.
    pub fn bounds(&self) -> Box3 {
        Box3::of(self.triangles.iter().flatten())
    }

    /// Cross product of two edges: twice the area, along the outward normal by the file's winding. Zero for slivers.
    pub fn doubled_area_vector(t: &[Point; 3]) -> Vector {
        (t[1] - t[0]).cross(&(t[2] - t[0]))
    }
}
