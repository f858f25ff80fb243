//! A height raster as a lit block: orthographic camera, z-buffer, soft light. Work coordinates in, pixels out.
//!
//! ```text
//!      toward the eye                z-buffer: per sub-pixel the nearest ground (depth along "toward", larger is nearer)
//!         \                          light: sun with cast shadow + sky dimmed in hollows + a little gloss
//!    up |  \  /\_                    a block: walls from the raster's rim down to the floor
//!       |___\/__ \__ right
//! ```

use rayon::prelude::*;

use super::canvas::Canvas;
use super::color::{Rgb, linear, screen};
use super::raster::Raster;
use crate::geom::{Point, Point2, Vector};

/// Where the eye is, infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Straight above: X to the right, Y up.
    Above,
    /// From the front, turned and raised.
    Oblique {
        /// The part is seen turned clockwise by this, degrees; 0 looks along +Y.
        azimuth_deg: f64,
        /// Height of the eye above the table's horizon, degrees.
        elevation_deg: f64,
    },
}

impl Default for View {
    fn default() -> Self {
        View::Oblique {
            azimuth_deg: 28.0,
            elevation_deg: 42.0,
        }
    }
}

/// Axes of the picture and its scale.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Picture's right, unit.
    pub right: Vector,
    /// Picture's up, unit.
    pub up: Vector,
    /// Towards the eye, unit.
    pub toward: Vector,
    /// Away from the eye along the table, unit.
    pub ahead: Vector,
    /// Pixels per mm.
    pub scale: f64,
    /// Pixel of the work origin.
    pub offset: [f64; 2],
}

impl Camera {
    /// A camera of one pixel per mm with the work origin at pixel (0, 0).
    pub fn new(view: View) -> Self {
        let (azimuth, elevation) = match view {
            View::Above => (0.0, std::f64::consts::FRAC_PI_2),
            View::Oblique {
                azimuth_deg,
                elevation_deg,
            } => (
                azimuth_deg.to_radians(),
                elevation_deg.clamp(5.0, 90.0).to_radians(),
            ),
        };
        let right = Vector::new(azimuth.cos(), azimuth.sin(), 0.0);
        let ahead = Vector::new(-azimuth.sin(), azimuth.cos(), 0.0);
        Camera {
            right,
            ahead,
            up: ahead * elevation.sin() + Vector::z() * elevation.cos(),
            toward: Vector::z() * elevation.sin() - ahead * elevation.cos(),
            scale: 1.0,
            offset: [0.0, 0.0],
        }
    }

    /// Pixel (y downwards) and depth in mm.
    pub fn project(&self, p: &Point) -> [f64; 3] {
        [
            self.offset[0] + self.scale * p.coords.dot(&self.right),
            self.offset[1] - self.scale * p.coords.dot(&self.up),
            p.coords.dot(&self.toward),
        ]
    }

    fn unproject(&self, x: f64, y: f64, depth: f64) -> Point {
        Point::from(
            self.right * ((x - self.offset[0]) / self.scale)
                + self.up * ((self.offset[1] - y) / self.scale)
                + self.toward * depth,
        )
    }
}

/// Sub-pixels along a pixel's side.
const SUB: usize = 3;
const NOTHING: u8 = 0;
const GROUND: u8 = 1;

/// What each sub-pixel shows.
pub struct Depths {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    what: Vec<u8>,
    camera: Camera,
}

