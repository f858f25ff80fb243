//! Blocks that move: L, CC, C, CR, CT, LP, CP.
//!
//! Arcs lie in the plane of X and Y, the working plane of tool axis Z; a Z beside them makes a helix.

use super::super::event::{Arc, Plane};
use super::super::tongue::circle;
use super::words::{Coordinate, Feed, Words};
use super::*;
use crate::geom::Point;
use crate::units::MmPerMin;

/// How far the end of an arc may lie off its circle, mm (iTNC 530, "Circular path C": input tolerance 0.016 mm).
const SLACK: f64 = 0.016;
/// How far a chord may exceed the diameter, mm: what rounding to three decimals makes.
const CHORD_SLACK: f64 = 0.002;

/// `L`.
pub(super) fn line(job: &mut Job) -> Result<(), Fault> {
    let words = words::read(job, false)?;
    no_polar(&words, false)?;
    if words.clockwise.is_some() {
        let name = Name::of("DR");
        return wrong(words.first_at, Wrong::NotUnderstood { name });
    }
    let machine = words.functions.iter().find(|f| f.0 == 91).map(|f| f.1);
    if let Some(at) = machine
        && words.axes.iter().flatten().any(|c| c.incremental)
    {
        return refuse(
            at,
            "M91 with I coordinates",
            "write them without I, from the machine's datum",
        );
    }
    let to = match machine {
        Some(_) => machine_place(job, &words),
        None => place(job, &words),
    };
    go(job, &words, to, None, machine.is_some())
}

/// `CC`: the pole.
pub(super) fn pole(job: &mut Job) -> Result<(), Fault> {
    let words = words::read(job, false)?;
    no_polar(&words, false)?;
    if let Some(&(m, at)) = words.functions.first() {
        let name = Name::of(&format!("M{m}"));
        return wrong(at, Wrong::NotUnderstood { name });
    }
    if words.feed.is_some() {
        let name = Name::of("F");
        return wrong(words.feed_at, Wrong::NotUnderstood { name });
    }
    if words.axes[2].is_some() {
        return refuse(
            words.first_at,
            "CC with Z",
            "arcs are read in X and Y only; post this one as lines",
        );
    }
    match (words.axes[0], words.axes[1]) {
        (None, None) | (Some(_), Some(_)) => {}
        _ => {
            let (command, what) = ("CC", "both X and Y (or neither, for the last position)");
            return wrong(words.first_at, Wrong::Missing { command, what });
        }
    }
    let p = place(job, &words);
    job.modes.pole = Some([p.x, p.y]);
    Ok(())
}

/// `C`: about the pole.
pub(super) fn circle(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.at();
    let words = words::read(job, false)?;
    no_polar(&words, true)?;
    let center = center(job, "C", at)?;
    in_plane(&words, "C", at)?;
    let to = place(job, &words);
    let arc = about(job, &words, "C", at, center, &to)?;
    go(job, &words, to, Some(arc), false)
}

/// `CR`: by its radius.
pub(super) fn circle_of_radius(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.at();
    let words = words::read(job, true)?;
    no_polar(&words, true)?;
    in_plane(&words, "CR", at)?;
    let Some(r) = words.radius else {
        let (command, what) = ("CR", "a radius (R+ up to half a circle, R- beyond)");
        return wrong(at, Wrong::Missing { command, what });
    };
    let clockwise = direction(&words, "CR", at)?;
    let from = job.desk.state.position;
    let to = place(job, &words);
    let radius = r.abs() * job.mm();
    let (plane, slack) = (Plane::Xy, CHORD_SLACK);
    match circle::of_radius(plane, &from, &to, radius, r < 0.0, clockwise, slack) {
        Ok(arc) => go(job, &words, to, Some(arc), false),
        Err(distance) => wrong(at, Wrong::Radius { radius, distance }),
    }
}

/// `CT`: goes on in the direction in which the last contour block ended.
pub(super) fn tangent(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.at();
    let words = words::read(job, false)?;
    no_polar(&words, true)?;
    in_plane(&words, "CT", at)?;
    let from = job.desk.state.position;
    let to = place(job, &words);
    let Some([tx, ty]) = job.modes.tangent else {
        return wrong(at, Wrong::NoTangent);
    };
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    // The centre lies on the normal to the left, at a distance that makes it as far from the end.
    let (nx, ny) = (-ty, tx);
    let across = dx * nx + dy * ny;
    let chord = dx.hypot(dy);
    if across.abs() <= 1e-9 * chord {
        return wrong(at, Wrong::NoTangent);
    }
    let r = chord * chord / (2.0 * across);
    let center = Point::new(from.x + r * nx, from.y + r * ny, from.z);
    let clockwise = r < 0.0;
    let sweep = circle::turn(Plane::Xy, &from, &to, &center, clockwise);
    let arc = Arc {
        plane: Plane::Xy,
        center,
        clockwise,
        sweep,
    };
    go(job, &words, to, Some(arc), false)
}

