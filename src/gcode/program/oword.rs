//! Lines that begin with O and a keyword: subroutines, conditions and loops as LinuxCNC writes them.
//!
//! Rules: LinuxCNC, O Codes. A subroutine stands above its calls, its `#1` to `#30` are its own, and calls go ten deep. Every statement names
//! its partners by the same label, so what is skipped is found by label alone.

use super::frame::{Frame, Kind, Loop, LoopKind};
use super::front::{front, whole};
use super::labels::Found;
use super::{FlowComplaint, Interpreter, flow};
use crate::gcode::error::Fault;
use crate::gcode::expression::Evaluator;
use crate::gcode::source::LineStart;
use std::io::{BufRead, Seek};

const KEYWORDS: &str = "sub, endsub, call, return, if, elseif, else, endif, while, endwhile, do, repeat, endrepeat, break, continue";

/// The fixed label and the keyword of a line; the byte behind it.
fn oword(text: &str) -> Option<(Box<str>, &str, usize)> {
    let body = front(text).body;
    let rest = text.get(body..)?.strip_prefix(['O', 'o'])?.trim_start();
    let (label, rest): (Box<str>, &str) = match rest.strip_prefix('<') {
        Some(name) => {
            let (name, rest) = name.split_once('>')?;
            let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
            (format!("O<{}>", name.to_ascii_lowercase()).into(), rest)
        }
        None => {
            let count = rest.bytes().take_while(u8::is_ascii_digit).count();
            let number: u32 = rest.get(..count)?.parse().ok()?;
            (format!("O{number}").into(), rest.get(count..)?)
        }
    };
    let rest = rest.trim_start();
    let count = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
    let at = text.len() - rest.len() + count;
    Some((label, rest.get(..count)?, at))
}

/// The name under which a line's subroutine is called.
pub(super) fn subroutine_name(text: &str) -> Option<Box<str>> {
    let first = text.trim_start().bytes().next()?;
    if !matches!(first, b'O' | b'o' | b'N' | b'n' | b'/') {
        return None;
    }
    let (label, keyword, _) = oword(text)?;
    let sub = keyword.eq_ignore_ascii_case("sub");
    sub.then(|| format!("{label} sub").into())
}

