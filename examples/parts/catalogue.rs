//! The shipped test parts: what they are, and their files' bytes. Shared by the generator and the test of the committed files.

pub mod surface;

use serde_json::{Value, json};
use surface::{Kind, Sheet, Surface, Term};

/// A file of this folder.
pub struct File {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// Largest sheet whose binary STL stays below a megabyte.
const MOST: usize = 19_600;

struct Part {
    name: &'static str,
    what: &'static str,
    surface: Surface,
    make: Make,
}

#[derive(Clone, Copy, PartialEq)]
enum Make {
    Sheet,
    Solid,
    Soup,
    Obj,
}

fn parts() -> Vec<Part> {
    use Term::{Bell, Dome, Level, Mesa, Ripple, Tilt};
    let part = |name, what, make, width, depth, terms: &[Term]| Part {
        name,
        what,
        surface: Surface {
            width,
            depth,
            terms: terms.to_vec(),
        },
        make,
    };
    vec![
        part(
            "two-peaks",
            "open sheet, two peaks on a dome: the plainest case",
            Make::Sheet,
            60.0,
            60.0,
            &[
                Level(12.0),
                Dome(0.0021),
                Bell(10.5, [16.5, 25.0], [10.5, 9.5], 30.0),
                Bell(8.5, [44.0, 36.5], [8.5, 10.0], -20.0),
            ],
        ),
        part(
            "peaks-and-pits",
            "open sheet, several peaks and pits",
            Make::Sheet,
            64.0,
            58.0,
            &[
                Level(10.0),
                Dome(0.0009),
                Tilt(0.012, -0.02),
                Bell(6.0, [13.0, 14.0], [7.5, 6.8], 15.0),
                Bell(5.2, [49.5, 12.5], [7.2, 8.4], -25.0),
                Bell(6.6, [15.5, 44.0], [7.8, 7.0], 40.0),
                Bell(5.6, [50.5, 45.5], [8.2, 7.0], 10.0),
                Bell(3.6, [32.5, 29.5], [5.8, 6.4], 0.0),
                Bell(-4.2, [31.5, 12.0], [5.6, 7.0], 8.0),
                Bell(-4.6, [33.0, 47.0], [6.2, 6.6], -30.0),
            ],
        ),
        part(
            "steep-relief",
            "open sheet, flanks to 70 degrees, sharp tops; a 6 mm ball fits everywhere",
            Make::Sheet,
            56.0,
            56.0,
            &[
                Level(4.0),
                Dome(0.0008),
                Bell(36.6, [20.0, 34.5], [8.4, 8.2], 20.0),
                Bell(8.0, [43.0, 14.0], [9.0, 9.5], -35.0),
            ],
        ),
        part(
            "walled-boss",
            "closed solid, upright walls down to z = 0, freeform top",
            Make::Solid,
            56.0,
            56.0,
            &[
                Level(18.0),
                Dome(0.0016),
                Tilt(0.014, 0.009),
                Mesa(3.4, [18.0, 37.0], [12.5, 11.0], 25.0),
                Bell(4.2, [40.5, 18.5], [8.5, 9.5], -20.0),
                Bell(-2.8, [21.0, 17.0], [8.0, 7.0], 10.0),
            ],
        ),
        part(
            "noisy-soup",
            "open sheet as scanners make them: noise, holes, flipped and double facets, slivers, no order",
            Make::Soup,
            60.0,
            60.0,
            &[
                Level(9.0),
                Dome(0.0018),
                Tilt(-0.015, 0.022),
                Bell(6.5, [19.0, 39.0], [11.0, 9.5], 25.0),
                Bell(5.5, [42.0, 20.5], [9.5, 10.5], 15.0),
            ],
        ),
        part(
            "wave",
            "open sheet, an egg box",
            Make::Obj,
            60.0,
            60.0,
            &[Level(6.0), Ripple(3.2, [46.0, 49.0]), Tilt(0.01, 0.02)],
        ),
    ]
}

/// All files of this folder that are made rather than written.
pub fn files() -> Vec<File> {
    let mut files = Vec::new();
    let mut rows = String::new();
    for part in parts() {
        let most = match part.make {
            Make::Soup => 14_000,
            Make::Solid => 18_000,
            _ => MOST,
        };
        let (sheet, tolerance) = part.surface.finest_sheet(most);
        let mut json = describe(&part, tolerance);
        let (ending, bytes) = match part.make {
            Make::Sheet => ("stl", stl(&sheet.corners())),
            Make::Solid => ("stl", stl(&sheet.closed().corners())),
            Make::Obj => ("obj", obj(&sheet)),
            Make::Soup => {
                let (triangles, faults) = soup(&part.surface, &sheet);
                json["soup"] = faults;
                ("stl", stl(&triangles))
            }
        };
        let triangles = match part.make {
            Make::Obj => bytes
                .split(|b| *b == b'\n')
                .filter(|l| l.starts_with(b"f "))
                .count(),
            _ => (bytes.len() - 84) / 50,
        };
        json["triangles"] = json!(triangles);
        let file = format!("{}.{ending}", part.name);
        let c = &json["counts"];
        rows.push_str(&format!(
            "| `{file}` | {} | {} x {} | {triangles} | {} / {} / {} | {} | {} | {} | {} |\n",
            part.what,
            part.surface.width,
            part.surface.depth,
            c["max"],
            c["min"],
            c["saddle"],
            json["max_slope_deg"],
            json["min_convex_radius"],
            json["min_concave_radius"],
            json["chord_error_um"],
        ));
        let mut text = serde_json::to_string_pretty(&json).unwrap_or_default();
        text.push('\n');
        files.push(File { name: file, bytes });
        files.push(File {
            name: format!("{}.json", part.name),
            bytes: text.into_bytes(),
        });
    }
    files.push(File {
        name: "README.md".to_string(),
        bytes: README.replace("ROWS\n", &rows).into_bytes(),
    });
    files
}

/// The file's truth: terms, critical points and bounds of the analytic surface.
fn describe(part: &Part, tolerance: f64) -> Value {
    let s = &part.surface;
    let round = |v: f64, digits: i32| {
        let p = 10f64.powi(digits);
        (v * p).round() / p
    };
    let critical = s.critical_points();
    let count = |kind| critical.iter().filter(|c| c.kind == kind).count();
    let (mut low, mut high, mut slope2, mut convex, mut concave) =
        (f64::MAX, f64::MIN, 0.0f64, 1e-9f64, 1e-9f64);
    for j in 0..=600 {
        for i in 0..=600 {
            let jet = s.jet(
                s.width * f64::from(i) / 600.0,
                s.depth * f64::from(j) / 600.0,
            );
            let k = jet.curvatures();
            low = low.min(jet.z);
            high = high.max(jet.z);
            slope2 = slope2.max(jet.slope2());
            concave = concave.max(-k[0]);
            convex = convex.max(k[1]);
        }
    }
    let term = |t: &Term| match *t {
        Term::Level(c) => json!(["level", c]),
        Term::Tilt(a, b) => json!(["tilt", a, b]),
        Term::Dome(k) => json!(["dome", k]),
        Term::Bell(h, at, size, turn) => json!(["bell", h, at, size, turn]),
        Term::Mesa(h, at, size, turn) => json!(["mesa", h, at, size, turn]),
        Term::Ripple(h, l) => json!(["ripple", h, l]),
    };
    let name = |kind| match kind {
        Kind::Max => "max",
        Kind::Min => "min",
        Kind::Saddle => "saddle",
    };
    json!({
        "name": part.name,
        "note": part.what,
        "units": "mm",
        "width": s.width,
        "height": s.depth,
        "closed": part.make == Make::Solid,
        "terms": s.terms.iter().map(term).collect::<Vec<_>>(),
        "z_min": round(low, 4),
        "z_max": round(high, 4),
        "max_slope_deg": round(slope2.sqrt().atan().to_degrees(), 1),
        "min_convex_radius": round(1.0 / convex, 1),
        "min_concave_radius": round(1.0 / concave, 1),
        "chord_error_um": round(1e3 * tolerance, 1),
        "counts": {"max": count(Kind::Max), "min": count(Kind::Min), "saddle": count(Kind::Saddle)},
        "critical_points": critical.iter().map(|c| json!({
            "type": name(c.kind), "where": c.place, "x": round(c.x, 5), "y": round(c.y, 5), "z": round(c.z, 5),
        })).collect::<Vec<_>>(),
    })
}

fn stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = b"morsemill test part, mm".to_vec();
    out.resize(80, b' ');
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        let p = t.map(|c| c.map(f64::from));
        let [u, v] = [1, 2].map(|k| [0, 1, 2].map(|i| p[k][i] - p[0][i]));
        let n = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        for c in n {
            out.extend(((if length > 0.0 { c / length } else { 0.0 }) as f32).to_le_bytes());
        }
        t.iter().flatten().for_each(|c| out.extend(c.to_le_bytes()));
        out.extend([0u8; 2]);
    }
    out
}

