//! Lines and keys typed by hand: what they may do, and by which rule they are sent.

use super::error::ErrandError;
use super::exchange::{Exchange, Rule, Situation, Step, Task};
use super::restore::check;
use crate::link::introduction::Known;
use crate::wire::{Firmware, LINE_CHARS, Realtime, State};
use std::collections::VecDeque;
use std::time::Duration;

/// How long a typed `$H` may take.
const HOMING: Duration = Duration::from_secs(600);

/// What becomes of a typed line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is sent.
    Send(Exchange),
    /// It is sent once the operator says yes to this.
    Ask(Exchange, &'static str),
    /// It is not sent, for this reason.
    Refuse(String),
}

/// Names of the real-time keys, with their bytes.
const KEYS: [(&str, Realtime); 24] = [
    ("?", Realtime::Status),
    ("status", Realtime::Status),
    ("!", Realtime::Hold),
    ("hold", Realtime::Hold),
    ("~", Realtime::Resume),
    ("resume", Realtime::Resume),
    ("reset", Realtime::Reset),
    ("^x", Realtime::Reset),
    ("door", Realtime::Door),
    ("cancel", Realtime::JogCancel),
    ("feed=100", Realtime::FeedNormal),
    ("feed+10", Realtime::FeedPlus10),
    ("feed-10", Realtime::FeedMinus10),
    ("feed+1", Realtime::FeedPlus1),
    ("feed-1", Realtime::FeedMinus1),
    ("rapid=100", Realtime::RapidFull),
    ("rapid=50", Realtime::RapidHalf),
    ("rapid=25", Realtime::RapidQuarter),
    ("spindle=100", Realtime::SpindleNormal),
    ("spindle+10", Realtime::SpindlePlus10),
    ("spindle-10", Realtime::SpindleMinus10),
    ("spindle-stop", Realtime::SpindleStop),
    ("flood", Realtime::Flood),
    ("mist", Realtime::Mist),
];

/// The real-time byte that a typed word means, if it is one.
pub fn key(text: &str) -> Option<Realtime> {
    let name = text.trim().to_ascii_lowercase();
    KEYS.iter().find(|(n, _)| *n == name).map(|(_, k)| *k)
}

/// What becomes of a line typed by hand.
pub fn judge(typed: &str, known: &Known) -> Verdict {
    let refuse = |why: &str| Verdict::Refuse(why.to_string());
    if typed.contains(['?', '~', '!']) {
        return refuse("?, ~ and ! act at once wherever they stand in a line: type them alone");
    }
    let text = significant(typed);
    if !text.bytes().all(|b| (b' '..0x7F).contains(&b)) {
        return refuse("only plain ASCII may be sent: other bytes act as real-time commands");
    }
    if text.contains('/') {
        return refuse("GRBL drops the slash and runs the line: leave the line or the slash out");
    }
    if text.contains('%') {
        return refuse("% belongs to files, not to the controller");
    }
    if text.len() > LINE_CHARS {
        return Verdict::Refuse(format!(
            "the line has {} characters, and GRBL takes {LINE_CHARS}",
            text.len()
        ));
    }
    let send = |rule| Exchange {
        text: text.clone(),
        rule,
    };
    match text.strip_prefix('$') {
        Some(dollar) => judge_dollar(dollar, known, send),
        None => judge_code(&text, send),
    }
}

