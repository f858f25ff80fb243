//! The part with its features and critical points, and the passes over it.

use super::PictureError;
use super::canvas::{Align, Canvas, Pen};
use super::color::{self, Rgb};
use super::panel::{heading, panel, scale_bar};
use super::raster::Raster;
use super::relief::{self, Camera, Depths, Relief, View};
use crate::geom::{Point, Point2, Vector};

/// Kind of a critical point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MarkerKind {
    /// A peak: red triangle, point up.
    Max,
    /// A pit: blue triangle, point down.
    Min,
    /// A saddle: yellow cross.
    Saddle,
}

/// A critical point to mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Its symbol.
    pub kind: MarkerKind,
    /// Its place on the ground, work coordinates, mm.
    pub at: Point,
    /// Words beside it; may be empty.
    pub label: String,
}

/// What the tool does along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LineKind {
    /// A pass.
    Cut,
    /// A pass along a crease.
    Pencil,
    /// A pass that fills what others left.
    Fill,
    /// A link at feed, down on the part.
    Link,
    /// A plunge or a retract at feed.
    Plunge,
    /// A rapid.
    Rapid,
}

impl LineKind {
    pub(super) const ALL: [LineKind; 6] = [
        LineKind::Cut,
        LineKind::Pencil,
        LineKind::Fill,
        LineKind::Link,
        LineKind::Plunge,
        LineKind::Rapid,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            LineKind::Cut => "passes",
            LineKind::Pencil => "crease passes",
            LineKind::Fill => "fill passes",
            LineKind::Link => "links on the part",
            LineKind::Plunge => "plunge, retract",
            LineKind::Rapid => "rapids",
        }
    }

    pub(super) fn pen(self, feature: u16) -> Pen {
        let pen = |color, alpha, width, dash| Pen {
            color,
            alpha,
            width,
            dash,
        };
        match self {
            LineKind::Cut => {
                let dark = if feature == 0 {
                    [30, 58, 110]
                } else {
                    color::mix(color::feature(feature), [0, 0, 20], 0.52)
                };
                pen(dark, 235, 1.15, None)
            }
            LineKind::Pencil => pen([140, 20, 140], 240, 1.5, None),
            LineKind::Fill => pen([0, 120, 60], 240, 1.2, None),
            LineKind::Link => pen([255, 120, 0], 255, 1.9, None),
            LineKind::Plunge => pen([0, 150, 200], 230, 1.4, None),
            LineKind::Rapid => pen([225, 30, 40], 150, 1.1, Some([6.0, 4.0])),
        }
    }
}

/// A polyline of the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What happens along it.
    pub kind: LineKind,
    /// Label of the feature it cuts, for its colour; 0 for none.
    pub feature: u16,
    /// Work coordinates, mm. Tool tips or contacts, as the caller likes.
    pub points: Vec<Point>,
}

/// What both pictures of the part share. Heights are needed; all else may be absent or empty.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line, smaller.
    pub subtitle: &'a str,
    /// Height of the part, mm; NaN where there is none.
    pub heights: &'a Raster<f32>,
    /// Feature labels from 1, 0 for none; its grid may differ from that of the heights.
    pub labels: Option<&'a Raster<u16>>,
    /// Words for features in the legend, by label, in the order wanted.
    pub features: &'a [(u16, String)],
    /// Critical points.
    pub markers: &'a [Marker],
    /// Height of the part's underside, mm, where it has one; else a slab is drawn.
    pub floor: Option<f64>,
    /// Where the eye is.
    pub view: View,
    /// Width of the picture, 400 to 4000 pixels; the height follows.
    pub width_px: u32,
}

/// Nodes along a side that a screen can show.
const MOST_NODES: usize = 640;
pub(super) const PANEL: f64 = 264.0;
pub(super) const TOP: f64 = 92.0;
/// Room for words above the highest mark.
const HEADROOM: f64 = 22.0;
const MARGIN: f64 = 34.0;
const FOOT: f64 = 66.0;

/// The part in soft light, features as colours, critical points as labelled marks, legend and scale. PNG.
pub fn shaded(scene: &Scene<'_>) -> Result<Vec<u8>, PictureError> {
    draw(scene, None)
}

/// The tool's lines over the part. Lines behind the part are left out. PNG.
pub fn passes(scene: &Scene<'_>, lines: &[Line]) -> Result<Vec<u8>, PictureError> {
    draw(scene, Some(lines))
}

