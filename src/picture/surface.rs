//! A triangulated surface coloured by a function, seen from the front right: closed solids too. Work coordinates in, PNG out.

use super::PictureError;
use super::canvas::{Align, Canvas, Pen};
use super::color::{self, Rgb};
use super::panel::{heading, scale_bar};
use super::relief::{Camera, View};
use super::scene::{Marker, MarkerKind, TOP, symbol};
use crate::geom::{Box3, Point};

/// A surface and the function on it.
#[derive(Clone, Debug)]
pub struct SurfaceScene<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line, smaller.
    pub subtitle: &'a str,
    /// Vertices, mm.
    pub points: &'a [Point],
    /// Corners, as indices of vertices.
    pub triangles: &'a [[u32; 3]],
    /// Value at each vertex.
    pub value: &'a [f64],
    /// What it is: "mean curvature".
    pub quantity: &'a str,
    /// Its unit: "1/mm".
    pub unit: &'a str,
    /// Critical points.
    pub markers: &'a [Marker],
    /// Where the eye is.
    pub view: View,
    /// Width of the picture, 400 to 4000 pixels; the height follows.
    pub width_px: u32,
}

const PANEL: f64 = 230.0;
const MARGIN: f64 = 34.0;
const FOOT: f64 = 66.0;
/// Sub-pixels along a pixel's side.
const SUB: usize = 2;
/// Bands of the colour scale, so that level curves show.
const BANDS: f64 = 24.0;

/// Draws it. Colours run from the 1st to the 99th percentile of the values. Triangles with wild numbers are left out.
pub fn surface_map(scene: &SurfaceScene<'_>) -> Result<Vec<u8>, PictureError> {
    if !(400..=4000).contains(&scene.width_px) {
        return Err(PictureError::Size(scene.width_px, 0));
    }
    let known = |t: &&[u32; 3]| {
        t.iter().all(|&v| {
            let v = v as usize;
            scene
                .points
                .get(v)
                .is_some_and(|p| p.iter().all(|x| x.is_finite()))
                && scene.value.get(v).is_some_and(|x| x.is_finite())
        })
    };
    let triangles: Vec<&[u32; 3]> = scene.triangles.iter().filter(known).collect();
    if triangles.is_empty() {
        return Err(PictureError::Nothing("surface"));
    }
    let mut camera = Camera::new(scene.view);
    let bounds = Box3::of(
        triangles
            .iter()
            .flat_map(|t| t.map(|v| &scene.points[v as usize])),
    );
    let width = f64::from(scene.width_px);
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for t in &triangles {
        for &v in *t {
            let q = camera.project(&scene.points[v as usize]);
            for k in 0..2 {
                low[k] = low[k].min(q[k]);
                high[k] = high[k].max(q[k]);
            }
        }
    }
    let room = [width - PANEL - 2.0 * MARGIN, 0.74 * width];
    let span = [(high[0] - low[0]).max(1e-6), (high[1] - low[1]).max(1e-6)];
    camera.scale = (room[0] / span[0]).min(room[1] / span[1]);
    camera.offset = [
        MARGIN + 0.5 * (room[0] - camera.scale * span[0]) - camera.scale * low[0],
        TOP + 22.0 - camera.scale * low[1],
    ];
    let height = (TOP + 22.0 + camera.scale * span[1] + FOOT)
        .max(480.0)
        .round();
    let mut canvas = Canvas::new(scene.width_px, height as u32, color::PAPER)?;
    let scale = Scale::new(scene.value);
    let seen = draw(&mut canvas, scene, &triangles, &camera, &scale);
    markers(
        &mut canvas,
        scene,
        &camera,
        &seen,
        0.01 * bounds.size().norm(),
    );
    heading(&mut canvas, scene.title, scene.subtitle);
    legend(&mut canvas, scene, &scale, (width - PANEL) as f32 + 10.0);
    scale_bar(&mut canvas, camera.scale, 40.0, height as f32 - 34.0);
    let (w, h) = (canvas.width() as f32, canvas.height() as f32);
    canvas.frame(0.0, 0.0, w, h, color::INK);
    canvas.png()
}