fn obj(sheet: &Sheet) -> Vec<u8> {
    let mut out = String::from("# morsemill test part, mm\no wave\n");
    for p in &sheet.points {
        out.push_str(&format!("v {:.4} {:.4} {:.5}\n", p[0], p[1], p[2]));
    }
    for t in &sheet.triangles {
        out.push_str(&format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    }
    out.into_bytes()
}

/// A small generator of chance (a 64-bit multiplicative congruential one, upper bits), the same on every machine.
struct Chance(u64);

impl Chance {
    /// Evenly from 0 to below 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

/// What a scanner and three converters leave of a good sheet.
fn soup(surface: &Surface, sheet: &Sheet) -> (Vec<[[f32; 3]; 3]>, Value) {
    let mut chance = Chance(2026);
    let mut sheet = sheet.clone();
    for p in &mut sheet.points {
        p[2] += 0.005 * (2.0 * chance.next() - 1.0);
    }
    let mut triangles = sheet.corners();
    // Holes of a few facets, on slopes: on level ground the ball would find a pit in them that the part does not have.
    let mut holes = 0;
    while holes < 8 {
        let at = triangles[chance.below(triangles.len())][0].map(f64::from);
        let [x, y, _] = at;
        let inside = x > 8.0 && x < surface.width - 8.0 && y > 8.0 && y < surface.depth - 8.0;
        if inside && surface.jet(x, y).slope2().sqrt() > 0.35 {
            triangles.retain(|t| !t.iter().any(|c| c.map(f64::from) == at));
            holes += 1;
        }
    }
    let (mut flipped, mut doubled, mut slivers) = (0, 0, 0);
    for k in 0..triangles.len() {
        let t = triangles[k];
        let dice = chance.next();
        if dice < 0.05 {
            triangles[k].swap(0, 1);
            flipped += 1;
        } else if dice < 0.06 {
            triangles.push([t[1], t[2], t[0]]);
            doubled += 1;
        } else if dice < 0.065 {
            triangles.push([t[0], t[1], t[0]]);
            slivers += 1;
        }
    }
    for k in (1..triangles.len()).rev() {
        let other = chance.below(k + 1);
        triangles.swap(k, other);
    }
    let faults = json!({
        "noise_um": 5, "holes": holes, "flipped": flipped, "duplicates": doubled, "degenerate": slivers,
    });
    (triangles, faults)
}

const README: &str = "\
# Test parts

Made by `cargo run --release --example make_parts` (source: `surface.rs`, `catalogue.rs` in this folder); a test checks that the
committed files equal what it makes, byte for byte. Do not edit them by hand.

Each part is an analytic height field z = f(x, y) over a rectangle, in mm, cut into right triangles that are halved wherever the
surface bends, so that every file stays below 1 MB. Beside it, NAME.json has the terms of the surface, its bounds and its critical
points: inside by Newton's method on grad f = 0; on the border by the rule that a point is a minimum if all of the part near it is higher
(along the border a minimum, and falling outwards), likewise a maximum.

| file | what | size, mm | triangles | max / min / saddle | slope, deg | convex radius, mm | concave radius, mm | chord error, um |
|---|---|---|---|---|---|---|---|---|
ROWS

Slope is the steepest, radii are the smallest, and the chord error is the largest distance from the middle of an edge to the analytic
surface, before any noise.

`noisy-soup.stl` is the sheet after 5 um of noise in z, eight holes, 5 % flipped facets, 1 % doubled, 0.5 % without area, and a shuffle; the
counts are in its JSON. Its critical points are those of the surface without noise.
";
