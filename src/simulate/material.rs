//! The stock as it is cut, in program order: what the ball sweeps, and where a rapid meets what still stands.

use super::dry_run::{PartContext, Stock};
use super::report::ProgramFigures;
use super::start::Places;
use crate::gcode::{Event, MotionKind};
use crate::geom::{Point, Vector};
use crate::kinematics::chords;
use crate::sweep::{Encounter, Lattice, Reachable, Segment, Swept};
use crate::units::Mm;

/// Arcs become chords within this, mm.
const FLATTEN: f64 = 5e-4;

/// A straight piece of the way of the ball's centre, work coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    pub segment: Segment,
    pub rapid: bool,
    pub line: usize,
}

/// All moves whose place is known, and the way in figures. `events` begin at [`UNKNOWN`](super::start::UNKNOWN) on the axes whose
/// start the text does not tell: until all three axes have been told, only the ends of moves are known. The same holds after
/// moves in machine coordinates and after probing.
pub fn moves(events: &[Event], radius: f64) -> (Vec<Move>, ProgramFigures) {
    let up = Vector::new(0.0, 0.0, radius);
    let mut out = Vec::new();
    let mut f = ProgramFigures::default();
    let mut places = Places::default();
    // A feed motion came last, and no rapid has risen since.
    let mut in_work = false;
    for event in events {
        let Some((m, from_known, to_known)) = places.follow(event) else {
            continue;
        };
        if m.machine_coordinates {
            in_work = false;
            continue;
        }
        let rapid = m.kind == MotionKind::Rapid;
        let mut push = |from: Point, to: Point| {
            out.push(Move {
                segment: Segment {
                    from: from + up,
                    to: to + up,
                },
                rapid,
                line: m.line,
            });
            (to - from).norm()
        };
        let mut length = 0.0;
        if from_known.iter().all(|k| *k) {
            match &m.arc {
                Some(arc) => {
                    let mut from = m.from;
                    for to in chords(&m.from, &m.to, arc, Mm(FLATTEN)) {
                        length += push(from, to);
                        from = to;
                    }
                }
                None => length += push(m.from, m.to),
            }
        } else if to_known.iter().all(|k| *k) {
            push(m.to, m.to);
        }
        if rapid {
            f.rapid_mm += length;
            if in_work && m.to.z > m.from.z {
                f.retracts += 1;
                in_work = false;
            }
        } else {
            f.cut_mm += length;
            in_work = true;
        }
    }
    (out, f)
}

/// A rapid that met standing stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    pub line: usize,
    pub encounter: Encounter,
}

/// Height of the stock over each cell of a tile before the first move; `-inf` where there is none.
pub fn stock(part: &PartContext, r: &Reachable, stock: &Stock) -> Vec<f64> {
    let b = part.drop.bounds();
    let near = match *stock {
        Stock::Allowance(mm) => highest_near(&r.lattice, &r.reach_z, mm),
        Stock::Block { .. } => Vec::new(),
    };
    (0..r.lattice.len())
        .map(|i| match *stock {
            Stock::Allowance(mm) => {
                if r.part_z[i].is_nan() || !r.reach_z[i].is_finite() {
                    f64::NEG_INFINITY
                } else {
                    // Measured along the normal, so more on slopes; five times as much at most, and nowhere more than this much over
                    // what stands near: the ball's normal on the edge of a wall is not the stock's.
                    let slope = mm / f64::from(r.normal_z[i]).max(0.2);
                    (r.reach_z[i] + slope).min(near[i] + mm)
                }
            }
            Stock::Block { top_z } => {
                let c = r.lattice.center_at(i);
                let over = c.x >= b.min.x && c.x <= b.max.x && c.y >= b.min.y && c.y <= b.max.y;
                if over { top_z } else { f64::NEG_INFINITY }
            }
        })
        .collect()
}

/// The highest value within so many mm of each cell along X and Y; what is not finite counts as nothing.
fn highest_near(lattice: &Lattice, z: &[f64], mm: f64) -> Vec<f64> {
    let reach = (mm / lattice.step).ceil().max(0.0) as usize;
    let known = |v: f64| if v.is_finite() { v } else { f64::NEG_INFINITY };
    let (nx, ny) = (lattice.nx, lattice.ny);
    let most = |n: usize, at: &dyn Fn(usize) -> f64, out: &mut dyn FnMut(usize, f64)| {
        // Falling candidates of a sliding window, the highest in front.
        let mut queue: std::collections::VecDeque<(usize, f64)> = std::collections::VecDeque::new();
        for k in 0..n + reach {
            if k < n {
                let v = at(k);
                while queue.back().is_some_and(|b| b.1 <= v) {
                    queue.pop_back();
                }
                queue.push_back((k, v));
            }
            if k >= reach {
                let middle = k - reach;
                while queue.front().is_some_and(|f| f.0 + reach < middle) {
                    queue.pop_front();
                }
                out(middle, queue.front().map_or(f64::NEG_INFINITY, |f| f.1));
            }
        }
    };
    let mut rows = vec![f64::NEG_INFINITY; z.len()];
    for y in 0..ny {
        most(nx, &|x| known(z[y * nx + x]), &mut |x, v| {
            rows[y * nx + x] = v
        });
    }
    let mut out = vec![f64::NEG_INFINITY; z.len()];
    for x in 0..nx {
        most(ny, &|y| rows[y * nx + x], &mut |y, v| out[y * nx + x] = v);
    }
    out
}

/// Cuts the moves numbered in `which` in order over one tile: what is left, and the rapids that met stock, one for each line at
/// most, in program order. `tolerance`: a rapid may touch the stock this deep, mm.
pub fn cut(
    moves: &[Move],
    which: &[u32],
    lattice: Lattice,
    radius: f64,
    stock: &[f64],
    tolerance: f64,
) -> (Swept, Vec<Collision>) {
    let top = stock.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut swept = Swept::new(lattice);
    let mut collisions = Vec::new();
    let mut waiting: Vec<Segment> = Vec::with_capacity(which.len());
    for m in which.iter().filter_map(|&k| moves.get(k as usize)) {
        if !m.rapid {
            waiting.push(m.segment);
            continue;
        }
        if m.segment.from.z.min(m.segment.to.z) - radius >= top {
            continue;
        }
        swept.cut_alone(&waiting, radius);
        waiting.clear();
        if let Some(encounter) = swept.encounter(stock, m.segment, radius, tolerance) {
            collisions.push(Collision {
                line: m.line,
                encounter,
            });
        }
    }
    swept.cut_alone(&waiting, radius);
    (swept, collisions)
}

/// The deepest collision of each line, in program order; of equals the one nearest the lower left.
pub fn deepest_per_line(mut found: Vec<Collision>) -> Vec<Collision> {
    let key = |c: &Collision| (c.encounter.place.y, c.encounter.place.x);
    found.sort_by(|a, b| {
        let (p, q) = (key(a), key(b));
        a.line
            .cmp(&b.line)
            .then(b.encounter.depth.total_cmp(&a.encounter.depth))
            .then(p.0.total_cmp(&q.0))
            .then(p.1.total_cmp(&q.1))
    });
    found.dedup_by_key(|c| c.line);
    found
}
