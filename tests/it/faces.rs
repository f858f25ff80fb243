//! Parts with upright walls, cut face by face.
#![allow(clippy::unwrap_used)]

use super::morse::options;
use super::plans::{R, links, machine};
use morsemill::geom::Point;
use morsemill::kinematics::Settings;
use morsemill::part::Mesh;
use morsemill::reach::DropCutter;
use morsemill::toolpath::plan::{Plan, Strategy, plan, survey};
use morsemill::toolpath::{Layout, MoveKind, Toolpath};
use morsemill::units::MmPerMin;
use morsemill::weigh::weigh;

/// A plate of 36 mm on a gentle slope with a boss of 14 mm that stands 5 mm over it, off its middle, turned by `angle` about it; walls upright.
fn boss(angle: f64) -> Mesh {
    let (s, c) = angle.sin_cos();
    let base = |x: f64, y: f64| 2.0 + 0.04 * x + 0.02 * y;
    let at = |q: [f64; 2], lift: f64| {
        let (x, y) = (q[0] * c - q[1] * s, q[0] * s + q[1] * c);
        Point::new(18.0 + x, 18.0 + y, base(x, y) + lift)
    };
    let (inner, outer) = ([[-8.0, -6.0], [6.0, -6.0], [6.0, 8.0], [-8.0, 8.0]], 18.0);
    let corners = [
        [-outer, -outer],
        [outer, -outer],
        [outer, outer],
        [-outer, outer],
    ];
    let mut triangles = Vec::new();
    let mut quad = |p: [Point; 4]| {
        triangles.push([p[0], p[1], p[2]]);
        triangles.push([p[0], p[2], p[3]]);
    };
    for k in 0..4 {
        let l = (k + 1) % 4;
        quad([
            at(corners[k], 0.0),
            at(corners[l], 0.0),
            at(inner[l], 0.0),
            at(inner[k], 0.0),
        ]);
        quad([
            at(inner[k], 0.0),
            at(inner[l], 0.0),
            at(inner[l], 5.0),
            at(inner[k], 5.0),
        ]);
    }
    quad(inner.map(|q| at(q, 5.0)));
    Mesh { triangles }
}

fn laid(mesh: &Mesh, scallop: f64) -> Plan {
    let mut how = options(scallop);
    how.strategy = Strategy::Auto;
    let cutter = DropCutter::new(mesh, R);
    let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
    let settings = Settings::from(&machine());
    let clock = |path: &Toolpath| weigh(path, &settings, MmPerMin(1500.0), MmPerMin(500.0));
    let top = mesh.bounds().max.z;
    plan(mesh, &ground, &how, &links(top), &clock, &mut |_| {}).0
}

/// Face by face, whichever way the boss is turned: quicker than the whole part in one, hardly a retract, and most of the time cutting.
#[test]
fn a_boss_is_cut_face_by_face() {
    for angle in [0.0, 0.646] {
        let plan = laid(&boss(angle), 0.04);
        assert_eq!(plan.layout, Layout::Faces, "{angle}");
        assert_eq!(plan.regions.features.len(), 2);
        let f = &plan.figures;
        let whole = &plan.candidates[0].figures;
        assert!(f.time_s < 0.85 * whole.time_s, "{f:?} {whole:?}");
        let retracts = plan
            .toolpath
            .moves
            .iter()
            .filter(|m| m.kind == MoveKind::Retract)
            .count();
        assert!(retracts <= 3, "{retracts}");
        let idle = (f.link_s + f.air_s) / f.time_s;
        assert!(idle < 0.16, "{idle}");
    }
}
