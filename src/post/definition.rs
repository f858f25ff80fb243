//! A dialect as data: `posts/*.toml` read once into a checked [`Post`].

use super::comment::{CommentStyle, Comments};
use super::template::{Slot, Template};
use crate::machine::data::{self, Bounds, DataError, Reader};
use crate::units::Mm;
use serde::Deserialize;
use toml::Spanned;

/// The dialects that come with the program: name and text of each file in `posts/`, by rising name.
pub const BUILT_IN: [(&str, &str); 2] = [
    ("grbl", include_str!("../../posts/grbl.toml")),
    ("linuxcnc", include_str!("../../posts/linuxcnc.toml")),
];

/// Interpreters a dialect can name as the one that reads its programs.
pub const READERS: [&str; 2] = ["grbl", "linuxcnc"];

/// The units of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// G21.
    Mm,
    /// G20.
    Inch,
}

impl Units {
    /// Millimetres in one unit.
    pub fn mm(self) -> f64 {
        match self {
            Units::Mm => 1.0,
            Units::Inch => 25.4,
        }
    }

    /// The word that chooses these units.
    pub fn word(self) -> &'static str {
        match self {
            Units::Mm => "G21",
            Units::Inch => "G20",
        }
    }
}

/// Decimals of each class of word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals {
    /// X, Y, Z, I, J in mm.
    pub mm: u8,
    /// X, Y, Z, I, J in inches.
    pub inch: u8,
    /// F in mm/min.
    pub feed_mm: u8,
    /// F in inch/min.
    pub feed_inch: u8,
    /// S in rpm.
    pub speed: u8,
    /// P of a dwell in s.
    pub seconds: u8,
}

/// What may be left out when it has not changed since the last line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modal {
    /// The G0, G1, G2 or G3 of a line.
    pub motion: bool,
    /// An axis that does not move.
    pub axes: bool,
    /// F.
    pub feed: bool,
}

/// A dialect, checked: every figure is in its bounds and every template can be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Post {
    /// File name without `.toml`.
    pub name: String,
    /// What people call it.
    pub title: String,
    /// The interpreter that reads such programs back: one of [`READERS`].
    pub reader: String,
    /// Units of the program; the caller may change them.
    pub units: Units,
    /// G2 and G3 may be used.
    pub arcs: bool,
    /// Decimals of each class of word.
    pub decimals: Decimals,
    /// `"\n"` or `"\r\n"`.
    pub line_end: &'static str,
    /// Most characters in a line, without its end.
    pub longest: usize,
    /// Step of line numbers (N words); zero for none.
    pub number_step: u32,
    /// How comments are written.
    pub comments: Comments,
    /// What may be left out.
    pub modal: Modal,
    /// First lines: modes, path tolerance, tool.
    pub start: Vec<Template>,
    /// Spindle on and up to speed.
    pub spindle: Vec<Template>,
    /// Flood coolant on; empty when the dialect has none.
    pub flood: Vec<Template>,
    /// Mist coolant on; empty when the dialect has none.
    pub mist: Vec<Template>,
    /// Last lines: everything off, end of program.
    pub end: Vec<Template>,
    /// Path tolerance when the job names none.
    pub path_tolerance: Option<Mm>,
}

impl Post {
    /// Reads and checks a dialect called `name`. Unknown keys, missing keys, unknown placeholders and figures out of bounds are
    /// refused with line and column; all wrong values are reported, not only the first.
    pub fn from_toml(name: &str, text: &str) -> Result<Post, DataError> {
        Post::read(name, &format!("posts/{name}.toml"), text)
    }

    /// A built-in dialect by name, or a dialect file by path (anything with a `/`, or ending in `.toml`).
    pub fn load(name_or_path: &str) -> Result<Post, DataError> {
        let (name, file, text) = data::find("post", "posts", &BUILT_IN, name_or_path)?;
        Post::read(&name, &file, &text)
    }

    /// Decimals of X, Y and Z in the post's units.
    pub fn coordinate_decimals(&self) -> u8 {
        match self.units {
            Units::Mm => self.decimals.mm,
            Units::Inch => self.decimals.inch,
        }
    }

    /// Decimals of F in the post's units.
    pub fn feed_decimals(&self) -> u8 {
        match self.units {
            Units::Mm => self.decimals.feed_mm,
            Units::Inch => self.decimals.feed_inch,
        }
    }

    /// The worst error of a written coordinate, mm: half a unit of its last decimal.
    pub fn rounding(&self) -> Mm {
        Mm(0.5 * self.units.mm() * 0.1_f64.powi(i32::from(self.coordinate_decimals())))
    }

