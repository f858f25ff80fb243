//! What the tests of laws share: the shipped parts with their truth, balls against triangles by brute force, and numbers by chance
//! from a printed seed. The geometry here is written anew on purpose: it must not share a mistake with what it judges.
#![allow(dead_code, clippy::unwrap_used)]

pub use super::chance::Chance;
use morsemill::geom::{Point, Point2, Vector};
use morsemill::part::{Mesh, Units, load};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

/// A shipped part: its file, and whether it is smooth (its finish must be perfect) or a scan with noise.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    pub file: &'static str,
    pub smooth: bool,
}

pub const PARTS: [Shipped; 6] = [
    Shipped {
        file: "two-peaks.stl",
        smooth: true,
    },
    Shipped {
        file: "peaks-and-pits.stl",
        smooth: true,
    },
    Shipped {
        file: "steep-relief.stl",
        smooth: true,
    },
    Shipped {
        file: "walled-boss.stl",
        smooth: true,
    },
    Shipped {
        file: "noisy-soup.stl",
        smooth: false,
    },
    Shipped {
        file: "wave.obj",
        smooth: true,
    },
];

impl Shipped {
    pub fn path(&self) -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("examples/parts")
            .join(self.file)
    }

    pub fn mesh(&self) -> Mesh {
        load(&self.path(), Units::Mm).unwrap().mesh
    }

    /// Its analytic truth.
    pub fn truth(&self) -> serde_json::Value {
        let text = std::fs::read(self.path().with_extension("json")).unwrap();
        serde_json::from_slice(&text).unwrap()
    }
}

/// Made once for each key, by whoever asks first; others wait for that one only.
pub struct Shelf<T>(Mutex<Vec<(String, Arc<OnceLock<T>>)>>);

impl<T> Shelf<T> {
    pub const fn new() -> Self {
        Shelf(Mutex::new(Vec::new()))
    }

    pub fn get(&self, key: &str) -> Arc<OnceLock<T>> {
        let mut shelf = self.0.lock().unwrap_or_else(|e| e.into_inner());
        if let Some((_, cell)) = shelf.iter().find(|(k, _)| k == key) {
            return cell.clone();
        }
        let cell = Arc::new(OnceLock::new());
        shelf.push((key.to_string(), cell.clone()));
        cell
    }
}

/// Triangles of all sizes and attitudes in a box.
pub fn soup(seed: u64, triangles: usize) -> Mesh {
    let mut c = Chance(seed);
    let mut mesh = Mesh::default();
    for _ in 0..triangles {
        let at = Vector::new(
            c.between(-9.0, 9.0),
            c.between(-9.0, 9.0),
            c.between(-3.0, 3.0),
        );
        let size = c.between(0.2, 4.0);
        let mut corner = || {
            Point::from(
                at + Vector::new(
                    c.between(-size, size),
                    c.between(-size, size),
                    c.between(-size, size),
                ),
            )
        };
        let t = [corner(), corner(), corner()];
        mesh.triangles.push(t);
    }
    mesh
}

/// The sheet z = f(x, y) over a rectangle, two triangles a cell.
pub fn sheet(min: [f64; 2], max: [f64; 2], cells: [usize; 2], z: impl Fn(f64, f64) -> f64) -> Mesh {
    let at = |i: usize, j: usize| {
        let x = min[0] + (max[0] - min[0]) * i as f64 / cells[0] as f64;
        let y = min[1] + (max[1] - min[1]) * j as f64 / cells[1] as f64;
        Point::new(x, y, z(x, y))
    };
    let mut mesh = Mesh::default();
    for j in 0..cells[1] {
        for i in 0..cells[0] {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([a, c, d]);
        }
    }
    mesh
}

/// A place turned about z through the origin.
pub fn turn(p: &Point, degrees: f64) -> Point {
    let (s, c) = degrees.to_radians().sin_cos();
    Point::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z)
}

/// A mesh turned about z through the origin.
pub fn turned(mesh: &Mesh, degrees: f64) -> Mesh {
    Mesh {
        triangles: mesh
            .triangles
            .iter()
            .map(|t| t.map(|p| turn(&p, degrees)))
            .collect(),
    }
}

/// A mesh with its corners moved up or down by chance, the same corner always alike. `deviation` is a standard deviation, mm.
pub fn noisy(mesh: &Mesh, deviation: f64, seed: u64) -> Mesh {
    let lift = |p: &Point| {
        let mut c = Chance(
            seed ^ p.x.to_bits().rotate_left(17) ^ p.y.to_bits().rotate_left(41) ^ p.z.to_bits(),
        );
        // Twelve even numbers make a normal one, well enough.
        (0..12).map(|_| c.between(-0.5, 0.5)).sum::<f64>() * deviation
    };
    Mesh {
        triangles: mesh
            .triangles
            .iter()
            .map(|t| t.map(|p| Point::new(p.x, p.y, p.z + lift(&p))))
            .collect(),
    }
}