impl<R: BufRead + Seek> Interpreter<R> {
    /// `o100 ...`
    pub(super) fn oword_line(
        &mut self,
        text: &str,
        at: usize,
        here: LineStart,
    ) -> Result<(), Fault> {
        let (label, keyword, behind) = match oword(text) {
            Some((label, keyword, behind)) => (label, keyword.to_ascii_lowercase(), behind),
            None => self.computed_label(text, at)?,
        };
        let open = |frame: &Frame| {
            frame
                .loops
                .last()
                .filter(|l| l.label == label)
                .map(|l| l.kind)
        };
        let top = open(self.frame());
        let plain_end = matches!(
            &*keyword,
            "sub" | "else" | "endif" | "endwhile" | "do" | "endrepeat" | "break" | "continue"
        );
        if plain_end {
            self.alone(text, behind, &format!("{label} {keyword}"))?;
        }
        if !matches!(&*keyword, "" | "sub" | "endsub") {
            self.begun = true;
        }
        match &*keyword {
            "" => self.numbered_program(text, at, here),
            "sub" => self.sub(&label, at, here),
            "endsub" | "return" => self.return_from(text, (&label, &keyword), behind, at),
            "call" => self.call_subroutine(text, label, behind, (at, here)),
            "if" => {
                let met = self.truth(text, behind, "if")?;
                let end = self.partner(here.line, &label, &["endif"])?;
                let end = end.ok_or_else(|| not_closed(at, &label, "if", "endif"))?;
                let (head, inside, end) = (here, self.source.place(), end.line.line);
                let kind = LoopKind::If(!met);
                let one = Loop {
                    kind,
                    label: label.clone(),
                    head,
                    inside,
                    end,
                };
                self.open(one, at)?;
                if met {
                    Ok(())
                } else {
                    self.next_branch(&label, at, here)
                }
            }
            "elseif" | "else" => match top {
                Some(LoopKind::If(true)) => {
                    let met = keyword == "else" || self.truth(text, behind, "elseif")?;
                    if !met {
                        return self.next_branch(&label, at, here);
                    }
                    if let Some(one) = self.frame().loops.last_mut() {
                        one.kind = LoopKind::If(false);
                    }
                    Ok(())
                }
                Some(LoopKind::If(false)) => {
                    // The branch that was carried out ends here.
                    let end = self.partner(here.line, &label, &["endif"])?;
                    let end = end.ok_or_else(|| not_closed(at, &label, "if", "endif"))?;
                    self.jump(end.line)
                }
                _ => Err(not_opened(at, &label, &keyword, "if")),
            },
            "endif" => match top {
                Some(LoopKind::If(_)) => {
                    self.frame().loops.pop();
                    Ok(())
                }
                _ => Err(not_opened(at, &label, "endif", "if")),
            },
            "while" => self.while_word(text, &label, behind, (at, here), top),
            "endwhile" => match top {
                Some(LoopKind::While) => self.again(at),
                _ => Err(not_opened(at, &label, "endwhile", "while")),
            },
            "do" => self
                .begin(&label, LoopKind::Do, "while", (at, here))
                .map(|_| ()),
            "repeat" => self.repeat_word(text, &label, behind, (at, here)),
            "endrepeat" => match top {
                Some(LoopKind::Repeat(0)) => {
                    self.frame().loops.pop();
                    Ok(())
                }
                Some(LoopKind::Repeat(left)) => {
                    let last = self.frame().loops.last_mut();
                    let inside = last.map(|l| {
                        l.kind = LoopKind::Repeat(left - 1);
                        l.inside
                    });
                    inside.map_or(Ok(()), |i| self.jump(i))
                }
                _ => Err(not_opened(at, &label, "endrepeat", "repeat")),
            },
            "break" | "continue" => self.leave(&label, &keyword, (at, here)),
            _ => {
                let found = keyword.into();
                let known = KEYWORDS;
                Err(flow(at, FlowComplaint::Keyword { found, known }))
            }
        }
    }

    /// `o[#1+2] call`: a label that has to be computed.
    fn computed_label(&self, text: &str, at: usize) -> Result<(Box<str>, String, usize), Fault> {
        let mut e = self.evaluator(text, at + 1);
        if !matches!(e.peek(), Some(b'[' | b'#')) {
            let (statement, what) = ("O".into(), "a number, or a name in < >");
            return Err(flow(at, FlowComplaint::Incomplete { statement, what }));
        }
        let value = e.value()?.number()?;
        let number = whole(value, at + 1, "the number behind O", 0, 99_999_999)?;
        let keyword = e.letters().to_ascii_lowercase();
        let behind = e.at + keyword.len();
        if keyword != "call" {
            let (found, known) = (
                keyword.into(),
                "behind a computed number only call can stand",
            );
            return Err(flow(at, FlowComplaint::Keyword { found, known }));
        }
        Ok((format!("O{number}").into(), keyword, behind))
    }

    /// The next line ahead with the same label and one of these keywords.
    fn partner(
        &mut self,
        from: usize,
        label: &str,
        keywords: &[&str],
    ) -> Result<Option<Found>, Fault> {
        let what = format!("{label} {}", keywords.join(" "));
        self.ahead(from, &what, |text| {
            let first = text.trim_start().bytes().next()?;
            if !matches!(first, b'O' | b'o' | b'N' | b'n' | b'/') {
                return None;
            }
            let (other, keyword, _) = oword(text)?;
            let which = keywords
                .iter()
                .position(|k| keyword.eq_ignore_ascii_case(k))?;
            (*other == *label).then_some(which as u8)
        })
    }

