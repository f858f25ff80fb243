//! What is left of the stock, against what was asked for.

use super::dry_run::{DryRunOptions, PartContext};
use super::moves::{MOST_HELD, Moves};
use super::report::{DryRun, Kind, Problem};
use super::{gouge, material};
use crate::sweep::tiles::area;
use crate::sweep::{CuspMap, FinishOptions, FinishStats, Judging, Paths};

/// Problems of one kind that are listed one by one.
const LISTED: usize = 20;

/// Cuts moves into the stock and looks at what is left.
pub(super) fn judge(
    moves: &Moves,
    part: &PartContext,
    options: &DryRunOptions,
    report: &mut DryRun,
) {
    judge_holding(MOST_HELD, moves, part, options, report);
}

/// Holds at most so many moves at once, where they are not in memory anyway and a single tile has no more.
fn judge_holding(
    most: usize,
    moves: &Moves,
    part: &PartContext,
    options: &DryRunOptions,
    report: &mut DryRun,
) {
    let radius = part.drop.radius();
    let tiles = part.reachable;
    let mut judging = Judging::new(tiles, &FinishOptions::for_scallop(options.scallop_mm));
    let room = judging.room();
    let mut collisions = Vec::new();
    let mut held = Vec::new();
    for group in moves.groups(tiles, room, most) {
        let moves = moves.near(tiles, room, &group, &mut held);
        let which = tiles.touched(moves.iter().map(|m| &m.segment));
        let feed = moves.iter().filter(|m| !m.rapid).map(|m| m.segment);
        let paths = Paths::new(feed, 0.25 * radius, area(tiles.lattice()));
        let found = judging.look(group, &paths, |k, reach| {
            let stock = material::stock(part, reach, &options.stock);
            let which = which.get(k).map_or(&[][..], Vec::as_slice);
            let limit = options.collision_limit_mm;
            material::cut(moves, which, reach.lattice, radius, &stock, limit)
        });
        collisions.extend(found.into_iter().flatten());
    }
    drop(held);
    let collisions = material::deepest_per_line(collisions);
    for c in collisions.iter().take(LISTED) {
        let p = c.encounter.place;
        report.problems.push(Problem {
            kind: Kind::Collision,
            line: Some(c.line),
            text: format!(
                "rapid move through {:.3} mm of standing stock at X{:.3} Y{:.3} Z{:.3}: retract higher before it, or feed",
                c.encounter.depth, p.x, p.y, p.z
            ),
        });
    }
    if collisions.len() > LISTED {
        report.problems.push(Problem {
            kind: Kind::Collision,
            line: None,
            text: format!("and {} more lines like these", collisions.len() - LISTED),
        });
    }

    let (map, mut stats): (CuspMap, FinishStats) = match judging.finish() {
        Ok(f) => (f.map, f.stats),
        Err(e) => {
            report.problems.push(Problem {
                kind: Kind::Nothing,
                line: None,
                text: e.to_string(),
            });
            return;
        }
    };
    let gouge = gouge::deepest(moves, part);
    let mut line = None;
    if let Some(g) = gouge
        && 1e3 * g.depth >= stats.gouge_um_max - 0.05
    {
        stats.gouge_um_max = 1e3 * g.depth;
        stats.gouge_at = Some([g.center.x, g.center.y, g.center.z - radius]);
        line = Some(g.line);
    }
    verdict(&stats, line, options, &mut report.problems);
    report.finish = Some(stats);
    report.map = Some(map);
}

