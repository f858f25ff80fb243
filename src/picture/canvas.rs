//! A sheet to draw on: filled shapes, smooth lines, words. Pixels, y downwards.

use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform,
};

use super::PictureError;
use super::color::Rgb;
use super::text::{self, glyph};

/// A picture in the making. Always opaque.
pub struct Canvas {
    pixmap: Pixmap,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Colour.
    pub color: Rgb,
    /// 0 invisible, 255 solid.
    pub alpha: u8,
    /// Width in pixels.
    pub width: f32,
    /// Dash and gap in pixels.
    pub dash: Option<[f32; 2]>,
}

impl Pen {
    /// A solid pen.
    pub fn solid(color: Rgb, width: f32) -> Self {
        Pen {
            color,
            alpha: 255,
            width,
            dash: None,
        }
    }
}

/// Horizontal alignment of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// They begin at x.
    Left,
    /// Their middle is at x.
    Center,
    /// They end at x.
    Right,
}

impl Canvas {
    /// A sheet of one colour.
    pub fn new(width: u32, height: u32, color: Rgb) -> Result<Self, PictureError> {
        if width == 0 || height == 0 || width > 8000 || height > 8000 {
            return Err(PictureError::Size(width, height));
        }
        let mut pixmap = Pixmap::new(width, height).ok_or(PictureError::Size(width, height))?;
        pixmap.fill(tiny_skia::Color::from_rgba8(
            color[0], color[1], color[2], 255,
        ));
        Ok(Canvas { pixmap })
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.pixmap.width()
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.pixmap.height()
    }

