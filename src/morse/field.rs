//! A Morse function on the tool-centre grid, and its critical points.

use super::average::{AverageOptions, average_distance};
use super::cancel::{Pair, peaks, pits};
use super::critical::{CriticalKind, CriticalPoint, Link, Scalar, classify};
use super::curvature;
use super::euler::Euler;
use super::function::{MorseFunction, noise};
use super::height::{beyond_border, border_doubt, linear};
use super::plane::Plane;
use super::refine::{is_beside_border, refined};
use super::select::{Chosen, Saddle, select};
use super::surface::Surface;
use crate::geom::Point;
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// What counts as a critical point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MorseOptions {
    /// Pairs of critical points whose values differ by less than this are noise; mm, or the function's own unit.
    pub persistence_mm: f64,
}

/// The values that the link rule is applied to: the ground, and one ring of nodes beyond its border that carry the function's
/// value *on* the border.
///
/// Without that ring the border would be the staircase of the grid, and each step of it a false pit on a slope.
#[derive(Clone, Debug)]
pub struct GridField {
    /// What the values are.
    pub function: MorseFunction,
    /// Value per node, in the function's unit.
    pub value: Vec<f64>,
    /// Ground and the ring beyond it.
    pub active: Vec<bool>,
    /// Roughness, in the function's unit. Of height and projection that of the border: the standard deviation of its heights about planes
    /// fitted along it, by their median; a few micrometres on a clean mesh, the noise of the scanner on a scanned one. Of curvature
    /// what it differs by from its mean over twice the radius. Zero for average distance.
    pub roughness: f64,
}

/// How to work functions out on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldOptions {
    /// Curvature is averaged over this radius in plan, mm: about a stepover.
    pub radius: f64,
    /// How finely average distance is integrated.
    pub average: AverageOptions,
}

impl GridField {
    /// The height of the contact.
    pub fn new(grid: &ToolCentreGrid) -> GridField {
        linear(grid, MorseFunction::Height, |p| p.z)
    }

    /// Any function. Cost: height and projection linear in the nodes; curvature with the nodes in `radius` as well; geodesic see
    /// [`average_distance`].
    pub fn of(grid: &ToolCentreGrid, function: MorseFunction, options: &FieldOptions) -> GridField {
        match function {
            MorseFunction::Height => GridField::new(grid),
            MorseFunction::Projection => {
                let plane = Plane::fitted(&contacts(grid).0);
                linear(grid, function, |p| plane.distance(p))
            }
            MorseFunction::MeanCurvature => bent(grid, options.radius),
            MorseFunction::Geodesic => {
                let (surface, node) = contacts(grid);
                let at_vertex = average_distance(&surface, &options.average);
                let mut value = vec![0.0; grid.len()];
                let mut active = vec![false; grid.len()];
                for (&n, v) in node.iter().zip(at_vertex) {
                    value[n as usize] = v;
                    active[n as usize] = true;
                }
                GridField {
                    function,
                    value,
                    active,
                    roughness: 0.0,
                }
            }
        }
    }

    fn scalar<'a>(&'a self, grid: &ToolCentreGrid) -> Scalar<'a> {
        Scalar {
            nx: grid.nx,
            value: &self.value,
            active: &self.active,
        }
    }

    /// Differences that mean nothing, in the function's unit, for functions that have no better yardstick: see [`noise`].
    pub fn noise(&self) -> f64 {
        let there = self.value.iter().zip(&self.active);
        noise(
            self.function,
            there.filter(|(_, a)| **a).map(|(v, _)| *v),
            self.roughness,
        )
    }
}

/// Curvature at ground nodes and on the border.
fn bent(grid: &ToolCentreGrid, radius: f64) -> GridField {
    let mut active: Vec<bool> = grid.kind.iter().map(|k| *k == NodeKind::Ground).collect();
    let mut value: Vec<f64> = (0..grid.len())
        .into_par_iter()
        .map(|i| {
            if grid.kind[i] != NodeKind::Ground {
                return 0.0;
            }
            let q = grid.xy(i);
            curvature::at_place(grid, q.x, q.y, radius)
        })
        .collect();
    let at_crossing: Vec<f64> = grid
        .crossings
        .par_iter()
        .map(|c| curvature::at_place(grid, c.contact.center.x, c.contact.center.y, radius))
        .collect();
    let roughness = curvature::roughness_of_grid(grid, &value, radius);
    beyond_border(grid, &at_crossing, &mut value, &mut active);
    GridField {
        function: MorseFunction::MeanCurvature,
        value,
        active,
        roughness,
    }
}

/// The ground as the ball touches it, and the node of each vertex. Nodes beyond the border stand where the border is.
fn contacts(grid: &ToolCentreGrid) -> (Surface, Vec<u32>) {
    let mut active: Vec<bool> = grid.kind.iter().map(|k| *k == NodeKind::Ground).collect();
    let mut place = vec![f64::INFINITY; grid.len()];
    let mut of = vec![0u32; grid.len()];
    for (k, c) in grid.crossings.iter().enumerate() {
        let o = c.outside as usize;
        let q = grid.xy(o);
        let d = (c.contact.center.x - q.x).hypot(c.contact.center.y - q.y);
        active[o] = true;
        if d < place[o] {
            place[o] = d;
            of[o] = k as u32;
        }
    }
    let at = |i: usize| -> Point {
        if grid.kind[i] == NodeKind::Ground {
            grid.point[i]
        } else {
            grid.crossings[of[i] as usize].contact.point
        }
    };
    Surface::of_grid(grid, &active, &at)
}

