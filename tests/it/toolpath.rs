//! Laws of passes, links and programs: no ball enters the part wherever the text sends it, and every line says what was meant.
#![allow(clippy::unwrap_used)]

use super::common::{Brute, along};
use super::plans::{self, ALLOWANCE, Planned, R, motions};
use morsemill::geom::{Plane, Point, Vector};
use morsemill::part::Mesh;
use morsemill::post::{BUILT_IN, Post, Units, write};
use morsemill::reach::{Contact, DropCutter, NodeKind};
use morsemill::toolpath::{ArcOptions, MoveKind, PassKind, arcs};
use morsemill::verify::verify;
use rayon::prelude::*;

/// Distance between two looks along a move, mm.
const GAP: f64 = 0.05;
/// Deepest a ball may enter the part, mm.
const LIMIT: f64 = 0.003;

#[test]
fn no_ball_enters_the_part_anywhere_along_the_program() {
    for p in plans::all() {
        let p = p.get().unwrap();
        let brute = Brute::new(&p.mesh);
        let up = Vector::new(0.0, 0.0, R);
        let moves = motions(&p.posted.text);
        let worst = moves
            .par_iter()
            .map(|(_, from, to, line)| {
                along(&(from + up), &(to + up), GAP)
                    .map(|c| (brute.depth(&c, R), *line))
                    .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
            })
            .reduce(
                || (0.0, 0),
                |a, b| if (b.0, a.1) > (a.0, b.1) { b } else { a },
            );
        let ends = moves
            .par_iter()
            .map(|m| brute.depth(&(m.2 + up), R))
            .reduce(|| 0.0, f64::max);
        eprintln!(
            "{}: {} moves, {:.2} um deep at ends, {:.2} um between (line {})",
            p.part.file,
            moves.len(),
            1e3 * ends,
            1e3 * worst.0,
            worst.1
        );
        assert!(
            worst.0 <= LIMIT,
            "{}: {} um at line {}",
            p.part.file,
            1e3 * worst.0,
            worst.1
        );
        // The verdict must not be kinder than brute force, nor much harsher.
        let told = 1e-3 * p.verdict.finish.as_ref().unwrap().gouge_um_max;
        assert!(
            (told - worst.0).abs() < 3e-4,
            "{}: verdict {told}, brute force {}",
            p.part.file,
            worst.0
        );
    }
}

fn normal(c: &Contact) -> Vector {
    (c.center - c.point).normalize()
}

/// Signed distance of a centre from the tool-centre surface, along the contact normal: positive leaves stock.
fn off(cutter: &DropCutter, c: &Point) -> Option<f64> {
    let rest = cutter.drop(c.x, c.y)?;
    Some(normal(&rest).dot(&(c - rest.center)))
}

