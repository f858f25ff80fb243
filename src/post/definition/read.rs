//! From the file's text to a checked [`Post`].

use super::arcs::{Arcs, Form};
use super::file::*;
use super::format::{Decimals, Modal, Numbered, Numbers, Spelling, Units};
use super::{CoolantLines, Post, Program, Spindle, Tools, WorkOffsets, laws};
use crate::machine::data::{Bounds, DataError, Reader};
use crate::post::built_in::READERS;
use crate::post::comment::{CommentStyle, Comments};
use crate::post::template::{Slot, Template, Use};
use crate::units::{Mm, MmPerMin};
use toml::Spanned;

/// A post called `name`; complaints call it `file`.
pub(super) fn post(name: &str, file: &str, text: &str) -> Result<Post, DataError> {
    let mut r = Reader::new(file, text, "posts");
    let f: File = r.parse()?;
    let post = Hand {
        iso: f
            .spelling
            .as_ref()
            .is_none_or(|s| s.get_ref() != "heidenhain"),
        forbidden: f.comments.forbidden.get_ref().clone(),
        longest: *f.lines.longest.get_ref(),
        r: &mut r,
    }
    .post(name, &f);
    laws::check(&post, &f, &mut r);
    r.finish(post)
}

/// Reads the values.
struct Hand<'r, 'a> {
    r: &'r mut Reader<'a>,
    iso: bool,
    forbidden: String,
    /// Characters of a line.
    longest: f64,
}

impl Hand<'_, '_> {
    fn post(&mut self, name: &str, f: &File) -> Post {
        let title = f.title.get_ref().trim().to_string();
        if title.is_empty() {
            let problem = "must say what people call the dialect";
            self.r.complain("title", &f.title, "\"\"".into(), problem);
        }
        let spelling = self.choice("spelling", f.spelling.as_ref(), &["words", "heidenhain"]);
        let units = self.choice("units", Some(&f.units), &["mm", "inch"]);
        let end = self.choice("end", Some(&f.lines.end), &["lf", "crlf"]);
        let numbered = self.choice(
            "numbered",
            f.lines.numbered.as_ref(),
            &["words", "all", "tools"],
        );
        let longest = self.whole(
            "longest",
            &f.lines.longest,
            [40, 10_000],
            "GRBL takes 79 characters",
        );
        let longest_comment = f.comments.longest.as_ref().map_or(longest, |v| {
            self.whole(
                "longest",
                v,
                [20, longest.max(20)],
                "no more than [lines] longest",
            )
        });
        let advice = "0 for no line numbers, 1 or 10";
        let number_step = self.whole("number_step", &f.lines.number_step, [0, 1000], advice);
        Post {
            name: name.to_string(),
            title,
            reader: self.r.word("reader", &f.reader, &READERS),
            spelling: [Spelling::Words, Spelling::Heidenhain][spelling.min(1)],
            units: [Units::Mm, Units::Inch][units.min(1)],
            unit_words: match &f.unit_words {
                None => [Some("G21".into()), Some("G20".into())],
                Some(w) => [w.mm.clone(), w.inch.clone()],
            },
            arcs: f.arcs.as_ref().map_or(Arcs::NONE, |a| self.arcs(a)),
            decimals: self.decimals(&f.decimals),
            numbers: f.numbers.as_ref().map_or(Numbers::default(), |n| Numbers {
                point: n.point,
                trailing_zeros: n.trailing_zeros,
                plus: n.plus,
            }),
            line_end: ["\n", "\r\n"][end.min(1)],
            longest: longest as usize,
            separator: self.short("separator", f.lines.separator.as_ref(), " ", &["", " "]),
            number_step,
            number_start: f.lines.number_start.as_ref().map(|v| {
                self.whole(
                    "number_start",
                    v,
                    [0, 99_999_999],
                    "the number of the first line",
                )
            }),
            number_highest: f.lines.number_highest.as_ref().map_or(9_999_999, |v| {
                self.whole(
                    "number_highest",
                    v,
                    [1000, 99_999_999],
                    "counting starts over after it",
                )
            }),
            number_prefix: self.short(
                "number_prefix",
                f.lines.number_prefix.as_ref(),
                "N",
                &["N", ""],
            ),
            numbered: [Numbered::Words, Numbered::All, Numbered::Tools][numbered.min(2)],
            comments: self.comments(&f.comments),
            longest_comment: longest_comment as usize,
            modal: Modal {
                motion: f.modal.motion,
                axes: f.modal.axes,
                feed: f.modal.feed,
            },
            rapid_feed: f
                .rapid
                .as_ref()
                .and_then(|t| t.feed_mm_min.as_ref())
                .map(|v| {
                    let advice =
                        "the machine's rapid speed: the firmware holds each axis to its own limit";
                    MmPerMin(self.figure("feed_mm_min", v, [0.0, 200_000.0], "mm/min", advice))
                }),
            machine_rapid: self.moves(f.rapid.as_ref().and_then(|t| t.machine.as_ref())),
            tool: self.tools(f.tool.as_ref()),
            work_offsets: self.work_offsets(f.work_offsets.as_ref()),
            spindle: Spindle {
                cw: self.lines("cw", Some(&f.spindle.cw), &[Slot::Speed]),
                ccw: self.lines("ccw", f.spindle.ccw.as_ref(), &[Slot::Speed]),
                off: self.lines("off", Some(&f.spindle.off), &[]),
                waits: f.spindle.waits,
            },
            coolant: self.coolant(f.coolant.as_ref()),
            dwell: self.lines(
                "dwell",
                f.dwell.as_ref(),
                &[Slot::Seconds, Slot::Milliseconds],
            ),
            pause: self.lines("pause", f.pause.as_ref(), &[]),
            optional_pause: self.lines("optional_pause", f.optional_pause.as_ref(), &[]),
            pause_stops_spindle: f.pause_stops_spindle.unwrap_or(false),
            program: self.program(&f.program),
            path_tolerance: f.program.path_tolerance_mm.as_ref().map(|v| {
                Mm(self.figure(
                    "path_tolerance_mm",
                    v,
                    [0.0, 1.0],
                    "mm",
                    "0.002 keeps the surface",
                ))
            }),
        }
    }

