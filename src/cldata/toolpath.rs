//! A planned toolpath and its job as steps.

use super::job::{Coolant, Job};
use super::step::{Bow, Step};
use crate::geom::{Plane, Point};
use crate::toolpath::{Move, MoveKind, Toolpath, Turn};
use crate::units::MmPerMin;

/// The steps of a whole job, each with the index of the move that it carries out, if it does:
///
/// ```text
/// comments, tool
/// up to the safe height   before anything else moves or turns
/// spindle, coolant
/// over the first place at that height, then moves; section names as comments between them
/// up to the safe height   unless the last move ended there or above
/// end
/// ```
///
/// The toolpath must begin with a [`MoveKind::Rapid`]; what else it holds is the writer's to judge.
pub fn steps<'a>(
    path: &'a Toolpath,
    job: &'a Job,
) -> impl Iterator<Item = (Option<usize>, Step)> + 'a {
    let up = path
        .moves
        .first()
        .map_or(path.safe_z, |m| path.safe_z.max(m.to.z));
    let rise = move |z| {
        (
            None,
            Step::Rapid {
                to: [None, None, Some(z)],
            },
        )
    };
    let last = path.moves.last().map_or(up, |m| m.to.z);
    let turning = (job.speed.0 > 0.0).then_some(Step::Spindle {
        direction: 1,
        speed: job.speed,
        spin_up: job.spin_up,
    });
    let coolant = (job.coolant != Coolant::Off).then_some(Step::Coolant(job.coolant));
    let over = path
        .moves
        .first()
        .filter(|m| m.to.z < up)
        .map(|m| Step::Rapid {
            to: [Some(m.to.x), Some(m.to.y), Some(up)],
        });
    let head = (job.header.iter().cloned().map(Step::Comment))
        .chain([Step::Tool {
            number: job.tool_number,
        }])
        .map(|s| (None, s));
    let ready = turning.into_iter().chain(coolant).map(|s| (None, s));
    let mut sections = path.sections.iter().peekable();
    let moves = path.moves.iter().enumerate().flat_map(move |(i, m)| {
        let mut here = Vec::with_capacity(1);
        while let Some(s) = sections.next_if(|s| s.first_move <= i) {
            here.push((None, Step::Comment(s.name.clone())));
        }
        if i == 0 {
            here.extend(over.clone().map(|s| (None, s)));
        }
        let before = i.checked_sub(1).and_then(|k| path.moves.get(k));
        here.push((Some(i), step(m, before.map(|b| b.to), job)));
        here
    });
    head.chain([rise(up)])
        .chain(ready)
        .chain(moves)
        .chain((last < path.safe_z).then(|| rise(path.safe_z)))
        .chain([(None, Step::End)])
}

