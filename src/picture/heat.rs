//! A scalar field from above: colours you can read a number off, a limit that shouts.

use super::PictureError;
use super::canvas::{Align, Canvas};
use super::color::{self, Rgb};
use super::panel::{clip, heading, scale_bar};
use super::raster::Raster;
use crate::geom::Point2;

/// Where the tool went into the part.
#[derive(Clone, Copy, Debug)]
pub struct Gouge<'a> {
    /// Depth of cut below the part, in the unit of the field; NaN or 0 where there is none.
    pub depth: &'a Raster<f32>,
    /// Deeper than this is shown.
    pub limit: f64,
}

/// A field to show, with its scale from 0 to one and a half times the limit.
#[derive(Clone, Debug)]
pub struct HeatMap<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line, smaller.
    pub subtitle: &'a str,
    /// The field; NaN where it was not measured.
    pub field: &'a Raster<f32>,
    /// What it is, for the scale: "cusp height".
    pub quantity: &'a str,
    /// Its unit: "um".
    pub unit: &'a str,
    /// Where the alarm begins, in that unit; above zero.
    pub limit: f64,
    /// Gouges, on their own grid.
    pub gouge: Option<Gouge<'a>>,
    /// Heights of the part, mm, for a faint relief beneath the colours.
    pub heights: Option<&'a Raster<f32>>,
    /// Lines of figures for the side, e.g. percentiles.
    pub facts: &'a [String],
    /// Width of the picture, 400 to 4000 pixels; the height follows.
    pub width_px: u32,
}

const PANEL: f64 = 270.0;
const TOP: f64 = 98.0;
const MARGIN: f64 = 34.0;
const FOOT: f64 = 70.0;
const UNMEASURED: Rgb = [222, 225, 230];

/// Draws the map, X to the right, Y up. Where several nodes share a pixel the worst one shows; marks of alarm are at least
/// three pixels wide (five for a gouge), so that a single bad node is seen. PNG.
pub fn heat_map(map: &HeatMap<'_>) -> Result<Vec<u8>, PictureError> {
    let consistent = map.field.is_consistent() && map.limit > 0.0 && map.limit.is_finite();
    if !consistent {
        return Err(PictureError::Raster("field"));
    }
    if map.gouge.is_some_and(|g| !g.depth.is_consistent()) {
        return Err(PictureError::Raster("gouge"));
    }
    if map.heights.is_some_and(|h| !h.is_consistent()) {
        return Err(PictureError::Raster("height"));
    }
    if !(400..=4000).contains(&map.width_px) {
        return Err(PictureError::Size(map.width_px, 0));
    }
    if map.field.values.is_empty() {
        return Err(PictureError::Nothing("field"));
    }
    let f = map.field;
    let width = f64::from(map.width_px);
    let span = [f.step * f.nx as f64, f.step * f.ny as f64];
    let room = [width - PANEL - 2.0 * MARGIN, 0.8 * width];
    let scale = (room[0] / span[0]).min(room[1] / span[1]);
    let [w, h] = span.map(|s| (s * scale).round().max(1.0) as usize);
    let left = (MARGIN + 0.5 * (room[0] - w as f64)).round();
    let height = (TOP + h as f64 + FOOT).max(560.0);
    let mut canvas = Canvas::new(map.width_px, height as u32, color::PAPER)?;

    let value = worst_per_pixel(f, f, scale, w, h);
    let over = |v: f32| f64::from(v) > map.limit;
    let gouged: Vec<bool> = match map.gouge {
        Some(g) => worst_per_pixel(g.depth, f, scale, w, h)
            .iter()
            .map(|v| f64::from(*v) > g.limit)
            .collect(),
        None => vec![false; w * h],
    };
    let light = map.heights.map(|r| hillshade(&r.thinned(800)));
    let near = |k: usize, r: i64, test: &dyn Fn(usize) -> bool| {
        let (x, y) = ((k % w) as i64, (k / w) as i64);
        (-r..=r).any(|b| {
            (-r..=r).any(|a| {
                let (i, j) = (x + a, y + b);
                i >= 0
                    && j >= 0
                    && i < w as i64
                    && j < h as i64
                    && test(j as usize * w + i as usize)
            })
        })
    };
    for k in 0..w * h {
        let (x, y) = (k % w, k / w);
        let v = value[k];
        let mut c = if v.is_nan() {
            UNMEASURED
        } else {
            color_of(f64::from(v), map.limit)
        };
        if let Some(light) = &light {
            let p = Point2::new(
                f.origin.x + (x as f64 + 0.5) / scale - 0.5 * f.step,
                f.origin.y + (h as f64 - y as f64 - 0.5) / scale - 0.5 * f.step,
            );
            let l = light.bilinear(p);
            if l.is_finite() {
                c = c.map(|v| (f32::from(v) * l).clamp(0.0, 255.0) as u8);
            }
        }
        if !over(v) && near(k, 1, &|q| over(value[q])) {
            c = color::LOUD;
        }
        if near(k, 2, &|q| gouged[q]) {
            c = color::GOUGE;
        }
        canvas.blend(left as i64 + x as i64, TOP as i64 + y as i64, c, 1.0);
    }
    canvas.frame(
        left as f32 - 1.0,
        TOP as f32 - 1.0,
        w as f32 + 2.0,
        h as f32 + 2.0,
        color::INK,
    );
    heading(&mut canvas, map.title, map.subtitle);
    panel(
        &mut canvas,
        map,
        (width - PANEL) as f32 + 16.0,
        gouged.iter().any(|g| *g),
    );
    scale_bar(
        &mut canvas,
        scale,
        left as f32,
        (TOP + h as f64) as f32 + 28.0,
    );
    let (cw, ch) = (canvas.width() as f32, canvas.height() as f32);
    canvas.frame(0.0, 0.0, cw, ch, color::INK);
    canvas.png()
}