    fn decimals(&mut self, d: &DecimalsTable) -> Decimals {
        let coarse = "positions in mm need 3 decimals, a micrometre; in inches 4 or 5";
        Decimals {
            mm: self.whole("mm", &d.mm, [2, 6], coarse) as u8,
            inch: self.whole("inch", &d.inch, [3, 7], coarse) as u8,
            feed_mm: self.whole("feed_mm", &d.feed_mm, [0, 4], "0 or 1 is usual") as u8,
            feed_inch: self.whole("feed_inch", &d.feed_inch, [0, 5], "1 or 2 is usual") as u8,
            speed: self.whole("speed", &d.speed, [0, 3], "0 is usual") as u8,
            seconds: self.whole("seconds", &d.seconds, [0, 4], "2 is usual") as u8,
            angle: d.angle.as_ref().map_or(4, |v| {
                self.whole(
                    "angle",
                    v,
                    [3, 7],
                    "at 50 mm 0.0001 degrees are 0.1 micrometres",
                ) as u8
            }),
        }
    }

    fn arcs(&mut self, a: &ArcsTable) -> Arcs {
        let forms = ["from-start", "absolute", "radius", "cr"];
        let form = match self.choice("form", a.form.as_ref(), &forms) {
            1 => Form::Absolute,
            2 => Form::Radius("R"),
            3 => Form::Radius("CR="),
            _ => Form::FromStart,
        };
        let mut planes = [false; 3];
        for plane in a.planes.get_ref() {
            let which = self.choice("planes", Some(plane), &["xy", "zx", "yz"]);
            if let Some(p) = planes.get_mut(which) {
                *p = true;
            }
        }
        if a.planes.get_ref().is_empty() {
            let problem = "must name a plane: \"xy\", \"zx\", \"yz\"; leave [arcs] out where there are no arcs";
            self.r.complain("planes", &a.planes, "[]".into(), problem);
        }
        let mut size = |key, v: &Option<Figure>, without: f64| {
            v.as_ref().map_or(without, |v| {
                self.figure(
                    key,
                    v,
                    [0.0, 1e6],
                    "mm",
                    "leave it out where there is no such limit",
                )
            })
        };
        Arcs {
            planes,
            form,
            full_circles: a.full_circles,
            helices: a.helices,
            radius: [
                Mm(size("smallest_radius_mm", &a.smallest_radius_mm, 0.0)),
                Mm(size(
                    "largest_radius_mm",
                    &a.largest_radius_mm,
                    f64::INFINITY,
                )),
            ],
            shortest_chord: Mm(size("shortest_chord_mm", &a.shortest_chord_mm, 0.0)),
        }
    }

