//! Reading APT cutter-location data as CAD systems write it.
//!
//! Crosses the border: bytes in; [`Step`]s of the tool tip out, mm and mm/min, each with the line that caused it, one at a time: memory does
//! not grow with the file. A file of inches becomes mm. The points of a CL file are taken to be those of the tool *tip*; a file that says
//! they are the centre's is refused.
//!
//! Nothing that moves, switches or stops is skipped in silence: a statement is carried out, or noted because it changes nothing
//! ([`NoteKind`]), or an error with line and column. The first error ends the reading.
//!
//! Words are those of ISO 4343 (postprocessor vocabulary) and ANSI X3.37 (APT); where systems differ:
//!
//! | statement | read as | from |
//! |---|---|---|
//! | `RAPID` | the next motion only; a `FEDRAT` between them takes it back | ISO 4343 5.42 |
//! | `CIRCLE/x,y,z,i,j,k,r` + `GOTO`s | right hand about i,j,k; all following points that lie on it, evenly apart | Creo, *CL Output for Circular Interpolation* |
//! | `CIRCLE/` with 11 numbers + `GOTO` | clockwise seen against i,j,k; one `GOTO`; `TIMES,n` turns | NX, *CLSF Manager*: CIRCLE |
//! | `MOVARC/x,y,z,i,j,k,r,ANGLE,a` + `GOTO` | right hand; points and angle must agree; `CENTER`, `AXIS`, `RADIUS` too | ISO 4343, Fusion's APT output |
//! | `INDIRV/`, `TLON,GOFWD/(CIRCLE/..),ON,(LINE/..)` | along the circle to the first crossing with the line, `2,INTOF` to the second | CATIA V5, Creo's APT_FORMAT |
//! | `CLEARP/XYPLAN,z` and `RETRCT` | straight up to z in rapid, if the tool is lower or its place is not known | GPost's vocabulary |

mod arcs;
mod args;
mod drive;
mod motion;
mod setup;
mod switch;
mod words;

#[cfg(test)]
mod tests;

use super::cutter::Cutter;
use super::error::{ClError, ClProblem, Fault};
use super::note::{Note, NoteKind, Notes};
use super::statement::{Statements, text_word};
use super::step::Step;
use super::token::{Placed, blanks, first_char, tokens, word};
use crate::geom::{Point, Vector};
use crate::machine::data::nearest;
use args::{Args, upper};
use std::collections::VecDeque;
use std::io::BufRead;

/// Units of length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lengths {
    /// Millimetres.
    #[default]
    Mm,
    /// Inches.
    Inch,
}

impl Lengths {
    /// One of them in mm.
    fn mm(self) -> f64 {
        match self {
            Lengths::Mm => 1.0,
            Lengths::Inch => 25.4,
        }
    }
}

/// How to read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Units of a file that has no UNITS statement (NX writes none).
    pub unsaid: Lengths,
}

/// What a file says about itself, as far as it is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Text of PARTNO.
    pub part: Option<String>,
    /// Text of MACHIN.
    pub machine: Option<String>,
    /// The cutter told last.
    pub cutter: Option<Cutter>,
}

/// A feed as told.
#[derive(Clone, Copy, Debug)]
enum Feed {
    /// mm/min.
    PerMinute(f64),
    /// mm per revolution, told on this line.
    PerTurn(f64, usize),
}

/// How the next motion goes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Manner {
    /// At the feed that holds.
    Feed,
    Rapid,
    /// At a feed of its own, mm/min.
    Once(f64),
}