/// Up to the limit a calm ramp, above it alarm.
fn color_of(v: f64, limit: f64) -> Rgb {
    if v <= limit {
        color::ramp(v / limit)
    } else {
        color::mix(color::LOUD, color::LOUDEST, (v / limit - 1.0) / 0.5)
    }
}

/// The largest value among the nodes whose cells a pixel touches; between nodes that are wider apart than pixels, the nearest.
/// Pixel rows run down from the largest y of `frame`, whose cells fill the picture.
fn worst_per_pixel(
    field: &Raster<f32>,
    frame: &Raster<f32>,
    scale: f64,
    w: usize,
    h: usize,
) -> Vec<f32> {
    // Nodes (first, last) whose cells overlap the pixel's span, at least the nearest.
    let reach = |pixel: usize, origin: f64, start: f64| {
        let at = |p: f64| (start - 0.5 * frame.step + p / scale - origin) / field.step;
        let (a, b) = (at(pixel as f64), at(pixel as f64 + 1.0));
        let middle = (0.5 * (a + b)).round() as i64;
        (
            (a.ceil() as i64).min(middle),
            (b.ceil() as i64 - 1).max(middle),
        )
    };
    let mut out = Vec::with_capacity(w * h);
    for y in 0..h {
        let rows = reach(h - 1 - y, field.origin.y, frame.origin.y);
        for x in 0..w {
            let columns = reach(x, field.origin.x, frame.origin.x);
            let mut worst = f32::NAN;
            for j in rows.0..=rows.1 {
                for i in columns.0..=columns.1 {
                    worst = worst.max(field.get(i, j).unwrap_or(f32::NAN));
                }
            }
            out.push(worst);
        }
    }
    out
}

/// Brightness around 1 under a light from the upper left.
fn hillshade(heights: &Raster<f32>) -> Raster<f32> {
    let at = |i: i64, j: i64| heights.get(i, j).unwrap_or(f32::NAN);
    let step = heights.step as f32;
    let values = (0..heights.ny as i64)
        .flat_map(|j| (0..heights.nx as i64).map(move |i| (i, j)))
        .map(|(i, j)| {
            let (sx, sy) = (
                (at(i + 1, j) - at(i - 1, j)) / (2.0 * step),
                (at(i, j + 1) - at(i, j - 1)) / (2.0 * step),
            );
            let lit = (0.5 * sx - 0.5 * sy + 0.7) / (sx * sx + sy * sy + 1.0).sqrt();
            0.86 + 0.2 * lit.max(0.0)
        })
        .collect();
    Raster {
        values,
        ..heights.clone()
    }
}