    fn read(name: &str, file: &str, text: &str) -> Result<Post, DataError> {
        let mut r = Reader::new(file, text, "posts");
        let f: File = r.parse()?;
        let title = f.title.get_ref().trim().to_string();
        if title.is_empty() {
            r.complain(
                "title",
                &f.title,
                "\"\"".into(),
                "must say what people call the dialect",
            );
        }
        let reader = r.word("reader", &f.reader, &READERS);
        let units = match r.word("units", &f.units, &["mm", "inch"]).as_str() {
            "inch" => Units::Inch,
            _ => Units::Mm,
        };
        let d = &f.decimals;
        let coarse = "positions in mm need 3 decimals, a micrometre; in inches 4 or 5";
        let decimals = Decimals {
            mm: whole(&mut r, "mm", &d.mm, [2, 6], coarse) as u8,
            inch: whole(&mut r, "inch", &d.inch, [3, 7], coarse) as u8,
            feed_mm: whole(&mut r, "feed_mm", &d.feed_mm, [0, 4], "0 or 1 is usual") as u8,
            feed_inch: whole(&mut r, "feed_inch", &d.feed_inch, [0, 5], "1 or 2 is usual") as u8,
            speed: whole(&mut r, "speed", &d.speed, [0, 3], "0 is usual") as u8,
            seconds: whole(&mut r, "seconds", &d.seconds, [0, 4], "2 is usual") as u8,
        };
        let line_end = match r.word("end", &f.lines.end, &["lf", "crlf"]).as_str() {
            "crlf" => "\r\n",
            _ => "\n",
        };
        let longest = whole(
            &mut r,
            "longest",
            &f.lines.longest,
            [40, 10_000],
            "GRBL takes 79 characters",
        );
        let number_step = whole(
            &mut r,
            "number_step",
            &f.lines.number_step,
            [0, 1000],
            "0 for no line numbers, 1 or 10",
        );
        let style = match r
            .word(
                "style",
                &f.comments.style,
                &["parentheses", "semicolon", "none"],
            )
            .as_str()
        {
            "semicolon" => CommentStyle::Semicolon,
            "none" => CommentStyle::None,
            _ => CommentStyle::Parentheses,
        };
        let charset = r.word("charset", &f.comments.charset, &["ascii", "ascii-upper"]);
        if f.comments
            .forbidden
            .get_ref()
            .contains(['_', '-', '[', ']', ' '])
        {
            let shown = format!("\"{}\"", f.comments.forbidden.get_ref());
            let problem = "may not hold _ - [ ] or a space: they stand in for what is left out";
            r.complain("forbidden", &f.comments.forbidden, shown, problem);
        }
        let path_tolerance = f.program.path_tolerance_mm.as_ref().map(|v| {
            let b = Bounds {
                min: 0.0,
                max: 1.0,
                above_min: true,
            };
            Mm(r.figure("path_tolerance_mm", v, b, "mm", "0.002 keeps the surface"))
        });
        let p = &f.program;
        let forbidden = f.comments.forbidden.get_ref().as_str();
        let post = Post {
            name: name.to_string(),
            title,
            reader,
            units,
            arcs: f.arcs,
            decimals,
            line_end,
            longest: longest as usize,
            number_step,
            comments: Comments {
                style,
                upper_case: charset == "ascii-upper",
                forbidden: f.comments.forbidden.get_ref().clone(),
                active: f.comments.active.clone(),
            },
            modal: Modal {
                motion: f.modal.motion,
                axes: f.modal.axes,
                feed: f.modal.feed,
            },
            start: templates(&mut r, forbidden, "start", &p.start),
            spindle: templates(&mut r, forbidden, "spindle", &p.spindle),
            flood: templates(&mut r, forbidden, "flood", &p.flood),
            mist: templates(&mut r, forbidden, "mist", &p.mist),
            end: templates(&mut r, forbidden, "end", &p.end),
            path_tolerance,
        };
        post.check_program(&mut r, p);
        r.finish(post)
    }