fn draw(scene: &Scene<'_>, lines: Option<&[Line]>) -> Result<Vec<u8>, PictureError> {
    if !scene.heights.is_consistent() {
        return Err(PictureError::Raster("height"));
    }
    if scene.labels.is_some_and(|l| !l.is_consistent()) {
        return Err(PictureError::Raster("label"));
    }
    if !(400..=4000).contains(&scene.width_px) {
        return Err(PictureError::Size(scene.width_px, 0));
    }
    let heights = scene.heights.thinned(MOST_NODES);
    let (low, high) = heights.range().ok_or(PictureError::Nothing("height"))?;
    let (low, high) = (f64::from(low), f64::from(high));
    let size = heights.step * heights.nx.max(heights.ny) as f64;
    let slab = low - (0.07 * size).max(0.12 * (high - low));
    let floor = scene
        .floor
        .filter(|f| f.is_finite() && *f <= low)
        .unwrap_or(slab);

    let mut camera = Camera::new(scene.view);
    let width = f64::from(scene.width_px);
    let height = frame_up(
        &mut camera,
        scene,
        lines.unwrap_or(&[]),
        &heights,
        floor,
        width,
    );
    let mut canvas = Canvas::new(scene.width_px, height as u32, color::PAPER)?;

    let stained = lines.is_none();
    let tint = |p: Point2| -> Rgb {
        let t = (f64::from(heights.bilinear(p)) - low) / (high - low).max(1e-9);
        let t = if t.is_finite() { t } else { 0.5 };
        let stone = color::mix([176, 184, 196], [226, 226, 222], t);
        match scene.labels.map_or(0, |l| l.label_at(p)) {
            0 => stone,
            label => color::mix(
                stone,
                color::feature(label),
                if stained { 0.66 } else { 0.30 },
            ),
        }
    };
    let label = |p: Point2| scene.labels.map_or(0, |l| l.label_at(p));
    let what = Relief {
        heights: &heights,
        floor,
        tint: &tint,
        label: &label,
    };
    let seen = relief::depths(&what, camera, canvas.width(), canvas.height());
    relief::draw(&mut canvas, &what, &seen);
    for kind in LineKind::ALL {
        for line in lines.unwrap_or(&[]).iter().filter(|l| l.kind == kind) {
            draw_line(&mut canvas, &camera, &seen, line, size);
        }
    }
    draw_markers(
        &mut canvas,
        &camera,
        &seen,
        scene.markers,
        size,
        width - PANEL,
    );
    heading(&mut canvas, scene.title, scene.subtitle);
    let left = (width - PANEL) as f32 + 14.0;
    panel(&mut canvas, scene, lines, left);
    axes(&mut canvas, &camera, height as f32);
    scale_bar(&mut canvas, camera.scale, 150.0, height as f32 - 34.0);
    let (w, h) = (canvas.width() as f32, canvas.height() as f32);
    canvas.frame(0.0, 0.0, w, h, color::INK);
    canvas.png()
}

/// Sets scale and offset so that all there is to see fills the space left of the panel; gives the picture's height.
fn frame_up(
    camera: &mut Camera,
    scene: &Scene<'_>,
    lines: &[Line],
    heights: &Raster<f32>,
    floor: f64,
    width: f64,
) -> f64 {
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    let mut see = |p: Point| {
        let q = camera.project(&p);
        for k in 0..2 {
            if q[k].is_finite() {
                low[k] = low[k].min(q[k]);
                high[k] = high[k].max(q[k]);
            }
        }
    };
    for (k, z) in heights
        .values
        .iter()
        .enumerate()
        .filter(|(_, z)| z.is_finite())
    {
        let (i, j) = (k % heights.nx, k / heights.nx);
        let (x, y) = (
            heights.origin.x + heights.step * i as f64,
            heights.origin.y + heights.step * j as f64,
        );
        see(Point::new(x, y, f64::from(*z)));
        see(Point::new(x, y, floor));
    }
    lines.iter().flat_map(|l| &l.points).for_each(|p| see(*p));
    scene.markers.iter().for_each(|m| see(m.at));
    let room = [width - PANEL - 2.0 * MARGIN, 0.74 * width];
    let span = [(high[0] - low[0]).max(1e-6), (high[1] - low[1]).max(1e-6)];
    let scale = (room[0] / span[0]).min(room[1] / span[1]);
    camera.scale = scale;
    let left = MARGIN + 0.5 * (room[0] - scale * span[0]);
    camera.offset = [left - scale * low[0], TOP + HEADROOM - scale * low[1]];
    // The legend needs its room too.
    let rows = scene.features.len().min(16) + 14;
    // From above nothing is free at the lower left, where the axes stand.
    let foot = if camera.toward.z > 0.999 {
        FOOT + 34.0
    } else {
        FOOT
    };
    (TOP + HEADROOM + scale * span[1] + foot)
        .max(TOP + 24.0 * rows as f64)
        .min(3000.0)
        .round()
}