/// From a value to its colour.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    fn new(value: &[f64]) -> Scale {
        let mut v: Vec<f64> = value.iter().copied().filter(|v| v.is_finite()).collect();
        v.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            v.get((share * v.len().saturating_sub(1) as f64).round() as usize)
                .copied()
                .unwrap_or(0.0)
        };
        Scale {
            low: at(0.01),
            high: at(0.99),
        }
    }

    fn color(&self, v: f64) -> Rgb {
        let t = (v - self.low) / (self.high - self.low).max(1e-300);
        color::ramp((t.clamp(0.0, 1.0) * BANDS).floor().min(BANDS - 1.0) / (BANDS - 1.0))
    }
}

/// Nearest depth per sub-pixel.
struct Depths {
    width: usize,
    depth: Vec<f32>,
}

impl Depths {
    fn sees(&self, at: [f64; 3], slack: f64) -> bool {
        let (x, y) = (at[0] * SUB as f64, at[1] * SUB as f64);
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f64) {
            return true;
        }
        self.depth
            .get(y as usize * self.width + x as usize)
            .is_none_or(|d| f64::from(*d) <= at[2] + slack)
    }
}

fn draw(
    canvas: &mut Canvas,
    scene: &SurfaceScene<'_>,
    triangles: &[&[u32; 3]],
    camera: &Camera,
    scale: &Scale,
) -> Depths {
    let (w, h) = (
        canvas.width() as usize * SUB,
        canvas.height() as usize * SUB,
    );
    let mut depth = vec![f32::NEG_INFINITY; w * h];
    let mut paint = vec![[0u8; 3]; w * h];
    let sun = (camera.toward + camera.up * 0.7 - camera.right * 0.6).normalize();
    for t in triangles {
        let c = t.map(|v| scene.points[v as usize]);
        let n = (c[1] - c[0]).cross(&(c[2] - c[0]));
        let Some(mut n) = n.try_normalize(0.0).filter(|n| n.x.is_finite()) else {
            continue;
        };
        if n.dot(&camera.toward) < 0.0 {
            n = -n; // the back of a sheet is lit like its front
        }
        let light = 0.45 + 0.6 * n.dot(&sun).max(0.0);
        let p = c.map(|c| {
            let [x, y, d] = camera.project(&c);
            [x * SUB as f64, y * SUB as f64, d]
        });
        let value = t.map(|v| scene.value[v as usize]);
        let area =
            (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
        if area == 0.0 || !area.is_finite() {
            continue;
        }
        let reach = |k: usize, most: usize| {
            let lo = p.iter().map(|q| q[k]).fold(f64::MAX, f64::min);
            let hi = p.iter().map(|q| q[k]).fold(f64::MIN, f64::max);
            (lo - 0.5).ceil().max(0.0) as usize
                ..((hi - 0.5).floor() + 1.0).clamp(0.0, most as f64) as usize
        };
        let columns = reach(0, w);
        for y in reach(1, h) {
            for x in columns.clone() {
                let (fx, fy) = (x as f64 + 0.5, y as f64 + 0.5);
                let part = |a: usize, b: usize| {
                    ((p[a][0] - fx) * (p[b][1] - fy) - (p[a][1] - fy) * (p[b][0] - fx)) / area
                };
                let weight = [part(1, 2), part(2, 0), part(0, 1)];
                if weight.iter().any(|w| *w < -1e-9) {
                    continue;
                }
                let mix = |of: [f64; 3]| (0..3).map(|k| weight[k] * of[k]).sum::<f64>();
                let d = mix([p[0][2], p[1][2], p[2][2]]) as f32;
                let k = y * w + x;
                if d > depth[k] {
                    depth[k] = d;
                    paint[k] = scale
                        .color(mix(value))
                        .map(|c| (f64::from(c) * light).clamp(0.0, 255.0) as u8);
                }
            }
        }
    }
    for y in 0..canvas.height() as usize {
        for x in 0..canvas.width() as usize {
            let (mut sum, mut count) = ([0.0f32; 3], 0.0f32);
            for k in 0..SUB * SUB {
                let at = (y * SUB + k / SUB) * w + x * SUB + k % SUB;
                if depth[at] > f32::NEG_INFINITY {
                    sum = [0, 1, 2].map(|i| sum[i] + f32::from(paint[at][i]));
                    count += 1.0;
                }
            }
            if count > 0.0 {
                let c = sum.map(|s| (s / count).round() as u8);
                canvas.blend(x as i64, y as i64, c, count / (SUB * SUB) as f32);
            }
        }
    }
    Depths { width: w, depth }
}

fn markers(
    canvas: &mut Canvas,
    scene: &SurfaceScene<'_>,
    camera: &Camera,
    seen: &Depths,
    slack: f64,
) {
    // Words only where there is room for them.
    let worded = scene.markers.len() <= 60;
    for m in scene.markers {
        let at = camera.project(&m.at);
        if !at.iter().all(|v| v.is_finite()) {
            continue;
        }
        let (x, y) = (at[0] as f32, at[1] as f32);
        if seen.sees(at, slack) {
            symbol(canvas, m.kind, x, y, 8.0);
            if worded && !m.label.is_empty() {
                for (dx, dy) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                    let (x, y) = (x + 12.0 + dx, y - 8.0 + dy);
                    canvas.text(x, y, 15.0, Align::Left, color::PAPER, &m.label);
                }
                canvas.text(x + 12.0, y - 8.0, 15.0, Align::Left, color::INK, &m.label);
            }
        } else {
            // Behind: a dot tells that it is there.
            let tone = match m.kind {
                MarkerKind::Max => color::RED,
                MarkerKind::Min => color::BLUE,
                MarkerKind::Saddle => color::YELLOW,
            };
            let ring: Vec<[f32; 2]> = (0..=16)
                .map(|k| {
                    let (s, c) = (k as f32 * std::f32::consts::TAU / 16.0).sin_cos();
                    [x + 4.0 * c, y + 4.0 * s]
                })
                .collect();
            canvas.line(&ring, &Pen::solid([255, 255, 255], 3.5));
            canvas.line(&ring, &Pen::solid(tone, 1.8));
        }
    }
}

