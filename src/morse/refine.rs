//! Placing critical points below the grid's step, and past the facets of the mesh.
//!
//! Inside, by the level point of a quadratic fitted to the *centre* heights round about: they are smoother than the contacts, and level
//! at the same place. On the border, by the extreme of a cubic fitted to the outline's heights along it.

use super::critical::{CriticalKind, CriticalPoint};
use super::field::GridField;
use super::function::MorseFunction;
use super::select::Chosen;
use crate::geom::{Point, Vector, Vector2};
use crate::reach::{Crossing, LINK, NodeKind, ToolCentreGrid};
use nalgebra::{SMatrix, SVector};

/// Half width, in steps, of the window a quadratic is fitted over: about a stepover, two facets of a good mesh.
const WINDOW: i32 = 6;
/// Most the fit may lead away from the node, in steps. Where a ball sits on a mesh vertex for many nodes on end, the node that wins the tie
/// may be at the rim of them.
const DRIFT: f64 = 8.0;

/// True where the border is no farther than one step.
pub(super) fn is_beside_border(grid: &ToolCentreGrid, node: usize) -> bool {
    LINK.iter().any(|d| {
        grid.neighbour(node, *d)
            .is_none_or(|j| grid.kind[j] != NodeKind::Ground)
    })
}

pub(super) fn refined(
    grid: &ToolCentreGrid,
    field: &GridField,
    chosen: &Chosen,
    boundary: bool,
) -> CriticalPoint {
    let &Chosen {
        kind,
        node,
        persistence,
    } = chosen;
    // An extreme of the border may be won by the ground node beside it.
    let boundary = boundary || (kind != CriticalKind::Saddle && is_beside_border(grid, node));
    let (center, contact) = if field.function != MorseFunction::Height {
        elsewhere(grid, field, kind, node, boundary)
    } else if boundary {
        on_border(grid, kind, node)
    } else {
        inside(grid, kind, node)
    };
    CriticalPoint {
        kind,
        node,
        boundary,
        center,
        contact,
        value: match field.function {
            MorseFunction::Height => contact.z,
            _ => field.value[node],
        },
        persistence,
    }
}

/// Half width, in steps, of the window a quadratic is fitted over for functions other than height, and the most it may lead away.
const FLAT_WINDOW: i32 = 4;
const FLAT_DRIFT: f64 = 3.0;

/// The place of a critical point of any function: on the border its crossing, inside the level point of a quadratic fitted to the
/// values round about, with the ball let down there between the nodes.
fn elsewhere(
    grid: &ToolCentreGrid,
    field: &GridField,
    kind: CriticalKind,
    node: usize,
    boundary: bool,
) -> (Point, Point) {
    let plain = (grid.center(node), grid.point[node]);
    if boundary {
        let q = grid.xy(node);
        let d = |c: &Crossing| (c.contact.center.xy() - q).norm();
        return grid
            .crossings
            .iter()
            .map(|c| (d(c), c))
            .reduce(|a, b| if b.0 < a.0 { b } else { a })
            .filter(|_| grid.kind[node] != NodeKind::Ground)
            .map_or(plain, |(_, c)| (c.contact.center, c.contact.point));
    }
    let w = FLAT_WINDOW as f64;
    let mut fit = Quadric::default();
    for dy in -FLAT_WINDOW..=FLAT_WINDOW {
        for dx in -FLAT_WINDOW..=FLAT_WINDOW {
            let (u, v) = (dx as f64 / w, dy as f64 / w);
            let near = 1.0 - u * u - v * v;
            if near > 0.0
                && let Some(j) = grid
                    .neighbour(node, (dx, dy))
                    .filter(|&j| grid.kind[j] == NodeKind::Ground)
            {
                fit.take(u, v, near, field.value[j] - field.value[node]);
            }
        }
    }
    let Some((u, v, _, hesse)) = fit.level() else {
        return plain;
    };
    let far = u.hypot(v) * w;
    if !is_meant(kind, hesse) || far.is_nan() || far > FLAT_DRIFT {
        return plain;
    }
    // Between the nodes about it, all of them ground.
    let (x, y) = ((u * w).floor(), (v * w).floor());
    let (fx, fy) = (u * w - x, v * w - y);
    let mut center = Vector::zeros();
    let mut contact = Vector::zeros();
    for (dx, dy, share) in [
        (0, 0, (1.0 - fx) * (1.0 - fy)),
        (1, 0, fx * (1.0 - fy)),
        (0, 1, (1.0 - fx) * fy),
        (1, 1, fx * fy),
    ] {
        let Some(j) = grid
            .neighbour(node, (x as i32 + dx, y as i32 + dy))
            .filter(|&j| grid.kind[j] == NodeKind::Ground)
        else {
            return plain;
        };
        center += grid.center(j).coords * share;
        contact += grid.point[j].coords * share;
    }
    (Point::from(center), Point::from(contact))
}