fn judge_dollar(dollar: &str, known: &Known, send: impl Fn(Rule) -> Exchange) -> Verdict {
    let refuse = |why: &str| Verdict::Refuse(why.to_string());
    let grbl = matches!(known.firmware, Firmware::Grbl11 | Firmware::Unknown);
    if let Some(jog) = dollar.strip_prefix("J=") {
        // GRBL 1.1 drives to machine zero on a jog without axis words.
        return match jog.contains(['X', 'Y', 'Z', 'A', 'B', 'C']) {
            true => Verdict::Send(send(Rule::Jog)),
            false => refuse("a jog without X, Y or Z drives to machine zero: name an axis"),
        };
    }
    if dollar == "H" {
        return Verdict::Send(send(Rule::Silent(HOMING)));
    }
    if dollar.starts_with('H') && grbl && !known.letters.contains('H') {
        return refuse(
            "this build has no homing of single axes, and would hang until a reset: use $H",
        );
    }
    if let Some((n, _)) = dollar.strip_prefix('N').and_then(|n| n.split_once('=')) {
        return match n {
            "0" | "1" => Verdict::Ask(
                send(Rule::Writer),
                "a start-up line is run at once, and at every start",
            ),
            _ => refuse("only $N0= and $N1= exist; others overwrite the controller's memory"),
        };
    }
    if dollar.starts_with("RST=") {
        return Verdict::Ask(
            send(Rule::Writer),
            "this erases settings or offsets: save them first",
        );
    }
    if dollar.starts_with("I=") {
        return Verdict::Send(send(Rule::Writer));
    }
    if dollar == "SLP" {
        return Verdict::Ask(
            send(Rule::Plain),
            "the motors go dead, and only a reset wakes the controller, locked",
        );
    }
    if let Some((number, value)) = dollar.split_once('=')
        && let Ok(number) = number.parse::<u16>()
    {
        return match check(number, value, known) {
            Ok(()) => Verdict::Ask(
                send(Rule::Writer),
                "this changes how the machine moves, for good",
            ),
            Err(why) => Verdict::Refuse(why),
        };
    }
    Verdict::Send(send(Rule::Plain))
}

fn judge_code(text: &str, send: impl Fn(Rule) -> Exchange) -> Verdict {
    let codes = codes(text);
    let has = |letter: char, number: f64| {
        codes
            .iter()
            .any(|(l, n)| *l == letter && (n - number).abs() < 5e-3)
    };
    let writes = has('G', 10.0) || has('G', 28.1) || has('G', 30.1);
    let rule = if writes { Rule::Writer } else { Rule::Motion };
    if text.is_empty() {
        return Verdict::Send(send(Rule::Plain));
    }
    if has('M', 3.0) || has('M', 4.0) {
        return Verdict::Ask(send(rule), "the spindle starts");
    }
    if has('G', 28.0) || has('G', 30.0) {
        return Verdict::Ask(
            send(rule),
            "the machine drives to a stored place on a straight line",
        );
    }
    Verdict::Send(send(rule))
}

/// G and M words.
fn codes(text: &str) -> Vec<(char, f64)> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['G', 'M']) {
        let letter = if rest.get(at..).is_some_and(|r| r.starts_with('G')) {
            'G'
        } else {
            'M'
        };
        rest = rest.get(at + 1..).unwrap_or_default();
        let end = rest
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(rest.len());
        if let Some(number) = rest.get(..end).and_then(|n| n.parse().ok()) {
            found.push((letter, number));
        }
    }
    found
}