fn legend(canvas: &mut Canvas, scene: &SurfaceScene<'_>, scale: &Scale, x: f32) {
    let mut y = TOP as f32 + 8.0;
    for (kind, name) in [
        (MarkerKind::Max, "peak"),
        (MarkerKind::Min, "pit"),
        (MarkerKind::Saddle, "saddle"),
    ] {
        let count = scene.markers.iter().filter(|m| m.kind == kind).count();
        symbol(canvas, kind, x + 9.0, y + 8.0, 7.0);
        let plural = if count == 1 { "" } else { "s" };
        let words = format!("{count} {name}{plural}");
        canvas.text(x + 26.0, y, 15.0, Align::Left, color::INK, &words);
        y += 24.0;
    }
    y += 14.0;
    let words = format!("{}, {}", scene.quantity, scene.unit);
    canvas.text(x, y, 15.0, Align::Left, color::FADED, &words);
    y += 28.0;
    let tall = 220;
    for k in 0..tall {
        let v = scale.high + (scale.low - scale.high) * f64::from(k) / f64::from(tall - 1);
        canvas.rect(x, y + k as f32, 22.0, 1.0, scale.color(v));
    }
    canvas.frame(x, y, 22.0, tall as f32, color::INK);
    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let v = scale.high + (scale.low - scale.high) * share;
        let size = scale.high.abs().max(scale.low.abs());
        let words = if size >= 100.0 {
            format!("{v:.0}")
        } else if size >= 1.0 {
            format!("{v:.2}")
        } else {
            format!("{v:.4}")
        };
        let at = y + (share * f64::from(tall)) as f32 - 8.0;
        canvas.text(x + 30.0, at, 14.0, Align::Left, color::INK, &words);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn wild_numbers_are_left_out_and_nothing_is_refused() {
        let points = [
            Point::new(0.0, 0.0, 0.0),
            Point::new(9.0, 0.0, 1.0),
            Point::new(0.0, 9.0, 2.0),
            Point::new(f64::NAN, 9.0, 2.0),
        ];
        let scene = SurfaceScene {
            title: "t",
            subtitle: "",
            points: &points,
            triangles: &[[0, 1, 2], [1, 2, 3], [0, 1, 9]],
            value: &[0.0, 1.0, 2.0, 3.0],
            quantity: "height",
            unit: "mm",
            markers: &[Marker {
                kind: MarkerKind::Max,
                at: points[3],
                label: "x".into(),
            }],
            view: View::default(),
            width_px: 500,
        };
        let png = surface_map(&scene).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png == surface_map(&scene).unwrap());
        let none = SurfaceScene {
            triangles: &[[1, 2, 3]],
            ..scene
        };
        assert_eq!(
            surface_map(&none).unwrap_err().to_string(),
            "nothing to draw: the surface raster has no values"
        );
    }
}