fn panel(canvas: &mut Canvas, map: &HeatMap<'_>, x: f32, any_gouge: bool) {
    let y0 = TOP as f32 + 34.0;
    let (bar, tall) = (26.0, 300.0);
    let top = 1.5 * map.limit;
    canvas.text(
        x,
        TOP as f32,
        15.0,
        Align::Left,
        color::INK,
        &format!("{}, {}", map.quantity, micro(map.unit)),
    );
    for row in 0..tall as i32 {
        let v = top * (1.0 - f64::from(row) / f64::from(tall));
        canvas.rect(x, y0 + row as f32, bar, 1.0, color_of(v, map.limit));
    }
    canvas.frame(x, y0, bar, tall, color::INK);
    let number = |v: f64| {
        let digits = if map.limit >= 20.0 { 0 } else { 1 };
        let s = format!("{v:.digits$}");
        s.strip_suffix(".0").map_or(s.clone(), str::to_string)
    };
    for k in 0..=6 {
        let v = top * f64::from(k) / 6.0;
        let y = y0 + tall * (1.0 - k as f32 / 6.0);
        let at_limit = k == 4;
        let (length, color) = if at_limit {
            (14.0, color::LOUD)
        } else {
            (7.0, color::INK)
        };
        canvas.rect(
            x + bar,
            y - 1.0,
            length,
            if at_limit { 3.0 } else { 1.5 },
            color,
        );
        let words = if at_limit {
            format!("{}  limit", number(v))
        } else {
            number(v)
        };
        canvas.text(x + bar + 18.0, y - 7.0, 15.5, Align::Left, color, &words);
    }
    let mut y = y0 + tall + 22.0;
    let mut key = |canvas: &mut Canvas, color: Rgb, words: &str| {
        canvas.rect(x, y, 18.0, 14.0, color);
        canvas.frame(x, y, 18.0, 14.0, color::INK);
        canvas.text(x + 26.0, y, 15.5, Align::Left, color::INK, words);
        y += 23.0;
    };
    key(canvas, color::LOUD, "above the limit");
    if let Some(g) = map.gouge {
        let words = format!(
            "gouge over {} {}{}",
            number(g.limit),
            micro(map.unit),
            if any_gouge { "" } else { ": none" }
        );
        key(canvas, color::GOUGE, &words);
    }
    key(canvas, UNMEASURED, "not measured");
    y += 12.0;
    for fact in map.facts {
        canvas.text(
            x,
            y,
            14.0,
            Align::Left,
            color::INK,
            &clip(&fact.replace(" um", " \u{b5}m"), 15.5, PANEL as f32 - 40.0),
        );
        y += 21.0;
    }
}

fn micro(unit: &str) -> String {
    if unit == "um" {
        "\u{b5}m".to_string()
    } else {
        unit.to_string()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn map(field: &Raster<f32>) -> HeatMap<'_> {
        HeatMap {
            title: "cusp",
            subtitle: "",
            field,
            quantity: "cusp height",
            unit: "um",
            limit: 20.0,
            gouge: None,
            heights: None,
            facts: &[],
            width_px: 500,
        }
    }

    fn flat(n: usize) -> Raster<f32> {
        Raster {
            origin: Point2::new(0.0, 0.0),
            step: 0.05,
            nx: n,
            ny: n,
            values: vec![5.0; n * n],
        }
    }

    /// Pixels of a colour in a PNG.
    fn count(png: &[u8], color: Rgb) -> usize {
        let p = tiny_skia::Pixmap::decode_png(png).unwrap();
        p.pixels()
            .iter()
            .filter(|q| [q.red(), q.green(), q.blue()] == color)
            .count()
    }

    #[test]
    fn one_bad_node_among_a_million_is_seen() {
        let mut f = flat(1000);
        let calm = count(&heat_map(&map(&f)).unwrap(), color::LOUD);
        f.values[400_300] = 20.5;
        let bad = count(&heat_map(&map(&f)).unwrap(), color::LOUD);
        assert!(bad >= calm + 8, "{calm} {bad}");
        f.values[400_300] = 20.0;
        assert_eq!(count(&heat_map(&map(&f)).unwrap(), color::LOUD), calm);
        // A gouge on another grid.
        let mut g = flat(100);
        g.step = 0.5;
        g.values.fill(0.0);
        g.values[5050] = 4.0;
        let with = |limit| HeatMap {
            gouge: Some(Gouge { depth: &g, limit }),
            ..map(&f)
        };
        let none = count(&heat_map(&with(4.0)).unwrap(), color::GOUGE);
        assert!(count(&heat_map(&with(3.0)).unwrap(), color::GOUGE) >= none + 8);
    }

    #[test]
    fn every_node_falls_into_some_pixel() {
        for (n, w) in [(10usize, 37usize), (37, 10), (50, 50), (1, 5)] {
            for k in 0..n * n {
                let mut f = flat(n);
                f.values[k] = 9.0;
                let scale = w as f64 / (n as f64 * f.step);
                assert!(
                    worst_per_pixel(&f, &f, scale, w, w).contains(&9.0),
                    "{n} {w} {k}"
                );
            }
        }
    }

    #[test]
    fn refusals() {
        let mut f = flat(10);
        for limit in [0.0, -1.0, f64::NAN] {
            assert!(heat_map(&HeatMap { limit, ..map(&f) }).is_err());
        }
        f.values.pop();
        assert_eq!(
            heat_map(&map(&f)).unwrap_err(),
            PictureError::Raster("field")
        );
        f = flat(10);
        f.values.fill(f32::NAN);
        assert!(heat_map(&map(&f)).is_ok());
    }
}
