//! A place seen closely from above, in panes side by side: the same ground cut in one way and in another, sharp turns marked.

use super::PictureError;
use super::canvas::{Align, Canvas, Pen};
use super::color::{self, Rgb};
use super::panel::{heading, scale_bar};
use super::raster::Raster;
use super::scene::{Line, LineKind, MarkerKind, symbol};
use crate::geom::Point2;

/// A place where a path turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnMark {
    /// Where, mm.
    pub at: Point2,
    /// How sharply, degrees.
    pub degrees: f64,
}

/// One of the views.
#[derive(Clone, Debug)]
pub struct Pane<'a> {
    /// Words above it.
    pub words: &'a str,
    /// Lines of the tool; what lies outside the view is cut off.
    pub lines: &'a [Line],
    /// Where it turns; those at or below the first limit are not marked.
    pub turns: &'a [TurnMark],
}

/// Panes of one place.
#[derive(Clone, Debug)]
pub struct CloseUp<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line, smaller.
    pub subtitle: &'a str,
    /// Heights of the ground for its contour lines, mm; NaN where there is none.
    pub heights: &'a Raster<f32>,
    /// The saddle, in the middle of each pane.
    pub center: Point2,
    /// A circle of this radius is drawn about it, mm; above zero.
    pub reach: f64,
    /// Turns above the first are marked, above the second loudly; degrees.
    pub limits: [f64; 2],
    /// The views, from left to right.
    pub panes: &'a [Pane<'a>],
    /// Width of the picture, 400 to 4000 pixels; the height follows.
    pub width_px: u32,
}

const TOP: f32 = 128.0;
const MARGIN: f32 = 28.0;
const FOOT: f32 = 74.0;
/// Half the side of a pane, in reaches.
const SEEN: f64 = 1.3;
/// Contour lines in a pane, about.
const CONTOURS: f64 = 14.0;
const GROUND: Rgb = [236, 238, 240];
const CONTOUR: Rgb = [196, 202, 210];
const AMBER: Rgb = [240, 140, 0];

/// Draws the panes, X to the right, Y up. PNG.
pub fn close_up(scene: &CloseUp<'_>) -> Result<Vec<u8>, PictureError> {
    if !scene.heights.is_consistent() {
        return Err(PictureError::Raster("height"));
    }
    if !(400..=4000).contains(&scene.width_px) {
        return Err(PictureError::Size(scene.width_px, 0));
    }
    if scene.panes.is_empty() || scene.reach.is_nan() || scene.reach <= 0.0 {
        return Err(PictureError::Nothing("close-up"));
    }
    let width = scene.width_px as f32;
    let count = scene.panes.len() as f32;
    let side = ((width - MARGIN * (count + 1.0)) / count).floor();
    if side < 40.0 {
        return Err(PictureError::Size(scene.width_px, 0));
    }
    let height = TOP + side + FOOT;
    let mut canvas = Canvas::new(scene.width_px, height as u32, color::PAPER)?;
    heading(&mut canvas, scene.title, scene.subtitle);
    for (k, pane) in scene.panes.iter().enumerate() {
        let frame = Frame {
            left: MARGIN + k as f32 * (side + MARGIN),
            side,
            center: scene.center,
            half: SEEN * scene.reach,
        };
        frame.draw(&mut canvas, scene, pane);
    }
    legend(&mut canvas, scene, side);
    canvas.png()
}

/// Where a pane lies in the picture, and what of the ground it shows.
struct Frame {
    left: f32,
    side: f32,
    center: Point2,
    half: f64,
}

impl Frame {
    fn pixel(&self, p: &Point2) -> [f32; 2] {
        let scale = f64::from(self.side) / (2.0 * self.half);
        let d = p - self.center;
        [
            self.left + ((d.x + self.half) * scale) as f32,
            TOP + ((self.half - d.y) * scale) as f32,
        ]
    }

