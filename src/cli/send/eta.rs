//! How long a job takes by the planner, line by line, and how much of that is left, corrected by how fast it really goes.
//!
//! Constant memory: time is kept at a few thousand lines and interpolated between them.

use crate::gcode::Event;
use crate::kinematics::{Clock, Settings};

/// Marks kept at most.
const MOST_MARKS: usize = 4096;
/// Planned seconds that must be done before the real pace is believed.
const BELIEVE_AFTER: f64 = 5.0;
/// The pace is never taken to be farther from the planner's than this factor.
const WILDEST: f64 = 20.0;

/// Planned seconds at lines of the program.
#[derive(Clone, Debug, Default)]
pub struct TimeTable {
    /// Line of the program, and seconds from the start until it is done. Ascending.
    marks: Vec<(usize, f64)>,
    /// All of it, s.
    pub total: f64,
}

/// Builds a [`TimeTable`] from events told one by one.
pub struct Timer {
    clock: Clock,
    table: Building,
}

impl Timer {
    /// For a machine with these settings.
    pub fn new(settings: &Settings) -> Timer {
        Timer {
            clock: Clock::new(settings),
            table: Building::default(),
        }
    }

    /// The next event.
    pub fn hear(&mut self, event: &Event) {
        let table = &mut self.table;
        self.clock
            .hear(event, &mut |line, time| table.spent(line, time));
    }

    /// No more events.
    pub fn finish(self) -> TimeTable {
        let Timer { clock, mut table } = self;
        clock.finish(&mut |line, time| table.spent(line, time));
        table.mark();
        table.table
    }
}

/// A table to which time is still added.
#[derive(Default)]
struct Building {
    table: TimeTable,
    /// The line that time goes to.
    line: usize,
    /// Doublings of the number of lines for which one mark is kept.
    coarse: u32,
}

impl Building {
    fn spent(&mut self, line: usize, time: f64) {
        if line != self.line {
            self.mark();
            self.line = line;
        }
        self.table.total += time;
    }

    /// The present line is done.
    fn mark(&mut self) {
        let (marks, coarse) = (&mut self.table.marks, &mut self.coarse);
        let last = marks.last().map_or(0, |m| m.0);
        if self.line >> *coarse <= last >> *coarse {
            return;
        }
        marks.push((self.line, self.table.total));
        while marks.len() > MOST_MARKS {
            *coarse += 1;
            marks.dedup_by_key(|m| m.0 >> *coarse);
        }
    }
}

impl TimeTable {
    /// Planned seconds until `line` is done.
    pub fn at(&self, line: usize) -> f64 {
        let next = self.marks.partition_point(|m| m.0 <= line);
        let before = next
            .checked_sub(1)
            .and_then(|i| self.marks.get(i))
            .copied()
            .unwrap_or((0, 0.0));
        match self.marks.get(next) {
            Some(after) if after.0 > before.0 => {
                let share = line.saturating_sub(before.0) as f64 / (after.0 - before.0) as f64;
                before.1 + share * (after.1 - before.1)
            }
            _ if line > before.0 => self.total,
            _ => before.1,
        }
    }

    /// Seconds left when `line` is being done after `running` seconds without pauses, of which the first `from` planned ones were not
    /// part of this job (a resume).
    pub fn left(&self, line: usize, from: f64, running: f64) -> f64 {
        let at = self.at(line);
        let done = at - from;
        let pace = match done > BELIEVE_AFTER && running > BELIEVE_AFTER {
            true => (running / done).clamp(1.0 / WILDEST, WILDEST),
            false => 1.0,
        };
        (self.total - at).max(0.0) * pace
    }
}

/// `1:02:03`, or `2:03`.
pub fn clock(seconds: f64) -> String {
    let s = seconds.max(0.0).round().min(1e9) as u64;
    match s / 3600 {
        0 => format!("{}:{:02}", s / 60, s % 60),
        h => format!("{h}:{:02}:{:02}", s / 60 % 60, s % 60),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gcode::{Dialect, interpret};
    use crate::kinematics::line_times;
    use crate::machine::Machine;

    fn table(text: &str) -> TimeTable {
        let machine = Machine::load(crate::machine::DEFAULT_MACHINE).unwrap();
        let mut timer = Timer::new(&Settings::from(&machine));
        for event in &interpret(text, Dialect::Grbl).unwrap().events {
            timer.hear(event);
        }
        timer.finish()
    }

    #[test]
    fn the_table_is_the_planners_time_and_rises() {
        let text: String = (0..20_000)
            .map(|i| format!("G1 X{} Y{} F1000\n", i % 7, i % 11))
            .collect();
        let machine = Machine::load(crate::machine::DEFAULT_MACHINE).unwrap();
        let whole = line_times(
            &interpret(&text, Dialect::Grbl).unwrap().events,
            &Settings::from(&machine),
        );
        let t = table(&text);
        // The same times in the same order.
        assert_eq!(t.total, whole.iter().sum::<f64>());
        assert!(t.marks.len() <= MOST_MARKS);
        let mut last = 0.0;
        for line in (0..21_000).step_by(37) {
            let now = t.at(line);
            assert!(now >= last && now <= t.total + 1e-9, "{line}: {now} {last}");
            last = now;
        }
        let direct: f64 = whole.iter().take(10_000).sum();
        assert!((t.at(10_000) / direct - 1.0).abs() < 1e-3);
    }

    #[test]
    fn what_is_left_follows_the_real_pace() {
        let t = table(&"G1 X100 F600\nG1 X0\n".repeat(50));
        assert!((t.left(0, 0.0, 0.0) - t.total).abs() < 1e-9);
        let half = t.at(50);
        assert!((t.left(50, 0.0, 2.0 * half) - 2.0 * (t.total - half)).abs() < 1e-6);
        assert_eq!(t.left(1000, 0.0, 5000.0), 0.0);
        assert_eq!(TimeTable::default().left(5, 0.0, 1.0), 0.0);
    }

    #[test]
    fn times_read_like_a_clock() {
        assert_eq!(clock(3.4), "0:03");
        assert_eq!(clock(754.0), "12:34");
        assert_eq!(clock(3723.0), "1:02:03");
        assert_eq!(clock(-1.0), "0:00");
    }
}
