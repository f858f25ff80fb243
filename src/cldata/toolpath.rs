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
