//! One resting ball per node of the lattice: the drops that everything else is made from.

use crate::reach::{Contact, DropCutter, Hint};
use crate::sweep::Lattice;
use rayon::prelude::*;

/// One resting ball per node.
pub(super) struct Nodes {
    pub(super) center_z: Vec<f64>,
    pub(super) part_z: Vec<f64>,
    /// Plan part of the unit vector from contact to centre (f32: used to seed and to detect only).
    pub(super) normal: Vec<[f32; 2]>,
}

pub(super) fn sample(drop: &DropCutter, lattice: &Lattice) -> Nodes {
    let n = lattice.len();
    let mut nodes = Nodes {
        center_z: vec![f64::NEG_INFINITY; n],
        part_z: vec![f64::NAN; n],
        normal: vec![[0.0; 2]; n],
    };
    let nx = lattice.nx.max(1);
    nodes
        .center_z
        .par_chunks_mut(nx)
        .zip(nodes.part_z.par_chunks_mut(nx))
        .zip(nodes.normal.par_chunks_mut(nx))
        .enumerate()
        .for_each(|(iy, ((center_z, part_z), normal))| {
            let y = lattice.y(iy);
            let mut hint = Hint::default();
            for ix in 0..center_z.len() {
                let x = lattice.x(ix);
                if let Some(c) = drop.drop_near(x, y, &mut hint) {
                    center_z[ix] = c.center.z;
                    let u = unit(&c);
                    normal[ix] = [u[0] as f32, u[1] as f32];
                    if let Some(z) = drop.surface_z(x, y) {
                        part_z[ix] = z;
                    }
                }
            }
        });
    nodes
}

/// Unit vector from contact to centre.
pub(super) fn unit(c: &Contact) -> [f64; 3] {
    let d = c.center - c.point;
    let n = d.norm();
    if n > 0.0 {
        [d.x / n, d.y / n, d.z / n]
    } else {
        [0.0, 0.0, 1.0]
    }
}
