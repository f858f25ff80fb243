//! Which line goes out next: our own, the job's, the closing one.

use super::watching::{Look, Upcoming};
use super::{Closing, Phase, Session};
use crate::gcode::{Distance, FeedMode, MotionMode, Plane, State as Parser, Units};
use crate::link::job::JobLine;
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, PromptKind, Span};
use crate::link::stream::Stream;
use crate::wire::{Firmware, State};
use std::time::Duration;

impl Session {
    /// The controller is known: compares it with what the job was vetted for and begins.
    pub(super) fn begin(&mut self, now: Duration) {
        self.news
            .push(Progress::Connected(Box::new(self.known.clone())));
        if self.known.state != State::Idle {
            let why = match self.known.state {
                State::Alarm => {
                    "the controller is locked by an alarm: home it with $H, or unlock it with $X if you know where it is, then send again"
                        .to_string()
                }
                ref other => format!(
                    "the controller is not idle but says {}: wait until it is, or reset it",
                    other.text()
                ),
            };
            return self.end(Ending::NotReady(why), now);
        }
        self.compare();
        self.stand();
        match self.job.lines() {
            Ok(lines) => self.lines = Some(lines),
            Err(e) => return self.end(Ending::Unreadable(e), now),
        }
        self.stream = Stream::new(self.known.rx_bytes);
        let modes = mode_words(&self.job.options.start);
        if modes.iter().any(|m| !self.known.modes.has(m)) {
            let text = format!(
                "the controller's modes were {}; the job starts from {}",
                self.known.modes,
                modes.join(" ")
            );
            self.note(&text);
            self.own.push_back(modes_line(&modes).into());
        }
        if let Err(e) = self.entry() {
            return self.end(Ending::Unreadable(e), now);
        }
        self.news.push(Progress::Started {
            total: self.job.total,
        });
        (self.last_answer, self.last_heard) = (now, now);
        (self.asked, self.last_asked) = (None, now);
        self.enter(Phase::Streaming, now);
    }

    fn compare(&mut self) {
        for (number, promised) in self.options.settings.clone() {
            match self.known.setting(number) {
                Some(actual) if (actual - promised).abs() > 1e-3 + promised.abs() * 1e-3 => {
                    self.note(&format!(
                        "${number} is {actual} on the controller, {promised} in the machine file: time and limits will differ"
                    ));
                }
                _ => {}
            }
        }
        if self.known.setting(32).is_some_and(|v| v != 0.0) {
            self.note("laser mode is on ($32=1): spindle speed changes behave differently");
        }
        let (vetted, is) = (self.job.options.firmware, self.known.firmware);
        if vetted != is && is != Firmware::Unknown {
            self.note(&format!(
                "the program was checked by the rules of {}, but the controller is {}",
                vetted.title(),
                is.title()
            ));
        }
        for warning in self.job.warnings.clone() {
            self.note(&warning.to_string());
        }
    }

    /// Puts into the stream what may go out now.
    pub(super) fn send_lines(&mut self, now: Duration) {
        let looking = matches!(self.look, Look::Now { .. });
        if self.waiting.is_some() || looking || self.hold_asked || now < self.quiet_until {
            return;
        }
        loop {
            if let Some(own) = self.own.front() {
                if self.stream.verdict(&own.line).is_err() {
                    return;
                }
                if let Some(own) = self.own.pop_front()
                    && !self.push(own, None, now)
                {
                    return;
                }
                continue;
            }
            if matches!(self.look, Look::Due(_)) {
                return;
            }
            if self.next.is_none() && self.closing == Closing::NotYet {
                match self.read_on() {
                    Ok(Some(next)) => self.next = Some(next),
                    Err(e) => {
                        return self.stop(
                            Ending::Unreadable(e),
                            "the program cannot be read on",
                            now,
                        );
                    }
                    Ok(None) => self.closing = Closing::Due,
                }
            }
            if let Some(next) = &mut self.next {
                if next.line.text.starts_with('$') && !next.settled {
                    // GRBL takes `$` lines only at standstill (error 8).
                    next.settled = true;
                    self.own.push_back(JobLine::settle().into());
                    continue;
                }
                if self.index >= self.allowed || self.stream.verdict(&next.line).is_err() {
                    return;
                }
                if let Some(next) = self.next.take() {
                    let index = self.index;
                    self.index += 1;
                    if !self.push(next, Some(index), now) {
                        return;
                    }
                }
            } else if self.closing == Closing::Due {
                let line = JobLine::settle();
                if self.stream.verdict(&line).is_err() {
                    return;
                }
                self.closing = Closing::Sent;
                self.push(line.into(), None, now);
                return;
            } else {
                return;
            }
        }
    }

