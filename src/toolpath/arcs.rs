//! Arcs: runs of segments that a circular arc in the XY plane (with Z even along it) says in one line.
//!
//! ```text
//!  a --.--.--.-- b      ends stay; the circle through both that comes nearest to the points between them,
//!   \     c     /       its centre on the program's last decimal; then the arc itself is proven against the part
//! ```
//!
//! A controller cuts an arc as chords inside it, so up to a sagitta more on the side of the centre belongs to its error: over sloping
//! ground that is most of the budget, which is why few arcs survive there.
//!
//! Crosses the border: a toolpath of tool tips (work coordinates, mm) and the ball it was made for in; the same path with arcs out.
//! Knows nothing of dialects but a chord tolerance.

use super::curve::Curve;
use super::fit::FitOptions;
use super::fit::prove::examine;
use super::moves::{Move, MoveKind, Section, Toolpath, Turn};
use crate::geom::{Point, Point2, Vector, Vector2};
use crate::reach::{DropCutter, Hint};
use rayon::prelude::*;

/// Which arcs are worth having, and how true they must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcOptions {
    /// Budgets of the proof, and the last decimal that centres are placed on.
    pub fit: FitOptions,
    /// The controller cuts chords that stay within so much of an arc, mm (GRBL's `$12`); zero for one that does not.
    pub chord_tolerance: f64,
    /// Fewest segments that an arc replaces.
    pub fewest: usize,
    /// Smallest and largest radius, mm: below it is a corner, beyond it a line.
    pub radius: [f64; 2],
    /// Largest turn of one arc, rad; below half a turn.
    pub sweep: f64,
}

impl ArcOptions {
    /// What suits a finish fitted with `fit`, on a controller with this chord tolerance (mm).
    pub fn new(fit: FitOptions, chord_tolerance: f64) -> ArcOptions {
        ArcOptions {
            fit,
            chord_tolerance,
            fewest: 3,
            radius: [0.2, 2000.0],
            sweep: 2.5,
        }
    }
}

/// Radii of start and end may differ by this, mm, once the centre is on the last decimal.
const RADII_DIFFER: f64 = 0.0008;
/// Segments one arc may replace at most: a limit for the work.
const MOST: usize = 400;

/// Replaces runs of cuts and links by arcs where each arc is proven to keep the budgets. Sections keep their names and places.
pub fn arcs(toolpath: &Toolpath, cutter: &DropCutter, options: &ArcOptions) -> Toolpath {
    let moves = &toolpath.moves;
    // Stretches of straight moves of one kind and feed within one section: an arc never crosses their ends.
    let mut stretches: Vec<(usize, usize)> = Vec::new();
    let starts = |i: usize| {
        toolpath
            .sections
            .binary_search_by_key(&i, |s| s.first_move)
            .is_ok()
    };
    let curved = |m: &Move| m.turn.is_none() && matches!(m.kind, MoveKind::Cut | MoveKind::Link);
    let mut i = 1;
    while i < moves.len() {
        let first = i;
        i += 1;
        if !curved(&moves[first]) {
            continue;
        }
        while i < moves.len()
            && curved(&moves[i])
            && moves[i].kind == moves[first].kind
            && moves[i].feed == moves[first].feed
            && !starts(i)
        {
            i += 1;
        }
        if i - first >= options.fewest.max(2) {
            stretches.push((first, i));
        }
    }
    let found: Vec<Vec<Found>> = stretches
        .par_iter()
        .map(|&(first, end)| in_stretch(moves, first, end, cutter, options))
        .collect();

    let mut out = Toolpath {
        moves: Vec::with_capacity(moves.len()),
        sections: Vec::with_capacity(toolpath.sections.len()),
        safe_z: toolpath.safe_z,
    };
    let mut sections = toolpath.sections.iter().peekable();
    let mut found = found.into_iter().flatten().peekable();
    let mut i = 0;
    while i < moves.len() {
        while let Some(s) = sections.next_if(|s| s.first_move <= i) {
            out.sections.push(Section {
                name: s.name.clone(),
                first_move: out.moves.len(),
            });
        }
        match found.next_if(|f| f.first == i) {
            None => {
                out.moves.push(moves[i]);
                i += 1;
            }
            Some(f) => {
                out.moves.push(Move {
                    kind: moves[i].kind,
                    to: moves[f.last].to,
                    turn: Some(f.turn),
                    feed: moves[i].feed,
                });
                i = f.last + 1;
            }
        }
    }
    out.sections.extend(sections.map(|s| Section {
        name: s.name.clone(),
        first_move: out.moves.len(),
    }));
    out
}

