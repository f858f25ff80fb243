//! Arcs: G2 and G3 with I J K, CR or AR, and TURN for helices.
//!
//! Crosses the border: a block's words and where it starts and ends, work coordinates, mm; an [`Arc`] with its end out.

use super::super::event::{Arc, Plane};
use super::super::state::MotionMode;
use super::super::tongue::circle;
use super::block::{Block, Coordinate};
use super::*;
use crate::geom::Point;
use std::f64::consts::TAU;

/// How far the end of an arc may lie off its circle: mm, and a share of the radius (machine data CIRCLE_ERROR_CONST and _FACTOR).
const SLACK: (f64, f64) = (0.01, 0.001);
/// How far a chord may exceed the diameter, mm: what rounding to three decimals makes.
const CHORD_SLACK: f64 = 0.002;

/// The block's arc, with its end, which AR may give.
pub(super) fn arc(job: &Job, block: &Block, to: Point, at: u32) -> Result<(Point, Arc), Fault> {
    let state = &job.desk.state;
    let plane = state.plane;
    let [a, b, n] = plane.axes();
    let clockwise = state.motion == MotionMode::ArcClockwise;
    let from = state.position;
    let in_plane = block.axes[a].is_some() || block.axes[b].is_some();
    if let Some(c) = block.center[n] {
        let name = Name::of(["I", "J", "K"][n]);
        return wrong(c.at, Wrong::Unused { name });
    }
    let centered = block.center[a].is_some() || block.center[b].is_some();
    let mut to = to;
    let mut arc = match (centered, block.radius, block.angle) {
        (false, Some((r, at)), None) => {
            let radius = r.abs() * job.mm();
            let long = r < 0.0;
            match circle::of_radius(plane, &from, &to, radius, long, clockwise, CHORD_SLACK) {
                Ok(arc) => arc,
                Err(distance) => return wrong(at, Wrong::Radius { radius, distance }),
            }
        }
        (true, None, None) => {
            let center = center(job, block);
            about(plane, &from, &to, &center, clockwise)
                .or_else(|(start, end)| wrong(at, Wrong::RadiiDiffer { start, end }))?
        }
        (true, None, Some((angle, at))) => {
            opening(angle, at)?;
            if in_plane {
                let name = Name::of("AR with centre and end point");
                return wrong(at, Wrong::Unused { name });
            }
            let center = center(job, block);
            let turn = angle.to_radians() * if clockwise { -1.0 } else { 1.0 };
            let end = circle::turned(plane, &from, &center, turn);
            (to[a], to[b]) = (end[a], end[b]);
            let mut arc = about(plane, &from, &to, &center, clockwise)
                .or_else(|(start, end)| wrong(at, Wrong::RadiiDiffer { start, end }))?;
            arc.sweep = turn;
            arc
        }
        (false, None, Some((angle, at))) => {
            opening(angle, at)?;
            // The chord and the angle over it give the radius.
            let chord = circle::distance(plane, &from, &to);
            let radius = chord / 2.0 / (angle / 2.0).to_radians().sin();
            let long = angle > 180.0;
            circle::of_radius(plane, &from, &to, radius, long, clockwise, CHORD_SLACK)
                .or_else(|distance| wrong(at, Wrong::Radius { radius, distance }))?
        }
        (false, None, None) => {
            return missing(at, "an arc", "its centre (I J K), CR or AR");
        }
        _ => {
            let (name, at) = match (block.radius, block.angle) {
                (Some(r), _) => ("CR", r.1),
                (None, Some(ar)) => ("AR", ar.1),
                _ => ("CR", at),
            };
            let name = Name::of(name);
            return wrong(at, Wrong::Unused { name });
        }
    };
    if let Some((turns, at)) = block.turns {
        if turns.fract() != 0.0 || !(0.0..=999.0).contains(&turns) {
            return range(at, "TURN", "a whole number from 0 to 999");
        }
        if turns > 0.0 && circle::distance(plane, &from, &to) == 0.0 {
            return refuse(
                at,
                "TURN in a full circle",
                "whether one more full circle is meant differs; split it into single circles",
            );
        }
        arc.sweep += turns * TAU * arc.sweep.signum();
    }
    Ok((to, arc))
}

/// AR's range.
fn opening(angle: f64, at: u32) -> Result<(), Fault> {
    if !(angle > 0.0 && angle < 360.0) {
        return range(at, "AR", "an angle above 0 and below 360 degrees");
    }
    Ok(())
}

/// The arc about a centre, within the control's slack.
fn about(
    plane: Plane,
    from: &Point,
    to: &Point,
    center: &Point,
    clockwise: bool,
) -> Result<Arc, (f64, f64)> {
    let radius = circle::distance(plane, from, center);
    let slack = SLACK.0.max(SLACK.1 * radius);
    circle::about(plane, from, to, center, clockwise, slack)
}

/// The centre: from the start, or, with AC(), in the part's system.
fn center(job: &Job, block: &Block) -> Point {
    let mut center = job.desk.state.position;
    for (axis, c) in block.center.iter().enumerate() {
        if let Some(Coordinate {
            value, incremental, ..
        }) = *c
        {
            let value = value * job.mm();
            center[axis] = match incremental {
                Some(false) => job.modes.shift[axis] + value,
                _ => center[axis] + value,
            };
        }
    }
    center
}