    /// What a program cannot do without.
    fn check_program(&self, r: &mut Reader<'_>, p: &ProgramTable) {
        let has_word = |lines: &[Template], letter: char, numbers: &[f64]| {
            lines
                .iter()
                .flat_map(Template::words)
                .any(|(l, n)| l == letter && n.parse().is_ok_and(|n: f64| numbers.contains(&n)))
        };
        let unit_lines = self.start.iter().filter(|t| t.has(Slot::Units)).count();
        if unit_lines != 1 {
            let problem = "must have {units} once: without it the machine reads the numbers in whatever it was left in";
            r.complain("start", &p.start, "[...]".into(), problem);
        }
        if !has_word(&self.start, 'G', &[90.0]) {
            let problem = "must have G90: the writer's coordinates are absolute";
            r.complain("start", &p.start, "[...]".into(), problem);
        }
        if !has_word(&self.spindle, 'M', &[3.0]) || !self.spindle.iter().any(|t| t.has(Slot::Speed))
        {
            let problem = "must start the spindle clockwise: M3 S{speed}";
            r.complain("spindle", &p.spindle, "[...]".into(), problem);
        }
        let ends = |t: &Template| has_word(std::slice::from_ref(t), 'M', &[2.0, 30.0]);
        if !has_word(&self.end, 'M', &[5.0]) || !self.end.iter().any(ends) {
            let problem = "must have M5, to stop the spindle, and M2 or M30, to end the program";
            r.complain("end", &p.end, "[...]".into(), problem);
        }
        let early = self
            .start
            .iter()
            .chain(&self.spindle)
            .chain(&self.flood)
            .chain(&self.mist);
        if early.into_iter().any(ends) {
            let problem = "M2 and M30 belong to the last lines: here they would end the program before it cuts";
            r.complain("start", &p.start, "[...]".into(), problem);
        }
    }
}

/// A whole number within bounds. Read as a float so that `1.5`, `-1` and `1e30` all get the same plain complaint.
fn whole(
    r: &mut Reader<'_>,
    key: &str,
    value: &Spanned<f64>,
    [min, max]: [u32; 2],
    advice: &str,
) -> u32 {
    let b = Bounds {
        min: f64::from(min),
        max: f64::from(max),
        above_min: false,
    };
    let v = r.figure(key, value, b, "", advice);
    if v.is_finite() && v.fract() != 0.0 {
        r.complain(
            key,
            value,
            format!("{v}"),
            format!("must be a whole number: {advice}"),
        );
    }
    // `as` saturates; a value out of bounds has its complaint and will not be used.
    (v as u32).min(max)
}

fn templates(
    r: &mut Reader<'_>,
    forbidden: &str,
    key: &str,
    lines: &Spanned<Vec<Spanned<String>>>,
) -> Vec<Template> {
    let mut good = Vec::new();
    for line in lines.get_ref() {
        match Template::parse(line.get_ref()) {
            Ok(_) if line.get_ref().contains(|c| forbidden.contains(c)) => {
                let problem =
                    format!("has one of {forbidden}, which this dialect forbids even in comments");
                r.complain(key, line, format!("\"{}\"", line.get_ref()), problem);
            }
            Ok(t) => good.push(t),
            Err(problem) => r.complain(key, line, format!("\"{}\"", line.get_ref()), problem),
        }
    }
    good
}