/// An arc in the place of the moves `first` to `last`.
struct Found {
    first: usize,
    last: usize,
    turn: Turn,
}

fn in_stretch(
    moves: &[Move],
    first: usize,
    end: usize,
    cutter: &DropCutter,
    options: &ArcOptions,
) -> Vec<Found> {
    let mut hint = Hint::default();
    let mut out = Vec::new();
    let with_stock = moves[first].kind == MoveKind::Cut;
    let up = Vector::new(0.0, 0.0, cutter.radius());
    let fewest = options.fewest.max(2);
    let mut i = first;
    while i + fewest <= end {
        // The points from the start of move i to the end of move j.
        let points = |j: usize| -> Vec<Point> { moves[i - 1..=j].iter().map(|m| m.to).collect() };
        let limit = end.min(i + MOST);
        let mut j = i + fewest - 1;
        let mut best = circle(&points(j), options);
        // Gallop while the points allow it, then ask the part.
        let mut stride = 1;
        while best.is_some() && j + stride < limit {
            match circle(&points(j + stride), options) {
                Some(t) => {
                    (best, j) = (Some(t), j + stride);
                    stride *= 2;
                }
                None if stride == 1 => break,
                None => stride = 1,
            }
        }
        let mut taken = None;
        while let Some(turn) = best {
            let curve = Curve::arc(
                moves[i - 1].to + up,
                moves[j].to + up,
                &turn,
                options.chord_tolerance,
            );
            let p = examine(cutter, &curve, &options.fit, with_stock, false, &mut hint);
            if p.worst.is_none() && p.gouge_kept && p.stock_kept {
                taken = Some(turn);
                break;
            }
            let shorter = (j - i + 1) * 2 / 3;
            if shorter < fewest {
                break;
            }
            j = i + shorter - 1;
            best = circle(&points(j), options);
        }
        match taken {
            Some(turn) => {
                out.push(Found {
                    first: i,
                    last: j,
                    turn,
                });
                i = j + 1;
            }
            None => i += 1,
        }
    }
    out
}

/// The arc from the first to the last of some points that comes near all of them, or `None`.
fn circle(points: &[Point], options: &ArcOptions) -> Option<Turn> {
    let (a, b) = (points.first()?, points.last()?);
    let chord = b.xy() - a.xy();
    let c = chord.norm();
    if c < 4.0 * options.fit.decimal.max(1e-4) {
        return None;
    }
    let along = chord / c;
    let left = Vector2::new(-along.y, along.x);
    // Points as (x, y) over the chord; a circle through its ends with signed curvature k is near y = -k x (c - x) / 2.
    let flat: Vec<(f64, f64)> = points[1..points.len() - 1]
        .iter()
        .map(|p| {
            let d = p.xy() - a.xy();
            (d.dot(&along), d.dot(&left))
        })
        .collect();
    let mut x = 0.0;
    for f in &flat {
        if f.0 <= x || f.0 >= c {
            return None;
        }
        x = f.0;
    }
    // By least squares for the height of the arc's middle, bettered by what is left over.
    let weight = |x: f64| x * (c - x) / (c * c / 4.0);
    let norm: f64 = flat.iter().map(|f| weight(f.0).powi(2)).sum();
    let mut sagitta = flat.iter().map(|f| f.1 * weight(f.0)).sum::<f64>() / norm;
    let most = 0.5 * c * (0.25 * options.sweep).tan();
    for _ in 0..3 {
        if !(sagitta.abs() > 1e-9 && sagitta.abs() < most) {
            return None;
        }
        let (r, h) = of_sagitta(sagitta, c);
        let miss = |f: &(f64, f64)| {
            let u = f.0 - 0.5 * c;
            let y = h + sagitta.signum() * (r * r - u * u).max(0.0).sqrt();
            f.1 - y
        };
        sagitta += flat.iter().map(|f| miss(f) * weight(f.0)).sum::<f64>() / norm;
    }
    let (r, h) = of_sagitta(sagitta, c);
    if !(r >= options.radius[0] && r <= options.radius[1]) {
        return None;
    }
    let ideal = a.xy() + along * (0.5 * c) + left * h;
    let center = on_decimals(&ideal, &a.xy(), &b.xy(), options.fit.decimal)?;
    let turn = Turn {
        center,
        // A path that bulges to the left of its chord turns to the right.
        clockwise: sagitta > 0.0,
    };
    near_all(points, &turn, options).then_some(turn)
}

/// Radius, and height of the centre over the chord (to its left), of the arc over a chord `c` whose middle stands `s` to the left.
fn of_sagitta(s: f64, c: f64) -> (f64, f64) {
    let r = (0.25 * c * c + s * s) / (2.0 * s.abs());
    (r, s - s.signum() * r)
}

