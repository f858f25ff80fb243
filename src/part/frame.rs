//! Placing the part on the table: which side is up, how it lies, and where the program's zero is.
//!
//! An open surface gets the local coordinate system of the method: z is the area-weighted mean normal, x and y follow the
//! smallest rectangle around its shadow on the table, long side along X.
//!
//! ```text
//!        mean normal -> +Z                  hull of the shadow          smallest rectangle, long side -> X
//!   sum of area vectors A_i n_i              .--''''--.                  +----------------+
//!   (winding put right by majority)         '--......-'                  |   .--''''--.   |
//!                                                                        +--'--......-'---+
//! ```
//!
//! Over a *closed* surface that sum is zero (divergence theorem), so it says nothing: the file's +Z stays up, and a note names the
//! axis from which most of the area is seen.
//!
//! Crosses the border: a [`Mesh`] in the file's axes in, a [`Placement`] in work coordinates out; mm, radians. Knows no tools.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::str::FromStr;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

use super::check::Soundness;
use super::hull::{convex_hull, smallest_rectangle};
use super::mesh::Mesh;
use crate::geom::{Point, Vector, xy};

/// An axis of the part file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The file's X.
    X,
    /// The file's Y.
    Y,
    /// The file's Z.
    Z,
}

/// Which way along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Towards larger values.
    Plus,
    /// Towards smaller values.
    Minus,
}

/// Which direction of the part file points to the spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// The mean normal of an open surface; the file's +Z for a closed one.
    #[default]
    Auto,
    /// This axis; the part is turned the shortest way, and never about the vertical.
    Axis(Axis, Sign),
}

impl FromStr for Up {
    type Err = String;

    /// Reads `auto`, `+x`, `-x`, `+y`, `-y`, `+z`, `-z` (the plus may be left out).
    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.trim().to_ascii_lowercase();
        let (sign, name) = match lower.strip_prefix('-') {
            Some(name) => (Sign::Minus, name),
            None => (Sign::Plus, lower.strip_prefix('+').unwrap_or(&lower)),
        };
        match name {
            "x" => Ok(Up::Axis(Axis::X, sign)),
            "y" => Ok(Up::Axis(Axis::Y, sign)),
            "z" => Ok(Up::Axis(Axis::Z, sign)),
            _ if lower == "auto" => Ok(Up::Auto),
            _ => Err(format!(
                "up axis \"{text}\" is not known: write auto, +x, -x, +y, -y, +z or -z"
            )),
        }
    }
}

/// Where the program's zero lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Origin {
    /// At the part file's own origin.
    #[default]
    Part,
    /// At the stock's top, its front-left corner: the part lies in x >= 0, y >= 0, z <= 0.
    TopLeft,
    /// At the stock's top, its middle in x and y.
    TopCenter,
}

impl FromStr for Origin {
    type Err = String;

    /// Reads `part`, `top-left`, `top-center`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().to_ascii_lowercase().as_str() {
            "part" => Ok(Origin::Part),
            "top-left" => Ok(Origin::TopLeft),
            "top-center" | "top-centre" => Ok(Origin::TopCenter),
            _ => Err(format!(
                "origin \"{text}\" is not known: write part, top-left or top-center"
            )),
        }
    }
}

/// How to place a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlaceOptions {
    /// What points to the spindle.
    pub up: Up,
    /// Where the program's zero is.
    pub origin: Origin,
}

/// What was measured to place the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Area-weighted mean normal in the file's axes, as long as it is decided: 1 for a flat sheet, 0 for a closed solid.
    pub normal: Vector,
    /// Area-weighted centroid in the file's axes, mm.
    pub centroid: Point,
    /// Long and short side of the smallest rectangle around the placed part's shadow, mm.
    pub rectangle: [f64; 2],
    /// Direction of the long side in work coordinates, radians from X towards Y, in (-pi/2, pi/2].
    pub angle: f64,
}