/// All that statements set and motions use.
#[derive(Debug)]
struct State {
    /// Line of the statement in hand.
    line: usize,
    queue: VecDeque<(usize, Step)>,
    notes: Notes,
    about: About,
    options: ReadOptions,
    /// mm per unit of the file, once told or taken.
    scale: Option<f64>,
    /// Where the tool tip is, mm.
    at: Option<Point>,
    moved: bool,
    manner: Manner,
    feed: Option<Feed>,
    speed: Option<f64>,
    /// As in [`Step::Spindle`].
    direction: i8,
    /// The tool change that stopped a turning spindle.
    stopped: Option<usize>,
    /// The tool change after which nothing moved yet.
    changed: Option<usize>,
    /// The tool that TOOLNO names and no LOADTL has put in, and its line.
    named_tool: Option<(u32, usize)>,
    /// The tool that LOADTL put in last.
    tool: Option<u32>,
    /// Height of the clearance plane, mm.
    clearance: Option<f64>,
    arc: Option<arcs::Open>,
    /// Direction of the next drive motion.
    along: Option<Vector>,
    frame: Option<[f64; 9]>,
    /// END or FINI, and its line.
    end: Option<(&'static str, usize)>,
}

/// A CL file as steps: an iterator of each step with the line that caused it. Fused; nothing comes behind an error.
///
/// To go through a file twice (to write a program and then to verify it), wind its source back and make a second one: the same bytes give
/// the same steps.
#[derive(Debug)]
pub struct Reader<R> {
    statements: Statements<R>,
    tokens: Vec<Placed>,
    state: State,
    finished: bool,
}

impl<R: BufRead> Reader<R> {
    /// Reads from where the source stands.
    pub fn new(from: R, options: ReadOptions) -> Reader<R> {
        Reader {
            statements: Statements::new(from),
            tokens: Vec::new(),
            finished: false,
            state: State {
                line: 0,
                queue: VecDeque::new(),
                notes: Notes::default(),
                about: About::default(),
                options,
                scale: None,
                at: None,
                moved: false,
                manner: Manner::Feed,
                feed: None,
                speed: None,
                direction: 0,
                stopped: None,
                changed: None,
                named_tool: None,
                tool: None,
                clearance: None,
                arc: None,
                along: None,
                frame: None,
                end: None,
            },
        }
    }

    /// What was tolerated so far, the first of each kind with how often. Complete when the steps are at their end.
    pub fn notes(&self) -> &[Note] {
        self.state.notes.list()
    }

    /// What the file said about itself so far.
    pub fn about(&self) -> &About {
        &self.state.about
    }

    /// Reads statements until there is a step.
    fn advance(&mut self) -> Result<Option<(usize, Step)>, ClError> {
        loop {
            if let Some(step) = self.state.queue.pop_front() {
                return Ok(Some(step));
            }
            if self.finished {
                return Ok(None);
            }
            if self.statements.read(&mut self.state.notes)? {
                let now = &self.statements.now;
                self.tokens.clear();
                (self
                    .state
                    .statement(now.line(), &now.text, &mut self.tokens))
                .map_err(|fault| now.error(fault))?;
            } else {
                self.finished = true;
                let line = self.statements.line().max(1);
                (self.state.finish(line)).map_err(|problem| ClError {
                    line,
                    column: 1,
                    problem,
                })?;
            }
        }
    }
}

impl<R: BufRead> Iterator for Reader<R> {
    type Item = Result<(usize, Step), ClError>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.advance().transpose();
        if matches!(next, Some(Err(_))) {
            self.finished = true;
            self.state.queue.clear();
        }
        next
    }
}

/// A statement's word in capitals; those with blanks within are joined, those with commas (`TLON,GOFWD`) keep them.
struct Head {
    bytes: [u8; 40],
    length: usize,
    /// Where its values begin.
    values: usize,
    /// True when a slash stands before them.
    slash: bool,
}

fn head(text: &[u8]) -> Result<Head, Fault> {
    let mut head = Head {
        bytes: [0; 40],
        length: 0,
        values: text.len(),
        slash: false,
    };
    let mut push = |b: &[u8]| {
        for b in b {
            let place = head.bytes.get_mut(head.length);
            *place.ok_or_else(|| unknown(text))? = b.to_ascii_uppercase();
            head.length += 1;
        }
        Ok(())
    };
    let mut i = text;
    loop {
        let at = text.len() - i.len();
        let Ok((rest, w)) = word(i) else {
            let wanted = "a word such as GOTO";
            return Err(match i.first() {
                None => (at, ClProblem::Ends { wanted }),
                Some(_) => {
                    let found = first_char(i);
                    (at, ClProblem::Unexpected { found, wanted })
                }
            });
        };
        push(w)?;
        i = blanks(rest).map_or(rest, |(rest, _)| rest);
        let here = text.len() - i.len();
        match i.first() {
            None => break,
            Some(b'/') => {
                head.values = here + 1;
                head.slash = true;
                break;
            }
            Some(b',') => {
                push(b",")?;
                i = blanks(i.get(1..).unwrap_or_default()).map_or(i, |(rest, _)| rest);
            }
            Some(b) if b.is_ascii_alphabetic() => {}
            Some(b'=') => {
                let why = "geometry needs an APT processor: output CL data, not the part program";
                let word = upper(text.get(..here).unwrap_or_default().trim_ascii());
                return Err((0, ClProblem::Refused { word, why }));
            }
            Some(_) => {
                let found = first_char(i);
                let wanted = "a slash or the statement's end";
                return Err((here, ClProblem::Unexpected { found, wanted }));
            }
        }
    }
    Ok(head)
}

