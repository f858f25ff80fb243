//! What is written around a picture: heading, legend, scale.

use super::canvas::{Align, Canvas, Pen};
use super::color;
use super::scene::{Line, LineKind, MarkerKind, PANEL, Scene, TOP, symbol};

/// The two lines at the top and the rule beneath them.
pub(super) fn heading(canvas: &mut Canvas, title: &str, subtitle: &str) {
    canvas.text(28.0, 20.0, 29.0, Align::Left, color::INK, title);
    canvas.text(28.0, 54.0, 17.0, Align::Left, color::FADED, subtitle);
    let w = canvas.width() as f32;
    canvas.rect(28.0, 79.0, w - 56.0, 1.0, [214, 218, 224]);
}

/// The legend right of the picture, from x on: critical points, features, kinds of lines.
pub(super) fn panel(canvas: &mut Canvas, scene: &Scene<'_>, lines: Option<&[Line]>, x: f32) {
    const ROW: f32 = 23.0;
    let mut y = TOP as f32 + 8.0;
    let head = |canvas: &mut Canvas, y: &mut f32, words: &str| {
        canvas.text(x, *y, 16.5, Align::Left, color::FADED, words);
        *y += ROW + 2.0;
    };
    if !scene.markers.is_empty() {
        head(canvas, &mut y, "Critical points");
        for (kind, name) in [
            (MarkerKind::Max, "peak"),
            (MarkerKind::Min, "pit"),
            (MarkerKind::Saddle, "saddle"),
        ] {
            let count = scene.markers.iter().filter(|m| m.kind == kind).count();
            symbol(canvas, kind, x + 9.0, y + 8.0, 7.0);
            canvas.text(
                x + 26.0,
                y,
                15.0,
                Align::Left,
                color::INK,
                &format!("{count} {name}{}", if count == 1 { "" } else { "s" }),
            );
            y += ROW;
        }
        y += 12.0;
    }
    if let Some(lines) = lines {
        head(canvas, &mut y, "Tool");
        for kind in LineKind::ALL {
            if lines.iter().any(|l| l.kind == kind) {
                canvas.line(
                    &[[x, y + 8.0], [x + 20.0, y + 8.0]],
                    &Pen {
                        width: 2.0,
                        ..kind.pen(0)
                    },
                );
                canvas.text(x + 28.0, y, 16.5, Align::Left, color::INK, kind.name());
                y += ROW;
            }
        }
        y += 12.0;
    }
    if !scene.features.is_empty() {
        head(canvas, &mut y, "Features");
        let most = 16;
        for (label, words) in scene.features.iter().take(most) {
            canvas.rect(
                x,
                y + 1.0,
                18.0,
                14.0,
                color::mix(color::STONE, color::feature(*label), 0.85),
            );
            canvas.frame(x, y + 1.0, 18.0, 14.0, color::INK);
            canvas.text(
                x + 26.0,
                y,
                14.0,
                Align::Left,
                color::INK,
                &clip(words, 15.5, PANEL as f32 - 54.0),
            );
            y += ROW;
        }
        if scene.features.len() > most {
            let more = format!("and {} more", scene.features.len() - most);
            canvas.text(x + 26.0, y, 15.5, Align::Left, color::FADED, &more);
        }
    }
}

/// Words cut to a width, two dots at the cut.
pub(super) fn clip(words: &str, size: f32, width: f32) -> String {
    if Canvas::text_width(size, words) <= width {
        return words.to_string();
    }
    let mut s = String::new();
    for c in words.chars() {
        s.push(c);
        if Canvas::text_width(size, &s) > width - size {
            break;
        }
    }
    s.push_str("..");
    s
}

/// A bar of a round number of mm, about 100 to 250 pixels long, its left end at x.
pub(super) fn scale_bar(canvas: &mut Canvas, px_per_mm: f64, x: f32, y: f32) {
    let mut mm = 1000.0;
    for (k, step) in (0..).zip([0.4, 0.5, 0.5].iter().cycle()) {
        if mm * px_per_mm <= 220.0 || k > 24 {
            break;
        }
        mm *= step;
    }
    let w = (mm * px_per_mm) as f32;
    canvas.rect(x, y, w, 3.0, color::INK);
    canvas.rect(x, y - 5.0, 2.0, 13.0, color::INK);
    canvas.rect(x + w - 2.0, y - 5.0, 2.0, 13.0, color::INK);
    let words = format!("{} mm", (mm * 1000.0).round() / 1000.0);
    canvas.text(x + w + 10.0, y - 6.0, 15.5, Align::Left, color::INK, &words);
}