    fn push(&mut self, next: Upcoming, index: Option<usize>, now: Duration) -> bool {
        self.goes_out(&next);
        if self.stream.is_empty() {
            // Nothing was waited for until now.
            self.last_answer = now;
        }
        match self.stream.push(next.line, index) {
            Ok(()) => true,
            Err(e) => {
                self.stop(Ending::Unstreamable(e), "a line does not fit", now);
                false
            }
        }
    }

    /// So many bytes of lines were written.
    pub(super) fn begun(&mut self, bytes: usize) {
        let begun = self.stream.written(bytes);
        let mut indices = begun
            .iter()
            .filter_map(|(index, source)| Some(((*index)?, *source)));
        if let Some((first, source)) = indices.next() {
            let (last, source) = indices.next_back().unwrap_or((first, source));
            self.sent = last + 1;
            self.news.push(Progress::Sent(Span {
                lines: first..last + 1,
                source,
            }));
        }
    }

    /// The machine goes on behind a tool change: whatever was done meanwhile, the program's modes hold again.
    pub(super) fn restore_modes(&mut self) {
        let Some(lines) = &self.lines else { return };
        let state = lines.state();
        let mut modes = mode_words(state);
        let feeds = state.feed.0 > 0.0 && state.feed_mode == FeedMode::PerMinute;
        if let Some(motion) = modes.first_mut() {
            // A line that relies on an arc or on inverse time is refused behind G80 (error 31), which is better than a wrong move.
            *motion = match state.motion {
                MotionMode::Rapid => "G0",
                MotionMode::Linear if feeds => "G1",
                _ => "G80",
            }
            .to_string();
        }
        let unit = state.units.mm();
        if feeds {
            modes.push(format!("F{:.4}", state.feed.0 / unit));
        }
        if state.speed.0 > 0.0 {
            modes.push(format!("S{:.0}", state.speed.0));
        }
        for (on, word) in [(state.flood, "M8"), (state.mist, "M7")] {
            if on {
                modes.push(word.to_string());
            }
        }
        self.own.push_back(modes_line(&modes).into());
    }

    /// Remembers which lines of the program may have been carried out without an answer.
    pub(super) fn note_maybe(&mut self) {
        let mut sources = self
            .stream
            .unanswered()
            .filter(|f| f.written > 0 && f.line.source > 0)
            .map(|f| f.line.source);
        if let Some(first) = sources.next() {
            self.maybe = Some((first, sources.last().unwrap_or(first)));
        }
    }

    /// A line at which the operator is asked for, if it is the oldest unanswered one.
    pub(super) fn prompt_under_way(&self) -> Option<crate::link::progress::Prompt> {
        let oldest = self.stream.unanswered().next()?;
        oldest
            .line
            .prompt
            .clone()
            .filter(|p| p.kind == PromptKind::Pause)
    }
}

/// The modes a vetted job takes for granted, as words.
fn mode_words(state: &Parser) -> Vec<String> {
    let plane = match state.plane {
        Plane::Xy => "G17",
        Plane::Zx => "G18",
        Plane::Yz => "G19",
    };
    let units = match state.units {
        Units::Mm => "G21",
        Units::Inch => "G20",
    };
    let distance = match state.distance {
        Distance::Absolute => "G90",
        Distance::Incremental => "G91",
    };
    let feed = match state.feed_mode {
        FeedMode::InverseTime => "G93",
        FeedMode::PerMinute | FeedMode::PerTurn => "G94",
    };
    let offset = format!("G{}", 54 + state.work_offset.min(5));
    vec![
        "G0".to_string(),
        offset,
        plane.to_string(),
        units.to_string(),
        distance.to_string(),
        feed.to_string(),
    ]
}

/// Nothing is sent behind it until it is answered.
fn modes_line(modes: &[String]) -> JobLine {
    let mut line = JobLine::own(&modes.concat());
    line.weight.changes_frame = true;
    line.weight.dangerous = true;
    line
}