#[test]
fn every_pass_point_is_a_resting_ball_and_every_chord_keeps_its_signed_tolerance() {
    let mut wrong = Vec::new();
    for p in plans::all() {
        let p = p.get().unwrap();
        let cutter = &p.ground.cutter;
        let fit = p.plan.fitting;
        let (lowest, highest) = p
            .plan
            .passes
            .par_iter()
            // Passes at constant height rest against a wall, not on the ground.
            .filter(|pass| pass.kind != PassKind::Wall)
            .map(|pass| {
                let run = pass.run();
                for (k, c) in run.iter().enumerate() {
                    let rest = cutter.drop(c.x, c.y).unwrap();
                    let lift = c.z - rest.center.z;
                    // At a cliff the ball first goes up on the spot; everywhere else it rests.
                    let cliff = k > 0
                        && k + 1 < run.len()
                        && run[k - 1..k + 2]
                            .windows(2)
                            .any(|w| (w[0] - w[1]).xy().norm() < 0.005);
                    // Elsewhere it rests, but for the lift that lets chords use both budgets, and the last decimal.
                    let n = normal(&rest).dot(&(c - rest.center));
                    assert!(
                        (-fit.gouge - 2e-5..=fit.stock + 2e-5).contains(&n)
                            || (lift > 0.0 && cliff),
                        "{}: a {:?} pass floats {lift} mm over {}",
                        p.part.file,
                        pass.kind,
                        c
                    );
                }
                let mut range = (0.0f64, 0.0f64);
                for w in run.windows(2) {
                    for c in along(&w[0], &w[1], GAP) {
                        if let Some(d) = off(cutter, &c) {
                            range = (range.0.min(d), range.1.max(d));
                        }
                    }
                }
                range
            })
            .reduce(|| (0.0, 0.0), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        eprintln!(
            "{}: chords {:.2} to {:+.2} um, tolerances -{:.2} and +{:.2}",
            p.part.file,
            1e3 * lowest,
            1e3 * highest,
            1e3 * fit.gouge,
            1e3 * fit.stock
        );
        // Both sides are proven along the whole chord; only a segment too short to be split may miss.
        if lowest < -1.02 * fit.gouge || highest > 1.1 * fit.stock {
            wrong.push(format!("{}: {lowest} to {highest}", p.part.file));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn level_passes_close_or_end_on_a_border_or_a_rim() {
    for p in plans::all() {
        let p = p.get().unwrap();
        let g = &p.ground.grid;
        let mut wrong = Vec::new();
        for pass in p
            .plan
            .passes
            .iter()
            // In a chain a loop ends where it began.
            .filter(|q| {
                q.kind == PassKind::Level && !q.closed && q.points.first() != q.points.last()
            })
        {
            let own = pass.feature.unwrap();
            let feature = &p.plan.regions.features[own];
            let free = &feature.free;
            for end in [pass.points[0], pass.points[pass.points.len() - 1]] {
                let n = g.nearest(end.x, end.y).unwrap();
                // A pass left for an errand goes on where it was left; a spiral begins beside its seed and ends on itself.
                let goes_on = p
                    .plan
                    .passes
                    .iter()
                    .filter(|q| q.kind == PassKind::Level)
                    .any(|q| {
                        // Its own end is no reason.
                        let own = std::ptr::eq(q, pass);
                        let skip = if own { 4 } else { 0 };
                        let n = q.points.len().saturating_sub(1);
                        (skip..n.saturating_sub(skip)).any(|i| {
                            let (a, b) = (q.points[i], q.points[i + 1]);
                            let (e, d) = (b - a, end - a);
                            let t = (d.dot(&e) / e.norm_squared().max(1e-12)).clamp(0.0, 1.0);
                            (d - e * t).norm() < 0.03
                        })
                    });
                if goes_on || feature.field.at(g, n) <= 1.0 {
                    continue;
                }
                // Near the end: ground that ends, or ground that an earlier feature holds, whose rim's own pass cuts half a step of this.
                let reason = (-4..=4).any(|dy| {
                    (-4..=4).any(|dx| {
                        g.neighbour(n, (dx, dy)).is_none_or(|j| {
                            g.kind[j] != NodeKind::Ground
                                || free.at(g, j) < 0.0
                                || !free.at(g, j).is_finite()
                                || usize::from(p.plan.regions.label[j]) != own + 1
                        })
                    })
                });
                if !reason {
                    wrong.push(format!("feature {} at {end}", own + 1));
                }
            }
        }
        assert!(wrong.is_empty(), "{}: {wrong:?}", p.part.file);
        for q in &p.plan.passes {
            // A fill may be a single dab at a peak.
            assert!(
                q.points.len() > 1 || q.kind == PassKind::Fill,
                "{:?}",
                q.kind
            );
        }
    }
}

/// The moves before posting, as centres of the ball: kind, from, to.
fn centres(p: &Planned) -> Vec<(MoveKind, Point, Point)> {
    let up = Vector::new(0.0, 0.0, R);
    p.plan
        .toolpath
        .moves
        .windows(2)
        .map(|w| (w[1].kind, w[0].to + up, w[1].to + up))
        .collect()
}

#[test]
fn links_stay_down_without_gouge_and_hops_clear_the_stock() {
    for p in plans::all() {
        let p = p.get().unwrap();
        let brute = Brute::new(&p.mesh);
        let moves = centres(p);
        let worst = |want: fn(MoveKind) -> bool, radius: f64| {
            moves
                .par_iter()
                .filter(|m| want(m.0))
                .map(|m| {
                    along(&m.1, &m.2, GAP)
                        .map(|c| brute.depth(&c, radius))
                        .fold(0.0, f64::max)
                })
                .reduce(|| 0.0, f64::max)
        };
        let down = worst(|k| k == MoveKind::Link, R);
        assert!(
            down <= 1.25 * p.plan.fitting.gouge,
            "{}: links {} um deep",
            p.part.file,
            1e3 * down
        );
        // In the air: a ball as thick as tool and stock together touches nothing, on the way up, across, and down to the plunge.
        let air = worst(
            |k| matches!(k, MoveKind::Rapid | MoveKind::Retract),
            R + ALLOWANCE,
        );
        assert!(
            air <= 1e-6,
            "{}: hops enter the stock by {} um",
            p.part.file,
            1e3 * air
        );
        // And there is air below it: half a millimetre straight down, less what lies between two probes of a hop.
        let below = Vector::new(0.0, 0.0, 0.45);
        let low = moves
            .par_iter()
            .filter(|m| m.0 == MoveKind::Rapid)
            .flat_map_iter(|m| {
                let (from, to) = (m.1 - below, m.2 - below);
                along(&from, &to, GAP).skip(1)
            })
            .map(|c| brute.depth(&c, R + ALLOWANCE))
            .reduce(|| 0.0, f64::max);
        assert!(
            low < 1e-6,
            "{}: rapids are {low} mm too near the stock",
            p.part.file
        );
        let links = moves.iter().filter(|m| m.0 == MoveKind::Link).count();
        let plunges = moves.iter().filter(|m| m.0 == MoveKind::Plunge).count();
        assert!(links > 0 && plunges > 0);
        assert!(
            p.verdict
                .problems
                .iter()
                .all(|q| q.kind != morsemill::simulate::Kind::Collision)
        );
    }
}

#[test]
fn every_emitted_line_reads_back_as_the_same_motion_on_every_post() {
    let mut posts: Vec<Post> = Vec::new();
    for (name, _) in BUILT_IN {
        let post = Post::load(name).unwrap();
        if post.unit_word(Units::Inch).is_some() {
            posts.push(Post {
                units: Units::Inch,
                ..post.clone()
            });
        }
        posts.push(post);
    }
    assert!(posts.len() > 2 * BUILT_IN.len() - 5);
    for p in plans::all() {
        let p = p.get().unwrap();
        let straight = &p.plan.toolpath;
        let how = ArcOptions::new(p.plan.fitting, plans::machine().arc_tolerance.0);
        let bent = arcs(straight, &p.ground.cutter, &how);
        for post in &posts {
            let path = match post.arcs.has(Plane::Xy) {
                true => &bent,
                false => straight,
            };
            // A dialect with few decimals, of lengths or of angles, may not have one of the arcs: then it is lines, as `mill` does.
            let (path, posted) = match write(path, &p.job, post) {
                Err(e) if e.refusal.is_of_arcs() => {
                    (straight, write(straight, &p.job, post).unwrap())
                }
                posted => (path, posted.unwrap()),
            };
            let d = verify(&posted, path, &p.job, post).unwrap_or_else(|e| {
                panic!("{} by {} {:?}: {e}", p.part.file, post.name, post.units)
            });
            assert!(d.moves >= path.moves.len());
            // Half a unit of the last decimal an axis; a whole one where a helix ends by its angle.
            let units = if post.name == "heidenhain" { 2.0 } else { 1.0 };
            assert!(d.position.0 <= units * post.rounding().0 * 3f64.sqrt() + 1e-12);
        }
    }
}

/// A part and a path that gouges between exact ends: what judges the others must itself see it.
#[test]
fn brute_force_sees_a_gouge_between_two_exact_ends() {
    let mesh: Mesh = super::common::sheet([0.0, 0.0], [20.0, 10.0], [40, 20], |x, _| {
        -((x - 10.0) / 10.0).powi(2)
    });
    let cutter = DropCutter::new(&mesh, R);
    let brute = Brute::new(&mesh);
    let (a, b) = (
        cutter.drop(8.0, 5.0).unwrap().center,
        cutter.drop(12.0, 5.0).unwrap().center,
    );
    assert!(brute.depth(&a, R) < 1e-9 && brute.depth(&b, R) < 1e-9);
    let deepest = along(&a, &b, GAP)
        .map(|c| brute.depth(&c, R))
        .fold(0.0, f64::max);
    assert!((0.03..0.07).contains(&deepest), "{deepest}");
}
