//! Analytic test surfaces z = f(x, y), their critical points, and triangles for them. Shared by the generator
//! (`examples/make_parts.rs`) and the test that compares the committed files with it.
//!
//! Only + - * / and sqrt touch a number here: `exp`, `sin` and `cos` are spelled out below, so that every machine makes the
//! same bytes. Frame: x from 0 to width, y from 0 to depth, z up, mm.

/// One addend of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// A constant height.
    Level(f64),
    /// A slope: `a (x - cx) + b (y - cy)` about the middle.
    Tilt(f64, f64),
    /// Sinking corners: `-k r^2` about the middle, k in 1/mm.
    Dome(f64),
    /// A bell (a pit if the height is negative): height, place, two widths, turn in degrees.
    Bell(f64, [f64; 2], [f64; 2], f64),
    /// The same with a flat top: exp(-q^2 / 2) instead of exp(-q / 2).
    Mesa(f64, [f64; 2], [f64; 2], f64),
    /// `h cos(2 pi x / lx) cos(2 pi y / ly)`, x and y from the middle.
    Ripple(f64, [f64; 2]),
}

/// Height and derivatives at a place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Jet {
    pub z: f64,
    pub x: f64,
    pub y: f64,
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
}

impl Jet {
    pub fn slope2(&self) -> f64 {
        self.x * self.x + self.y * self.y
    }

    /// Principal curvatures, 1/mm, smaller first; positive where the ground is convex.
    pub fn curvatures(&self) -> [f64; 2] {
        let w2 = 1.0 + self.slope2();
        let w = w2.sqrt();
        let mean = ((1.0 + self.y * self.y) * self.xx - 2.0 * self.x * self.y * self.xy
            + (1.0 + self.x * self.x) * self.yy)
            / (2.0 * w2 * w);
        let gauss = (self.xx * self.yy - self.xy * self.xy) / (w2 * w2);
        let spread = (mean * mean - gauss).max(0.0).sqrt();
        [-mean - spread, -mean + spread]
    }
}

/// A sum of terms over a rectangle.
#[derive(Clone, Debug)]
pub struct Surface {
    pub width: f64,
    pub depth: f64,
    pub terms: Vec<Term>,
}

/// What kind of critical point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Max,
    Min,
    Saddle,
}

/// A critical point of the height over the rectangle, border included.
#[derive(Clone, Copy, Debug)]
pub struct Critical {
    pub kind: Kind,
    /// interior, edge or corner
    pub place: &'static str,
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

impl Surface {
    pub fn jet(&self, x: f64, y: f64) -> Jet {
        let mut j = Jet::default();
        let (cx, cy) = (x - self.width / 2.0, y - self.depth / 2.0);
        for term in &self.terms {
            match *term {
                Term::Level(c) => j.z += c,
                Term::Tilt(a, b) => {
                    j.z += a * cx + b * cy;
                    j.x += a;
                    j.y += b;
                }
                Term::Dome(k) => {
                    j.z -= k * (cx * cx + cy * cy);
                    j.x -= 2.0 * k * cx;
                    j.y -= 2.0 * k * cy;
                    j.xx -= 2.0 * k;
                    j.yy -= 2.0 * k;
                }
                Term::Bell(h, at, size, turn) | Term::Mesa(h, at, size, turn) => {
                    let (s, c) = sin_cos(turn * PI / 180.0);
                    let (dx, dy) = (x - at[0], y - at[1]);
                    let (u, v) = (c * dx + s * dy, c * dy - s * dx);
                    let (iu, iv) = (1.0 / (size[0] * size[0]), 1.0 / (size[1] * size[1]));
                    let q = u * u * iu + v * v * iv;
                    // g(q) and its first two derivatives by q
                    let (g, g1, g2) = match term {
                        Term::Bell(..) => {
                            let g = h * exp(-q / 2.0);
                            (g, -g / 2.0, g / 4.0)
                        }
                        _ => {
                            let g = h * exp(-q * q / 2.0);
                            (g, -q * g, (q * q - 1.0) * g)
                        }
                    };
                    let (qu, qv) = (2.0 * u * iu, 2.0 * v * iv);
                    let (fu, fv) = (g1 * qu, g1 * qv);
                    let fuu = g2 * qu * qu + 2.0 * g1 * iu;
                    let fvv = g2 * qv * qv + 2.0 * g1 * iv;
                    let fuv = g2 * qu * qv;
                    j.z += g;
                    j.x += c * fu - s * fv;
                    j.y += s * fu + c * fv;
                    j.xx += c * c * fuu - 2.0 * c * s * fuv + s * s * fvv;
                    j.xy += c * s * (fuu - fvv) + (c * c - s * s) * fuv;
                    j.yy += s * s * fuu + 2.0 * c * s * fuv + c * c * fvv;
                }
                Term::Ripple(h, length) => {
                    let (a, b) = (2.0 * PI / length[0], 2.0 * PI / length[1]);
                    let ((sx, kx), (sy, ky)) = (sin_cos(a * cx), sin_cos(b * cy));
                    j.z += h * kx * ky;
                    j.x -= h * a * sx * ky;
                    j.y -= h * b * kx * sy;
                    j.xx -= h * a * a * kx * ky;
                    j.xy += h * a * b * sx * sy;
                    j.yy -= h * b * b * kx * ky;
                }
            }
        }
        j
    }

