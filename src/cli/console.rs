//! `morsemill console`: lines typed by hand to a controller, and what it answers, with its meaning.
//!
//! Lines go out one at a time. What would do harm is refused or asked; real-time keys go by name and act at once.

use super::Failure;
use super::errand::{ConnectArgs, SimBench, finish, place};
use super::output::say;
use crate::link::Known;
use crate::link::errand::{Console, Exchange, News, Verdict, judge, key};
use crate::wire::{Realtime, Reply, alarm_meaning, error_meaning};
use std::collections::VecDeque;
use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::mpsc;

/// Arguments of `morsemill console`.
#[derive(Clone, Debug, clap::Args)]
pub struct ConsoleArgs {
    /// Send lines that need a yes without asking. Without it, lines that come from a script instead of a terminal and need one are not sent
    #[arg(long)]
    pub yes: bool,
    /// What the controller says as it says it, without the meaning of its numbers
    #[arg(long)]
    pub raw: bool,
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

const HELP: &str = "lines are sent with Enter; ? status, ! hold, ~ resume, reset, cancel (a jog), door, feed+10, feed-10, feed+1, feed-1, feed=100, \
                    rapid=25|50|100, spindle+10, spindle-10, spindle=100, spindle-stop, flood, mist act at once; history lists what was sent, \
                    again or again N sends it once more; help, quit";

/// Lines remembered.
const HISTORY: usize = 50;

/// What a typed line came to.
#[derive(Debug, PartialEq)]
enum Typed {
    Nothing,
    Quit,
    Tell(String),
    /// Not sent, and why.
    Refused(String),
    Key(Realtime),
    Send(Exchange),
}

/// Who types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Typist {
    /// Somebody who can be asked.
    Person,
    /// A script: nobody answers.
    Script,
    /// Whoever it is has said yes to everything.
    Trusted,
}

/// What was typed before, and what waits for a yes.
#[derive(Debug, Default)]
struct Desk {
    asked: Option<Exchange>,
    history: VecDeque<String>,
}

impl Desk {
    /// What to do with a typed line.
    fn typed(&mut self, line: &str, typist: Typist, known: &Known) -> Typed {
        let text = line.trim();
        if let Some(exchange) = self.asked.take() {
            return match text {
                "yes" | "y" => Typed::Send(exchange),
                _ => Typed::Tell("not sent".to_string()),
            };
        }
        let mut words = text.split_whitespace();
        match (words.next(), words.next()) {
            (None, _) => return Typed::Nothing,
            (Some("quit" | "exit"), None) => return Typed::Quit,
            (Some("help"), None) => return Typed::Tell(HELP.to_string()),
            (Some("history"), None) => {
                let lines = self.history.iter().enumerate();
                let lines: Vec<String> = lines.map(|(i, l)| format!("{:>3}  {l}", i + 1)).collect();
                return Typed::Tell(match lines.is_empty() {
                    true => "nothing was sent yet".to_string(),
                    false => lines.join("\n"),
                });
            }
            (Some("again"), which) => {
                let number = which.map_or(Ok(self.history.len()), str::parse::<usize>);
                let line = number
                    .ok()
                    .and_then(|n| self.history.get(n.checked_sub(1)?))
                    .cloned();
                return match line {
                    Some(line) => self.judged(&line, typist, known),
                    None => Typed::Refused("no such line: `history` lists them".to_string()),
                };
            }
            _ => {}
        }
        match key(text) {
            Some(key) => Typed::Key(key),
            None => self.judged(text, typist, known),
        }
    }