/// Without blanks and comments, upper case: as the controller would keep it.
fn significant(line: &str) -> String {
    let mut out = String::new();
    let mut comment = false;
    for c in line.chars() {
        match c {
            ')' if comment => comment = false,
            _ if comment => {}
            '(' => comment = true,
            ';' => break,
            c if c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    out
}

/// Lines typed by hand, one at a time. Push them between ticks.
#[derive(Clone, Debug, Default)]
pub struct Console {
    lines: VecDeque<Exchange>,
    /// The last line sent moves the machine.
    moved: bool,
    quit: bool,
}

impl Console {
    /// To be sent once the lines before it were answered.
    pub fn push(&mut self, line: Exchange) {
        self.lines.push_back(line);
    }

    /// No more: it ends once everything was answered and the machine stands.
    pub fn quit(&mut self) {
        self.quit = true;
    }

    /// Lines that wait for the answer of another.
    pub fn waiting(&self) -> usize {
        self.lines.len()
    }
}

/// The controller would refuse it in motion (error 8): it waits for the end instead.
fn needs_rest(line: &Exchange) -> bool {
    line.text
        .strip_prefix('$')
        .is_some_and(|dollar| !(matches!(dollar, "" | "G" | "X") || dollar.starts_with("J=")))
}

impl Task for Console {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        let busy = matches!(now.known.state, State::Run | State::Jog)
            || (self.moved && now.status.is_none());
        if busy && self.lines.front().is_some_and(needs_rest) {
            return Ok(Step::Listen);
        }
        match self.lines.pop_front() {
            Some(line) => {
                self.moved = matches!(line.rule, Rule::Motion | Rule::Jog);
                Ok(Step::Send(line))
            }
            None if self.quit && !busy && (now.known.state.at_rest() || now.status.is_none()) => {
                Ok(Step::Done)
            }
            None => Ok(Step::Listen),
        }
    }

    fn carries_on(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::introduction::{Introduction, IntroductionOptions};
    use proptest::prelude::*;

    fn known() -> Known {
        let mut known = Introduction::new(IntroductionOptions::default(), Duration::ZERO)
            .known()
            .clone();
        known.settings = vec![(2, 0.0), (22, 0.0), (110, 500.0)];
        known
    }

    fn rule(text: &str) -> Rule {
        match judge(text, &known()) {
            Verdict::Send(e) => e.rule,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn ordinary_lines_are_sent_by_their_rule() {
        assert_eq!(rule("g1 x1 f100 ; go"), Rule::Motion);
        assert_eq!(rule("$$"), Rule::Plain);
        assert_eq!(rule("$j=g91 x1 f100"), Rule::Jog);
        assert_eq!(rule("G10 L20 P0 X0"), Rule::Writer);
        assert_eq!(rule("$h"), Rule::Silent(HOMING));
        assert_eq!(rule(""), Rule::Plain);
    }

    #[test]
    fn dangerous_lines_are_asked_or_refused() {
        for text in [
            "M3 S1000", "m04", "G28", "$110=400", "$N0=G20", "$RST=*", "$slp",
        ] {
            assert!(matches!(judge(text, &known()), Verdict::Ask(..)), "{text}");
        }
        for text in [
            "$J=F600",
            "$HX",
            "$N2=G0",
            "G0 X1 !",
            "/G0 X1",
            "%",
            "$2=300",
            "$110=-1",
            "$999=1",
            "G0 X\u{e9}",
        ] {
            assert!(
                matches!(judge(text, &known()), Verdict::Refuse(_)),
                "{text}"
            );
        }
        let Verdict::Refuse(why) = judge("$2=300", &known()) else {
            panic!()
        };
        assert!(why.contains("255"), "{why}");
    }

    #[test]
    fn keys_by_name() {
        assert_eq!(key(" Hold "), Some(Realtime::Hold));
        assert_eq!(key("?"), Some(Realtime::Status));
        assert_eq!(key("^X"), Some(Realtime::Reset));
        assert_eq!(key("feed+10"), Some(Realtime::FeedPlus10));
        assert_eq!(key("G0"), None);
    }

    proptest! {
        /// Whatever is typed: no real-time byte and no line end travels in a line.
        #[test]
        fn no_real_time_byte_in_a_line(text in "[$GXYZFJHN=0-9 .!?~;()\\n\u{e9}\u{91}/%-]{0,40}") {
            if let Verdict::Send(e) | Verdict::Ask(e, _) = judge(&text, &known()) {
                prop_assert!(e.text.bytes().all(|b| b > b' ' && b < 0x7F && !b"!?~".contains(&b)), "{}", e.text);
                prop_assert!(!e.text.starts_with("$J=") || e.text.contains(['X', 'Y', 'Z', 'A', 'B', 'C']));
            }
        }
    }
}