    /// All critical points: maxima, minima, saddles, each from the most to the least extreme.
    ///
    /// Inside, the sign changes of f - f(node) round each node of a dense grid (two: regular; none: extreme; four: saddle) give a
    /// start for Newton's method on grad f = 0. On the border a point counts as a minimum if all of the rectangle near it is
    /// higher: along the border it is one, and the slope across falls outwards. Likewise maxima.
    pub fn critical_points(&self) -> Vec<Critical> {
        const N: usize = 600;
        let (w, d) = (self.width, self.depth);
        let at = |i: usize, j: usize| (w * i as f64 / N as f64, d * j as f64 / N as f64);
        let z: Vec<f64> = (0..=N)
            .flat_map(|j| (0..=N).map(move |i| (i, j)))
            .map(|(i, j)| self.jet(at(i, j).0, at(i, j).1).z)
            .collect();
        let mut found: Vec<Critical> = Vec::new();
        for j in 1..N {
            for i in 1..N {
                let higher = morsemill::geom::RING.map(|(a, b)| {
                    let (a, b) = (i64::from(a), i64::from(b));
                    let k = (j as i64 + b) as usize * (N + 1) + (i as i64 + a) as usize;
                    z[k] > z[j * (N + 1) + i]
                });
                let changes = (0..8).filter(|&k| higher[k] != higher[(k + 1) % 8]).count();
                if changes == 2 {
                    continue;
                }
                if let Some(c) = self.newton(at(i, j))
                    && found
                        .iter()
                        .all(|o| (o.x - c.x).abs() + (o.y - c.y).abs() > 0.02)
                {
                    found.push(c);
                }
            }
        }
        self.border(&mut found);
        let key = |c: &Critical| if c.kind == Kind::Max { -c.z } else { c.z };
        found.sort_by(|a, b| a.kind.cmp(&b.kind).then(key(a).total_cmp(&key(b))));
        found
    }

    fn newton(&self, start: (f64, f64)) -> Option<Critical> {
        let (mut x, mut y) = start;
        for _ in 0..40 {
            let j = self.jet(x, y);
            let det = j.xx * j.yy - j.xy * j.xy;
            if det.abs() < 1e-14 {
                return None;
            }
            x -= (j.yy * j.x - j.xy * j.y) / det;
            y -= (j.xx * j.y - j.xy * j.x) / det;
        }
        let j = self.jet(x, y);
        let inside = x > 0.0 && x < self.width && y > 0.0 && y < self.depth;
        let det = j.xx * j.yy - j.xy * j.xy;
        (inside && j.slope2() < 1e-18).then_some(Critical {
            kind: match (det < 0.0, j.xx < 0.0) {
                (true, _) => Kind::Saddle,
                (false, true) => Kind::Max,
                (false, false) => Kind::Min,
            },
            place: "interior",
            x,
            y,
            z: j.z,
        })
    }

    fn border(&self, found: &mut Vec<Critical>) {
        const N: usize = 6000;
        let (w, d) = (self.width, self.depth);
        for side in 0..4 {
            let length = if side < 2 { d } else { w };
            let place = |t: f64| match side {
                0 => (0.0, t),
                1 => (w, t),
                2 => (t, 0.0),
                _ => (t, d),
            };
            // slope along the side, and outwards across it
            let slopes = |t: f64| {
                let j = self.jet(place(t).0, place(t).1);
                match side {
                    0 => (j.y, -j.x),
                    1 => (j.y, j.x),
                    2 => (j.x, -j.y),
                    _ => (j.x, j.y),
                }
            };
            for k in 0..N {
                let (mut a, mut b) = (
                    length * k as f64 / N as f64,
                    length * (k + 1) as f64 / N as f64,
                );
                let (sa, sb) = (slopes(a).0, slopes(b).0);
                if (sa > 0.0) == (sb > 0.0) {
                    continue;
                }
                for _ in 0..60 {
                    let m = 0.5 * (a + b);
                    if (slopes(m).0 > 0.0) == (sa > 0.0) {
                        a = m
                    } else {
                        b = m
                    }
                }
                // A top along the side is a maximum only if the surface rises outwards, a bottom a minimum if it falls.
                let top = sa > 0.0;
                if top == (slopes(a).1 > 0.0) && a > 1e-6 && a < length - 1e-6 {
                    let (x, y) = place(a);
                    found.push(Critical {
                        kind: if top { Kind::Max } else { Kind::Min },
                        place: "edge",
                        x,
                        y,
                        z: self.jet(x, y).z,
                    });
                }
            }
        }
        for (x, y) in [(0.0, 0.0), (w, 0.0), (0.0, d), (w, d)] {
            let j = self.jet(x, y);
            let inward = [
                if x > 0.0 { -j.x } else { j.x },
                if y > 0.0 { -j.y } else { j.y },
            ];
            let kind = match inward.map(|s| s > 0.0) {
                [true, true] => Kind::Min,
                [false, false] => Kind::Max,
                _ => continue,
            };
            found.push(Critical {
                kind,
                place: "corner",
                x,
                y,
                z: j.z,
            });
        }
    }