    /// A condition, alone behind its keyword.
    fn truth(&self, text: &str, at: usize, keyword: &str) -> Result<bool, Fault> {
        let mut e = self.evaluator(text, at);
        let value = bracket(&mut e, keyword)?;
        self.alone(text, e.at, keyword)?;
        Ok(value != 0.0)
    }

    /// From a condition that was not met to the next one of the same label.
    fn next_branch(&mut self, label: &str, at: usize, here: LineStart) -> Result<(), Fault> {
        let found = self.partner(here.line, label, &["elseif", "else", "endif"])?;
        match found {
            Some(found) => self.jump(found.line),
            None => Err(not_closed(at, label, "if", "endif")),
        }
    }

    /// `sub`, met on the way: its lines are for callers.
    fn sub(&mut self, label: &str, at: usize, here: LineStart) -> Result<(), Fault> {
        let frame = self.frame();
        if frame.kind == Kind::Subroutine && frame.entry == here {
            return Ok(());
        }
        match self.partner(here.line, label, &["endsub"])? {
            Some(end) => self.jump(end.behind),
            None => {
                self.over = true;
                Err(not_closed(at, label, "sub", "endsub"))
            }
        }
    }

    fn return_from(
        &mut self,
        text: &str,
        (label, keyword): (&str, &str),
        behind: usize,
        at: usize,
    ) -> Result<(), Fault> {
        let frame = self.frame();
        // A return may carry the label of whatever stands around it; an end may not.
        if frame.kind != Kind::Subroutine || (keyword != "return" && *frame.label != *label) {
            return Err(not_opened(at, label, keyword, "sub"));
        }
        let mut e = self.evaluator(text, behind);
        let value = match e.peek() {
            Some(b'[') => Some(e.bracket()?.number()?),
            _ => None,
        };
        self.alone(text, e.at, keyword)?;
        self.give_back()?;
        self.parameters.returned(value);
        Ok(())
    }

    fn call_subroutine(
        &mut self,
        text: &str,
        label: Box<str>,
        behind: usize,
        (at, here): (usize, LineStart),
    ) -> Result<(), Fault> {
        let mut arguments = Vec::new();
        let mut e = self.evaluator(text, behind);
        while e.peek() == Some(b'[') {
            arguments.push(e.bracket()?.number()?);
        }
        let (end, count) = (e.at, arguments.len());
        self.alone(text, end, "call")?;
        whole(count as f64, at, "the number of values handed over", 0, 30)?;
        let Some(start) = self.start_of(&format!("{label} sub"))? else {
            return Err(flow(at, FlowComplaint::ProgramMissing { label }));
        };
        let first = start.found.line.line;
        if let Some(second) = start.second {
            return Err(flow(
                at,
                FlowComplaint::ProgramTwice {
                    label,
                    first,
                    second,
                },
            ));
        }
        if first > here.line {
            let line = first;
            return Err(flow(at, FlowComplaint::DefinedBelow { label, line }));
        }
        self.may_call(at)?;
        self.parameters.returned(None);
        self.parameters.enter_subroutine(&arguments);
        self.enter(Frame::call(Kind::Subroutine, label, start.found.line, 1))
    }

    /// Opens a loop whose last line has this keyword.
    fn begin(
        &mut self,
        label: &str,
        kind: LoopKind,
        closing: &str,
        (at, here): (usize, LineStart),
    ) -> Result<Found, Fault> {
        let opening = match kind {
            LoopKind::Do => "do",
            LoopKind::Repeat(_) => "repeat",
            _ => "while",
        };
        let end = self.partner(here.line, label, &[closing])?;
        let end = end.ok_or_else(|| not_closed(at, label, opening, closing))?;
        let (head, inside) = (here, self.source.place());
        let one = Loop {
            kind,
            label: label.into(),
            head,
            inside,
            end: end.line.line,
        };
        self.open(one, at)?;
        Ok(end)
    }

