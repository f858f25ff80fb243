//! `morsemill console`: lines typed by hand to a controller, and what it answers, with its meaning.
//!
//! Lines go out one at a time. What would do harm is refused or asked; real-time keys go by name and act at once.

use super::Failure;
use super::errand::{ConnectArgs, NoDetails, SimBench, finish, place};
use super::output::say;
use crate::link::Known;
use crate::link::errand::{Console, Exchange, News, Verdict, judge, key};
use crate::wire::{Realtime, Reply, alarm_meaning, error_meaning};
use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::mpsc;

/// Arguments of `morsemill console`.
#[derive(Clone, Debug, clap::Args)]
pub struct ConsoleArgs {
    /// Send lines that need a yes without asking (for scripts)
    #[arg(long)]
    pub yes: bool,
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

const HELP: &str = "lines are sent with Enter; ? status, ! hold, ~ resume, reset, cancel (a jog), door, feed+10, feed-10, feed=100, rapid=25|50|100, \
                    spindle+10, spindle-10, spindle-stop, flood, mist act at once; help, quit";

/// What a typed line came to.
#[derive(Debug, PartialEq)]
enum Typed {
    Nothing,
    Quit,
    Tell(String),
    Key(Realtime),
    Send(Exchange),
}

/// What to do with a typed line; `asked` is what waits for a yes.
fn typed(line: &str, asked: &mut Option<Exchange>, yes: bool, known: &Known) -> Typed {
    let text = line.trim();
    if let Some(exchange) = asked.take() {
        return match text {
            "yes" | "y" => Typed::Send(exchange),
            _ => Typed::Tell("not sent".to_string()),
        };
    }
    match text {
        "" => return Typed::Nothing,
        "quit" | "exit" => return Typed::Quit,
        "help" => return Typed::Tell(HELP.to_string()),
        _ => {}
    }
    if let Some(key) = key(text) {
        return Typed::Key(key);
    }
    match judge(text, known) {
        Verdict::Send(exchange) => Typed::Send(exchange),
        Verdict::Ask(exchange, _) if yes => Typed::Send(exchange),
        Verdict::Ask(exchange, why) => {
            let question = format!("`{}`: {why}. Type yes to send it", exchange.text);
            *asked = Some(exchange);
            Typed::Tell(question)
        }
        Verdict::Refuse(why) => Typed::Tell(format!("not sent: {why}")),
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

/// Runs until `quit`, the end of the input, or Ctrl-C (which stops what moves first).
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
    let mut asked = None;
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
                News::Said(line, reply) if !line.is_empty() => show(&with_meaning(line, reply)),
                News::Report(status, known) if std::mem::take(&mut wants_report) => {
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
            match typed(&line, &mut asked, args.yes, errand.known()) {
                Typed::Nothing => {}
                Typed::Quit => {
                    ended = true;
                    errand.task.quit();
                    break;
                }
                Typed::Tell(text) => say(&text),
                Typed::Key(key) => {
                    wants_report |= key == Realtime::Status;
                    errand.key(key.byte());
                }
                Typed::Send(exchange) => errand.task.push(exchange),
            }
        }
    });
    finish("console", args.connect.json.as_ref(), &done, NoDetails {})
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
        let mut asked = None;
        assert_eq!(
            typed(" hold ", &mut asked, false, &known),
            Typed::Key(Realtime::Hold)
        );
        assert_eq!(typed("", &mut asked, false, &known), Typed::Nothing);
        assert_eq!(typed("quit", &mut asked, false, &known), Typed::Quit);
        assert_eq!(
            typed("M3 S1", &mut asked, false, &known),
            Typed::Tell("`M3S1`: the spindle starts. Type yes to send it".into())
        );
        assert_eq!(
            typed("no", &mut asked, false, &known),
            Typed::Tell("not sent".into())
        );
        assert_eq!(
            typed("M3 S1", &mut asked, false, &known),
            Typed::Tell("`M3S1`: the spindle starts. Type yes to send it".into())
        );
        assert!(
            matches!(typed("yes", &mut asked, false, &known), Typed::Send(e) if e.text == "M3S1")
        );
        assert!(matches!(
            typed("M3 S1", &mut asked, true, &known),
            Typed::Send(_)
        ));
        let Typed::Tell(text) = typed("$J=F100", &mut asked, true, &known) else {
            panic!()
        };
        assert_eq!(
            text,
            "not sent: a jog without X, Y or Z drives to machine zero: name an axis"
        );
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
