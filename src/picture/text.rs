//! Letters: the public-domain 8 x 8 bitmap font, rounded off so that it is pleasant at any size.

use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};

/// A glyph cut to its inked columns.
pub struct Glyph {
    rows: [u8; 8],
    first: u32,
    /// Inked columns, eighths of the size.
    pub columns: u32,
}

/// The glyph of a character; a question mark for one the font lacks.
pub fn glyph(c: char) -> Glyph {
    let rows = BASIC_FONTS
        .get(c)
        .or_else(|| LATIN_FONTS.get(c))
        .or_else(|| BASIC_FONTS.get('?'))
        .unwrap_or([0; 8]);
    let ink = rows.iter().fold(0, |a, r| a | r);
    // Bit 0 is the leftmost column. Digits keep one width, so that columns of figures line up.
    let (first, columns) = if c.is_ascii_digit() {
        (0, 7)
    } else if ink == 0 {
        (0, 4)
    } else {
        (ink.trailing_zeros(), 8 - ink.leading_zeros() - ink.trailing_zeros())
    };
    Glyph {
        rows,
        first,
        columns,
    }
}

impl Glyph {
    /// Ink (0 or 1) of a cell; columns are counted from the first inked one.
    fn ink(&self, column: i32, row: i32) -> f32 {
        let column = column + self.first as i32;
        let inside = (0..8).contains(&column) && (0..8).contains(&row);
        if inside && self.rows[row as usize] >> column & 1 == 1 { 1.0 } else { 0.0 }
    }

    /// How much ink covers a pixel whose middle is at (x, y) in cells and whose side is `pixel` cells: 0 to 1.
    ///
    /// The bitmap is smoothed (bilinear between cell middles) and cut at one half: corners come out round, strokes even.
    pub fn coverage(&self, x: f32, y: f32, pixel: f32) -> f32 {
        let mut sum = 0.0;
        for a in 0..3 {
            for b in 0..3 {
                let px = x + pixel * (a as f32 - 1.0) / 3.0 - 0.5;
                let py = y + pixel * (b as f32 - 1.0) / 3.0 - 0.5;
                let (i, j) = (px.floor(), py.floor());
                let (u, v) = (px - i, py - j);
                let at = |c: i32, r: i32| self.ink(i as i32 + c, j as i32 + r);
                let value = (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v)
                    + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v;
                let t = ((value - 0.36) / 0.2).clamp(0.0, 1.0);
                sum += t * t * (3.0 - 2.0 * t);
            }
        }
        sum / 9.0
    }
}