    /// The finished picture.
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        let failed = |e: png::EncodingError| PictureError::Png(e.to_string());
        // Everything is drawn on an opaque ground: leave the alpha out, a quarter of the bytes.
        let rgb: Vec<u8> = self
            .pixmap
            .pixels()
            .iter()
            .flat_map(|p| [p.red(), p.green(), p.blue()])
            .collect();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.pixmap.width(), self.pixmap.height());
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&rgb).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }

    /// Lays a colour over one pixel; places outside are ignored.
    pub fn blend(&mut self, x: i64, y: i64, color: Rgb, cover: f32) {
        if x < 0 || y < 0 || x >= i64::from(self.width()) || y >= i64::from(self.height()) {
            return;
        }
        let at = 4 * (y as usize * self.width() as usize + x as usize);
        let cover = cover.clamp(0.0, 1.0);
        if let Some(pixel) = self.pixmap.data_mut().get_mut(at..at + 3) {
            for (p, c) in pixel.iter_mut().zip(color) {
                let (old, new) = (f32::from(*p), f32::from(c));
                *p = (old + (new - old) * cover).round() as u8;
            }
        }
    }

    fn paint(pen: &Pen) -> Paint<'static> {
        let mut paint = Paint::default();
        paint.set_color_rgba8(pen.color[0], pen.color[1], pen.color[2], pen.alpha);
        paint.anti_alias = true;
        paint
    }

    fn path(points: &[[f32; 2]], close: bool) -> Option<tiny_skia::Path> {
        let mut b = PathBuilder::with_capacity(points.len() + 1, points.len());
        let mut points = points
            .iter()
            .filter(|p| p[0].is_finite() && p[1].is_finite());
        let first = points.next()?;
        b.move_to(first[0], first[1]);
        points.for_each(|p| b.line_to(p[0], p[1]));
        if close {
            b.close();
        }
        b.finish()
    }

    fn stroke(&mut self, path: &tiny_skia::Path, pen: &Pen, stroke: &Stroke) {
        let paint = Self::paint(pen);
        self.pixmap
            .stroke_path(path, &paint, stroke, Transform::identity(), None);
    }

    /// An open polyline.
    pub fn line(&mut self, points: &[[f32; 2]], pen: &Pen) {
        let stroke = Stroke {
            width: pen.width,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            dash: pen.dash.and_then(|d| StrokeDash::new(d.to_vec(), 0.0)),
            ..Stroke::default()
        };
        if let Some(path) = Self::path(points, false) {
            self.stroke(&path, pen, &stroke);
        }
    }

    /// A filled polygon with an outline.
    pub fn polygon(&mut self, points: &[[f32; 2]], fill: Rgb, outline: Option<&Pen>) {
        let Some(path) = Self::path(points, true) else {
            return;
        };
        let paint = Self::paint(&Pen::solid(fill, 0.0));
        self.pixmap.fill_path(
            &path,
            &paint,
            FillRule::Winding,
            Transform::identity(),
            None,
        );
        if let Some(pen) = outline {
            let stroke = Stroke {
                width: pen.width,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            self.stroke(&path, pen, &stroke);
        }
    }

    /// A filled box.
    pub fn rect(&mut self, x: f32, y: f32, width: f32, height: f32, color: Rgb) {
        if let Some(r) = Rect::from_xywh(x, y, width, height) {
            self.pixmap.fill_rect(
                r,
                &Self::paint(&Pen::solid(color, 0.0)),
                Transform::identity(),
                None,
            );
        }
    }

    /// The outline of a box, inside its edges.
    pub fn frame(&mut self, x: f32, y: f32, width: f32, height: f32, color: Rgb) {
        self.rect(x, y, width, 1.0, color);
        self.rect(x, y + height - 1.0, width, 1.0, color);
        self.rect(x, y, 1.0, height, color);
        self.rect(x + width - 1.0, y, 1.0, height, color);
    }

    /// Width of words of a size (height of a line of text, pixels).
    pub fn text_width(size: f32, words: &str) -> f32 {
        let units: f32 = words.chars().map(|c| glyph(c).1).sum();
        units * size / text::HEIGHT
    }

    /// Words; `y` is the top of the line. Gives their width. Characters without a drawing become question marks.
    pub fn text(
        &mut self,
        x: f32,
        y: f32,
        size: f32,
        align: Align,
        color: Rgb,
        words: &str,
    ) -> f32 {
        self.write(
            x,
            y,
            size,
            align,
            &Pen::solid(color, Self::nib(size)),
            words,
        )
    }

    /// Words with a light rim, legible on any ground.
    pub fn rimmed_text(
        &mut self,
        x: f32,
        y: f32,
        size: f32,
        align: Align,
        color: Rgb,
        words: &str,
    ) {
        let rim = Pen {
            alpha: 225,
            ..Pen::solid([255, 255, 255], Self::nib(size) + 4.5)
        };
        self.write(x, y, size, align, &rim, words);
        self.text(x, y, size, align, color, words);
    }

    /// Width of the pen that suits a size: a little bolder for small letters.
    fn nib(size: f32) -> f32 {
        0.085 * size + 0.45
    }

    fn write(&mut self, x: f32, y: f32, size: f32, align: Align, pen: &Pen, words: &str) -> f32 {
        let width = Self::text_width(size, words);
        let scale = size / text::HEIGHT;
        let mut left = match align {
            Align::Left => x,
            Align::Center => x - width / 2.0,
            Align::Right => x - width,
        } + scale;
        let top = y + text::CAP * scale;
        let mut b = PathBuilder::new();
        for c in words.chars() {
            let (strokes, advance) = glyph(c);
            for s in &strokes {
                let p: Vec<[f32; 2]> = s
                    .points
                    .iter()
                    .map(|q| [left + q[0] * scale, top + q[1] * scale])
                    .collect();
                Self::trace(&mut b, &p, s.smooth, s.closed);
            }
            left += advance * scale;
        }
        if let Some(path) = b.finish() {
            let stroke = Stroke {
                width: pen.width,
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            self.stroke(&path, pen, &stroke);
        }
        width
    }

    fn trace(b: &mut PathBuilder, p: &[[f32; 2]], smooth: bool, closed: bool) {
        let middle = |a: [f32; 2], b: [f32; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let (Some(&first), Some(&last)) = (p.first(), p.last()) else {
            return;
        };
        if closed {
            let start = middle(last, first);
            b.move_to(start[0], start[1]);
            for k in 0..p.len() {
                let end = middle(p[k], p[(k + 1) % p.len()]);
                b.quad_to(p[k][0], p[k][1], end[0], end[1]);
            }
            b.close();
        } else if smooth && p.len() > 2 {
            b.move_to(first[0], first[1]);
            for k in 1..p.len() - 1 {
                let end = if k + 2 == p.len() {
                    last
                } else {
                    middle(p[k], p[k + 1])
                };
                b.quad_to(p[k][0], p[k][1], end[0], end[1]);
            }
        } else {
            b.move_to(first[0], first[1]);
            p.iter().skip(1).for_each(|q| b.line_to(q[0], q[1]));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn words_leave_ink_and_have_their_width() {
        let mut c = Canvas::new(200, 40, [255; 3]).unwrap();
        let w = c.text(10.0, 10.0, 16.0, Align::Left, [0; 3], "Iµ \u{4e00}");
        assert!(w > 20.0 && w < 64.0, "{w}");
        let dark = c.pixmap.data().chunks(4).filter(|p| p[0] < 128).count();
        assert!(dark > 40, "{dark}");
        assert_eq!(Canvas::text_width(16.0, ""), 0.0);
        // Two digits, two columns of figures: equal widths.
        assert_eq!(
            Canvas::text_width(16.0, "11"),
            Canvas::text_width(16.0, "88")
        );
    }

    #[test]
    fn nonsense_is_ignored_or_refused() {
        assert_eq!(
            Canvas::new(0, 5, [0; 3]).err().unwrap().to_string(),
            "a picture of 0 x 5 pixels cannot be made: ask for a width of 400 to 4000"
        );
        let mut c = Canvas::new(20, 20, [255; 3]).unwrap();
        let pen = Pen::solid([0; 3], 1.0);
        c.line(&[[f32::NAN, 1.0], [f32::INFINITY, 2.0]], &pen);
        c.line(&[], &pen);
        c.polygon(&[[1.0, 1.0]], [0; 3], Some(&pen));
        c.rect(1.0, 1.0, -5.0, f32::NAN, [0; 3]);
        c.line(&[[-1e9, 1.0], [1e9, 2.0]], &pen);
        assert!(c.png().unwrap().starts_with(b"\x89PNG"));
    }
}