impl Depths {
    /// True when nothing nearer to the eye than `slack` mm hides the place.
    pub fn sees(&self, p: &Point, slack: f64) -> bool {
        let [x, y, d] = self.camera.project(p);
        let (x, y) = ((x * SUB as f64).floor(), (y * SUB as f64).floor());
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64) {
            return true;
        }
        f64::from(self.depth[y as usize * self.width + x as usize]) <= d + slack
    }

    fn triangle(&mut self, corners: [Point; 3], what: u8) {
        let s = SUB as f64;
        let p = corners.map(|c| {
            let [x, y, d] = self.camera.project(&c);
            [x * s, y * s, d]
        });
        let area =
            (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let reach = |k: usize, most: usize| {
            let low = p.iter().map(|q| q[k]).fold(f64::MAX, f64::min);
            let high = p.iter().map(|q| q[k]).fold(f64::MIN, f64::max);
            // Sub-pixels whose middles lie within.
            let first = (low - 0.5).ceil().max(0.0) as usize;
            let end = ((high - 0.5).floor() + 1.0).clamp(0.0, most as f64) as usize;
            first..end
        };
        // Weight of corner k and the depth are linear in x and y: w = a + b x + c y, taken at sub-pixel middles.
        let plane = |a: usize, b: usize| {
            let (bx, by) = (-(p[b][1] - p[a][1]) / area, (p[b][0] - p[a][0]) / area);
            [-(bx * p[a][0] + by * p[a][1]) + 0.5 * (bx + by), bx, by]
        };
        let w = [plane(1, 2), plane(2, 0), plane(0, 1)];
        let depth = [0, 1, 2].map(|i| w[0][i] * p[0][2] + w[1][i] * p[1][2] + w[2][i] * p[2][2]);
        let columns = reach(0, self.width);
        for y in reach(1, self.height) {
            let fy = y as f64;
            let row = w.map(|w| w[0] + w[2] * fy);
            let row_depth = depth[0] + depth[2] * fy;
            for x in columns.clone() {
                let fx = x as f64;
                if (0..3).any(|k| row[k] + w[k][1] * fx < -1e-9) {
                    continue;
                }
                let d = (row_depth + depth[1] * fx) as f32;
                let k = y * self.width + x;
                if d > self.depth[k] {
                    self.depth[k] = d;
                    self.what[k] = what;
                }
            }
        }
    }
}

/// What to draw and how.
pub struct Relief<'a> {
    /// Heights, mm; NaN where there is nothing.
    pub heights: &'a Raster<f32>,
    /// Height of the block's underside, mm.
    pub floor: f64,
    /// Colour of the ground at a place.
    pub tint: &'a (dyn Fn(Point2) -> Rgb + Sync),
    /// Feature at a place, for the lines between them; 0 for none.
    pub label: &'a (dyn Fn(Point2) -> u16 + Sync),
}

/// Finds what the camera sees of the relief in a sheet of `width` x `height` pixels.
pub fn depths(relief: &Relief<'_>, camera: Camera, width: u32, height: u32) -> Depths {
    let (w, h) = (width as usize * SUB, height as usize * SUB);
    let mut out = Depths {
        width: w,
        height: h,
        depth: vec![f32::NEG_INFINITY; w * h],
        what: vec![NOTHING; w * h],
        camera,
    };
    let r = relief.heights;
    let node = |i: i64, j: i64| -> Option<Point> {
        let z = r.get(i, j).filter(|z| z.is_finite())?;
        let (x, y) = (
            r.origin.x + r.step * i as f64,
            r.origin.y + r.step * j as f64,
        );
        Some(Point::new(x, y, f64::from(z)))
    };
    let full = |i: i64, j: i64| {
        [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)]
            .iter()
            .all(|&(a, b)| node(a, b).is_some())
    };
    for j in 0..r.ny as i64 - 1 {
        for i in 0..r.nx as i64 - 1 {
            let (Some(a), Some(b), Some(c), Some(d)) = (
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ) else {
                continue;
            };
            out.triangle([a, b, c], GROUND);
            out.triangle([a, c, d], GROUND);
            // Walls where the next cell is missing; `what` 2..5 tells which way they face.
            for (p, q, next, what) in [
                (d, a, (i - 1, j), 2u8),
                (b, c, (i + 1, j), 3),
                (a, b, (i, j - 1), 4),
                (c, d, (i, j + 1), 5),
            ] {
                if !full(next.0, next.1) {
                    let foot = |p: Point| Point::new(p.x, p.y, relief.floor.min(p.z));
                    out.triangle([p, q, foot(q)], what);
                    out.triangle([p, foot(q), foot(p)], what);
                }
            }
        }
    }
    out
}

/// Slopes, sky and sun at every node.
struct Light {
    slope_x: Raster<f32>,
    slope_y: Raster<f32>,
    sky: Raster<f32>,
    sun: Raster<f32>,
    direction: Vector,
}