/// A function's critical points on a grid at every threshold: worked out once, asked often.
#[derive(Debug)]
pub struct GridMorse<'a> {
    grid: &'a ToolCentreGrid,
    field: &'a GridField,
    peaks: Vec<Pair>,
    pits: Vec<Pair>,
    saddles: Vec<Saddle>,
    /// Peaks less saddles plus pits before anything is cancelled, against Euler's number.
    pub euler: Euler,
}

impl<'a> GridMorse<'a> {
    /// Sorts the nodes, floods them from below and above, and reads every link.
    pub fn new(grid: &'a ToolCentreGrid, field: &'a GridField) -> GridMorse<'a> {
        let s = field.scalar(grid);
        // An extreme of the border must be deeper than the border is known; a lone node is no place to start a feature from.
        let known = |p: &Pair| {
            p.persistence >= border_doubt(grid, field, p.extreme)
                && classify(&s, p.extreme).0 != Link::Regular
        };
        let split = |all: Vec<Pair>| all.into_iter().partition::<Vec<Pair>, _>(known);
        let ((peaks, doubtful_peaks), (pits, doubtful_pits)) = (split(peaks(&s)), split(pits(&s)));
        let mut gone: Vec<usize> = doubtful_peaks
            .iter()
            .chain(&doubtful_pits)
            .filter_map(|p| p.merge)
            .collect();
        gone.sort_unstable();
        let mut saddles = Vec::new();
        for node in (0..grid.len()).filter(|&i| field.active[i]) {
            if let (Link::Saddle(arms), _) = classify(&s, node) {
                let lost =
                    gone.partition_point(|g| *g <= node) - gone.partition_point(|g| *g < node);
                let arms = arms.saturating_sub(lost as u32);
                if arms > 0 {
                    saddles.push(Saddle { node, arms });
                }
            }
        }
        GridMorse {
            grid,
            field,
            peaks,
            pits,
            saddles,
            euler: Euler::of_grid(&s),
        }
    }

    /// Extremes and where they end: `(kind, extreme, pair)`.
    pub fn pairs(&self) -> impl Iterator<Item = (CriticalKind, &Pair)> {
        let kinds = [CriticalKind::Maximum, CriticalKind::Minimum];
        [&self.peaks, &self.pits]
            .into_iter()
            .zip(kinds)
            .flat_map(|(list, kind)| list.iter().map(move |p| (kind, p)))
    }

    fn chosen(&self, limit: f64) -> Vec<Chosen> {
        select(&self.peaks, &self.pits, &self.saddles, limit)
    }

    /// The critical points that are left when pairs below `limit` are cancelled, placed below the grid's step: peaks by falling
    /// value, pits by rising value, saddles by falling value. A saddle of several arms is listed once per arm too many.
    pub fn critical_points(&self, limit: f64) -> Vec<CriticalPoint> {
        let s = self.field.scalar(self.grid);
        let out = self
            .chosen(limit)
            .iter()
            .map(|c| {
                let boundary = c.kind != CriticalKind::Saddle && classify(&s, c.node).1;
                refined(self.grid, self.field, c, boundary)
            })
            .collect();
        self.sorted(out)
    }

    /// The same at their nodes, unplaced: to count and to grow from.
    pub fn critical_nodes(&self, limit: f64) -> Vec<CriticalPoint> {
        let s = self.field.scalar(self.grid);
        let out = self
            .chosen(limit)
            .iter()
            .map(|c| CriticalPoint {
                kind: c.kind,
                node: c.node,
                boundary: c.kind != CriticalKind::Saddle
                    && (classify(&s, c.node).1 || is_beside_border(self.grid, c.node)),
                center: self.grid.center(c.node),
                contact: self.grid.point[c.node],
                value: self.field.value[c.node],
                persistence: c.persistence,
            })
            .collect();
        self.sorted(out)
    }

    fn sorted(&self, mut out: Vec<CriticalPoint>) -> Vec<CriticalPoint> {
        // Height stands for what the tool does: its order is that of the centres.
        let key = |c: &CriticalPoint| match self.field.function {
            MorseFunction::Height => c.center.z,
            _ => c.value,
        };
        out.sort_by(|a, b| {
            let rise = if a.kind == CriticalKind::Minimum {
                1.0
            } else {
                -1.0
            };
            a.kind
                .cmp(&b.kind)
                .then((rise * key(a)).total_cmp(&(rise * key(b))))
                .then(a.node.cmp(&b.node))
        });
        out
    }
}

/// Critical points of a function over a grid: peaks by falling value, pits by rising value, saddles by falling value.
/// A saddle of several arms is listed once per arm too many.
pub fn critical_points(
    grid: &ToolCentreGrid,
    field: &GridField,
    options: &MorseOptions,
) -> Vec<CriticalPoint> {
    GridMorse::new(grid, field).critical_points(options.persistence_mm)
}