/// A polyline, the hidden stretches left out.
fn draw_line(canvas: &mut Canvas, camera: &Camera, seen: &Depths, line: &Line, size: f64) {
    let pen = line.kind.pen(line.feature);
    // Passes lie on the ground: allow for the raster's own coarseness.
    let slack = 0.012 * size;
    let mut run: Vec<[f32; 2]> = Vec::new();
    let mut flush = |run: &mut Vec<[f32; 2]>| {
        if run.len() > 1 {
            canvas.line(run, &pen);
        }
        run.clear();
    };
    let mut visit = |p: Point| {
        if seen.sees(&p, slack) {
            let [x, y, _] = camera.project(&p);
            run.push([x as f32, y as f32]);
        } else {
            flush(&mut run);
        }
    };
    let Some(first) = line.points.first() else {
        return;
    };
    visit(*first);
    for pair in line.points.windows(2) {
        let length = (pair[1] - pair[0]).norm() * camera.scale;
        let steps = if length.is_finite() {
            (length / 4.0).ceil().clamp(1.0, 2000.0) as usize
        } else {
            1
        };
        for k in 1..=steps {
            visit(pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64));
        }
    }
    flush(&mut run);
}

pub(super) fn symbol(canvas: &mut Canvas, kind: MarkerKind, x: f32, y: f32, r: f32) {
    let rim = Pen::solid([255, 255, 255], 2.0);
    match kind {
        MarkerKind::Max => {
            let p = [
                [x, y - 1.15 * r],
                [x + r, y + 0.7 * r],
                [x - r, y + 0.7 * r],
            ];
            canvas.polygon(&p, color::RED, Some(&rim));
        }
        MarkerKind::Min => {
            let p = [
                [x, y + 1.15 * r],
                [x - r, y - 0.7 * r],
                [x + r, y - 0.7 * r],
            ];
            canvas.polygon(&p, color::BLUE, Some(&rim));
        }
        MarkerKind::Saddle => {
            let d = 0.8 * r;
            for pen in [Pen::solid(color::INK, 7.5), Pen::solid(color::YELLOW, 4.5)] {
                canvas.line(&[[x - d, y - d], [x + d, y + d]], &pen);
                canvas.line(&[[x - d, y + d], [x + d, y - d]], &pen);
            }
        }
    }
}

fn draw_markers(
    canvas: &mut Canvas,
    camera: &Camera,
    seen: &Depths,
    markers: &[Marker],
    size: f64,
    right_end: f64,
) {
    const R: f32 = 9.0;
    const TEXT: f32 = 16.0;
    // Boxes that words must not cover: left, top, right, bottom.
    let mut taken: Vec<[f32; 4]> = Vec::new();
    let places: Vec<(f32, f32, bool)> = markers
        .iter()
        .map(|m| {
            let [x, y, _] = camera.project(&m.at);
            (x as f32, y as f32, seen.sees(&m.at, 0.02 * size))
        })
        .collect();
    for &(x, y, _) in &places {
        taken.push([x - R, y - R, x + R, y + R]);
    }
    for (m, &(x, y, visible)) in markers.iter().zip(&places) {
        if visible {
            symbol(canvas, m.kind, x, y, R);
        } else {
            // Behind a flank: a hollow ring tells that it is there.
            let ring: Vec<[f32; 2]> = (0..=24)
                .map(|k| {
                    let (s, c) = (k as f32 * std::f32::consts::TAU / 24.0).sin_cos();
                    [x + 5.0 * c, y + 5.0 * s]
                })
                .collect();
            let color = match m.kind {
                MarkerKind::Max => color::RED,
                MarkerKind::Min => color::BLUE,
                MarkerKind::Saddle => color::YELLOW,
            };
            canvas.line(&ring, &Pen::solid([255, 255, 255], 4.5));
            canvas.line(&ring, &Pen::solid(color, 2.2));
        }
        if m.label.is_empty() {
            continue;
        }
        let w = Canvas::text_width(TEXT, &m.label);
        let spots = [
            [x + R + 5.0, y - TEXT / 2.0],
            [x - R - 6.0 - w, y - TEXT / 2.0],
            [x - w / 2.0, y - R - 6.0 - TEXT],
            [x - w / 2.0, y + R + 6.0],
        ];
        let boxed = |s: &[f32; 2]| [s[0] - 2.0, s[1] - 2.0, s[0] + w + 2.0, s[1] + TEXT + 2.0];
        let free = |s: &&[f32; 2]| {
            let b = boxed(s);
            let apart = |t: &[f32; 4]| b[0] > t[2] || b[2] < t[0] || b[1] > t[3] || b[3] < t[1];
            b[0] > 4.0 && b[2] < right_end as f32 && taken.iter().all(apart)
        };
        let spot = *spots.iter().find(free).unwrap_or(&spots[0]);
        taken.push(boxed(&spot));
        canvas.rimmed_text(spot[0], spot[1], TEXT, Align::Left, color::INK, &m.label);
    }
}