impl Light {
    fn new(heights: &Raster<f32>, camera: &Camera) -> Light {
        let from_above = camera.toward.z > 0.999;
        // From the upper left; for an oblique eye a little from its own side, or all it sees would lie in shade.
        let ahead = if from_above { 0.55 } else { -0.12 };
        let direction =
            (camera.right * -0.75 + camera.ahead * ahead + Vector::z() * 0.85).normalize();
        let at = |i: i64, j: i64| heights.get(i, j).filter(|z| z.is_finite()).map(f64::from);
        let nodes: Vec<(i64, i64)> = (0..heights.ny as i64)
            .flat_map(|j| (0..heights.nx as i64).map(move |i| (i, j)))
            .collect();
        let map = |f: &(dyn Fn(i64, i64, f64) -> f64 + Sync)| Raster {
            values: nodes
                .par_iter()
                .map(|&(i, j)| at(i, j).map_or(f32::NAN, |z| f(i, j, z) as f32))
                .collect(),
            ..heights.clone()
        };
        let slope = |di: i64, dj: i64| {
            map(
                &move |i, j, z| match (at(i - di, j - dj), at(i + di, j + dj)) {
                    (Some(a), Some(b)) => (b - a) / (2.0 * heights.step),
                    (None, Some(b)) => (b - z) / heights.step,
                    (Some(a), None) => (z - a) / heights.step,
                    (None, None) => 0.0,
                },
            )
        };
        // How far the ground lies below its surroundings, at two sizes, dims the sky; ridges get a touch more of it.
        let side = heights.nx.max(heights.ny);
        let windows = [side / 60, side / 18].map(|r| r.max(1));
        let around = windows.map(|r| heights.blurred(r).blurred(r));
        let sky = map(&|i, j, z| {
            let mut open = 1.0;
            for (blur, r) in around.iter().zip(windows) {
                let below = f64::from(blur.get(i, j).unwrap_or(0.0)) - z;
                open -= (0.9 * below / (heights.step * r as f64)).clamp(-0.10, 0.38);
            }
            open
        });
        let level = Vector::new(direction.x, direction.y, 0.0);
        let rise = direction.z / level.norm();
        let level = level.normalize();
        let sun = map(&|i, j, z| {
            // The steepest line from here to the ground on the sun's side, against the sun's own height.
            let mut excess: f64 = -1.0;
            let mut t = 1.5;
            while t < side as f64 {
                let (x, y) = (i as f64 + level.x * t, j as f64 + level.y * t);
                let Some(other) = at(x.round() as i64, y.round() as i64) else {
                    break;
                };
                excess = excess.max((other - z) / (t * heights.step) - rise);
                t *= 1.12;
            }
            1.0 - ((excess + 0.12) / 0.24).clamp(0.0, 1.0)
        });
        // A march to whole nodes is ragged at the shadow's rim.
        let sun = sun.blurred((side / 250).max(1));
        Light {
            slope_x: slope(1, 0),
            slope_y: slope(0, 1),
            sky,
            sun,
            direction,
        }
    }

    fn shade(&self, base: Rgb, n: Vector, sky: f64, sun: f64, toward: &Vector) -> [f32; 3] {
        let facing = n.dot(&self.direction).max(0.0) * sun;
        let fill = n
            .dot(&Vector::new(-self.direction.y, self.direction.x, 0.5).normalize())
            .max(0.0);
        let light = 0.95 * facing + (0.34 * (0.6 + 0.4 * n.z) + 0.10 * fill) * sky;
        let half = (self.direction + toward).normalize();
        let gloss = 0.07 * n.dot(&half).max(0.0).powi(36) * sun;
        linear(base).map(|c| c * light as f32 + gloss as f32)
    }
}

