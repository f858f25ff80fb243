//! `$` commands.

use super::complaint::error_number;
use super::execute::Step;
use super::{Controller, Mode};
use crate::gcode::single::read_single;
use crate::gcode::{State as Parser, interpret_jog};
use crate::geom::Point;
use crate::kinematics::Speed;

impl Controller {
    /// Settings that did not read back right at power-up: the defaults, and all of them shown.
    pub(super) fn recover_memory(&mut self) {
        self.memory.restore();
        self.memory.damaged = false;
        self.motion
            .set_settings(&self.memory.planner_settings(self.build.blocks));
        self.error(7);
        for line in self.memory.lines() {
            self.say(&line);
        }
    }

    /// Carries out a line that begins with `$`, and answers it (now, or behind the steps it queues).
    pub(super) fn dollar(&mut self, line: &str) {
        match self.dollar_result(line) {
            Ok(()) => self.steps.push_back(Step::Ok),
            Err(number) => self.error(number),
        }
    }

    fn dollar_result(&mut self, line: &str) -> Result<(), u16> {
        let rest = line.get(1..).unwrap_or_default();
        let idle = self.mode == Mode::Normal && !self.motion.going();
        let idle_or_alarm = idle || self.mode == Mode::Alarm;
        match rest.bytes().next() {
            None => {
                self.say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
                Ok(())
            }
            Some(b'J') => {
                if !idle && self.mode != Mode::Jog {
                    return Err(8);
                }
                let text = rest.strip_prefix("J=").ok_or(3u16)?;
                self.jog(text)
            }
            Some(b'$' | b'G' | b'C' | b'X') => {
                if rest.len() != 1 {
                    return Err(3);
                }
                self.one_letter(rest, idle)
            }
            _ if !idle_or_alarm => Err(8),
            Some(b'#') if rest == "#" => {
                self.report_offsets();
                Ok(())
            }
            Some(b'H') => self.home(rest),
            Some(b'S') if rest == "SLP" => {
                self.mode = Mode::Sleep;
                (self.spindle, self.flood) = (0, false);
                self.overrides_in = 0;
                self.steps.push_back(Step::Ok);
                self.steps.push_back(Step::Say("[MSG:Sleeping]"));
                // The answer is queued here, so the caller's would be one too many.
                self.steps.push_back(Step::Asleep);
                Ok(())
            }
            Some(b'I') => {
                if rest == "I" {
                    self.report_build();
                } else {
                    let text = rest.strip_prefix("I=").ok_or(3u16)?;
                    self.fits_memory(text)?;
                    let mut after = self.memory.clone();
                    after.build_text = text.to_string();
                    let bytes = self.memory.bytes_to(&after);
                    self.memory = after;
                    self.steps.push_back(Step::Write(bytes));
                }
                Ok(())
            }
            Some(b'N') => self.startup_line(rest, idle),
            Some(b'R') => self.restore(rest),
            Some(b'#' | b'S') => Err(3),
            _ => self.store_setting(rest),
        }
    }

    fn one_letter(&mut self, letter: &str, idle: bool) -> Result<(), u16> {
        match letter {
            "$" => {
                if self.motion.going() && self.mode == Mode::Normal {
                    return Err(8);
                }
                for line in self.memory.lines() {
                    self.say(&line);
                }
            }
            "G" => self.report_modes(),
            "C" if self.mode == Mode::Check => {
                // The reset is set off first: what finds no room to be said in any more is dropped.
                if self.cable.has_room() {
                    self.say("[MSG:Disabled]");
                    self.steps.push_back(Step::Ok);
                }
                self.steps.push_back(Step::LeaveCheck);
            }
            "C" if idle => {
                self.mode = Mode::Check;
                self.say("[MSG:Enabled]");
            }
            "C" => return Err(8),
            _ => {
                if self.mode == Mode::Alarm {
                    if self.door_ajar() {
                        return Err(13);
                    }
                    self.say("[MSG:Caution: Unlocked]");
                    self.mode = Mode::Normal;
                }
            }
        }
        Ok(())
    }

    fn jog(&mut self, text: &str) -> Result<(), u16> {
        let mut ahead: Parser = self.parser.clone();
        if !self.build.quirks.jog_to_zero && !text.contains(['X', 'Y', 'Z']) {
            return Err(26);
        }
        let motion = interpret_jog(&mut ahead, text, 0).map_err(|e| error_number(&e.complaint))?;
        let to = ahead.machine_position();
        if self.memory.is_on(20) && self.outside(&to) {
            return Err(15);
        }
        self.parser = ahead;
        self.mode = Mode::Jog;
        self.steps.push_back(Step::Block {
            to,
            speed: Speed::Fixed(motion.feed),
            beam: self.jog_beam(),
        });
        self.steps.push_back(Step::Start);
        Ok(())
    }

