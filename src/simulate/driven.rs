//! A way that was really driven, judged like a program: no text, only where the tip went, how, and when.
//!
//! A move whose spindle stands is judged as a rapid: neither can cut.

use super::dry_run::{DryRunOptions, PartContext, blank};
use super::judge::judge;
use super::material::Move;
use super::moves::Moves;
use super::report::{Problem, ProgramFigures};
use crate::geom::{Point, Vector};
use crate::sweep::{FinishStats, Segment};

/// A straight move of the tool's tip in work coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenMove {
    /// Start.
    pub from: Point,
    /// End.
    pub to: Point,
    /// A rapid, not a feed move.
    pub rapid: bool,
    /// The spindle turned.
    pub turning: bool,
    /// Moment of its start, s.
    pub at: f64,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rehearsal {
    /// Way at feed, mm.
    pub cut_mm: f64,
    /// Way at rapid speed, mm.
    pub rapid_mm: f64,
    /// The surface left; `None` when nothing was driven over the part.
    pub finish: Option<FinishStats>,
    /// What speaks against it, each with the moment it happened where there is one.
    pub problems: Vec<Problem>,
}

impl Rehearsal {
    /// Something was hit: a gouge, or a move through stock that could not cut.
    pub fn crashed(&self) -> bool {
        self.problems.iter().any(|p| p.kind.is_crash())
    }
}

/// Cuts the moves into the stock, in their order, and judges what is left. Same result for any number of threads.
pub fn judge_driven(
    path: impl IntoIterator<Item = DrivenMove>,
    part: &PartContext,
    options: &DryRunOptions,
) -> Rehearsal {
    let up = Vector::new(0.0, 0.0, part.drop.radius());
    let mut moves = Vec::new();
    // Moment and whether it was a feed move with the spindle standing, by the number that stands for a line.
    let mut notes = Vec::new();
    let (mut cut_mm, mut rapid_mm) = (0.0, 0.0);
    for m in path {
        *if m.rapid { &mut rapid_mm } else { &mut cut_mm } += (m.to - m.from).norm();
        notes.push((m.at, !m.rapid && !m.turning));
        moves.push(Move {
            segment: Segment {
                from: m.from + up,
                to: m.to + up,
            },
            rapid: m.rapid || !m.turning,
            line: notes.len(),
        });
    }
    let mut report = blank(ProgramFigures::default());
    judge(&Moves::Held(&moves), part, options, &mut report);
    let problems = report
        .problems
        .into_iter()
        .map(
            |p| match p.line.and_then(|l| notes.get(l.wrapping_sub(1))) {
                Some((at, standing)) => {
                    let text = if *standing {
                        p.text
                            .replacen("rapid move", "move with the spindle stopped", 1)
                            .replacen("retract higher before it, or feed", "start it first", 1)
                    } else {
                        p.text
                    };
                    Problem {
                        kind: p.kind,
                        line: None,
                        text: format!("after {at:.2} s: {text}"),
                    }
                }
                None => p,
            },
        )
        .collect();
    Rehearsal {
        cut_mm,
        rapid_mm,
        finish: report.finish,
        problems,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Mesh;
    use crate::reach::DropCutter;
    use crate::simulate::{Stock, judging_step};
    use crate::sweep::ReachTiles;

    /// A plate 12 x 9 mm at Z0, passes of a 6 mm ball 0.6 mm apart over it, and what is added to them.
    fn rehearse(turning: bool, more: &[(Point, bool)]) -> Rehearsal {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let mesh = Mesh {
            triangles: vec![
                [p(0.0, 0.0), p(12.0, 0.0), p(12.0, 9.0)],
                [p(0.0, 0.0), p(12.0, 9.0), p(0.0, 9.0)],
            ],
        };
        let drop = DropCutter::new(&mesh, 3.0);
        let tiles = ReachTiles::new(&drop, judging_step(&mesh.bounds(), 3.0, 0.02), 1);
        let part = PartContext {
            mesh: &mesh,
            drop: &drop,
            reachable: &tiles,
        };
        let mut way = vec![
            (Point::new(-5.0, 0.0, 20.0), true),
            (Point::new(-5.0, 0.0, 0.0), false),
        ];
        for k in 0..=15 {
            let y = 0.6 * f64::from(k);
            let (a, b) = if k % 2 == 0 {
                (-4.0, 16.0)
            } else {
                (16.0, -4.0)
            };
            way.extend([(p(a, y), false), (p(b, y), false)]);
        }
        way.extend([(Point::new(16.0, 9.0, 20.0), true)]);
        way.extend_from_slice(more);
        let mut from = Point::new(-5.0, 0.0, 50.0);
        let path = way.iter().zip(0..).map(|((to, rapid), k)| {
            let m = DrivenMove {
                from,
                to: *to,
                rapid: *rapid,
                turning,
                at: f64::from(k),
            };
            from = *to;
            m
        });
        let path: Vec<DrivenMove> = path.collect();
        judge_driven(
            path,
            &part,
            &DryRunOptions::new(0.02, Stock::Allowance(0.5)),
        )
    }

    #[test]
    fn a_sound_way_passes_and_a_low_one_gouges() {
        let good = rehearse(true, &[]);
        assert_eq!(good.problems, []);
        assert!(good.finish.is_some() && !good.crashed());
        assert!(good.cut_mm > 16.0 * 20.0 && good.rapid_mm > 40.0);
        let bad = rehearse(
            true,
            &[
                (Point::new(6.0, 4.0, 1.0), true),
                (Point::new(6.0, 4.0, -0.2), false),
            ],
        );
        assert!(bad.crashed());
        let text = bad
            .problems
            .iter()
            .map(|p| p.to_string())
            .collect::<String>();
        assert!(
            text.contains("gouge: after 36.00 s: the ball cuts 200.0 um into the part"),
            "{text}"
        );
    }

    #[test]
    fn a_rapid_and_a_standing_spindle_crash_into_stock() {
        let text = |r: &Rehearsal| {
            r.problems
                .iter()
                .map(|p| format!("{p}\n"))
                .collect::<String>()
        };
        let standing = rehearse(false, &[]);
        assert!(standing.crashed());
        assert!(text(&standing).contains("collision: after 3.00 s: move with the spindle stopped through 0.500 mm of standing stock"), "{}", text(&standing));
        assert!(
            text(&standing).contains(": start it first\n"),
            "{}",
            text(&standing)
        );
    }
}