/// Draws the relief over what is on the canvas, with a soft shadow beneath the block.
pub fn draw(canvas: &mut Canvas, relief: &Relief<'_>, depths: &Depths) {
    let camera = depths.camera;
    let light = Light::new(relief.heights, &camera);
    let (w, h) = (canvas.width() as usize, canvas.height() as usize);
    drop_shadow(canvas, depths);
    let wide = depths.width;
    let place = |x: usize, y: usize| {
        let d = f64::from(depths.depth[y * wide + x]);
        camera.unproject(
            (x as f64 + 0.5) / SUB as f64,
            (y as f64 + 0.5) / SUB as f64,
            d,
        )
    };
    let labels: Vec<u16> = (0..depths.what.len())
        .into_par_iter()
        .map(|k| {
            if depths.what[k] != GROUND {
                return 0;
            }
            let p = place(k % wide, k / wide);
            (relief.label)(Point2::new(p.x, p.y))
        })
        .collect();
    let jump = (relief.heights.step * relief.heights.nx.max(relief.heights.ny) as f64) * 0.05;
    let sample = |x: usize, y: usize| -> Option<[f32; 3]> {
        let k = y * wide + x;
        let what = depths.what[k];
        if what == NOTHING {
            return None;
        }
        let p = place(x, y);
        let here = Point2::new(p.x, p.y);
        let or = |v: f32, other: f64| if v.is_finite() { f64::from(v) } else { other };
        let mut color = if what == GROUND {
            let n = Vector::new(
                -or(light.slope_x.bilinear(here), 0.0),
                -or(light.slope_y.bilinear(here), 0.0),
                1.0,
            )
            .normalize();
            let (sky, sun) = (
                or(light.sky.bilinear(here), 1.0),
                or(light.sun.bilinear(here), 1.0),
            );
            light.shade((relief.tint)(here), n, sky, sun, &camera.toward)
        } else {
            let n = match what {
                2 => -Vector::x(),
                3 => Vector::x(),
                4 => -Vector::y(),
                _ => Vector::y(),
            };
            // Darker towards the floor.
            let t = ((p.z - relief.floor) / (3.0 * jump)).clamp(0.0, 1.0);
            light.shade([158, 164, 173], n, 0.75 + 0.3 * t, 1.0, &camera.toward)
        };
        // Ink along borders of features, edges of the block, and where a nearer flank hides what is behind it.
        let mut ink: f32 = 1.0;
        for (dx, dy) in [(1i64, 0i64), (0, 1), (-1, 0), (0, -1)] {
            let (nx, ny) = (x as i64 + dx, y as i64 + dy);
            if nx < 0 || ny < 0 || nx >= wide as i64 || ny >= depths.height as i64 {
                continue;
            }
            let other = ny as usize * wide + nx as usize;
            if depths.what[other] == NOTHING || depths.depth[k] > depths.depth[other] + jump as f32
            {
                ink = ink.min(0.25);
            } else if depths.what[other] != what {
                ink = ink.min(0.45);
            } else if what == GROUND && labels[other] != labels[k] {
                ink = ink.min(0.22);
            }
        }
        color = color.map(|c| c * ink);
        Some(color)
    };
    // No edge within the pixel or at its rim.
    let plain = |x: usize, y: usize| {
        let inside = x > 0 && y > 0 && x + SUB < wide && y + SUB < depths.height;
        inside && {
            let middle = (y + SUB / 2) * wide + x + SUB / 2;
            depths.what[middle] != NOTHING
                && (y - 1..=y + SUB).all(|b| {
                    (x - 1..=x + SUB).all(|a| {
                        let k = b * wide + a;
                        depths.what[k] == depths.what[middle]
                            && labels[k] == labels[middle]
                            && (depths.depth[k] - depths.depth[middle]).abs() < 0.5 * jump as f32
                    })
                })
        }
    };
    let rows: Vec<Vec<(Rgb, f32)>> = (0..h.min(depths.height / SUB))
        .into_par_iter()
        .map(|y| {
            (0..w.min(wide / SUB))
                .map(|x| {
                    // Open ground of one feature: the middle speaks for all.
                    if plain(x * SUB, y * SUB) {
                        let c = sample(x * SUB + SUB / 2, y * SUB + SUB / 2).unwrap_or_default();
                        return (screen(c), 1.0);
                    }
                    let (mut sum, mut count) = ([0.0f32; 3], 0.0f32);
                    for k in 0..SUB * SUB {
                        if let Some(c) = sample(x * SUB + k % SUB, y * SUB + k / SUB) {
                            // Mixed as the eye mixes neighbouring screen dots.
                            let c = screen(c);
                            sum = [0, 1, 2].map(|i| sum[i] + f32::from(c[i]));
                            count += 1.0;
                        }
                    }
                    let color = sum.map(|s| (s / count.max(1.0)).round() as u8);
                    (color, count / (SUB * SUB) as f32)
                })
                .collect()
        })
        .collect();
    for (y, row) in rows.iter().enumerate() {
        for (x, &(color, cover)) in row.iter().enumerate() {
            if cover > 0.0 {
                canvas.blend(x as i64, y as i64, color, cover);
            }
        }
    }
}

