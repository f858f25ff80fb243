//! A small job that shows a post at work: every kind of step that its controller can carry out.

use super::definition::{Fit, Post, Shape};
use super::error::PostError;
use super::options::Options;
use super::writer::Writer;
use crate::cldata::{Bow, Coolant, Step};
use crate::geom::{Plane, Point};
use crate::units::{MmPerMin, Rpm, Seconds};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The steps, in order: comments, a tool, lines, arcs, a pause, a second tool, the end. What the post cannot write is left out.
pub fn specimen(post: &Post) -> Vec<Step> {
    let mut s = vec![
        Step::Comment("specimen: 10 mm square, 2 mm deep".into()),
        Step::Comment("tool 1: ball 6 mm (tip programmed)".into()),
    ];
    if post.work_offsets.most >= 2 {
        s.push(Step::WorkOffset(2));
    }
    let turn = |direction, rpm| Step::Spindle {
        direction,
        speed: Rpm(rpm),
        spin_up: match post.dwell.is_empty() {
            true => Seconds(0.0),
            false => Seconds(2.0),
        },
    };
    let up = Step::Rapid {
        to: [None, None, Some(25.0)],
    };
    let over = |x, y| Step::Rapid {
        to: [Some(x), Some(y), None],
    };
    s.extend([Step::Tool { number: 1 }, up.clone(), turn(1, 12_000.0)]);
    if !post.coolant.flood.is_empty() {
        s.push(Step::Coolant(Coolant::Flood));
    }
    s.push(Step::Comment("lines".into()));
    s.extend([
        over(10.0, 0.0),
        Step::Rapid {
            to: [None, None, Some(2.0)],
        },
    ]);
    let line = |x, y, z, feed| Step::Feed {
        to: Point::new(x, y, z),
        bow: None,
        feed: MmPerMin(feed),
    };
    s.extend([
        line(10.0, 0.0, -1.0, 300.0),
        line(10.0, 5.5, -1.125, 1200.0),
        line(10.0, 0.0, -1.0, 1200.0),
    ]);
    let arcs = arcs(post);
    if !arcs.is_empty() {
        s.push(Step::Comment("arcs".into()));
        s.extend(arcs);
    }
    if !post.dwell.is_empty() {
        s.push(Step::Dwell(Seconds(1.0)));
    }
    s.push(up.clone());
    if !post.optional_pause.is_empty() {
        s.push(Step::Pause { optional: true });
    }
    if !post.pause.is_empty() {
        s.push(Step::Pause { optional: false });
    }
    if !post.tool.change.is_empty() {
        s.push(Step::Comment("tool 2".into()));
        s.extend([Step::Tool { number: 2 }, up.clone()]);
        let ccw = !post.spindle.ccw.is_empty();
        s.push(turn(if ccw { -1 } else { 1 }, 8000.0));
        if !post.coolant.both.is_empty() {
            s.push(Step::Coolant(Coolant::Both));
        }
        s.extend([
            over(0.0, 0.0),
            Step::Rapid {
                to: [None, None, Some(1.0)],
            },
            line(0.0, 0.0, -0.5, 150.0),
            up,
        ]);
    }
    s.push(Step::End);
    s
}

/// The specimen as text.
pub fn specimen_text(post: &Post) -> Result<String, PostError> {
    let mut writer = Writer::new(post, Options::default(), Vec::new())?;
    for step in specimen(post) {
        writer.step(&step)?;
    }
    Ok(String::from_utf8_lossy(&writer.finish()?).into_owned())
}

/// From (10, 0, -1) and back there: a quarter, a helix, a full circle, a half in ZX.
fn arcs(post: &Post) -> Vec<Step> {
    let home = Point::new(10.0, 0.0, -1.0);
    let quarter = Point::new(0.0, 10.0, -1.0);
    let lower = Point::new(10.0, 0.0, -2.0);
    let ways = [
        (home, quarter, Plane::Xy, Point::origin(), FRAC_PI_2),
        (quarter, lower, Plane::Xy, Point::origin(), -FRAC_PI_2),
        (lower, lower, Plane::Xy, Point::origin(), TAU),
        (
            lower,
            Point::new(8.0, 0.0, -2.0),
            Plane::Zx,
            Point::new(9.0, 0.0, -2.0),
            -0.5 * TAU,
        ),
    ];
    let mut at = home;
    let mut steps = Vec::new();
    for (from, to, plane, center, sweep) in ways {
        let shape = Shape::new(plane, &from, &to, &center, sweep);
        if from == at && post.arcs.fit(&shape) == Fit::Good {
            steps.push(Step::Feed {
                to,
                bow: Some(Bow {
                    plane,
                    center,
                    sweep,
                }),
                feed: MmPerMin(600.0),
            });
            at = to;
        }
    }
    steps
}
