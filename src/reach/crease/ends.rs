//! What the edges of the grid do not meet of a crease: its corners and its ends.

use super::{Crease, CreasePoint, between};
use crate::geom::{Vector, Vector2};
use crate::reach::drop::DropCutter;

/// Turns sharper than this between two places are corners, radians.
const CORNER: f64 = 0.25;
/// Places looked back over for the way a chain runs.
const BASE: usize = 4;

/// Puts in what the edges of the grid do not meet: corners, where the ball touches in three places, and the ends.
pub(super) fn complete(cutter: &DropCutter, c: &mut Crease, step: f64, angle: f64) {
    let n = c.points.len();
    if n < 3 {
        return;
    }
    let at = |k: isize| -> Option<&CreasePoint> {
        if c.closed {
            c.points.get(k.rem_euclid(n as isize) as usize)
        } else {
            usize::try_from(k).ok().and_then(|k| c.points.get(k))
        }
    };
    // The way the chain runs into place k, looking back (`sign` -1) or from its other side (+1).
    let way = |k: isize, sign: isize| -> Option<Vector2> {
        let here = at(k)?.center.xy();
        let mut d = None;
        for b in 1..=BASE as isize {
            let Some(p) = at(k + sign * b) else { break };
            let v = here - p.center.xy();
            let l = v.norm();
            // As far back as it runs straight.
            match d {
                Some(u) if l > 0.0 && (v / l).dot(&u) < (0.5 * CORNER).cos() => break,
                _ if l > 0.0 => d = Some(v / l),
                _ => {}
            }
        }
        d
    };
    let reach = 2.0 * step;
    // With each place, whether it was put in.
    let mut out: Vec<(CreasePoint, bool)> = Vec::with_capacity(n + 8);
    if !c.closed
        && let (Some(p), Some(d)) = (at(0), way(0, 1))
    {
        out.extend(led_on(cutter, p, &d, reach, step, angle).map(|p| (p, true)));
    }
    for k in 0..n as isize {
        let Some(p) = at(k) else { break };
        out.push((*p, false));
        let (Some(q), Some(u), Some(v)) = (at(k + 1), way(k, -1), way(k + 1, 1)) else {
            continue;
        };
        let gap = (q.center.xy() - p.center.xy()).norm();
        if -u.dot(&v) > CORNER.cos() || gap > reach {
            continue;
        }
        // Not past the other place: there the chain still runs straight, and its corner comes behind that.
        let first =
            led_on(cutter, p, &u, reach, step, angle).filter(|c| !on_the_way(p, q, c, 0.1 * step));
        let second =
            led_on(cutter, q, &v, reach, step, angle).filter(|c| !on_the_way(q, p, c, 0.1 * step));
        out.extend(first.map(|p| (p, true)));
        if let Some(s) = second
            && first.is_none_or(|f| (f.center.xy() - s.center.xy()).norm() > 2e-3)
        {
            out.push((s, true));
        }
    }
    if !c.closed
        && let (Some(p), Some(d)) = (at(n as isize - 1), way(n as isize - 1, -1))
    {
        out.extend(led_on(cutter, p, &d, reach, step, angle).map(|p| (p, true)));
    }
    // A place of the grid right beside a corner only makes the path stutter.
    let n = out.len();
    let near = |k: usize, l: usize| {
        out[l].1 && (out[l].0.center.xy() - out[k].0.center.xy()).norm() < 0.3 * step
    };
    c.points = (0..n)
        .filter(|&k| {
            let beside = [k.checked_sub(1), (k + 1 < n).then_some(k + 1)];
            out[k].1 || !beside.into_iter().flatten().any(|l| near(k, l))
        })
        .map(|k| out[k].0)
        .collect();
}

/// Does place `by` lie between two others, no further than `aside` (mm) beside the straight between them?
fn on_the_way(from: &CreasePoint, by: &CreasePoint, to: &CreasePoint, aside: f64) -> bool {
    let way = to.center.xy() - from.center.xy();
    let d = by.center.xy() - from.center.xy();
    let l = way.norm();
    let along = d.dot(&way) / l.max(1e-300);
    along > 0.0 && along < l && (d.norm_squared() - along * along).max(0.0).sqrt() < aside
}

/// The last place on the way on from `p` along `d` at which the ball still touches the same two walls; `None` when it does not even
/// a little way on.
fn led_on(
    cutter: &DropCutter,
    p: &CreasePoint,
    d: &Vector2,
    reach: f64,
    step: f64,
    angle: f64,
) -> Option<CreasePoint> {
    let across = Vector2::new(-d.y, d.x);
    let across = if across.dot(&p.out) < 0.0 {
        -across
    } else {
        across
    };
    let same = |t: f64| -> Option<CreasePoint> {
        let q = p.center.xy() + d * t;
        let w = across * (0.02 * step + 0.1 * t);
        let found = between(cutter, &(q + w), &(q - w), angle)?;
        let alike = |u: &Vector, v: &Vector| u.dot(v) > (0.4 * angle).cos();
        let [a, b] = found.normals;
        let [u, v] = p.normals;
        let cliffs = (found.rise > 0.0) == (p.rise > 0.0);
        (cliffs && (alike(&a, &u) && alike(&b, &v) || alike(&a, &v) && alike(&b, &u)))
            .then_some(found)
    };
    let mut best = None;
    let (mut lo, mut hi) = (0.0, reach);
    if let Some(f) = same(reach) {
        return Some(f);
    }
    while hi - lo > 1e-3 * step {
        let t = 0.5 * (lo + hi);
        match same(t) {
            Some(f) => {
                best = Some(f);
                lo = t;
            }
            None => hi = t,
        }
    }
    best
}