/// `LP`: a line to radius PR and angle PA about the pole.
pub(super) fn polar_line(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.at();
    let words = words::read(job, false)?;
    cartesian(&words)?;
    let center = center(job, "LP", at)?;
    let from = job.desk.state.position;
    let (x, y) = (from.x - center.x, from.y - center.y);
    let now = x.hypot(y);
    let radius = match words.polar_radius {
        None => now,
        Some(c) => c.value * job.mm() + if c.incremental { now } else { 0.0 },
    };
    let angle = match words.polar_angle {
        Some(c) if !c.incremental => c.value.to_radians(),
        relative => {
            if now < 1e-9 {
                let (command, what) = ("LP", "PA without I: the tool stands on the pole");
                return wrong(at, Wrong::Missing { command, what });
            }
            y.atan2(x) + relative.map_or(0.0, |c| c.value.to_radians())
        }
    };
    let (sin, cos) = circle::sine_cosine(angle);
    let mut to = place(job, &words);
    (to.x, to.y) = (center.x + radius * cos, center.y + radius * sin);
    go(job, &words, to, None, false)
}

/// `CP`: an arc or a helix about the pole to the angle PA, or by the angle IPA.
pub(super) fn polar_circle(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.at();
    let words = words::read(job, false)?;
    cartesian(&words)?;
    if words.polar_radius.is_some() {
        let name = Name::of("PR");
        return wrong(at, Wrong::NotUnderstood { name });
    }
    let center = center(job, "CP", at)?;
    let Some(pa) = words.polar_angle else {
        let (command, what) = ("CP", "an angle (PA or IPA)");
        return wrong(at, Wrong::Missing { command, what });
    };
    let from = job.desk.state.position;
    let radius = circle::distance(Plane::Xy, &from, &center);
    if radius <= 0.0 {
        let (start, end) = (radius, radius);
        return wrong(at, Wrong::RadiiDiffer { start, end });
    }
    let clockwise = direction(&words, "CP", at)?;
    let height = place(job, &words).z;
    let (mut to, sweep) = if pa.incremental {
        if pa.value == 0.0 || (pa.value < 0.0) != clockwise || pa.value.abs() > 5400.0 {
            let name = Name::of("IPA");
            let range = "the sign of DR, and degrees up to 5400 that are not zero";
            return wrong(at, Wrong::Range { name, range });
        }
        let sweep = pa.value.to_radians();
        let to = circle::turned(Plane::Xy, &from, &center, sweep);
        (to, sweep)
    } else {
        let (sin, cos) = circle::sine_cosine(pa.value.to_radians());
        let to = Point::new(center.x + radius * cos, center.y + radius * sin, from.z);
        (to, circle::turn(Plane::Xy, &from, &to, &center, clockwise))
    };
    to.z = height;
    let arc = Arc {
        plane: Plane::Xy,
        center: Point::new(center.x, center.y, from.z),
        clockwise,
        sweep,
    };
    go(job, &words, to, Some(arc), false)
}

/// Where the coordinates lead, work coordinates.
fn place(job: &Job, words: &Words) -> Point {
    let mut to = job.desk.state.position;
    for (axis, c) in words.axes.iter().enumerate() {
        if let Some(Coordinate { value, incremental }) = *c {
            let value = value * job.mm();
            to[axis] = match incremental {
                true => to[axis] + value,
                false => job.modes.shift[axis] + value,
            };
        }
    }
    to
}

/// Where they lead from the machine's datum (M91), in work coordinates.
fn machine_place(job: &Job, words: &Words) -> Point {
    let mut to = job.desk.state.machine_position();
    for (axis, c) in words.axes.iter().enumerate() {
        if let Some(c) = c {
            to[axis] = c.value * job.mm();
        }
    }
    let mut work = job.desk.state.work_of_machine(&to);
    for (axis, c) in words.axes.iter().enumerate() {
        if c.is_none() {
            // To the last bit: what is not named stays.
            work[axis] = job.desk.state.position[axis];
        }
    }
    work
}

/// The pole at the tool's height.
fn center(job: &Job, command: &'static str, at: u32) -> Result<Point, Fault> {
    match job.modes.pole {
        Some([x, y]) => Ok(Point::new(x, y, job.desk.state.position.z)),
        None => wrong(at, Wrong::PoleMissing { command }),
    }
}

/// DR.
fn direction(words: &Words, command: &'static str, at: u32) -> Result<bool, Fault> {
    match words.clockwise {
        Some(clockwise) => Ok(clockwise),
        None => {
            let what = "a direction (DR+ counter-clockwise, DR- clockwise)";
            wrong(at, Wrong::Missing { command, what })
        }
    }
}