    fn comments(&mut self, c: &CommentsTable) -> Comments {
        let style = self.choice(
            "style",
            Some(&c.style),
            &["parentheses", "semicolon", "none"],
        );
        let charset = self.choice("charset", Some(&c.charset), &["ascii", "ascii-upper"]);
        if c.forbidden.get_ref().contains(['_', '-', '[', ']', ' ']) {
            let shown = format!("\"{}\"", c.forbidden.get_ref());
            let problem = "may not hold _ - [ ] or a space: they stand in for what is left out";
            self.r.complain("forbidden", &c.forbidden, shown, problem);
        }
        let styles = [
            CommentStyle::Parentheses,
            CommentStyle::Semicolon,
            CommentStyle::None,
        ];
        Comments {
            style: styles[style.min(2)],
            upper_case: charset == 1,
            forbidden: c.forbidden.get_ref().clone(),
            active: c.active.clone(),
        }
    }

    fn tools(&mut self, t: Option<&ToolTable>) -> Tools {
        let Some(t) = t else {
            return Tools {
                change: Vec::new(),
                length: None,
                most: u32::MAX,
                retract_z: None,
            };
        };
        Tools {
            change: self.lines("change", Some(&t.change), &[Slot::Tool]),
            length: t
                .length
                .as_ref()
                .and_then(|l| self.line("length", l, &[Slot::Tool, Slot::Axes], true)),
            most: self.whole("most", &t.most, [1, 99_999_999], "the highest tool number"),
            retract_z: self.retract(t.retract_z_mm.as_ref()),
        }
    }

    fn work_offsets(&mut self, t: Option<&WorkOffsetsTable>) -> WorkOffsets {
        let Some(t) = t else {
            return WorkOffsets {
                words: Vec::new(),
                further: None,
                most: 0,
            };
        };
        let words: Vec<Template> = t
            .words
            .get_ref()
            .iter()
            .filter_map(|w| self.line("words", w, &[], false))
            .collect();
        let further = t
            .further
            .as_ref()
            .and_then(|l| self.line("further", l, &[Slot::Offset], false));
        let first = words.len().min(1000) as u16;
        let most = t.most.as_ref().map_or(first, |v| {
            self.whole(
                "most",
                v,
                [u32::from(first), 1000],
                "how many work offsets there are in all",
            ) as u16
        });
        WorkOffsets {
            most: if further.is_some() { most } else { first },
            words,
            further,
        }
    }

    fn coolant(&mut self, t: Option<&CoolantTable>) -> CoolantLines {
        CoolantLines {
            flood: self.lines("flood", t.and_then(|t| t.flood.as_ref()), &[]),
            mist: self.lines("mist", t.and_then(|t| t.mist.as_ref()), &[]),
            both: self.lines("both", t.and_then(|t| t.both.as_ref()), &[]),
            off: self.lines("off", t.map(|t| &t.off), &[]),
        }
    }

    fn program(&mut self, p: &ProgramTable) -> Program {
        const TITLE: &[Slot] = &[Slot::Name, Slot::Number];
        const START: &[Slot] = &[
            Slot::Comments,
            Slot::Units,
            Slot::Name,
            Slot::Number,
            Slot::Tolerance,
        ];
        let mut number = |key, v: &Option<Figure>, without| {
            v.as_ref().map_or(without, |v| {
                self.whole(key, v, [0, 99_999_999], "program numbers")
            })
        };
        let number = [
            number("lowest_number", &p.lowest_number, 1),
            number("highest_number", &p.highest_number, 9999),
        ];
        Program {
            first: self.lines("first", p.first.as_ref(), TITLE),
            start: self.lines("start", Some(&p.start), START),
            end: self.lines("end", Some(&p.end), &[Slot::Name, Slot::Units]),
            last: self.lines("last", p.last.as_ref(), TITLE),
            ends: !p.ends_with.get_ref().is_empty(),
            number,
            retract_z: self.retract(p.retract_z_mm.as_ref()),
        }
    }