/// Whether second derivatives `[xx, xy, yy]` are those of such a point.
fn is_meant(kind: CriticalKind, hesse: [f64; 3]) -> bool {
    let flat = hesse[0] * hesse[2] - hesse[1] * hesse[1];
    match kind {
        CriticalKind::Saddle => flat < 0.0,
        CriticalKind::Maximum => flat > 0.0 && hesse[0] < 0.0,
        CriticalKind::Minimum => flat > 0.0 && hesse[0] > 0.0,
    }
}

/// A quadratic in two coordinates, by weighted least squares.
#[derive(Clone, Debug, Default)]
struct Quadric {
    ata: SMatrix<f64, 6, 6>,
    atb: SVector<f64, 6>,
}

impl Quadric {
    fn take(&mut self, u: f64, v: f64, weight: f64, value: f64) {
        let row = SVector::<f64, 6>::from([1.0, u, v, u * u, u * v, v * v]);
        self.ata += row * row.transpose() * weight;
        self.atb += row * (weight * value);
    }

    /// Where it is level: the place, its value there, and its second derivatives `[xx, xy, yy]`.
    fn level(&self) -> Option<(f64, f64, f64, [f64; 3])> {
        let q = self.ata.cholesky()?.solve(&self.atb);
        let det = 4.0 * q[3] * q[5] - q[4] * q[4];
        let u = (-2.0 * q[5] * q[1] + q[4] * q[2]) / det;
        let v = (-2.0 * q[3] * q[2] + q[4] * q[1]) / det;
        if !(u.is_finite() && v.is_finite()) {
            return None;
        }
        let rise = q[0] + q[1] * u + q[2] * v + q[3] * u * u + q[4] * u * v + q[5] * v * v;
        Some((u, v, rise, [2.0 * q[3], q[4], 2.0 * q[5]]))
    }
}

fn inside(grid: &ToolCentreGrid, kind: CriticalKind, node: usize) -> (Point, Point) {
    let spot = settled(grid, kind, node).unwrap_or(Spot {
        center: grid.center(node),
        contact: Some(grid.point[node]),
        doubt: 0.5 * DRIFT * grid.step,
    });
    let spot = steadied(grid, kind, spot);
    // Level ground: the ball stands right above the point it touches.
    let c = spot.center;
    let below = Point::new(c.x, c.y, c.z - grid.radius);
    (c, spot.contact.unwrap_or(below))
}

/// A place found, and how far it may be off.
struct Spot {
    center: Point,
    /// Only where nothing could be fitted.
    contact: Option<Point>,
    /// Standard deviation, mm.
    doubt: f64,
}

/// The level point of a quadratic over a small window, fitted again about the place found until it stays.
fn settled(grid: &ToolCentreGrid, kind: CriticalKind, node: usize) -> Option<Spot> {
    let start = grid.xy(node);
    let mut at = node;
    for _ in 0..8 {
        let fit = Window::<6>::fitted(grid, at, WINDOW, [0.0; 2])?;
        let c = fit.center;
        let far = (c.xy() - start).norm();
        if !is_meant(kind, fit.hesse) || far.is_nan() || far > DRIFT * grid.step {
            return None;
        }
        let spot = Spot {
            center: c,
            contact: None,
            doubt: fit.doubt,
        };
        let here = grid.xy(at);
        if (c.xy() - here).norm() <= 0.75 * grid.step {
            return Some(spot);
        }
        // Fit again about the place found, or as near to it as the window lets one trust.
        let reach = 0.5 * WINDOW as f64 * grid.step;
        let d = c.xy() - here;
        let to = here + d * (reach / d.norm()).min(1.0);
        match grid.nearest(to.x, to.y) {
            Some(n) if n != at => at = n,
            _ => return Some(spot),
        }
    }
    None
}