/// The file as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: Spanned<String>,
    reader: Spanned<String>,
    units: Spanned<String>,
    arcs: bool,
    decimals: DecimalsTable,
    lines: LinesTable,
    comments: CommentsTable,
    modal: ModalTable,
    program: ProgramTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DecimalsTable {
    mm: Spanned<f64>,
    inch: Spanned<f64>,
    feed_mm: Spanned<f64>,
    feed_inch: Spanned<f64>,
    speed: Spanned<f64>,
    seconds: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LinesTable {
    end: Spanned<String>,
    longest: Spanned<f64>,
    number_step: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CommentsTable {
    style: Spanned<String>,
    charset: Spanned<String>,
    forbidden: Spanned<String>,
    active: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModalTable {
    motion: bool,
    axes: bool,
    feed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProgramTable {
    start: Spanned<Vec<Spanned<String>>>,
    spindle: Spanned<Vec<Spanned<String>>>,
    flood: Spanned<Vec<Spanned<String>>>,
    mist: Spanned<Vec<Spanned<String>>>,
    end: Spanned<Vec<Spanned<String>>>,
    path_tolerance_mm: Option<Spanned<f64>>,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn refusal(from: &str, to: &str) -> String {
        let good = BUILT_IN[0].1;
        assert!(good.contains(from), "{from}");
        Post::from_toml("test", &good.replacen(from, to, 1))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn every_shipped_post_is_built_in_and_loads() {
        let dir = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("posts");
        let mut files: Vec<String> = std::fs::read_dir(&dir)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        let built_in: Vec<String> = BUILT_IN.iter().map(|(n, _)| format!("{n}.toml")).collect();
        assert_eq!(files, built_in, "posts/ and BUILT_IN differ");
        for (name, text) in BUILT_IN {
            let p = Post::load(name).unwrap();
            assert_eq!(p, Post::from_toml(name, text).unwrap());
            assert_eq!(
                p,
                Post::load(dir.join(format!("{name}.toml")).to_str().unwrap()).unwrap()
            );
            assert_eq!(p.name, name);
        }
    }

    #[test]
    fn every_machine_names_a_post_that_exists() {
        for (name, _) in crate::machine::BUILT_IN {
            let machine = crate::machine::Machine::load(name).unwrap();
            Post::load(&machine.post).unwrap();
        }
    }

    #[test]
    fn rounding_is_half_the_last_decimal() {
        let mut p = Post::load("grbl").unwrap();
        assert!((p.rounding().0 - 0.0005).abs() < 1e-12);
        p.units = Units::Inch;
        assert!((p.rounding().0 - 0.000_127).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_understood_is_refused_with_its_place() {
        let e = refusal("longest", "longset");
        assert!(e.starts_with("posts/test.toml:"), "{e}");
        assert!(e.contains("unknown key \"longset\" (did you mean \"longest\"?); the keys here are end, longest, number_step"), "{e}");
        let e = refusal("S{speed}", "S{spede}");
        assert!(
            e.contains("{spede} is not known (did you mean {speed}?)"),
            "{e}"
        );
        let e = refusal("units = \"mm\"", "units = \"cm\"");
        assert!(
            e.starts_with("posts/test.toml:4:9: units = \"cm\": must be one of mm, inch"),
            "{e}"
        );
        let e = refusal("mm = 3", "mm = 9");
        assert!(
            e.contains("mm = 9: must be at least 2 and at most 6: positions in mm need 3 decimals"),
            "{e}"
        );
        let e = refusal("mm = 3", "mm = 2.5");
        assert!(e.contains("must be a whole number"), "{e}");
        let e = refusal("longest = 70", "longest = 7");
        assert!(e.contains("must be at least 40"), "{e}");
        let e = refusal("arcs = true", "arcs = 1");
        assert!(e.starts_with("posts/test.toml:5:8: "), "{e}");
        let e = refusal("forbidden = \"?!~\"", "forbidden = \"_\"");
        assert!(e.contains("may not hold _"), "{e}");
        let e = refusal("[modal]", "[mode]");
        assert!(
            e.contains("unknown key \"mode\" (did you mean \"modal\"?)"),
            "{e}"
        );
    }

    #[test]
    fn a_dialect_that_would_harm_is_refused() {
        for (from, to, what) in [
            ("{units} G17", "G17", "must have {units} once"),
            ("G17 G90", "G17", "must have G90"),
            ("G17 G90", "G17 G91", "programs are written with G90"),
            ("M3 S{speed}", "M3", "must start the spindle clockwise"),
            (
                "\"M30\"",
                "\"M9\"",
                "must have M5, to stop the spindle, and M2 or M30",
            ),
            ("\"M5\", ", "", "must have M5"),
            ("[\"M8\"]", "[\"M30\"]", "before it cuts"),
            ("[\"M8\"]", "[\"G0 Z0\"]", "would move the machine"),
            (
                "[\"M8\"]",
                "[\"M8 (wet?)\"]",
                "has one of ?!~, which this dialect forbids",
            ),
        ] {
            let e = refusal(from, to);
            assert!(e.contains(what), "{from} -> {to}: {e}");
        }
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let e = Post::load("gbrl").unwrap_err().to_string();
        assert!(
            e.starts_with(
                "post \"gbrl\" is not known (did you mean \"grbl\"?); there are grbl, linuxcnc; "
            ),
            "{e}"
        );
    }

    proptest::proptest! {
        // A file with a piece torn out or doubled is refused or read, never a panic; and so is any text at all.
        #[test]
        fn no_text_is_too_broken(at in 0..2_000_usize, length in 0..60_usize, double: bool, any_text: String) {
            use crate::machine::{self, Machine};
            let cut = |text: &str| {
                let chars: Vec<char> = text.chars().collect();
                let (start, end) = (at.min(chars.len()), (at + length).min(chars.len()));
                let keep = if double { start } else { end };
                chars[..end - (end - start) * usize::from(!double)].iter().chain(&chars[keep..]).collect::<String>()
            };
            for (name, text) in BUILT_IN {
                let _ = Post::from_toml(name, &cut(text)).map_err(|e| e.to_string());
            }
            for (name, text) in machine::BUILT_IN {
                let _ = Machine::from_toml(name, &cut(text)).map_err(|e| e.to_string());
            }
            proptest::prop_assert!(Post::from_toml("x", &any_text).is_err());
            proptest::prop_assert!(Machine::from_toml("x", &any_text).is_err());
        }
    }
}