    fn draw(&self, canvas: &mut Canvas, scene: &CloseUp<'_>, pane: &Pane<'_>) {
        canvas.text(
            self.left,
            TOP - 32.0,
            19.0,
            Align::Left,
            color::INK,
            pane.words,
        );
        self.ground(canvas, scene.heights);
        let ring: Vec<[f32; 2]> = (0..=96)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::TAU / 96.0).sin_cos();
                self.pixel(&(self.center + crate::geom::Vector2::new(c, s) * scene.reach))
            })
            .collect();
        let dashed = Pen {
            dash: Some([5.0, 5.0]),
            ..Pen::solid(color::FADED, 1.0)
        };
        canvas.line(&ring, &dashed);
        for line in pane.lines {
            let pen = Pen {
                width: if line.kind == LineKind::Link {
                    2.4
                } else {
                    1.7
                },
                ..line.kind.pen(line.feature)
            };
            for run in self.clipped(line) {
                canvas.line(&run, &pen);
            }
        }
        let [x, y] = self.pixel(&self.center);
        symbol(canvas, MarkerKind::Saddle, x, y, 8.0);
        self.marks(canvas, scene, pane);
        canvas.frame(self.left, TOP, self.side, self.side, color::INK);
    }

    /// Contour lines: pixels whose neighbour to the right or below lies in another band of height.
    fn ground(&self, canvas: &mut Canvas, heights: &Raster<f32>) {
        let n = self.side as usize;
        let at = |i: usize, j: usize| {
            let share = |k: usize| 2.0 * self.half * (k as f64 + 0.5) / n as f64 - self.half;
            let p = Point2::new(self.center.x + share(i), self.center.y - share(j));
            f64::from(heights.bilinear(p))
        };
        let z: Vec<f64> = (0..n * n).map(|k| at(k % n, k / n)).collect();
        let (low, high) = z
            .iter()
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |r, v| {
                (r.0.min(*v), r.1.max(*v))
            });
        let step = ((high - low) / CONTOURS).max(1e-9);
        let band = |k: usize| (z[k] / step).floor();
        for (k, height) in z.iter().enumerate() {
            let (i, j) = (k % n, k / n);
            let edge =
                (i + 1 < n && band(k) != band(k + 1)) || (j + 1 < n && band(k) != band(k + n));
            let color = if !height.is_finite() {
                color::PAPER
            } else if edge {
                CONTOUR
            } else {
                GROUND
            };
            canvas.blend(
                self.left as i64 + i as i64,
                TOP as i64 + j as i64,
                color,
                1.0,
            );
        }
    }

    /// The parts of a line within the pane, in pixels.
    fn clipped(&self, line: &Line) -> Vec<Vec<[f32; 2]>> {
        let mut out: Vec<Vec<[f32; 2]>> = Vec::new();
        let mut run: Vec<[f32; 2]> = Vec::new();
        for w in line.points.windows(2) {
            let (a, b) = (w[0].xy(), w[1].xy());
            let Some((s, t)) = self.within(&a, &b) else {
                out.push(std::mem::take(&mut run));
                continue;
            };
            if s > 0.0 || run.is_empty() {
                out.push(std::mem::take(&mut run));
                run.push(self.pixel(&(a + (b - a) * s)));
            }
            run.push(self.pixel(&(a + (b - a) * t)));
            if t < 1.0 {
                out.push(std::mem::take(&mut run));
            }
        }
        out.push(run);
        out.retain(|r| r.len() > 1);
        out
    }

    /// From which share of the way to which a straight line lies in the pane (Liang and Barsky).
    fn within(&self, a: &Point2, b: &Point2) -> Option<(f64, f64)> {
        let (p, d) = (a - self.center, b - a);
        let (mut s, mut t) = (0.0f64, 1.0f64);
        for (p, d) in [(p.x, d.x), (p.y, d.y)] {
            if d.abs() < 1e-12 {
                if p.abs() > self.half {
                    return None;
                }
                continue;
            }
            let (u, v) = ((-self.half - p) / d, (self.half - p) / d);
            s = s.max(u.min(v));
            t = t.min(u.max(v));
        }
        (s < t).then_some((s, t))
    }

    /// Dots where the path turns too sharply, and the largest turn in figures.
    fn marks(&self, canvas: &mut Canvas, scene: &CloseUp<'_>, pane: &Pane<'_>) {
        let [limit, loud] = scene.limits;
        let inside = |m: &&TurnMark| (m.at - self.center).norm() <= scene.reach;
        for m in pane
            .turns
            .iter()
            .filter(inside)
            .filter(|m| m.degrees > limit)
        {
            let color = if m.degrees > loud { color::LOUD } else { AMBER };
            let [x, y] = self.pixel(&m.at);
            dot(canvas, x, y, 4.5, color);
        }
        let largest = pane
            .turns
            .iter()
            .filter(inside)
            .reduce(|a, b| if b.degrees > a.degrees { b } else { a });
        let words = match largest {
            Some(m) => {
                let [x, y] = self.pixel(&m.at);
                let right = x > self.left + 0.75 * self.side;
                let (dx, align) = if right {
                    (-10.0, Align::Right)
                } else {
                    (10.0, Align::Left)
                };
                let text = format!("{:.0}", m.degrees);
                canvas.rimmed_text(x + dx, y - 8.0, 16.0, align, color::INK, &text);
                format!("largest turn in the circle {:.1} deg", m.degrees)
            }
            None => "no turns in the circle".to_string(),
        };
        let y = TOP + self.side + 8.0;
        canvas.text(self.left, y, 17.0, Align::Left, color::INK, &words);
    }
}