/// Half widths, in steps, of the wider windows that steady a place on rough ground.
const WIDER: [i32; 4] = [9, 13, 18, 25];
/// A wider window is believed while its place is this many standard deviations from those of the narrower ones, at most.
const AGREE: f64 = 2.0;
/// Steps over which the noise of neighbouring nodes hangs together: the facets and bumps one ball rests on.
const TOGETHER: f64 = 3.0;

/// Cubics over wider and wider windows, as long as each agrees with all before within their doubts and is surer than they: on a clean
/// part the first one that bends otherwise ends it, on a scanned one the noise is averaged out. (O. V. Lepski, *On a problem of adaptive
/// estimation in Gaussian white noise*, 1990.)
fn steadied(grid: &ToolCentreGrid, kind: CriticalKind, first: Spot) -> Spot {
    let mut tried: Vec<(Point, f64)> = vec![(first.center, first.doubt)];
    let mut best = first;
    for width in WIDER {
        let c = best.center;
        let Some(node) = grid.nearest(c.x, c.y) else {
            break;
        };
        let d = (c.xy() - grid.xy(node)) / (width as f64 * grid.step);
        let Some(fit) = Window::<10>::fitted(grid, node, width, [d.x, d.y]) else {
            break;
        };
        let agrees = tried
            .iter()
            .all(|(p, doubt)| (fit.center.xy() - p.xy()).norm() <= AGREE * doubt);
        if !(is_meant(kind, fit.hesse) && agrees) {
            break;
        }
        tried.push((fit.center, fit.doubt));
        if fit.doubt < best.doubt {
            best = Spot {
                center: fit.center,
                contact: None,
                doubt: fit.doubt,
            };
        }
    }
    best
}

/// A polynomial of N terms (6: quadratic, 10: cubic) fitted to the centre heights in a window.
struct Window<const N: usize> {
    /// Where it is level.
    center: Point,
    /// Its second derivatives there `[xx, xy, yy]`, up to scale.
    hesse: [f64; 3],
    /// Standard deviation of the place, by what the nodes differ from the polynomial, mm.
    doubt: f64,
}