/// A part on the table.
#[derive(Clone, Debug)]
pub struct Placement {
    /// The triangles in work coordinates, mm, in the file's order and winding.
    pub mesh: Mesh,
    /// The motion that brought them there.
    pub work_from_part: Isometry3<f64>,
    /// What was measured.
    pub frame: Frame,
    /// The part has no open edge.
    pub closed: bool,
    /// For each axis of the file, the share of the area (0 to 1) that does not face away from it; upright walls count.
    pub reachable_share: [(&'static str, f64); 6],
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
}

/// Why a part cannot be placed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// Nothing to place.
    #[error("the part has no area: nothing can be placed or milled")]
    NoArea,
}

/// Directions closer than this to an axis are that axis: files are rounded to 7 digits, and an upright part must stay so.
const SNAP: f64 = 1e-6;
/// Below this length the mean normal is noise: a nearly closed solid.
const DECIDED: f64 = 0.02;

/// Places a part. With [`Up::Axis`]`(Z, Plus)` and [`Origin::Part`] the coordinates stay as they are, bit for bit.
///
/// Of the rectangle's two ways to lie (four if its sides are equal within a thousandth) the one with the smallest turn wins, a
/// tie goes counter-clockwise. Cost: linear, with a sort of the shadow's outermost points.
pub fn place(
    mesh: &Mesh,
    soundness: &Soundness,
    options: &PlaceOptions,
) -> Result<Placement, PlaceError> {
    let m = measure(mesh, soundness);
    if !(m.area > 0.0 && m.area.is_finite()) {
        return Err(PlaceError::NoArea);
    }
    let mut notes = Vec::new();
    let open = !soundness.closed && m.normal.norm() >= DECIDED;
    let mut turn = match options.up {
        Up::Auto if open => upright(&m.normal),
        Up::Auto => Matrix3::identity(),
        Up::Axis(axis, sign) => upright(&axis_vector(axis, sign)),
    };
    let (mut long, mut short, mut angle) = rectangle(mesh, &turn);
    if options.up == Up::Auto && open {
        let equal = long - short <= 1e-3 * long;
        let spin = about_vertical(smallest_turn(angle, equal));
        turn = spin * turn;
        (long, short, angle) = rectangle(mesh, &turn);
    }
    notes_on(&mut notes, mesh, soundness, options, &m, &turn, open);

    let turned = turned(mesh, &turn);
    let b = turned.bounds();
    let shift = match options.origin {
        Origin::Part => Vector::zeros(),
        Origin::TopLeft => Vector::new(-b.min.x, -b.min.y, -b.max.z),
        Origin::TopCenter => Vector::new(-b.center().x, -b.center().y, -b.max.z),
    };
    let placed = if shift == Vector::zeros() {
        turned
    } else {
        Mesh {
            triangles: turned
                .triangles
                .iter()
                .map(|t| t.map(|p| p + shift))
                .collect(),
        }
    };
    let rotation = if turn == Matrix3::identity() {
        UnitQuaternion::identity()
    } else {
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn))
    };
    Ok(Placement {
        mesh: placed,
        work_from_part: Isometry3::from_parts(Translation3::from(shift), rotation),
        frame: Frame {
            normal: m.normal,
            centroid: m.centroid,
            rectangle: [long, short],
            angle,
        },
        closed: soundness.closed,
        reachable_share: m.reachable,
        notes,
    })
}

struct Measured {
    area: f64,
    normal: Vector,
    centroid: Point,
    reachable: [(&'static str, f64); 6],
    flipped_area: f64,
}

const AXES: [(&str, Axis, Sign); 6] = [
    ("+x", Axis::X, Sign::Plus),
    ("-x", Axis::X, Sign::Minus),
    ("+y", Axis::Y, Sign::Plus),
    ("-y", Axis::Y, Sign::Minus),
    ("+z", Axis::Z, Sign::Plus),
    ("-z", Axis::Z, Sign::Minus),
];

fn axis_vector(axis: Axis, sign: Sign) -> Vector {
    let v = match axis {
        Axis::X => Vector::x(),
        Axis::Y => Vector::y(),
        Axis::Z => Vector::z(),
    };
    match sign {
        Sign::Plus => v,
        Sign::Minus => -v,
    }
}

/// Twice the area along the outward normal, with flipped facets and inside-out solids put right.
fn outward<'a>(
    mesh: &'a Mesh,
    soundness: &'a Soundness,
) -> impl Iterator<Item = (&'a [Point; 3], Vector, bool)> {
    let mut flipped = soundness.flipped.iter().copied().peekable();
    mesh.triangles.iter().enumerate().map(move |(i, t)| {
        let turned = flipped.next_if_eq(&(i as u32)).is_some();
        let d = Mesh::doubled_area_vector(t);
        let d = if turned != soundness.inside_out {
            -d
        } else {
            d
        };
        (t, d, turned)
    })
}

fn measure(mesh: &Mesh, soundness: &Soundness) -> Measured {
    let mut area = 0.0;
    let mut normal = Vector::zeros();
    let mut moment = Vector::zeros();
    let mut flipped_area = 0.0;
    let mut seen = [0.0; 6];
    let base = mesh.bounds().center();
    for (t, d, turned) in outward(mesh, soundness) {
        let a = d.norm();
        area += a;
        normal += d;
        moment += ((t[0] - base) + (t[1] - base) + (t[2] - base)) * (a / 3.0);
        if turned {
            flipped_area += a;
        }
        for (s, (_, axis, sign)) in seen.iter_mut().zip(AXES) {
            if a > 0.0 && d.dot(&axis_vector(axis, sign)) >= -SNAP * a {
                *s += a;
            }
        }
    }
    let mut reachable = AXES.map(|(name, ..)| (name, 0.0));
    for (r, s) in reachable.iter_mut().zip(seen) {
        r.1 = s / area;
    }
    Measured {
        area: 0.5 * area,
        normal: normal / area,
        centroid: base + moment / area,
        reachable,
        flipped_area: flipped_area / area,
    }
}

/// The smallest turn that brings a direction to +Z; half a turn about X for -Z. Within [`SNAP`] of an axis it is exact.
fn upright(direction: &Vector) -> Matrix3<f64> {
    let n = direction.normalize();
    for (_, axis, sign) in AXES {
        if (n - axis_vector(axis, sign)).norm() <= SNAP {
            let s = if sign == Sign::Plus { 1.0 } else { -1.0 };
            return match (axis, sign) {
                (Axis::X, _) => Matrix3::new(0.0, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, 0.0),
                (Axis::Y, _) => Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -s, 0.0, s, 0.0),
                (Axis::Z, Sign::Plus) => Matrix3::identity(),
                (Axis::Z, Sign::Minus) => Matrix3::from_diagonal(&Vector::new(1.0, -1.0, -1.0)),
            };
        }
    }
    // About the horizontal axis n x z; n is not -z here.
    Rotation3::rotation_between(&n, &Vector::z()).map_or_else(Matrix3::identity, |r| *r.matrix())
}