/// An arc needs an end in X or Y.
fn in_plane(words: &Words, command: &'static str, at: u32) -> Result<(), Fault> {
    if words.axes[0].is_none() && words.axes[1].is_none() {
        let what = "an end point in X and Y";
        return wrong(at, Wrong::Missing { command, what });
    }
    // With Z and one of X and Y the control may take the arc for one of that plane (TNC 640, "Circular path C": arcs in the XZ plane).
    if words.axes[2].is_some() && (words.axes[0].is_none() || words.axes[1].is_none()) {
        let name = format!("{command} with Z and one of X and Y");
        return refuse(
            words.first_at,
            &name,
            "it may be an arc of another plane; give X, Y and Z, or post it as lines",
        );
    }
    Ok(())
}

/// The arc about the pole.
fn about(
    job: &Job,
    words: &Words,
    command: &'static str,
    at: u32,
    center: Point,
    to: &Point,
) -> Result<Arc, Fault> {
    let clockwise = direction(words, command, at)?;
    let from = job.desk.state.position;
    match circle::about(Plane::Xy, &from, to, &center, clockwise, SLACK) {
        Ok(arc) => Ok(arc),
        Err((start, end)) => wrong(at, Wrong::RadiiDiffer { start, end }),
    }
}

/// PR and PA belong to LP and CP only; `arc`: M91 has no place in arcs.
fn no_polar(words: &Words, arc: bool) -> Result<(), Fault> {
    let at = words.first_at;
    if words.polar_angle.is_some() || words.polar_radius.is_some() {
        let name = Name::of("PR or PA");
        return wrong(at, Wrong::NotUnderstood { name });
    }
    let machine = words.functions.iter().find(|f| f.0 == 91);
    match machine {
        Some(&(_, at)) if arc => refuse(at, "M91", "it goes with straight blocks (L) only"),
        _ => Ok(()),
    }
}

/// X and Y have no place in LP and CP.
fn cartesian(words: &Words) -> Result<(), Fault> {
    let name = match words.axes {
        [Some(_), _, _] => "X",
        [_, Some(_), _] => "Y",
        _ => match words.functions.iter().find(|f| f.0 == 91) {
            Some(_) => "M91",
            None => return Ok(()),
        },
    };
    let name = Name::of(name);
    wrong(words.first_at, Wrong::NotUnderstood { name })
}

/// Carries out the block: feed, functions, motion, functions.
fn go(
    job: &mut Job,
    words: &Words,
    to: Point,
    arc: Option<Arc>,
    machine: bool,
) -> Result<(), Fault> {
    let polar = words.polar_angle.is_some() || words.polar_radius.is_some();
    let moves = words.moves() || polar;
    // F in INCH programs is in tenths of an inch per minute.
    let unit = match job.desk.state.units {
        super::super::state::Units::Mm => 1.0,
        super::super::state::Units::Inch => 2.54,
    };
    let mut rapid = false;
    match words.feed {
        Some(Feed::Programmed(f)) => job.desk.state.feed = MmPerMin(f * unit),
        Some(Feed::Auto) => {
            if job.modes.auto_feed <= 0.0 {
                let (command, what) = ("F AUTO", "an F in the TOOL CALL before it");
                return wrong(words.feed_at, Wrong::Missing { command, what });
            }
            job.desk.state.feed = MmPerMin(job.modes.auto_feed);
        }
        Some(Feed::Max) => rapid = true,
        None => {}
    }
    if rapid && arc.is_some() {
        return refuse(
            words.feed_at,
            "FMAX in an arc",
            "write a feed, or a straight block",
        );
    }
    let feed = job.desk.state.feed;
    if moves && !rapid && feed.0 <= 0.0 {
        let at = words.first_at;
        return Err(Fault::at(at, Complaint::FeedMissing));
    }
    miscellany::before(job, &words.functions);
    if moves {
        let from = job.desk.state.position;
        if rapid {
            job.desk.rapid(to, machine);
        } else {
            job.desk.cut(to, arc, feed, machine);
        }
        job.modes.tangent = direction_at_end(&from, &to, arc.as_ref());
    }
    miscellany::after(job, &words.functions, moves)
}

/// The direction in X and Y in which a motion ends.
fn direction_at_end(from: &Point, to: &Point, arc: Option<&Arc>) -> Option<[f64; 2]> {
    let [x, y] = match arc {
        None => [to.x - from.x, to.y - from.y],
        Some(a) => {
            let (x, y) = (to.x - a.center.x, to.y - a.center.y);
            if a.clockwise { [y, -x] } else { [-y, x] }
        }
    };
    let length = x.hypot(y);
    (length > 1e-9).then(|| [x / length, y / length])
}