    fn judged(&mut self, text: &str, typist: Typist, known: &Known) -> Typed {
        let verdict = judge(text, known);
        if !matches!(verdict, Verdict::Refuse(_)) {
            if self.history.len() >= HISTORY {
                self.history.pop_front();
            }
            self.history.push_back(text.to_string());
        }
        match (verdict, typist) {
            (Verdict::Send(exchange), _) | (Verdict::Ask(exchange, _), Typist::Trusted) => {
                Typed::Send(exchange)
            }
            (Verdict::Ask(exchange, why), Typist::Person) => {
                let question = format!("`{}`: {why}. Type yes to send it", exchange.text);
                self.asked = Some(exchange);
                Typed::Tell(question)
            }
            (Verdict::Ask(exchange, why), Typist::Script) => Typed::Refused(format!(
                "`{}`: {why}, and there is nobody to ask: --yes sends such lines",
                exchange.text
            )),
            (Verdict::Refuse(why), _) => Typed::Refused(why),
        }
    }
}

/// A reply with its meaning.
fn with_meaning(line: &str, reply: &Reply) -> String {
    let meaning = match reply {
        Reply::Error(code) => error_meaning(*code),
        Reply::Alarm(code) => alarm_meaning(*code),
        _ => None,
    };
    match meaning {
        Some(m) => format!("{line}   {}. {}", m.what, m.advice),
        None => line.to_string(),
    }
}

/// Runs until `quit`, the end of the input, or Ctrl-C (which stops what moves first). A script's exit code is 1 when a line was not sent or
/// was refused, or an alarm came.
pub fn run(args: &ConsoleArgs) -> Result<ExitCode, Failure> {
    let mut connection = args.connect.open(SimBench::Plain)?;
    let (sender, lines) = mpsc::channel();
    let terminal = std::io::stdin().is_terminal();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { return };
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    if terminal {
        say(HELP);
    }
    let mut desk = Desk::default();
    let typist = match (args.yes, terminal) {
        (true, _) => Typist::Trusted,
        (false, true) => Typist::Person,
        (false, false) => Typist::Script,
    };
    let mut troubles = 0;
    let mut wants_report = false;
    let mut connected = false;
    let mut ended = false;
    let show = |text: &str| {
        let mut out = std::io::stdout().lock();
        let _ = writeln!(out, "{text}").and_then(|()| out.flush());
    };
    let done = connection.perform(Console::default(), &mut |errand, news| {
        for n in news {
            match n {
                News::Connected(known) => {
                    connected = true;
                    say(&format!("connected: {}", known.version));
                }
                News::Note(text) => {
                    connected = true;
                    say(&format!("note: {text}"));
                }
                News::Stopping(text) => say(text),
                // Told below, unless it is to be shown as it came.
                News::Said(_, reply) if matches!(**reply, Reply::Status(_)) && !args.raw => {}
                News::Said(line, reply) if matches!(**reply, Reply::Status(_)) => {
                    let wanted = std::mem::take(&mut wants_report);
                    wanted.then(|| show(line));
                }
                News::Said(line, reply) if !line.is_empty() => {
                    troubles += usize::from(matches!(**reply, Reply::Error(_) | Reply::Alarm(_)));
                    match args.raw {
                        true => show(line),
                        false => show(&with_meaning(line, reply)),
                    }
                }
                News::Report(status, known) if !args.raw && std::mem::take(&mut wants_report) => {
                    let machine = known.machine_position.map(place).unwrap_or_default();
                    let work = known.work_position().map(place).unwrap_or_default();
                    let pins = if status.pins.is_empty() {
                        String::new()
                    } else {
                        format!("  pins {}", status.pins)
                    };
                    show(&format!(
                        "{}  machine {machine}  work {work}{pins}",
                        status.state.text()
                    ));
                }
                _ => {}
            }
        }
        if !connected || ended {
            return;
        }
        // A script's lines wait for each other; a person's keys do not.
        while terminal || errand.task.waiting() == 0 {
            let line = match lines.try_recv() {
                Ok(line) => line,
                Err(mpsc::TryRecvError::Empty) => break,
                Err(mpsc::TryRecvError::Disconnected) => {
                    ended = true;
                    errand.task.quit();
                    break;
                }
            };
            match desk.typed(&line, typist, errand.known()) {
                Typed::Nothing => {}
                Typed::Quit => {
                    ended = true;
                    errand.task.quit();
                    break;
                }
                Typed::Tell(text) => say(&text),
                Typed::Refused(why) => {
                    troubles += 1;
                    say(&format!("not sent: {why}"));
                }
                Typed::Key(key) => {
                    wants_report |= key == Realtime::Status;
                    errand.key(key.byte());
                }
                Typed::Send(exchange) => errand.task.push(exchange),
            }
        }
    });
    let details = Details { troubles };
    let code = finish("console", args.connect.json.as_ref(), &done, details)?;
    Ok(match troubles > 0 && !terminal {
        true => ExitCode::from(1),
        false => code,
    })
}