/// The place on the last decimal near `ideal` from which both ends are equally far, or `None` where they differ too much.
fn on_decimals(ideal: &Point2, a: &Point2, b: &Point2, decimal: f64) -> Option<Point2> {
    if decimal <= 0.0 {
        return Some(*ideal);
    }
    let base = Point2::new((ideal.x / decimal).round(), (ideal.y / decimal).round());
    let mut best: Option<(f64, Point2)> = None;
    for v in -2..=2 {
        for u in -2..=2 {
            let q = Point2::new(
                (base.x + f64::from(u)) * decimal,
                (base.y + f64::from(v)) * decimal,
            );
            let differ = ((q - a).norm() - (q - b).norm()).abs();
            // Of two as good ones the nearer to where it should be.
            let cost = differ + 0.05 * (q - ideal).norm();
            if differ <= RADII_DIFFER && best.is_none_or(|(c, _)| cost < c) {
                best = Some((cost, q));
            }
        }
    }
    best.map(|b| b.1)
}

/// True when every point lies on the helix within the tolerances, as far as can be told without the part.
fn near_all(points: &[Point], turn: &Turn, options: &ArcOptions) -> bool {
    let (Some(a), Some(b)) = (points.first(), points.last()) else {
        return false;
    };
    let sweep = turn.sweep(a, b);
    if sweep.abs() > options.sweep {
        return false;
    }
    let radius = (a.xy() - turn.center).norm();
    let rise = b.z - a.z;
    let slope = rise / (sweep.abs() * radius).max(1e-12);
    let f = &options.fit;
    points[1..points.len() - 1].iter().all(|p| {
        let share = turn.sweep(a, p) / sweep;
        let aside = (p.xy() - turn.center).norm() - radius;
        // Upwards from the helix, but square to it.
        let off = (p.z - (a.z + rise * share)) / slope.hypot(1.0);
        // On a slope of any angle a miss sideways can become one along the normal, and be within its budgets all the same.
        (0.0..=1.0).contains(&share)
            && aside.hypot(off) <= f.sideways
            && off.abs() <= f.sideways.min(2.0 * (f.gouge + f.stock))
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use crate::toolpath::fit::{fit, proof};
    use proptest::prelude::*;

    const R: f64 = 3.0;

    /// A gentle dome of radius 200 mm, 24 mm across.
    fn dome() -> Mesh {
        let at = |i: usize, j: usize| {
            let (x, y) = (0.1 * i as f64 - 12.0, 0.1 * j as f64 - 12.0);
            Point::new(x, y, (4e4 - x * x - y * y).sqrt() - 200.0)
        };
        let mut triangles = Vec::new();
        for i in 0..240 {
            for j in 0..240 {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                triangles.push([a, b, c]);
                triangles.push([a, c, d]);
            }
        }
        Mesh { triangles }
    }

    /// A spiral over the dome, as a toolpath of tips.
    fn spiral(cutter: &DropCutter, turns: f64) -> (Toolpath, FitOptions) {
        let o = FitOptions::for_scallop(0.02, R);
        let n = (turns * 200.0) as usize;
        let curve: Vec<Point2> = (0..=n)
            .map(|i| {
                let t = std::f64::consts::TAU * i as f64 / 200.0;
                let r = 2.0 + 0.7 * i as f64 / 200.0;
                Point2::new(r * t.cos(), r * t.sin())
            })
            .collect();
        let run = fit(cutter, &curve, &o).concat();
        let down = Vector::new(0.0, 0.0, -R);
        let mut moves = vec![
            Move::straight(MoveKind::Rapid, Point::new(run[0].x, run[0].y, 5.0)),
            Move::straight(MoveKind::Plunge, run[0] + down),
        ];
        moves.extend(
            run[1..]
                .iter()
                .map(|p| Move::straight(MoveKind::Cut, p + down)),
        );
        let path = Toolpath {
            sections: vec![
                Section {
                    name: "one".into(),
                    first_move: 0,
                },
                Section {
                    name: "two".into(),
                    first_move: moves.len() / 2,
                },
                Section {
                    name: "never".into(),
                    first_move: moves.len() + 7,
                },
            ],
            moves,
            safe_z: 5.0,
        };
        (path, o)
    }

    #[test]
    fn a_spiral_over_a_gentle_dome_becomes_arcs_that_are_proven() {
        let cutter = DropCutter::new(&dome(), R);
        let (path, o) = spiral(&cutter, 8.0);
        let how = ArcOptions::new(o, 0.002);
        let short = arcs(&path, &cutter, &how);
        assert!(
            short.moves.len() * 2 < path.moves.len(),
            "{} of {}",
            short.moves.len(),
            path.moves.len()
        );
        let before = proof(&cutter, &path, 0.002, &o);
        let after = proof(&cutter, &short, 0.002, &o);
        assert_eq!((after.over_gouge, after.over_stock), (0, 0), "{after:?}");
        assert!((before.length_mm - after.length_mm).abs() < 1e-3 * before.length_mm);
        assert!(after.arcs * 2 > after.segments, "{after:?}");
        // The second section begins where it began: no arc runs across.
        let (a, b) = (&path.sections[1], &short.sections[1]);
        assert_eq!(a.name, b.name);
        assert_eq!(
            path.moves[a.first_move - 1].to,
            short.moves[b.first_move - 1].to
        );
        assert_eq!(short.sections.len(), 3);
        assert_eq!(
            path.moves.last().unwrap().to,
            short.moves.last().unwrap().to
        );
        for w in short.moves.windows(2) {
            let Some(t) = w[1].turn else { continue };
            // What a controller checks, with room.
            let (rs, re) = (
                (w[0].to.xy() - t.center).norm(),
                (w[1].to.xy() - t.center).norm(),
            );
            assert!((rs - re).abs() <= RADII_DIFFER);
            for c in t.center.iter() {
                assert!((c * 1e3 - (c * 1e3).round()).abs() < 1e-6);
            }
        }
        // The same again is the same; arcs are left alone.
        assert_eq!(arcs(&path, &cutter, &how), short);
        assert!(arcs(&short, &cutter, &how).moves.len() <= short.moves.len());
    }

    #[test]
    fn a_coarse_controller_gets_fewer_arcs_on_a_slope() {
        // Chords of 0.05 mm cut into the flank: nothing is left but lines.
        let cutter = DropCutter::new(&dome(), R);
        let (path, o) = spiral(&cutter, 8.0);
        let coarse = arcs(&path, &cutter, &ArcOptions::new(o, 0.2));
        let fine = arcs(&path, &cutter, &ArcOptions::new(o, 0.002));
        assert!(coarse.moves.len() > fine.moves.len());
        assert_eq!(proof(&cutter, &coarse, 0.2, &o).over_gouge, 0);
    }

    #[test]
    fn straight_paths_and_other_kinds_stay_as_they_are() {
        let cutter = DropCutter::new(&dome(), R);
        let o = FitOptions::for_scallop(0.02, R);
        let mut path = Toolpath::default();
        for i in 0..20 {
            path.moves.push(Move::straight(
                MoveKind::Rapid,
                Point::new(f64::from(i), 0.0, 9.0),
            ));
        }
        for i in 0..20 {
            path.moves.push(Move::straight(
                MoveKind::Cut,
                Point::new(f64::from(i), 0.0, 9.0),
            ));
        }
        assert_eq!(arcs(&path, &cutter, &ArcOptions::new(o, 0.002)), path);
        let empty = Toolpath::default();
        assert_eq!(arcs(&empty, &cutter, &ArcOptions::new(o, 0.002)), empty);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
        /// Points on a helix give that helix back, whichever way round.
        #[test]
        fn a_helix_is_found_again(
            x in -20.0..20.0f64, y in -20.0..20.0f64, r in 1.0..40.0f64, start in 0.0..6.0f64,
            sweep in 0.1..2.2f64, rise in -0.5..0.5f64, n in 4usize..20, back: bool,
        ) {
            let o = FitOptions::for_scallop(0.02, R);
            let sweep = if back { -sweep } else { sweep };
            let points: Vec<Point> = (0..=n)
                .map(|i| {
                    let s = i as f64 / n as f64;
                    let t = start + sweep * s;
                    let snap = |v: f64| (v * 1e3).round() * 1e-3;
                    Point::new(snap(x + r * t.cos()), snap(y + r * t.sin()), snap(rise * s))
                })
                .collect();
            let turn = circle(&points, &ArcOptions::new(o, 0.002)).unwrap();
            prop_assert_eq!(turn.clockwise, back);
            prop_assert!((turn.sweep(&points[0], &points[n]) - sweep).abs() < 0.2 * sweep.abs());
            let c = Curve::arc(points[0], points[n], &turn, 0.0);
            for (i, p) in points.iter().enumerate() {
                let q = c.at(c.length() * i as f64 / n as f64);
                prop_assert!((p - q).norm() < 0.004, "{} at {}", (p - q).norm(), i);
            }
        }
    }
}
