//! Letters as an engraver cuts them: one pen, single strokes. Drawn for this program, legible from 11 pixels up.
//!
//! A glyph is a list of strokes on a small lattice: x to the right from 0, y down from the cap line 0 over the x-height 3 to the
//! baseline 9 and the descender c (hexadecimal). The first character of a stroke says how its points are joined:
//!
//! ```text
//! -   straight from point to point
//! ~   a quadratic B-spline: first and last points are met, those between are pulled towards
//! o   the same, closed: four corners make an oval
//! ```

/// Strokes of a glyph; none for a character that is not drawn (a question mark stands in).
fn strokes(c: char) -> Option<&'static str> {
    Some(match c {
        ' ' => "",
        'A' => "-093069 -1656",
        'B' => "-0009 ~003050543404 ~043464693909",
        'C' => "~626000096967",
        'D' => "-0009 ~002060692909",
        'E' => "-50000959 -0444",
        'F' => "-500009 -0444",
        'G' => "~626000096965 -6535",
        'H' => "-0009 -6069 -0464",
        'I' => "-0009",
        'J' => "~4046490907",
        'K' => "-0009 -6005 -2369",
        'L' => "-000959",
        'M' => "-0900356069",
        'N' => "-09006960",
        'O' => "o00606909",
        'P' => "-0009 ~003060653505",
        'Q' => "o00606909 -467a",
        'R' => "-0009 ~003060653505 -3569",
        'S' => "~6160000465690908",
        'T' => "-0060 -3039",
        'U' => "~000509696560",
        'V' => "-003960",
        'W' => "-0029426980",
        'X' => "-0069 -6009",
        'Y' => "-003460 -3439",
        'Z' => "-00600969",
        'a' => "o03535909 -5359",
        'b' => "-0009 o03535909",
        'c' => "~545303095958",
        'd' => "-5059 o03535909",
        'e' => "-0656 ~565303095958",
        'f' => "~40101419 -0333",
        'g' => "o03535909 ~53595c0c0b",
        'h' => "-0009 ~0513535659",
        'i' => "-0309 -0001",
        'j' => "~23292c0c -2021",
        'k' => "-0009 -4307 -2559",
        'l' => "-0009",
        'm' => "-0309 ~0513434649 ~4553838689",
        'n' => "-0309 ~0513535659",
        'o' => "o03535909",
        'p' => "-030c o03535909",
        'q' => "-535c o03535909",
        'r' => "-0309 ~060333",
        's' => "~4443030646490908",
        't' => "~11161949 -0333",
        'u' => "~0306094957 -5359",
        'v' => "-032943",
        'w' => "-0329446983",
        'x' => "-0349 -4309",
        'y' => "-0329 -431c",
        'z' => "-03430949",
        '0' => "o00505909",
        '1' => "-123039",
        '2' => "~0200505409 -0959",
        '3' => "~0100505424 ~2454590908",
        '4' => "-49400656",
        '5' => "-500004 ~041353590908",
        '6' => "~400106 o04545909",
        '7' => "-005029",
        '8' => "o00505404 o04545909",
        '9' => "o00505505 ~535819",
        '.' => "-0809",
        ',' => "-180b",
        ':' => "-0405 -0809",
        ';' => "-1415 -180b",
        '-' | '\u{2013}' => "-0646",
        '\u{2014}' => "-0666",
        '+' => "-0565 -3238",
        '_' => "-0a6a",
        '/' => "-500a",
        '\\' => "-005a",
        '|' => "-000b",
        '(' => "~20052a",
        ')' => "~00250a",
        '[' => "-20000a2a",
        ']' => "-00202a0a",
        '%' => "o00202303 -6009 o46666949",
        '=' => "-0464 -0767",
        '<' => "-520558",
        '>' => "-025508",
        '*' => "-3137 -0265 -0562",
        '#' => "-2018 -5048 -0363 -0666",
        '"' => "-0002 -2022",
        '\'' => "-0002",
        '!' => "-0006 -0809",
        '?' => "~020050542426 -2829",
        '^' => "-042044",
        '~' => "~06036865",
        '\u{b0}' => "o00303303",
        '\u{b1}' => "-0464 -3137 -0969",
        '\u{b2}' => "~0100303204 -0434",
        '\u{b3}' => "~01003032 ~12323404",
        '\u{b5}' | '\u{3bc}' => "-030c ~0306094957 -5359",
        '\u{d7}' => "-0448 -4408",
        '\u{2192}' => "-0666 -446648",
        _ => return None,
    })
}

/// One pen stroke in lattice units.
pub struct Stroke {
    /// True for B-splines.
    pub smooth: bool,
    /// True when the end meets the beginning.
    pub closed: bool,
    /// Lattice points.
    pub points: Vec<[f32; 2]>,
}

/// A character's strokes and its width to the next one, in lattice units.
pub fn glyph(c: char) -> (Vec<Stroke>, f32) {
    let drawing = strokes(c).unwrap_or("~020050542426 -2829");
    let list: Vec<Stroke> = drawing
        .split_ascii_whitespace()
        .map(|s| {
            let digits: Vec<f32> = s
                .chars()
                .filter_map(|d| d.to_digit(16))
                .map(|d| d as f32)
                .collect();
            Stroke {
                smooth: !s.starts_with('-'),
                closed: s.starts_with('o'),
                points: digits.chunks_exact(2).map(|p| [p[0], p[1]]).collect(),
            }
        })
        .collect();
    let widest = list
        .iter()
        .flat_map(|s| &s.points)
        .map(|p| p[0])
        .fold(0.0, f32::max);
    let advance = match c {
        ' ' => 4.2,
        // Figures stand in columns.
        _ if c.is_ascii_digit() => 7.4,
        _ => widest + 2.5,
    };
    (list, advance)
}

/// Lattice units from the top of a line of text to the cap line, and in its whole height.
pub const CAP: f32 = 1.4;
/// See [`CAP`].
pub const HEIGHT: f32 = 13.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_character_we_use_is_drawn() {
        for c in ('a'..='z')
            .chain('A'..='Z')
            .chain('0'..='9')
            .chain(".,:;-+/()%=<>°µ²".chars())
        {
            assert!(strokes(c).is_some(), "{c}");
            let (list, advance) = glyph(c);
            assert!(!list.is_empty() && advance > 2.0);
            for s in &list {
                assert!(s.points.len() >= 2, "{c}");
                assert!(s.points.iter().all(|p| p[0] <= 9.0 && p[1] <= 12.0), "{c}");
            }
        }
        assert_eq!(glyph('\u{4e00}').0.len(), glyph('?').0.len());
    }
}