fn dot(canvas: &mut Canvas, x: f32, y: f32, r: f32, color: Rgb) {
    let ring: Vec<[f32; 2]> = (0..16)
        .map(|k| {
            let (s, c) = (k as f32 * std::f32::consts::TAU / 16.0).sin_cos();
            [x + r * c, y + r * s]
        })
        .collect();
    canvas.polygon(&ring, color, Some(&Pen::solid(color::PAPER, 1.0)));
}

fn legend(canvas: &mut Canvas, scene: &CloseUp<'_>, side: f32) {
    let y = TOP + side + 38.0;
    let mut x = MARGIN;
    for (kind, words) in [
        (LineKind::Cut, "passes"),
        (LineKind::Link, "from pass to pass"),
    ] {
        canvas.line(&[[x, y + 9.0], [x + 26.0, y + 9.0]], &kind.pen(0));
        x += 34.0 + canvas.text(x + 34.0, y, 15.5, Align::Left, color::INK, words) + 22.0;
    }
    let [limit, loud] = scene.limits;
    for (color, words) in [
        (AMBER, format!("turn over {limit:.0} deg")),
        (color::LOUD, format!("over {loud:.0} deg")),
    ] {
        dot(canvas, x + 6.0, y + 9.0, 4.5, color);
        x += 18.0 + canvas.text(x + 18.0, y, 15.5, Align::Left, color::INK, &words) + 22.0;
    }
    let scale = f64::from(side) / (2.0 * SEEN * scene.reach);
    scale_bar(canvas, scale, x, y + 7.0);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point;

    fn heights() -> Raster<f32> {
        Raster {
            origin: Point2::new(-10.0, -10.0),
            step: 1.0,
            nx: 21,
            ny: 21,
            values: (0..441)
                .map(|k| {
                    let (x, y) = ((k % 21) as f32 - 10.0, (k / 21) as f32 - 10.0);
                    0.01 * (x * x - y * y)
                })
                .collect(),
        }
    }

    fn drawn(turns: &[TurnMark]) -> Vec<u8> {
        let h = heights();
        let line = Line {
            kind: LineKind::Cut,
            feature: 0,
            points: vec![Point::new(-50.0, 0.3, 0.0), Point::new(50.0, 0.3, 0.0)],
        };
        let panes = [Pane {
            words: "one",
            lines: std::slice::from_ref(&line),
            turns,
        }];
        close_up(&CloseUp {
            title: "a saddle",
            subtitle: "",
            heights: &h,
            center: Point2::origin(),
            reach: 2.0,
            limits: [15.0, 30.0],
            panes: &panes,
            width_px: 500,
        })
        .unwrap()
    }

    fn count(png: &[u8], color: Rgb) -> usize {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png))
            .read_info()
            .unwrap();
        let mut buf = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut buf).unwrap();
        buf.chunks(3).filter(|c| **c == color).count()
    }

    #[test]
    fn a_sharp_turn_is_loud_a_gentle_one_is_not_marked() {
        let at = |degrees| TurnMark {
            at: Point2::new(0.5, 1.0),
            degrees,
        };
        let legend = count(&drawn(&[at(5.0)]), color::LOUD);
        assert!(count(&drawn(&[at(90.0)]), color::LOUD) > legend + 20);
        assert_eq!(count(&drawn(&[at(20.0)]), color::LOUD), legend);
        // Outside the circle it is another place's.
        let far = TurnMark {
            at: Point2::new(2.4, 0.0),
            degrees: 90.0,
        };
        assert_eq!(count(&drawn(&[far]), color::LOUD), legend);
    }

    #[test]
    fn lines_end_at_the_pane() {
        let f = Frame {
            left: 10.0,
            side: 100.0,
            center: Point2::origin(),
            half: 1.0,
        };
        let (s, t) = f
            .within(&Point2::new(-2.0, 0.0), &Point2::new(2.0, 0.0))
            .unwrap();
        assert!((s - 0.25).abs() < 1e-12 && (t - 0.75).abs() < 1e-12);
        assert_eq!(
            f.within(&Point2::new(-2.0, 2.0), &Point2::new(2.0, 2.0)),
            None
        );
    }
}