impl<const N: usize> Window<N> {
    /// Nodes count less the farther they are. The level point is sought from `from` on, in half widths. `None` near the border or where
    /// there is none.
    fn fitted(grid: &ToolCentreGrid, node: usize, width: i32, from: [f64; 2]) -> Option<Window<N>> {
        let here = grid.center(node);
        if grid.kind[node] != NodeKind::Ground {
            return None;
        }
        let powers: [(i32, i32); 10] = [
            (0, 0),
            (1, 0),
            (0, 1),
            (2, 0),
            (1, 1),
            (0, 2),
            (3, 0),
            (2, 1),
            (1, 2),
            (0, 3),
        ];
        let w = width as f64;
        let mut ata = SMatrix::<f64, N, N>::zeros();
        let mut atb = SVector::<f64, N>::zeros();
        let (mut used, mut wanted) = (0, 0);
        let (mut squares, mut weights) = (0.0, 0.0);
        for dy in -width..=width {
            for dx in -width..=width {
                let (u, v) = (dx as f64 / w, dy as f64 / w);
                let near = 1.0 - u * u - v * v;
                if near <= 0.0 {
                    continue;
                }
                wanted += 1;
                let Some(j) = grid
                    .neighbour(node, (dx, dy))
                    .filter(|&j| grid.kind[j] == NodeKind::Ground)
                else {
                    continue;
                };
                used += 1;
                let row = SVector::<f64, N>::from_fn(|k, _| {
                    let (a, b) = powers[k.min(9)];
                    u.powi(a) * v.powi(b)
                });
                let weight = near * near;
                let z = grid.center_z[j] - here.z;
                ata += row * row.transpose() * weight;
                atb += row * (weight * z);
                squares += weight * z * z;
                weights += weight;
            }
        }
        if 3 * used < 2 * wanted {
            return None;
        }
        let inverse = ata.cholesky()?.inverse();
        let q = inverse * atb;
        // The polynomial's derivatives of order (i, j) at a place.
        let part = |u: f64, v: f64, i: i32, j: i32| -> f64 {
            let one = |p: i32, d: i32, x: f64| -> f64 {
                (0..d).map(|k| f64::from(p - k)).product::<f64>()
                    * if p < d { 0.0 } else { x.powi(p - d) }
            };
            (0..N)
                .map(|k| q[k] * one(powers[k.min(9)].0, i, u) * one(powers[k.min(9)].1, j, v))
                .sum()
        };
        let [mut u, mut v] = from;
        for _ in 0..20 {
            let (gu, gv) = (part(u, v, 1, 0), part(u, v, 0, 1));
            let (a, b, c) = (part(u, v, 2, 0), part(u, v, 1, 1), part(u, v, 0, 2));
            let det = a * c - b * b;
            let (du, dv) = ((c * gu - b * gv) / det, (a * gv - b * gu) / det);
            u -= du;
            v -= dv;
            if !(u.is_finite() && v.is_finite()) || (N > 6 && u.hypot(v) > 1.0) {
                return None;
            }
            if du.hypot(dv) < 1e-9 {
                break;
            }
        }
        if N > 6 && u.hypot(v) > 0.5 {
            return None;
        }
        let (a, b, c) = (part(u, v, 2, 0), part(u, v, 1, 1), part(u, v, 0, 2));
        let det = a * c - b * b;
        // The gradient's spread, through the inverse of the second derivatives.
        let variance = ((squares - q.dot(&atb)).max(0.0) / weights) * TOGETHER * TOGETHER;
        let (gg, gh, hh) = (inverse[(1, 1)], inverse[(1, 2)], inverse[(2, 2)]);
        let spread = (c * c * gg - 2.0 * b * c * gh + b * b * hh)
            + (b * b * gg - 2.0 * a * b * gh + a * a * hh);
        let scale = w * grid.step;
        Some(Window {
            center: Point::new(
                here.x + u * scale,
                here.y + v * scale,
                here.z + part(u, v, 0, 0),
            ),
            hesse: [a, b, c],
            doubt: scale * (variance * spread.max(0.0)).sqrt() / det.abs(),
        })
    }
}

/// How far along the border a cubic is fitted, in steps: two to three stepovers to either side; and the longer stretches that steady it
/// on rough ground.
const ALONG: [f64; 4] = [13.0, 20.0, 30.0, 45.0];

fn on_border(grid: &ToolCentreGrid, kind: CriticalKind, node: usize) -> (Point, Point) {
    let q = grid.xy(node);
    let sign = if kind == CriticalKind::Maximum {
        -1.0
    } else {
        1.0
    };
    let near = |c: &&Crossing, reach: f64| (c.contact.center.xy() - q).norm() <= reach * grid.step;
    let best = grid
        .crossings
        .iter()
        .filter(|c| near(c, 2.5))
        .reduce(|a, b| {
            if sign * b.contact.point.z < sign * a.contact.point.z {
                b
            } else {
                a
            }
        });
    let Some(best) = best else {
        return (grid.center(node), grid.point[node]);
    };
    let plain = (best.contact.center, best.contact.point);
    let at = best.contact.point;
    let first = match along_border(grid, &at, sign, ALONG[0] * grid.step) {
        Along::Level(first) => first,
        Along::Corner => return corner(grid, node, sign, plain),
        Along::Nothing => return plain,
    };
    let mut tried = vec![(first.contact, first.doubt)];
    let mut best = first;
    for reach in &ALONG[1..] {
        let Along::Level(next) = along_border(grid, &at, sign, reach * grid.step) else {
            break;
        };
        let agrees = tried
            .iter()
            .all(|(p, doubt)| (next.contact.xy() - p.xy()).norm() <= AGREE * doubt);
        if !agrees {
            break;
        }
        tried.push((next.contact, next.doubt));
        if next.doubt < best.doubt {
            best = next;
        }
    }
    (best.center, best.contact)
}

/// What a stretch of border says.
enum Along {
    /// A level place of the right kind.
    Level(OnBorder),
    /// The border bends or ends here.
    Corner,
    /// Too little to fit.
    Nothing,
}

struct OnBorder {
    center: Point,
    contact: Point,
    /// Standard deviation of the place along the border, mm.
    doubt: f64,
}