    /// The finest sheet of at most `most` triangles, and its tolerance in mm (in steps of a twentieth).
    pub fn finest_sheet(&self, most: usize) -> (Sheet, f64) {
        let lattice = self.lattice();
        // Fewer triangles as the tolerance grows: halve the range of steps.
        let tolerance = |step: u32| (0..step).fold(0.0005, |t, _| t * 1.05);
        let (mut fine, mut coarse) = (0, 120);
        while coarse - fine > 1 {
            let middle = (fine + coarse) / 2;
            if lattice.cut(tolerance(middle)).triangles.len() <= most {
                coarse = middle;
            } else {
                fine = middle;
            }
        }
        (lattice.cut(tolerance(coarse)), tolerance(coarse))
    }

    fn lattice(&self) -> Lattice {
        const N: usize = LATTICE;
        let place = |i: usize, j: usize| {
            (
                self.width * i as f64 / N as f64,
                self.depth * j as f64 / N as f64,
            )
        };
        let jets: Vec<Jet> = (0..=N)
            .flat_map(|j| (0..=N).map(move |i| (i, j)))
            .map(|(i, j)| self.jet(place(i, j).0, place(i, j).1))
            .collect();
        let mut error = vec![0.0f64; jets.len()];
        // Smallest triangles first: each level's longest edges lie alternately along the axes and along diagonals.
        let mut length = 2;
        while length <= N {
            let half = length / 2;
            // Longest edges along an axis, of length `length`: their middles.
            for j in 0..=N / half {
                for i in 0..=N / half {
                    if (i + j) % 2 == 0 {
                        continue;
                    }
                    let (i, j) = (i * half, j * half);
                    // Along X when the middle is between two lattice lines in x.
                    let ends = if (i / half) % 2 == 1 {
                        [(i - half, j), (i + half, j)]
                    } else {
                        [(i, j - half), (i, j + half)]
                    };
                    let below = half as i64 / 2;
                    Lattice::settle(
                        &jets,
                        &mut error,
                        (i, j),
                        ends,
                        &[
                            (-below, -below),
                            (below, -below),
                            (-below, below),
                            (below, below),
                        ],
                    );
                }
            }
            // Longest edges along a diagonal of a square of side `length`: its middle. The diagonals alternate.
            for j in 0..N / length {
                for i in 0..N / length {
                    let (i0, j0) = (i * length, j * length);
                    let ends = if (i + j) % 2 == 0 {
                        [(i0, j0), (i0 + length, j0 + length)]
                    } else {
                        [(i0 + length, j0), (i0, j0 + length)]
                    };
                    let h = half as i64;
                    Lattice::settle(
                        &jets,
                        &mut error,
                        (i0 + half, j0 + half),
                        ends,
                        &[(-h, 0), (h, 0), (0, -h), (0, h)],
                    );
                }
            }
            length *= 2;
        }
        let points = (0..=N)
            .flat_map(|j| (0..=N).map(move |i| (i, j)))
            .zip(&jets)
            .map(|((i, j), jet)| [place(i, j).0, place(i, j).1, jet.z])
            .collect();
        Lattice {
            points,
            error,
            n: N,
        }
    }
}

/// Cells along a side of the finest lattice, a power of two.
const LATTICE: usize = 512;

/// All places a corner can have, with the error made by leaving each out.
struct Lattice {
    points: Vec<[f64; 3]>,
    error: Vec<f64>,
    n: usize,
}

impl Lattice {
    /// The error at a middle: its own, or any of those that need it.
    fn settle(
        jets: &[Jet],
        error: &mut [f64],
        middle: (usize, usize),
        ends: [(usize, usize); 2],
        below: &[(i64, i64)],
    ) {
        let row = LATTICE + 1;
        let k = middle.1 * row + middle.0;
        let [a, b] = ends.map(|(i, j)| jets[j * row + i].z);
        let m = &jets[k];
        let mut e = (m.z - 0.5 * (a + b)).abs() / (1.0 + m.slope2()).sqrt();
        for &(di, dj) in below {
            let (i, j) = (middle.0 as i64 + di, middle.1 as i64 + dj);
            if (di, dj) != (0, 0) && (0..row as i64).contains(&i) && (0..row as i64).contains(&j) {
                e = e.max(error[j as usize * row + i as usize]);
            }
        }
        error[k] = error[k].max(e);
    }