    fn while_word(
        &mut self,
        text: &str,
        label: &str,
        behind: usize,
        (at, here): (usize, LineStart),
        top: Option<LoopKind>,
    ) -> Result<(), Fault> {
        let met = self.truth(text, behind, "while")?;
        if top == Some(LoopKind::Do) {
            let inside = self.frame().loops.last().map(|l| l.inside);
            return match (met, inside) {
                (true, Some(inside)) => self.jump(inside).map_err(|f| Fault {
                    offset: at as u32,
                    ..f
                }),
                _ => {
                    self.frame().loops.pop();
                    Ok(())
                }
            };
        }
        let end = self.begin(label, LoopKind::While, "endwhile", (at, here))?;
        if met {
            return Ok(());
        }
        self.frame().loops.pop();
        self.jump(end.behind)
    }

    /// `endwhile`, `continue`: to the condition again, the loop left until it is met.
    fn again(&mut self, at: usize) -> Result<(), Fault> {
        match self.frame().loops.pop() {
            Some(one) => self.jump(one.head).map_err(|f| Fault {
                offset: at as u32,
                ..f
            }),
            None => Ok(()),
        }
    }

    fn repeat_word(
        &mut self,
        text: &str,
        label: &str,
        behind: usize,
        (at, here): (usize, LineStart),
    ) -> Result<(), Fault> {
        let mut e = self.evaluator(text, behind);
        let value = bracket(&mut e, "repeat")?;
        self.alone(text, e.at, "repeat")?;
        let times = whole(value, behind, "the number of repetitions", 0, 1_000_000_000)?;
        let kind = LoopKind::Repeat(times.saturating_sub(1));
        let end = self.begin(label, kind, "endrepeat", (at, here))?;
        if times > 0 {
            return Ok(());
        }
        self.frame().loops.pop();
        self.jump(end.behind)
    }

    /// `break`, `continue`
    fn leave(
        &mut self,
        label: &str,
        keyword: &str,
        (at, here): (usize, LineStart),
    ) -> Result<(), Fault> {
        let is_loop = |l: &Loop| *l.label == *label && !matches!(l.kind, LoopKind::If(_));
        let loops = &mut self.frame().loops;
        let Some(depth) = loops.iter().rposition(is_loop) else {
            return Err(not_opened(at, label, keyword, "while, do or repeat"));
        };
        loops.truncate(depth + 1);
        let kind = loops.last().map(|l| l.kind);
        if (keyword, kind) == ("continue", Some(LoopKind::While)) {
            return self.again(at);
        }
        let closing = match kind {
            Some(LoopKind::While) => "endwhile",
            Some(LoopKind::Do) => "while",
            _ => "endrepeat",
        };
        let end = self.partner(here.line, label, &[closing])?;
        let end = end.ok_or_else(|| not_closed(at, label, keyword, closing))?;
        if keyword == "continue" {
            return self.jump(end.line);
        }
        self.frame().loops.pop();
        self.jump(end.behind)
    }
}

/// A value in brackets, behind its keyword.
fn bracket(e: &mut Evaluator, keyword: &str) -> Result<f64, Fault> {
    if e.peek() != Some(b'[') {
        let (statement, what) = (keyword.into(), "a value in brackets: [ ... ]");
        return Err(flow(e.at, FlowComplaint::Incomplete { statement, what }));
    }
    e.bracket()?.number()
}

fn not_closed(at: usize, label: &str, opening: &str, closing: &str) -> Fault {
    let opening = format!("{label} {opening}").into();
    let closing = format!("{label} {closing}").into();
    flow(at, FlowComplaint::NotClosed { opening, closing })
}

fn not_opened(at: usize, label: &str, closing: &str, opening: &str) -> Fault {
    let closing = format!("{label} {closing}").into();
    let opening = format!("{label} {opening}").into();
    flow(at, FlowComplaint::NotOpened { closing, opening })
}