    fn retract(&mut self, v: Option<&Figure>) -> Option<Mm> {
        let b = Bounds {
            min: -10_000.0,
            max: 10_000.0,
            above_min: false,
        };
        let advice = "machine coordinates: 0 is the top on most machines";
        v.map(|v| Mm(self.r.figure("retract_z_mm", v, b, "mm", advice)))
    }

    /// A figure above the first bound, at most the second.
    fn figure(
        &mut self,
        key: &str,
        v: &Figure,
        [min, max]: [f64; 2],
        unit: &str,
        advice: &str,
    ) -> f64 {
        let bounds = Bounds {
            min,
            max,
            above_min: true,
        };
        self.r.figure(key, v, bounds, unit, advice)
    }

    /// A whole number within bounds. Read as a float so that `1.5`, `-1` and `1e30` all get the same plain complaint.
    fn whole(&mut self, key: &str, value: &Figure, [min, max]: [u32; 2], advice: &str) -> u32 {
        let b = Bounds {
            min: f64::from(min),
            max: f64::from(max),
            above_min: false,
        };
        let v = self.r.figure(key, value, b, "", advice);
        if v.is_finite() && v.fract() != 0.0 {
            let problem = format!("must be a whole number: {advice}");
            self.r.complain(key, value, format!("{v}"), problem);
        }
        // `as` saturates; a value out of bounds has its complaint and will not be used.
        (v as u32).min(max)
    }

    /// The index of a word among those it may be; 0 where it is left out or, with a complaint, none of them.
    fn choice(&mut self, key: &str, value: Option<&Word>, known: &[&str]) -> usize {
        let word = value.map(|v| self.r.word(key, v, known));
        word.and_then(|w| known.iter().position(|k| **k == w))
            .unwrap_or(0)
    }

    /// A piece of text out of a few.
    fn short(&mut self, key: &str, value: Option<&Word>, without: &str, known: &[&str]) -> String {
        let Some(v) = value else {
            return without.to_string();
        };
        if !known.contains(&v.get_ref().as_str()) {
            let shown: Vec<String> = known.iter().map(|k| format!("\"{k}\"")).collect();
            let problem = format!("must be one of {}", shown.join(", "));
            self.r
                .complain(key, v, format!("\"{}\"", v.get_ref()), problem);
        }
        v.get_ref().clone()
    }

    /// The lines of a rapid in machine coordinates.
    fn moves(&mut self, lines: Option<&Lines>) -> Vec<Template> {
        let all = lines.into_iter().flat_map(|l| l.get_ref());
        all.filter_map(|l| self.line("machine", l, &[Slot::Axes], true))
            .collect()
    }

    fn lines(&mut self, key: &str, lines: Option<&Lines>, slots: &'static [Slot]) -> Vec<Template> {
        let all = lines.into_iter().flat_map(|l| l.get_ref());
        all.filter_map(|l| self.line(key, l, slots, false))
            .collect()
    }

    fn line(
        &mut self,
        key: &str,
        line: &Spanned<String>,
        slots: &'static [Slot],
        moves: bool,
    ) -> Option<Template> {
        let text = line.get_ref();
        let place = Use {
            slots,
            // Only the line that holds the axes is a move.
            moves: moves && text.contains("{axes}"),
            iso: self.iso,
        };
        let problem = match Template::parse(text, place) {
            Ok(_) if text != "%" && text.contains(|c| self.forbidden.contains(c)) => format!(
                "has one of {}, which this dialect forbids even in comments",
                self.forbidden
            ),
            // What fills the slots comes on top; the writer looks at that.
            Ok(t) if t.least_length() as f64 > self.longest => format!(
                "has {} characters, and [lines] longest is {}: split it into two lines",
                t.least_length(),
                self.longest
            ),
            Ok(t) => return Some(t),
            Err(problem) => problem,
        };
        self.r.complain(key, line, format!("\"{text}\""), problem);
        None
    }
}