    fn home(&mut self, rest: &str) -> Result<(), u16> {
        if !self.memory.is_on(22) {
            return Err(5);
        }
        if rest != "H" {
            if self.build.quirks.home_axis_wedge && rest.len() == 2 {
                // The state is set before the axis is looked at, and stays.
                self.mode = Mode::Home;
            }
            return Err(3);
        }
        if self.door_ajar() {
            return Err(13);
        }
        self.begin_homing();
        Ok(())
    }

    /// A line that is kept has to fit the place it is kept in (error 14: builds that read longer lines than they can keep).
    fn fits_memory(&self, text: &str) -> Result<(), u16> {
        match text.len() < crate::wire::LINE_CHARS {
            true => Ok(()),
            false => Err(14),
        }
    }

    fn startup_line(&mut self, rest: &str, idle: bool) -> Result<(), u16> {
        if rest == "N" {
            let lines = self.memory.startup.clone();
            for (i, line) in lines.iter().enumerate() {
                self.say(&format!("$N{i}={line}"));
            }
            return Ok(());
        }
        if !idle {
            return Err(8);
        }
        let (slot, behind) = number(rest.get(1..).unwrap_or_default()).ok_or(2u16)?;
        let text = behind.strip_prefix('=').ok_or(3u16)?;
        let slot = usize::from(slot as i64 as u8);
        self.fits_memory(text)?;
        // It is carried out first, and kept only if it went well.
        self.carry_out(text)?;
        self.memory.keep_startup(slot, text);
        Ok(())
    }

    pub(super) fn queue_startup_lines(&mut self) {
        for text in self.memory.startup.clone() {
            if text.is_empty() {
                continue;
            }
            match self.carry_out(&text) {
                Ok(()) => self.say(&format!(">{text}:ok")),
                Err(number) => self.say(&format!(">{text}:error:{number}")),
            }
        }
        self.refresh_offset();
    }

    fn restore(&mut self, rest: &str) -> Result<(), u16> {
        let what = rest.strip_prefix("RST=").ok_or(3u16)?;
        if !matches!(what, "$" | "#" | "*") {
            return Err(3);
        }
        let before = self.memory();
        if what != "#" {
            self.memory.restore();
            self.motion
                .set_settings(&self.memory.planner_settings(self.build.blocks));
        }
        if what != "$" {
            self.parser.g5x = Default::default();
            (self.parser.g28, self.parser.g30) = (Point::origin(), Point::origin());
        }
        if what == "*" {
            self.memory.startup = Default::default();
            self.memory.build_text.clear();
        }
        self.memory.places = Controller::stored(&self.parser);
        self.steps
            .push_back(Step::Write(before.bytes_to(&self.memory)));
        self.steps.push_back(Step::Say("[MSG:Restoring defaults]"));
        self.steps.push_back(Step::Ok);
        self.steps.push_back(Step::LeaveCheck);
        Ok(())
    }

    fn store_setting(&mut self, rest: &str) -> Result<(), u16> {
        let (number, after) = number(rest).ok_or(2u16)?;
        let value = after.strip_prefix('=').ok_or(3u16)?;
        let (value, after) = self::number(value).ok_or(2u16)?;
        if !after.is_empty() {
            return Err(3);
        }
        let byte = matches!(number as u16, 1 | 2 | 3 | 10 | 23 | 26);
        let value = match byte && !self.build.quirks.byte_wrap {
            true => value.min(255.0),
            false => value,
        };
        let before = self.memory.clone();
        let mut after = before.clone();
        after.store(number, value)?;
        let options = self.build.options;
        if number as u16 == 32 && !options.variable_spindle && after.is_on(32) {
            return Err(17);
        }
        if let Some(most) = options.most_steps_per_second
            && after.steps_per_second() > f64::from(most)
            && matches!(number as u16, 100..=102 | 110..=112)
        {
            return Err(12);
        }
        self.memory = after;
        self.steps
            .push_back(Step::Write(before.bytes_to(&self.memory)));
        self.motion
            .set_settings(&self.memory.planner_settings(self.build.blocks));
        self.refresh_offset();
        self.wco_in = 0;
        Ok(())
    }
}

/// A number as the firmware reads it: sign, digits, one dot. And what follows it.
fn number(text: &str) -> Option<(f64, &str)> {
    let sign = usize::from(text.starts_with(['+', '-']));
    let mut dots = 0;
    let end = text
        .char_indices()
        .skip(sign)
        .find(|(_, c)| {
            dots += usize::from(*c == '.');
            !(c.is_ascii_digit() || (*c == '.' && dots == 1))
        })
        .map_or(text.len(), |(i, _)| i);
    let (figure, rest) = text.split_at_checked(end)?;
    figure.bytes().any(|b| b.is_ascii_digit()).then_some(())?;
    Some((read_single(figure), rest))
}