    /// Triangles over the rectangle, finer where the surface bends: right triangles halved until no edge's middle is farther
    /// than `tolerance` (mm, across the surface) from its chord, never with a corner on another's edge.
    ///
    /// ```text
    ///   c                 halving: m is the middle of the longest edge a-b; both triangles on a-b are halved together,
    ///   | \               because a middle's error is the largest of its own and those of the four middles below it.
    ///   |   m
    ///   | /   \
    ///   a ----- b
    /// ```
    fn cut(&self, tolerance: f64) -> Sheet {
        let n = self.n;
        let mut out = Sheet::default();
        let mut id = vec![usize::MAX; self.points.len()];
        let mut todo: Vec<[(usize, usize); 3]> = Vec::new();
        // The root square's diagonal runs from (0, 0) to (n, n): corner, then the two ends of the longest edge.
        todo.push([(0, n), (0, 0), (n, n)]);
        todo.push([(n, 0), (n, n), (0, 0)]);
        while let Some([c, a, b]) = todo.pop() {
            let m = ((a.0 + b.0) / 2, (a.1 + b.1) / 2);
            let splits = (a.0 + b.0) % 2 == 0 && (a.1 + b.1) % 2 == 0;
            if splits && self.error[m.1 * (n + 1) + m.0] > tolerance {
                todo.push([m, b, c]);
                todo.push([m, c, a]);
                continue;
            }
            out.triangles.push([c, a, b].map(|(i, j)| {
                let k = j * (n + 1) + i;
                if id[k] == usize::MAX {
                    id[k] = out.points.len();
                    out.points.push(self.points[k]);
                }
                id[k]
            }));
        }
        out
    }
}

/// An indexed mesh, facing up.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    pub points: Vec<[f64; 3]>,
    pub triangles: Vec<[usize; 3]>,
}

impl Sheet {
    /// Walls from the rim straight down to z = 0, and a bottom: a closed solid.
    pub fn closed(mut self) -> Sheet {
        // Rim edges are those without a twin the other way round.
        let mut edges: Vec<(usize, usize)> = self
            .triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
            .collect();
        edges.sort_unstable();
        let rim: Vec<(usize, usize)> = edges
            .iter()
            .copied()
            .filter(|&(a, b)| edges.binary_search(&(b, a)).is_err())
            .collect();
        let mut foot = vec![usize::MAX; self.points.len()];
        let mut middle = [0.0, 0.0];
        for &(a, _) in &rim {
            let [x, y, _] = self.points[a];
            middle = [
                middle[0] + x / rim.len() as f64,
                middle[1] + y / rim.len() as f64,
            ];
            foot[a] = self.points.len();
            self.points.push([x, y, 0.0]);
        }
        let hub = self.points.len();
        self.points.push([middle[0], middle[1], 0.0]);
        for (a, b) in rim {
            let (fa, fb) = (foot[a], foot[b]);
            self.triangles
                .extend([[b, a, fa], [b, fa, fb], [fa, hub, fb]]);
        }
        self
    }

    /// Corners of each triangle as an STL holds them.
    pub fn corners(&self) -> Vec<[[f32; 3]; 3]> {
        self.triangles
            .iter()
            .map(|t| t.map(|i| self.points[i].map(|v| v as f32)))
            .collect()
    }
}

pub const PI: f64 = std::f64::consts::PI;

/// e^x for x <= 0 down to -700, by halving the argument into the series' reach.
pub fn exp(x: f64) -> f64 {
    if x < -60.0 {
        return 0.0;
    }
    let (mut small, mut doublings) = (x, 0);
    while small < -0.25 {
        small *= 0.5;
        doublings += 1;
    }
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 1..16 {
        term *= small / f64::from(k);
        sum += term;
    }
    for _ in 0..doublings {
        sum *= sum;
    }
    sum
}

/// sin and cos by their series after whole turns and a quarter of the angle are taken away.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    let a = (angle - 2.0 * PI * (angle / (2.0 * PI)).round()) / 4.0;
    let (mut s, mut c, mut term) = (0.0, 0.0, 1.0);
    for k in 0..18u32 {
        match k % 4 {
            0 => c += term,
            1 => s += term,
            2 => c -= term,
            _ => s -= term,
        }
        term *= a / f64::from(k + 1);
    }
    for _ in 0..2 {
        (s, c) = (2.0 * s * c, c * c - s * s);
    }
    (s, c)
}
