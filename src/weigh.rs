//! What a toolpath takes on a machine, before there is any text: the planner's own clock over its moves.
//!
//! Stands above `toolpath` and `kinematics`, which know nothing of each other: toolpath asks its caller to weigh candidates, and this is
//! the answer. Pure: the same moves and settings give the same figures.

use crate::geom::Point;
use crate::kinematics::{Leg, Purpose, Settings, path_quality};
use crate::toolpath::{Figures, MoveKind, Toolpath};
use crate::units::MmPerMin;

/// Weighs a toolpath at a cutting and a plunge feed. One pass over its moves.
pub fn weigh(path: &Toolpath, settings: &Settings, feed: MmPerMin, plunge: MmPerMin) -> Figures {
    let Some(first) = path.moves.first() else {
        return Figures::default();
    };
    let mut at: Point = first.to;
    let legs = path.moves[1..].iter().map(|m| {
        let upright = (m.to.xy() - at.xy()).norm() < 1e-6;
        at = m.to;
        let (purpose, feed) = match m.kind {
            MoveKind::Rapid | MoveKind::Retract => (Purpose::Air, feed),
            MoveKind::Plunge => (Purpose::Plunge, plunge),
            // Straight up off the surface at feed, not along it.
            MoveKind::Link if upright => (Purpose::Plunge, m.feed_within(feed)),
            MoveKind::Link => (Purpose::Link, m.feed_within(feed)),
            MoveKind::Cut => (Purpose::Cut, m.feed_within(feed)),
        };
        Leg {
            to: m.to,
            purpose,
            feed,
        }
    });
    let q = path_quality(&first.to, legs, settings);
    Figures {
        time_s: q.time,
        link_s: q.link,
        air_s: q.air + q.plunge,
        vertical_acceleration_rms: q.vertical_acceleration_rms,
        largest_turn_deg: q.largest_turn,
        ..Figures::default()
    }
}