/// One move as a step.
fn step(m: &Move, before: Option<Point>, job: &Job) -> Step {
    let bow = |t: &Turn, from: &Point| Bow {
        plane: Plane::Xy,
        center: Point::new(t.center.x, t.center.y, from.z),
        sweep: t.sweep(from, &m.to),
    };
    let feed = |feed: MmPerMin| Step::Feed {
        to: m.to,
        bow: m.turn.as_ref().zip(before).map(|(t, b)| bow(t, &b)),
        feed,
    };
    match m.kind {
        MoveKind::Rapid | MoveKind::Retract => Step::Rapid {
            to: [Some(m.to.x), Some(m.to.y), Some(m.to.z)],
        },
        MoveKind::Plunge => feed(job.plunge),
        MoveKind::Cut | MoveKind::Link => feed(m.feed_within(job.feed)),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point2;
    use crate::toolpath::{Move, Section, Turn};
    use crate::units::{Rpm, Seconds};

    fn job() -> Job {
        Job {
            header: vec!["part".into(), "tool".into()],
            feed: MmPerMin(1500.0),
            plunge: MmPerMin(500.0),
            speed: Rpm(18000.0),
            tool_number: 3,
            spin_up: Seconds(2.0),
            coolant: Coolant::Flood,
            path_tolerance: None,
        }
    }

    fn go(kind: MoveKind, x: f64, y: f64, z: f64) -> Move {
        Move::straight(kind, Point::new(x, y, z))
    }

    fn path() -> Toolpath {
        let section = |name: &str, first_move| Section {
            name: name.into(),
            first_move,
        };
        let mut slow = go(MoveKind::Link, 3.0, 0.0, -1.0);
        slow.feed = Some(MmPerMin(600.0));
        let mut fast = go(MoveKind::Cut, 5.0, 0.0, -1.0);
        fast.feed = Some(MmPerMin(9000.0));
        let mut arc = go(MoveKind::Cut, 5.0, 4.0, -0.5);
        arc.turn = Some(Turn {
            center: Point2::new(5.0, 2.0),
            clockwise: true,
        });
        Toolpath {
            moves: vec![
                go(MoveKind::Rapid, 1.0, 0.0, 5.0),
                go(MoveKind::Plunge, 1.0, 0.0, -1.0),
                slow,
                fast,
                arc,
                go(MoveKind::Retract, 5.0, 4.0, 2.0),
            ],
            sections: vec![
                section("one", 0),
                section("two", 2),
                section("two b", 2),
                section("none", 6),
            ],
            safe_z: 5.0,
        }
    }

    fn rapid(x: Option<f64>, y: Option<f64>, z: f64) -> Step {
        Step::Rapid {
            to: [x, y, Some(z)],
        }
    }

    fn feed(x: f64, y: f64, z: f64, f: f64) -> Step {
        Step::Feed {
            to: Point::new(x, y, z),
            bow: None,
            feed: MmPerMin(f),
        }
    }

    #[test]
    fn a_job_in_order() {
        let (path, job) = (path(), job());
        let got: Vec<_> = steps(&path, &job).collect();
        let text = |t: &str| (None, Step::Comment(t.into()));
        let spindle = Step::Spindle {
            direction: 1,
            speed: Rpm(18000.0),
            spin_up: Seconds(2.0),
        };
        let bow = Bow {
            plane: Plane::Xy,
            center: Point::new(5.0, 2.0, -1.0),
            sweep: -std::f64::consts::PI,
        };
        let arc = Step::Feed {
            to: Point::new(5.0, 4.0, -0.5),
            bow: Some(bow),
            feed: MmPerMin(1500.0),
        };
        let want = [
            text("part"),
            text("tool"),
            (None, Step::Tool { number: 3 }),
            (None, rapid(None, None, 5.0)),
            (None, spindle),
            (None, Step::Coolant(Coolant::Flood)),
            text("one"),
            (Some(0), rapid(Some(1.0), Some(0.0), 5.0)),
            (Some(1), feed(1.0, 0.0, -1.0, 500.0)),
            text("two"),
            text("two b"),
            (Some(2), feed(3.0, 0.0, -1.0, 600.0)),
            // Never above the job's.
            (Some(3), feed(5.0, 0.0, -1.0, 1500.0)),
            (Some(4), arc),
            (Some(5), rapid(Some(5.0), Some(4.0), 2.0)),
            (None, rapid(None, None, 5.0)),
            (None, Step::End),
        ];
        assert_eq!(got, want);
    }

    #[test]
    fn rises_to_the_higher_of_the_safe_height_and_the_first_place() {
        let (mut p, job) = (path(), job());
        let rises = |p: &Toolpath| -> Vec<Step> {
            steps(p, &job)
                .filter(|s| s.0.is_none() && matches!(s.1, Step::Rapid { .. }))
                .map(|s| s.1)
                .collect()
        };
        // Over the first place first, then down to it; no rise at the end where the last move was one.
        p.moves[0].to.z = 2.0;
        p.moves[5].to.z = 5.0;
        assert_eq!(
            rises(&p),
            [rapid(None, None, 5.0), rapid(Some(1.0), Some(0.0), 5.0)]
        );
        p.moves[0].to.z = 9.0;
        assert_eq!(rises(&p), [rapid(None, None, 9.0)]);
    }

    #[test]
    fn a_resting_spindle_and_no_coolant_are_not_told() {
        let (p, mut j) = (path(), job());
        (j.speed, j.coolant) = (Rpm(0.0), Coolant::Off);
        let told = |s: &Step| matches!(s, Step::Spindle { .. } | Step::Coolant(_));
        assert!(!steps(&p, &j).any(|s| told(&s.1)));
    }

    #[test]
    fn an_empty_path_rises_and_ends() {
        let (p, j) = (Toolpath::default(), job());
        let got: Vec<Step> = steps(&p, &j).map(|s| s.1).skip(3).collect();
        assert_eq!(
            (&got[0], &got[got.len() - 1]),
            (&rapid(None, None, 0.0), &Step::End)
        );
        assert_eq!(got.len(), 4);
    }

    #[test]
    fn every_move_is_told_once_and_in_order() {
        let (p, j) = (path(), job());
        let told: Vec<usize> = steps(&p, &j).filter_map(|s| s.0).collect();
        assert_eq!(told, (0..p.moves.len()).collect::<Vec<_>>());
    }
}