fn verdict(
    s: &FinishStats,
    gouge_line: Option<usize>,
    options: &DryRunOptions,
    problems: &mut Vec<Problem>,
) {
    let h = 1e3 * options.scallop_mm;
    let place = |at: Option<[f64; 3]>| {
        at.map_or_else(String::new, |[x, y, z]| {
            format!(" at X{x:.3} Y{y:.3} Z{z:.3}")
        })
    };
    let mut add = |kind, line, text| problems.push(Problem { kind, line, text });
    if s.gouge_um_max > 1e3 * options.gouge_limit_mm {
        add(
            Kind::Gouge,
            gouge_line,
            format!(
                "the ball cuts {:.1} um into the part{} (limit {:.1} um)",
                s.gouge_um_max,
                place(s.gouge_at),
                1e3 * options.gouge_limit_mm
            ),
        );
    }
    let limit = h * (1.0 + 1e-6);
    if s.scallop_um.p99 > limit {
        add(
            Kind::Scallop,
            None,
            format!(
                "99 % of the area has cusps up to {:.2} um, asked for were {h:.2} um",
                s.scallop_um.p99
            ),
        );
    }
    if s.over_scallop_area_percent > options.over_area_limit_percent {
        add(
            Kind::Scallop,
            None,
            format!(
                "{:.2} % of the area lies above the cusp height of {h:.2} um (limit {} %)",
                s.over_scallop_area_percent, options.over_area_limit_percent
            ),
        );
    }
    if s.scallop_um.max > limit * options.max_cusp_factor {
        add(
            Kind::Scallop,
            None,
            format!(
                "a cusp of {:.1} um{} (limit {:.1} um)",
                s.scallop_um.max,
                place(s.max_at),
                h * options.max_cusp_factor
            ),
        );
    }
    if s.uncut_area_mm2 > options.uncut_limit_mm2 {
        add(
            Kind::Uncut,
            None,
            format!(
                "{:.2} mm2 of ground that this ball reaches are not cut, for one{}",
                s.uncut_area_mm2,
                place(s.uncut_at)
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::dry_run::{Stock, blank};
    use super::super::material::Move;
    use super::*;
    use crate::geom::Point;
    use crate::part::Mesh;
    use crate::reach::DropCutter;
    use crate::simulate::ProgramFigures;
    use crate::sweep::{ReachTiles, Segment};

    /// A ridged plate cut by passes with a gouge, a gap, and rapids through stock: judged at once, and by groups of tiles with few moves
    /// held, the report and the map are the same to the last bit.
    #[test]
    fn groups_of_tiles_find_what_all_tiles_find() {
        let height = |x: f64| 0.4 * (x * 0.9).sin();
        let mut triangles = vec![];
        for k in 0..24 {
            let (a, b) = (0.5 * f64::from(k), 0.5 * f64::from(k + 1));
            let p = |x: f64, y: f64| Point::new(x, y, height(x));
            triangles.push([p(a, 0.0), p(b, 0.0), p(b, 9.0)]);
            triangles.push([p(a, 0.0), p(b, 9.0), p(a, 9.0)]);
        }
        let mesh = Mesh { triangles };
        let radius = 1.0;
        let drop = DropCutter::new(&mesh, radius);
        let tiles = ReachTiles::new(&drop, 0.06, 1).with_side(64);
        assert!(tiles.len() > 8);
        let part = PartContext {
            mesh: &mesh,
            drop: &drop,
            reachable: &tiles,
        };
        let mut at = Point::new(-1.0, 0.0, 5.0);
        let mut moves: Vec<Move> = vec![];
        let mut go = |to: Point, rapid: bool| {
            let segment = Segment { from: at, to };
            let line = moves.len() + 1;
            moves.push(Move {
                segment,
                rapid,
                line,
            });
            at = to;
        };
        for row in 0..=22 {
            let y = 0.4 * f64::from(row);
            for k in 0..=60 {
                let x = 0.2 * f64::from(if row % 2 == 0 { k } else { 60 - k });
                let rest = drop.drop(x, y).map_or(radius, |c| c.center.z);
                let low = if (row, k) == (9, 30) { 0.05 } else { 0.0 };
                go(Point::new(x, y, rest - low), false);
            }
            if row == 12 {
                // Through what is not cut yet, and back.
                go(Point::new(6.0, 8.5, radius), true);
                go(Point::new(6.0, y, 3.0), true);
            }
        }
        let options = DryRunOptions::new(0.02, Stock::Allowance(0.5));
        let run = |most: usize, moves: &Moves| {
            let mut report = blank(ProgramFigures::default());
            judge_holding(most, moves, &part, &options, &mut report);
            report
        };
        let whole = run(MOST_HELD, &Moves::Held(&moves));
        let kinds: Vec<Kind> = whole.problems.iter().map(|p| p.kind).collect();
        assert!(kinds.contains(&Kind::Gouge) && kinds.contains(&Kind::Collision));
        let read = |hear: &mut dyn FnMut(&Move)| moves.iter().for_each(hear);
        let read = Moves::Read(&read);
        let room = 1.3;
        assert!(read.groups(&tiles, room, 500).len() > 3);
        for most in [500, 3000] {
            let by_groups = run(most, &read);
            assert_eq!(by_groups.problems, whole.problems, "{most}");
            assert_eq!(by_groups.finish, whole.finish, "{most}");
            // NaN is not equal to itself.
            assert_eq!(
                format!("{:?}", by_groups.map),
                format!("{:?}", whole.map),
                "{most}"
            );
        }
        // And it does hold few.
        let mut held = Vec::new();
        for group in read.groups(&tiles, room, 500) {
            let n = read.near(&tiles, room, &group, &mut held).len();
            assert!(n <= 3 * 500 || group.len() == 1, "{n} {group:?}");
        }
    }
}