/// The extreme of a cubic fitted to the outline's heights along it, within `scale` mm of a place.
fn along_border(grid: &ToolCentreGrid, at: &Point, sign: f64, scale: f64) -> Along {
    let beside: Vec<&Crossing> = grid
        .crossings
        .iter()
        .filter(|c| (c.contact.point.xy() - at.xy()).norm() <= scale)
        .collect();
    // The border's direction: the main axis of the places about; a corner has none, and is where it is.
    let n = beside.len() as f64;
    let mean = beside
        .iter()
        .map(|c| c.contact.point.xy().coords)
        .sum::<Vector2>()
        / n;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for c in &beside {
        let d = c.contact.point.xy().coords - mean;
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
    }
    let half = 0.5 * (xx - yy);
    let e = half.hypot(xy);
    let (large, small) = (0.5 * (xx + yy) + e, 0.5 * (xx + yy) - e);
    if small.is_nan() || small > 0.01 * large {
        return Along::Corner;
    }
    let angle = 0.5 * xy.atan2(half);
    let along = Vector2::new(angle.cos(), angle.sin());
    let mut ata = SMatrix::<f64, 4, 4>::zeros();
    let mut atb = SVector::<f64, 4>::zeros();
    let (mut lo, mut hi) = (0.0f64, 0.0f64);
    let (mut squares, mut weights) = (0.0, 0.0);
    for c in &beside {
        let t = (c.contact.point.xy() - at.xy()).dot(&along) / scale;
        (lo, hi) = (lo.min(t), hi.max(t));
        let weight = (1.0 - t * t).max(0.0);
        let row = SVector::<f64, 4>::from([1.0, t, t * t, t * t * t]);
        let z = c.contact.point.z - at.z;
        ata += row * row.transpose() * weight;
        atb += row * (weight * z);
        squares += weight * z * z;
        weights += weight;
    }
    let Some(inverse) = ata.cholesky().map(|c| c.inverse()) else {
        return Along::Nothing;
    };
    let p = inverse * atb;
    // Of the cubic's two level places the one of the right kind.
    let root = (p[2] * p[2] - 3.0 * p[1] * p[3]).max(0.0).sqrt();
    let t = -p[1] / (p[2] + sign * root);
    let bend = p[2] + 3.0 * p[3] * t;
    // An extreme of the right kind, well within what was fitted: else the border ends here, in a corner.
    if !(sign * bend > 0.0 && t.abs() < 0.6 && t > 0.8 * lo && t < 0.8 * hi) {
        return Along::Corner;
    }
    // Crossings within the reach of one bump say the same thing.
    let bump = (TOGETHER * grid.step * n / ((hi - lo) * scale)).max(1.0);
    let variance = (squares - p.dot(&atb)).max(0.0) / weights * bump;
    let to = at.xy() + along * (t * scale);
    beside
        .iter()
        .map(|c| ((c.contact.point.xy() - to).norm(), *c))
        .reduce(|a, b| if b.0 < a.0 { b } else { a })
        .map_or(Along::Nothing, |(_, c)| {
            // From the nearest crossing on along the border, at the height the fit gives.
            let slide = along * (to - c.contact.point.xy()).dot(&along);
            let z = at.z + p[0] + t * (p[1] + t * (p[2] + t * p[3]));
            let d = Vector::new(slide.x, slide.y, z - c.contact.point.z);
            Along::Level(OnBorder {
                center: c.contact.center + d,
                contact: c.contact.point + d,
                doubt: scale * (variance * inverse[(1, 1)]).sqrt() / (2.0 * bend.abs()),
            })
        })
}

/// A corner of the outline: balls that roll round it touch the corner itself.
fn corner(grid: &ToolCentreGrid, node: usize, sign: f64, plain: (Point, Point)) -> (Point, Point) {
    let (mut center, mut contact) = plain;
    for dy in -4..=4 {
        for dx in -4..=4 {
            if let Some(j) = grid.neighbour(node, (dx, dy))
                && grid.kind[j] == NodeKind::Rim
                && sign * grid.point[j].z < sign * contact.z
            {
                (center, contact) = (grid.center(j), grid.point[j]);
            }
        }
    }
    (center, contact)
}