#[derive(serde::Serialize)]
struct Details {
    /// Lines not sent or refused, and alarms.
    troubles: usize,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::{Introduction, IntroductionOptions};
    use std::time::Duration;

    #[test]
    fn keys_lines_questions() {
        let known = Introduction::new(IntroductionOptions::default(), Duration::ZERO)
            .known()
            .clone();
        let mut desk = Desk::default();
        let mut person = |text: &str| desk.typed(text, Typist::Person, &known);
        assert_eq!(person(" hold "), Typed::Key(Realtime::Hold));
        assert_eq!(person(""), Typed::Nothing);
        assert_eq!(person("quit"), Typed::Quit);
        let question = Typed::Tell("`M3S1`: the spindle starts. Type yes to send it".into());
        assert_eq!(person("M3 S1"), question);
        assert_eq!(person("no"), Typed::Tell("not sent".into()));
        assert_eq!(person("M3 S1"), question);
        assert!(matches!(person("yes"), Typed::Send(e) if e.text == "M3S1"));
        assert!(matches!(
            desk.typed("M3 S1", Typist::Trusted, &known),
            Typed::Send(_)
        ));
        assert_eq!(
            desk.typed("$J=F100", Typist::Trusted, &known),
            Typed::Refused(
                "a jog without X, Y or Z drives to machine zero: name an axis".to_string()
            )
        );
    }

    #[test]
    fn a_script_is_not_asked_and_its_next_line_is_no_answer() {
        let known = Introduction::new(IntroductionOptions::default(), Duration::ZERO)
            .known()
            .clone();
        let mut desk = Desk::default();
        assert_eq!(
            desk.typed("M3 S1", Typist::Script, &known),
            Typed::Refused(
                "`M3S1`: the spindle starts, and there is nobody to ask: --yes sends such lines"
                    .to_string()
            )
        );
        assert!(
            matches!(desk.typed("G0 X1", Typist::Script, &known), Typed::Send(e) if e.text == "G0X1")
        );
    }

    #[test]
    fn lines_are_remembered_and_sent_again() {
        let known = Introduction::new(IntroductionOptions::default(), Duration::ZERO)
            .known()
            .clone();
        let mut desk = Desk::default();
        let mut person = |text: &str| desk.typed(text, Typist::Person, &known);
        assert_eq!(
            person("history"),
            Typed::Tell("nothing was sent yet".into())
        );
        let none = Typed::Refused("no such line: `history` lists them".into());
        assert_eq!(person("again"), none);
        person("g0 x1");
        person("%");
        person("$$");
        assert_eq!(person("history"), Typed::Tell("  1  g0 x1\n  2  $$".into()));
        assert!(matches!(person("again 1"), Typed::Send(e) if e.text == "G0X1"));
        assert!(matches!(person("again"), Typed::Send(e) if e.text == "G0X1"));
        assert_eq!(person("again 0"), none);
        assert_eq!(person("again 99"), none);
        // What needed a yes needs it again.
        person("M3");
        person("no");
        assert!(matches!(person("again"), Typed::Tell(t) if t.contains("Type yes")));
    }

    #[test]
    fn replies_come_with_their_meaning() {
        assert_eq!(with_meaning("ok", &Reply::Ok), "ok");
        assert!(
            with_meaning("error:22", &Reply::Error(22))
                .starts_with("error:22   no feed rate is set.")
        );
    }
}