/// A turn about Z, exact for quarter turns.
fn about_vertical(angle: f64) -> Matrix3<f64> {
    let quarters = angle / FRAC_PI_2;
    let (s, c) = if (quarters - quarters.round()).abs() * FRAC_PI_2 <= SNAP {
        match quarters.round() as i64 {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            -1 => (-1.0, 0.0),
            _ => (0.0, -1.0),
        }
    } else {
        angle.sin_cos()
    };
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// The turn that lays the long side along X (either side along X when they are equal), in (-pi/2, pi/2] or (-pi/4, pi/4].
fn smallest_turn(angle: f64, equal_sides: bool) -> f64 {
    let (period, half) = if equal_sides {
        (FRAC_PI_2, FRAC_PI_4)
    } else {
        (PI, FRAC_PI_2)
    };
    let turn = -angle - period * (-angle / period).round();
    // A tie, within rounding, goes counter-clockwise.
    if turn <= -half + SNAP {
        turn + period
    } else {
        turn
    }
}

fn turned(mesh: &Mesh, turn: &Matrix3<f64>) -> Mesh {
    if *turn == Matrix3::identity() {
        return mesh.clone();
    }
    Mesh {
        triangles: mesh
            .triangles
            .iter()
            .map(|t| t.map(|p| Point::from(turn * p.coords)))
            .collect(),
    }
}

/// Long side, short side, and direction of the long side of the smallest rectangle around the shadow.
fn rectangle(mesh: &Mesh, turn: &Matrix3<f64>) -> (f64, f64, f64) {
    let shadow = |p: &Point| xy(&Point::from(turn * p.coords));
    let hull = convex_hull(mesh.triangles.iter().flatten().map(shadow));
    smallest_rectangle(&hull)
}

fn notes_on(
    notes: &mut Vec<String>,
    mesh: &Mesh,
    soundness: &Soundness,
    options: &PlaceOptions,
    m: &Measured,
    turn: &Matrix3<f64>,
    open: bool,
) {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    if options.up == Up::Auto && !open {
        let mut best = m.reachable[4];
        for r in m.reachable {
            if r.1 > best.1 + 1e-3 {
                best = r;
            }
        }
        let why = if soundness.closed {
            "a closed solid has no mean normal"
        } else {
            "the part is nearly closed, so its mean normal decides nothing"
        };
        let mut note = format!(
            "{why}: the file's +z stays up; {} of the area faces it or stands upright",
            percent(m.reachable[4].1)
        );
        if best.0 != "+z" {
            note.push_str(&format!(
                "; most faces {} ({}): set the up axis to that to mill from there",
                best.0,
                percent(best.1)
            ));
        }
        notes.push(note);
    }
    if soundness.flipped_facets > 0 {
        notes.push(format!(
            "{} of {} facets ({} of the area) are wound against their neighbours: the majority decides which side is outside",
            soundness.flipped_facets,
            soundness.triangles,
            percent(m.flipped_area)
        ));
    }
    if soundness.inside_out {
        notes.push(
            "the solid is inside out: its facets are taken to face the other way".to_string(),
        );
    }
    if soundness.closed || !open {
        return;
    }
    // What faces away: a sheet seen from behind, windings that no neighbour could put right, or overhangs.
    let up = turn.transpose() * Vector::z();
    let mut away = 0.0;
    for (_, d, _) in outward(mesh, soundness) {
        if d.dot(&up) < -SNAP * d.norm() {
            away += 0.5 * d.norm();
        }
    }
    let share = away / m.area;
    if m.normal.dot(&up) < 0.0 {
        notes.push(format!(
            "by its winding the surface faces away from the tool ({} of the area): it is milled as it lies; if this is the wrong \
             side, turn the up axis round",
            percent(share)
        ));
    } else if share > 0.01 {
        notes.push(format!(
            "{} of the area faces away from the tool: overhangs, or facets wound the wrong way",
            percent(share)
        ));
    }
}

#[cfg(test)]
#[path = "frame_tests.rs"]
mod tests;