/// The work axes at the lower left.
fn axes(canvas: &mut Canvas, camera: &Camera, height: f32) {
    let start = [66.0f32, height - 52.0];
    for (axis, name, color) in [
        (Vector::x(), "X", [196, 40, 40]),
        (Vector::y(), "Y", [40, 140, 60]),
        (Vector::z(), "Z", [40, 80, 200]),
    ] {
        let d = [axis.dot(&camera.right) as f32, -axis.dot(&camera.up) as f32];
        let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
        if length < 0.15 {
            continue;
        }
        let (u, l) = ([d[0] / length, d[1] / length], 34.0 * length);
        let tip = [start[0] + u[0] * l, start[1] + u[1] * l];
        canvas.line(&[start, tip], &Pen::solid(color, 2.0));
        let wing = |s: f32| {
            [
                tip[0] - 6.0 * u[0] + s * 3.5 * u[1],
                tip[1] - 6.0 * u[1] - s * 3.5 * u[0],
            ]
        };
        canvas.polygon(
            &[
                [tip[0] + 3.0 * u[0], tip[1] + 3.0 * u[1]],
                wing(1.0),
                wing(-1.0),
            ],
            color,
            None,
        );
        canvas.text(
            tip[0] + 12.0 * u[0],
            tip[1] + 12.0 * u[1] - 6.0,
            12.0,
            Align::Center,
            color,
            name,
        );
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn hill() -> Raster<f32> {
        let n = 60;
        Raster {
            origin: Point2::new(0.0, 0.0),
            step: 0.5,
            nx: n,
            ny: n,
            values: (0..n * n)
                .map(|k| {
                    let (x, y) = ((k % n) as f32 - 30.0, (k / n) as f32 - 30.0);
                    8.0 * (-(x * x + y * y) / 250.0).exp()
                })
                .collect(),
        }
    }

    fn scene<'a>(heights: &'a Raster<f32>, markers: &'a [Marker]) -> Scene<'a> {
        Scene {
            title: "hill",
            subtitle: "",
            heights,
            labels: None,
            features: &[],
            markers,
            floor: None,
            view: View::default(),
            width_px: 600,
        }
    }

    #[test]
    fn the_same_bytes_twice_and_with_any_number_of_threads() {
        let h = hill();
        let markers = [Marker {
            kind: MarkerKind::Max,
            at: Point::new(15.0, 15.0, 8.0),
            label: "1".into(),
        }];
        let lines = [Line {
            kind: LineKind::Cut,
            feature: 1,
            points: vec![Point::new(0.0, 15.0, 8.0), Point::new(29.0, 15.0, 8.0)],
        }];
        let make = || {
            (
                shaded(&scene(&h, &markers)).unwrap(),
                passes(&scene(&h, &markers), &lines).unwrap(),
            )
        };
        let pool = |n| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(n)
                .build()
                .unwrap()
        };
        let one = pool(1).install(make);
        assert!(one == pool(2).install(make) && one == make());
        assert!(one.0.starts_with(b"\x89PNG") && one.0 != one.1);
    }

    #[test]
    fn nothing_and_nonsense_are_refused() {
        let mut h = hill();
        h.values.fill(f32::NAN);
        assert_eq!(
            shaded(&scene(&h, &[])).unwrap_err().to_string(),
            "nothing to draw: the height raster has no values"
        );
        h.values.pop();
        assert_eq!(
            shaded(&scene(&h, &[])).unwrap_err().to_string(),
            "the height raster is inconsistent: its values do not fill its nodes, or its step is not above zero"
        );
        let h = hill();
        let tiny = Scene {
            width_px: 10,
            ..scene(&h, &[])
        };
        assert!(shaded(&tiny).is_err());
        // Wild numbers in lines and markers do no harm.
        let nan = Point::new(f64::NAN, 0.0, f64::INFINITY);
        let lines = [Line {
            kind: LineKind::Rapid,
            feature: 9,
            points: vec![nan, Point::origin(), nan],
        }];
        let markers = [Marker {
            kind: MarkerKind::Min,
            at: nan,
            label: "far".into(),
        }];
        assert!(passes(&scene(&h, &markers), &lines).is_ok());
    }
}
