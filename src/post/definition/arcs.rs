//! Which arcs a controller takes.

use crate::geom::{Plane, Point};
use crate::units::Mm;
use std::f64::consts::{PI, TAU};

/// How an arc's circle is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// By its centre, as I, J, K from the start of the arc.
    FromStart,
    /// By its centre, as I, J, K in work coordinates (G90.1).
    Absolute,
    /// By its radius: the word before it (`R`, `CR=`). Only arcs of a third of a circle and less are written so: beyond that the
    /// rounding of the radius moves the centre too far.
    Radius(&'static str),
}

/// Which arcs a controller takes. None at all when no plane is true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arcs {
    /// G17, G18, G19.
    pub planes: [bool; 3],
    /// How the circle is said.
    pub form: Form,
    /// An arc may end where it starts.
    pub full_circles: bool,
    /// An arc may move along its plane's normal.
    pub helices: bool,
    /// Smallest and largest radius.
    pub radius: [Mm; 2],
    /// Arcs whose ends are closer are not written as arcs.
    pub shortest_chord: Mm,
}

/// An arc as it will be judged: lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Its plane.
    pub plane: Plane,
    /// Signed turn, rad.
    pub sweep: f64,
    /// Its radius at the start.
    pub radius: f64,
    /// Distance of its ends in the plane.
    pub chord: f64,
    /// It moves along the normal.
    pub helix: bool,
}

/// What is wrong with an arc, if anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// The controller takes it.
    Good,
    /// It turns too far at once; parts of it would do.
    TurnsTooFar,
    /// No part of it will do.
    Never,
}

impl Shape {
    /// The shape of an arc from `from` to `to` about `center`.
    pub fn new(plane: Plane, from: &Point, to: &Point, center: &Point, sweep: f64) -> Shape {
        let [u, v, w] = plane.axes();
        let flat = |a: &Point, b: &Point| (a[u] - b[u]).hypot(a[v] - b[v]);
        Shape {
            plane,
            sweep,
            radius: flat(from, center),
            chord: flat(from, to),
            helix: (to[w] - from[w]).abs() > 1e-9,
        }
    }
}

impl Arcs {
    /// No arcs at all.
    pub const NONE: Arcs = Arcs {
        planes: [false; 3],
        form: Form::FromStart,
        full_circles: false,
        helices: false,
        radius: [Mm(0.0), Mm(f64::INFINITY)],
        shortest_chord: Mm(0.0),
    };

    /// True when arcs of this plane may be written.
    pub fn has(&self, plane: Plane) -> bool {
        self.planes[match plane {
            Plane::Xy => 0,
            Plane::Zx => 1,
            Plane::Yz => 2,
        }]
    }

    /// The furthest that one arc may turn, rad.
    pub fn most_turn(&self) -> f64 {
        match (self.form, self.full_circles) {
            (Form::Radius(_), _) => TAU / 3.0,
            (_, true) => TAU,
            // A controller without full circles takes what is nearly one, but not safely.
            (_, false) => 1.5 * PI,
        }
    }

    /// Whether the controller takes an arc.
    pub fn fit(&self, s: &Shape) -> Fit {
        let far = s.sweep.abs() > self.most_turn() * (1.0 + 1e-9);
        let short = s.sweep.abs() < PI && s.chord < self.shortest_chord.0;
        let size = s.radius >= self.radius[0].0 && s.radius <= self.radius[1].0;
        match self.has(s.plane) && (self.helices || !s.helix) && size && !short {
            false => Fit::Never,
            true if far => Fit::TurnsTooFar,
            true => Fit::Good,
        }
    }

    /// An arc in words, and what this controller takes instead.
    pub fn complaint(&self, s: &Shape) -> (String, String) {
        let plane = |p: Plane| match p {
            Plane::Xy => "XY",
            Plane::Zx => "ZX",
            Plane::Yz => "YZ",
        };
        let what = format!(
            "it is {} of {:.1} degrees with radius {:.4} mm in plane {}",
            if s.helix { "a helix" } else { "an arc" },
            s.sweep.to_degrees(),
            s.radius,
            plane(s.plane),
        );
        let planes: Vec<&str> = [Plane::Xy, Plane::Zx, Plane::Yz]
            .into_iter()
            .filter(|p| self.has(*p))
            .map(plane)
            .collect();
        let takes = match planes.is_empty() {
            true => "none".to_string(),
            false => format!(
                "arcs of up to {:.0} degrees and radii of {} to {} mm in {}, {}",
                self.most_turn().to_degrees(),
                self.radius[0].0,
                self.radius[1].0,
                planes.join(", "),
                if self.helices {
                    "helices too"
                } else {
                    "no helices"
                },
            ),
        };
        (what, takes)
    }
}