/// The complaint about a word nobody knows.
fn unknown(text: &[u8]) -> Fault {
    let blank = |b: &u8| matches!(b, b' ' | b'\t');
    let first = text.iter().position(|b| *b == b'/' || blank(b));
    let mut word = upper(text.get(..first.unwrap_or(text.len())).unwrap_or_default());
    let mut close = nearest(&word, words::known());
    if close.as_ref() == Some(&word) {
        // A known word and another behind it: a line too much was joined to it, or its slash is missing.
        let all = text.split(|b| *b == b'/').next().unwrap_or_default();
        let all = all.get(..all.len().min(40)).unwrap_or(all);
        (word, close) = (upper(all.trim_ascii()), None);
    }
    (
        0,
        ClProblem::UnknownWord {
            nearest: close,
            word,
        },
    )
}

/// The text of a text statement: a slash and apostrophes around all of it are not part of it.
fn said(rest: &[u8]) -> String {
    let rest = rest.trim_ascii();
    let rest = rest.strip_prefix(b"/").unwrap_or(rest).trim_ascii();
    let inner = (rest.strip_prefix(b"'")).and_then(|r| r.strip_suffix(b"'"));
    let rest = inner.unwrap_or(rest);
    let text = match std::str::from_utf8(rest) {
        Ok(t) => t.to_string(),
        // As old editors write it.
        Err(_) => rest.iter().map(|b| char::from(*b)).collect(),
    };
    text.replace(char::is_control, " ")
}

impl State {
    fn push(&mut self, step: Step) {
        self.queue.push_back((self.line, step));
    }

    fn note(&mut self, kind: NoteKind) {
        self.notes.add(self.line, kind);
    }

    /// mm per unit of the file.
    fn scale(&mut self) -> f64 {
        if let Some(s) = self.scale {
            return s;
        }
        let unsaid = self.options.unsaid;
        self.note(NoteKind::UnitsUnsaid(match unsaid {
            Lengths::Mm => "millimetres",
            Lengths::Inch => "inches",
        }));
        self.scale = Some(unsaid.mm());
        unsaid.mm()
    }