/// Distance from a place to a triangle: the nearest of its inside, its sides and its corners.
pub fn distance(t: &[Point; 3], c: &Point) -> f64 {
    let to_side = |a: &Point, b: &Point| {
        let e = b - a;
        let l = e.dot(&e);
        let s = if l > 0.0 { (c - a).dot(&e) / l } else { 0.0 };
        (c - (a + e * s.clamp(0.0, 1.0))).norm()
    };
    // Barycentric coordinates of the foot of the perpendicular.
    let (u, v, w) = (t[1] - t[0], t[2] - t[0], c - t[0]);
    let (uu, uv, vv, wu, wv) = (u.dot(&u), u.dot(&v), v.dot(&v), w.dot(&u), w.dot(&v));
    let det = uu * vv - uv * uv;
    if det > 1e-12 * uu * vv {
        let (s, r) = ((vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det);
        if s >= 0.0 && r >= 0.0 && s + r <= 1.0 {
            return (w - u * s - v * r).norm();
        }
    }
    to_side(&t[0], &t[1])
        .min(to_side(&t[1], &t[2]))
        .min(to_side(&t[2], &t[0]))
}

/// All triangles of a part, sorted into squares of the plan, so that every one near a ball is looked at.
pub struct Brute {
    triangles: Vec<[Point; 3]>,
    boxes: Vec<[f64; 6]>,
    min: Point2,
    size: [usize; 2],
    square: f64,
    lists: Vec<Vec<u32>>,
}

impl Brute {
    pub fn new(mesh: &Mesh) -> Brute {
        let b = mesh.bounds();
        let square = (b.size().x.max(b.size().y) / 200.0).max(0.3);
        let size = [0, 1].map(|k| (b.size()[k] / square) as usize + 1);
        let mut lists = vec![Vec::new(); size[0] * size[1]];
        let mut boxes = Vec::new();
        for (i, t) in mesh.triangles.iter().enumerate() {
            let of = |k: usize| {
                let v = [t[0][k], t[1][k], t[2][k]];
                (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]))
            };
            let (x, y, z) = (of(0), of(1), of(2));
            boxes.push([x.0, x.1, y.0, y.1, z.0, z.1]);
            let cell = |v: f64, lo: f64, n: usize| (((v - lo) / square) as usize).min(n - 1);
            for j in cell(y.0, b.min.y, size[1])..=cell(y.1, b.min.y, size[1]) {
                for k in cell(x.0, b.min.x, size[0])..=cell(x.1, b.min.x, size[0]) {
                    lists[j * size[0] + k].push(i as u32);
                }
            }
        }
        Brute {
            triangles: mesh.triangles.clone(),
            boxes,
            min: Point2::new(b.min.x, b.min.y),
            size,
            square,
            lists,
        }
    }

    /// How deep a ball enters the part, mm: its radius less the distance from its centre to the nearest point of any triangle; zero
    /// or less when it does not.
    pub fn depth(&self, c: &Point, radius: f64) -> f64 {
        let mut nearest = f64::INFINITY;
        let range = |v: f64, lo: f64, n: usize| {
            let f = |w: f64| ((w - lo) / self.square).floor().clamp(0.0, n as f64 - 1.0) as usize;
            f(v - radius)..=f(v + radius)
        };
        for j in range(c.y, self.min.y, self.size[1]) {
            for i in range(c.x, self.min.x, self.size[0]) {
                for &k in &self.lists[j * self.size[0] + i] {
                    let b = &self.boxes[k as usize];
                    let off = |lo: f64, hi: f64, v: f64| (lo - v).max(v - hi).max(0.0);
                    let (x, y, z) = (
                        off(b[0], b[1], c.x),
                        off(b[2], b[3], c.y),
                        off(b[4], b[5], c.z),
                    );
                    if x * x + y * y + z * z < nearest.min(radius).powi(2) {
                        nearest = nearest.min(distance(&self.triangles[k as usize], c));
                    }
                }
            }
        }
        radius - nearest.min(radius)
    }
}

/// Places along a straight line, no farther apart than `gap`, ends included.
pub fn along(a: &Point, b: &Point, gap: f64) -> impl Iterator<Item = Point> + use<> {
    let n = ((b - a).norm() / gap).ceil().max(1.0) as usize;
    let (a, e) = (*a, b - a);
    (0..=n).map(move |k| a + e * (k as f64 / n as f64))
}