/// A blurred, shifted silhouette.
fn drop_shadow(canvas: &mut Canvas, depths: &Depths) {
    let (w, h) = (depths.width / SUB, depths.height / SUB);
    let (right, down) = (10i64, 14i64);
    let mask = Raster {
        origin: Point2::new(0.0, 0.0),
        step: 1.0,
        nx: w,
        ny: h,
        values: (0..w * h)
            .map(|k| {
                let (x, y) = ((k % w) as i64 - right, (k / w) as i64 - down);
                let inside = x >= 0 && y >= 0;
                let at = |x: i64, y: i64| {
                    depths.what[y as usize * SUB * depths.width + x as usize * SUB]
                };
                if inside && at(x, y) != NOTHING {
                    1.0
                } else {
                    0.0
                }
            })
            .collect(),
    };
    let soft = mask.blurred(9).blurred(9);
    for (k, v) in soft.values.iter().enumerate() {
        if *v > 0.002 {
            canvas.blend((k % w) as i64, (k / w) as i64, [40, 46, 60], 0.34 * v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_goes_there_and_back_and_is_right_handed() {
        for view in [
            View::Above,
            View::default(),
            View::Oblique {
                azimuth_deg: 200.0,
                elevation_deg: 20.0,
            },
        ] {
            let mut c = Camera::new(view);
            assert!((c.right.cross(&c.up) - c.toward).norm() < 1e-12);
            c.scale = 7.0;
            c.offset = [300.0, 200.0];
            let p = Point::new(3.0, -4.0, 5.0);
            let [x, y, d] = c.project(&p);
            assert!((c.unproject(x, y, d) - p).norm() < 1e-9);
        }
        // Above: X right, Y up the picture.
        let c = Camera::new(View::Above);
        let q = c.project(&Point::new(2.0, 3.0, 9.0));
        assert!(
            (q[0] - 2.0).abs() < 1e-12 && (q[1] + 3.0).abs() < 1e-12 && (q[2] - 9.0).abs() < 1e-12
        );
    }

    #[test]
    fn a_ridge_hides_what_is_behind_it() {
        // A wall of 10 mm across the middle of a flat field, seen from the front.
        let (nx, ny) = (41, 41);
        let heights = Raster {
            origin: Point2::new(0.0, 0.0),
            step: 1.0,
            nx,
            ny,
            values: (0..nx * ny)
                .map(|k| if k / nx == 20 { 10.0 } else { 0.0 })
                .collect(),
        };
        let relief = Relief {
            heights: &heights,
            floor: -5.0,
            tint: &|_| [200; 3],
            label: &|_| 0,
        };
        let mut camera = Camera::new(View::Oblique {
            azimuth_deg: 0.0,
            elevation_deg: 35.0,
        });
        camera.scale = 5.0;
        camera.offset = [20.0, 200.0];
        let d = depths(&relief, camera, 260, 260);
        let sees = |y: f64| d.sees(&Point::new(20.0, y, 0.0), 0.1);
        // Shadow of the eye behind the wall: 10 / tan 35 = 14.3 mm.
        assert!(sees(5.0) && !sees(24.0) && !sees(32.0) && sees(36.0));
        assert!(d.sees(&Point::new(20.0, 20.0, 10.0), 0.1));
    }
}