    /// Carries a statement out.
    fn statement(
        &mut self,
        line: usize,
        text: &[u8],
        buffer: &mut Vec<Placed>,
    ) -> Result<(), Fault> {
        self.line = line;
        if let Some((word, length)) = text_word(text) {
            self.behind_end(word.as_bytes())?;
            return self.text(word, text, text.get(length..).unwrap_or_default());
        }
        let head = head(text)?;
        let name = head.bytes.get(..head.length).unwrap_or_default();
        self.behind_end(name)?;
        if name == b"GOTO" {
            tokens(text, head.values, buffer)?;
            return self.goto(Args::new("GOTO", text, buffer));
        }
        let as_text = std::str::from_utf8(name).unwrap_or_default();
        if let Some(word) = words::harmless(as_text) {
            self.note(NoteKind::Harmless(word));
            return Ok(());
        }
        if let Some(why) = words::refused(as_text) {
            let word = as_text.to_string();
            return Err((0, ClProblem::Refused { word, why }));
        }
        self.flush_arc();
        if name == b"MACHIN" {
            let rest = text.get(head.values..).unwrap_or_default();
            self.about.machine = Some(said(rest));
            return Ok(());
        }
        tokens(text, head.values, buffer)?;
        let buffer = buffer.as_slice();
        let args = |word| Args::new(word, text, buffer);
        match name {
            b"GODLTA" => self.godlta(args("GODLTA")),
            b"FROM" => self.start_place(args("FROM")),
            b"GOHOME" => self.go_home(args("GOHOME")),
            b"RAPID" => self.rapid(args("RAPID")),
            b"FEDRAT" => self.fedrat(args("FEDRAT")),
            b"CLEARP" => self.clearance(args("CLEARP")),
            b"RETRCT" => self.retract(args("RETRCT")),
            b"CIRCLE" => self.circle(args("CIRCLE")),
            b"MOVARC" => self.movarc(args("MOVARC")),
            b"INDIRV" => self.along(args("INDIRV")),
            b"INDIRP" => self.along(args("INDIRP")),
            b"TLON,GOFWD" => self.tlon(args("TLON,GOFWD")),
            b"SPINDL" => self.spindle(args("SPINDL")),
            b"COOLNT" => self.coolant(args("COOLNT")),
            b"TOOLNO" => self.name_tool(args("TOOLNO")),
            b"LOADTL" | b"LOAD" => self.load(args("LOADTL")),
            b"DELAY" | b"DWELL" => self.delay(args("DELAY")),
            b"STOP" => self.pause(args("STOP"), false),
            b"OPSTOP" => self.pause(args("OPSTOP"), true),
            b"AUXFUN" => self.auxfun(args("AUXFUN")),
            b"END" => self.end("END", args("END")),
            b"FINI" => self.end("FINI", args("FINI")),
            b"REWIND" => self.harmless("REWIND"),
            b"UNITS" => self.units(args("UNITS")),
            b"MULTAX" => self.multax(args("MULTAX")),
            b"TLAXIS" => self.tool_axis(args("TLAXIS")),
            b"MODE" => self.mode(args("MODE")),
            b"ORIGIN" => self.no_shift(args("ORIGIN")),
            b"TRANS" => self.no_shift(args("TRANS")),
            b"TRACUT" => self.tracut(args("TRACUT")),
            b"MSYS" => self.msys(args("MSYS")),
            b"CUTCOM" => self.only_off(args("CUTCOM"), "cutter compensation by the controller is not posted: output the path of the tool tip, and CUTCOM/OFF"),
            b"CYCLE" => self.only_off(args("CYCLE"), "drilling cycles are not carried out: output the holes as single motions (cycles expanded) in the CAM system"),
            b"OPSKIP" => self.only_off(args("OPSKIP"), "blocks that the operator may leave out are not posted: remove it"),
            b"TLDATA" => self.tldata(args("TLDATA")),
            b"CUTTER" => self.cutter(args("CUTTER")),
            _ => Err(unknown(text)),
        }?;
        if head.slash && buffer.is_empty() {
            let wanted = "a value behind the slash";
            return Err((text.len(), ClProblem::Ends { wanted }));
        }
        Ok(())
    }

    /// A text statement.
    fn text(&mut self, word: &'static str, text: &[u8], rest: &[u8]) -> Result<(), Fault> {
        if super::statement::says_center(text) {
            return Err((0, ClProblem::ToolCenter));
        }
        match word {
            "INSERT" => {
                let why = words::refused(word).unwrap_or_default();
                let word = word.to_string();
                return Err((0, ClProblem::Refused { word, why }));
            }
            "LETTER" | "TITLE" => self.note(NoteKind::Harmless(word)),
            // Behind END there is nobody to tell it to.
            _ if self.end.is_some() => self.note(NoteKind::Harmless(word)),
            "PARTNO" => self.about.part = Some(said(rest)),
            _ => {
                self.flush_arc();
                self.push(Step::Comment(said(rest)));
            }
        }
        Ok(())
    }

    /// Complains about statements behind the end. END may be followed by FINI and by what changes nothing.
    fn behind_end(&self, name: &[u8]) -> Result<(), Fault> {
        let Some((end, line)) = self.end else {
            return Ok(());
        };
        let name = String::from_utf8_lossy(name);
        let harmless = words::harmless(&name).is_some()
            || matches!(&*name, "REMARK" | "REWIND" | "TITLE" | "LETTER");
        if end == "END" && (name == "FINI" || harmless) {
            return Ok(());
        }
        let word = name.into_owned();
        Err((0, ClProblem::AfterEnd { word, end, line }))
    }

    fn harmless(&mut self, word: &'static str) -> Result<(), Fault> {
        self.note(NoteKind::Harmless(word));
        Ok(())
    }

    /// The source is at its end.
    fn finish(&mut self, line: usize) -> Result<(), ClProblem> {
        self.line = line;
        match self.end {
            Some(("FINI", _)) => Ok(()),
            Some(_) => {
                self.note(NoteKind::FiniMissing);
                Ok(())
            }
            None => {
                self.close_arc()?;
                self.note(NoteKind::FiniMissing);
                self.note(NoteKind::EndMissing);
                self.push(Step::End);
                Ok(())
            }
        }
    }
}
