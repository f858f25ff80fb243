//! The `$n=value` memory and what survives a power cycle beside it.

use super::eeprom::changed;
use super::report::as_printed;
use crate::gcode::State as Parser;
use crate::geom::{Point, Vector};
use crate::kinematics::Settings;
use crate::machine::Machine;
use crate::units::{Mm, MmPerMin, MmPerSec2, Seconds};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Eight bits: a larger value wraps around silently.
    Byte,
    /// Zero or one: anything above zero is one.
    Switch,
    /// Printed without decimals.
    Whole,
    /// Printed with three.
    Decimal,
}

/// Number, kind, GRBL's generic default.
const TABLE: [(u16, Kind, f64); 34] = [
    (0, Kind::Byte, 10.0),
    (1, Kind::Byte, 25.0),
    (2, Kind::Byte, 0.0),
    (3, Kind::Byte, 0.0),
    (4, Kind::Switch, 0.0),
    (5, Kind::Switch, 0.0),
    (6, Kind::Switch, 0.0),
    (10, Kind::Byte, 1.0),
    (11, Kind::Decimal, 0.010),
    (12, Kind::Decimal, 0.002),
    (13, Kind::Switch, 0.0),
    (20, Kind::Switch, 0.0),
    (21, Kind::Switch, 0.0),
    (22, Kind::Switch, 0.0),
    (23, Kind::Byte, 0.0),
    (24, Kind::Decimal, 25.0),
    (25, Kind::Decimal, 500.0),
    (26, Kind::Byte, 250.0),
    (27, Kind::Decimal, 1.0),
    (30, Kind::Whole, 1000.0),
    (31, Kind::Whole, 0.0),
    (32, Kind::Switch, 0.0),
    (100, Kind::Decimal, 250.0),
    (101, Kind::Decimal, 250.0),
    (102, Kind::Decimal, 250.0),
    (110, Kind::Decimal, 500.0),
    (111, Kind::Decimal, 500.0),
    (112, Kind::Decimal, 500.0),
    (120, Kind::Decimal, 10.0),
    (121, Kind::Decimal, 10.0),
    (122, Kind::Decimal, 10.0),
    (130, Kind::Decimal, 200.0),
    (131, Kind::Decimal, 200.0),
    (132, Kind::Decimal, 200.0),
];

/// Where the first startup line stands on the chip, what one takes with its checksum, where the user's text stands.
const STARTUP_AT: usize = 768;
const STARTUP_BYTES: usize = 81;
const BUILD_TEXT_AT: usize = 942;
const CHIP_BYTES: usize = 1024;

/// The settings. Lengths mm, rates mm/min, accelerations mm/s².
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    values: [f64; TABLE.len()],
    /// `$N0`, `$N1`: lines run at every start.
    pub startup: [String; 2],
    /// `$I=` text.
    pub build_text: String,
    /// Origins of G54 to G59, then the places of G28 and G30, machine coordinates, mm.
    pub places: [[f64; 3]; 8],
    /// The settings do not read back right: the next power-up restores the defaults and says so (error 7).
    pub damaged: bool,
}

impl Default for Memory {
    fn default() -> Self {
        Memory {
            values: TABLE.map(|t| t.2),
            startup: Default::default(),
            build_text: String::new(),
            places: [[0.0; 3]; 8],
            damaged: false,
        }
    }
}

impl Memory {
    /// GRBL's defaults with the figures of a machine.
    pub fn of_machine(machine: &Machine) -> Memory {
        let mut memory = Memory::default();
        memory.set(11, machine.junction_deviation.0);
        memory.set(12, machine.arc_tolerance.0);
        memory.set(30, machine.spindle[1].0);
        memory.set(31, machine.spindle[0].0);
        for (axis, offset) in (0..3).zip(0u16..) {
            memory.set(100 + offset, machine.steps_per_mm[axis]);
            memory.set(110 + offset, machine.max_rate[axis].0);
            memory.set(120 + offset, machine.acceleration[axis].0);
            memory.set(130 + offset, machine.travel[axis].0);
        }
        memory
    }

    /// The value of `$number`; 0 for a number there is not.
    pub fn get(&self, number: u16) -> f64 {
        TABLE
            .iter()
            .zip(&self.values)
            .find(|(t, _)| t.0 == number)
            .map_or(0.0, |(_, v)| *v)
    }

    /// True for a switch or byte that is not zero.
    pub fn is_on(&self, number: u16) -> bool {
        self.get(number) != 0.0
    }

    /// The X, Y, Z values of `$first`, `$first+1`, `$first+2`.
    pub fn axes(&self, first: u16) -> [f64; 3] {
        [self.get(first), self.get(first + 1), self.get(first + 2)]
    }

    /// What the planner must know, with a window of `blocks`. Zeros, which the firmware would store without complaint, become the
    /// smallest figure that still moves.
    pub fn planner_settings(&self, blocks: usize) -> Settings {
        let above_zero = |v: [f64; 3]| v.map(|x| if x > 1e-3 { x } else { 1e-3 });
        let idle = self.get(1);
        Settings {
            steps_per_mm: above_zero(self.axes(100)),
            max_rate: above_zero(self.axes(110)).map(MmPerMin),
            acceleration: above_zero(self.axes(120)).map(MmPerSec2),
            junction_deviation: Mm(self.get(11)),
            arc_tolerance: Mm(self.get(12).max(1e-6)),
            blocks,
            // 255 holds the motors for ever, without waiting for it.
            idle_delay: Seconds(if idle >= 255.0 { 0.0 } else { idle / 1000.0 }),
        }
    }

    /// Sets a value without the checks of `$n=`.
    pub fn set(&mut self, number: u16, value: f64) {
        if let Some((_, v)) = TABLE
            .iter()
            .zip(&mut self.values)
            .find(|(t, _)| t.0 == number)
        {
            *v = value;
        }
    }

    /// `$number=value` with the firmware's checks.
    ///
    /// # Errors
    /// GRBL's error number.
    pub fn store(&mut self, number: f64, value: f64) -> Result<(), u16> {
        // The firmware cuts the number's fraction off: `$1.5=` sets $1.
        let number = number.trunc();
        let number = if (0.0..=255.0).contains(&number) {
            number as u16
        } else {
            return Err(3);
        };
        if value < 0.0 {
            return Err(4);
        }
        let Some((entry, _)) = TABLE.iter().zip(&self.values).find(|(t, _)| t.0 == number) else {
            return Err(3);
        };
        let byte = (value as u64 % 256) as f64;
        let stored = match entry.1 {
            Kind::Byte => byte,
            Kind::Switch => f64::from(u8::from(byte != 0.0)),
            Kind::Whole | Kind::Decimal => value,
        };
        match number {
            0 if byte < 3.0 => return Err(6),
            20 if stored != 0.0 && !self.is_on(22) => return Err(10),
            22 if stored == 0.0 => self.set(20, 0.0),
            _ => {}
        }
        self.set(number, stored);
        Ok(())
    }

    /// Takes the stored offsets and places from what the parser knows.
    pub(super) fn remember(&mut self, parser: &Parser) {
        self.places = super::Controller::stored(parser);
    }

    /// Gives the stored offsets and places to the parser.
    pub(super) fn recall(&self, parser: &mut Parser) {
        for (origin, place) in parser.g5x.iter_mut().zip(&self.places) {
            *origin = Vector::from(*place);
        }
        let [.., g28, g30] = self.places;
        (parser.g28, parser.g30) = (Point::from(g28), Point::from(g30));
    }

    /// Keeps a startup line (`$Nn=`). There are two; for any other number the firmware writes where that line would be, over what
    /// stands there.
    pub(super) fn keep_startup(&mut self, slot: usize, text: &str) {
        match self.startup.get_mut(slot) {
            Some(place) => *place = text.to_string(),
            None => {
                let at = (STARTUP_AT + slot * STARTUP_BYTES) % CHIP_BYTES;
                if at < BUILD_TEXT_AT + STARTUP_BYTES && at + STARTUP_BYTES > BUILD_TEXT_AT {
                    self.build_text.clear();
                }
            }
        }
    }

    /// The most steps an axis makes in a second at its highest rate.
    pub(super) fn steps_per_second(&self) -> f64 {
        let (steps, rate) = (self.axes(100), self.axes(110));
        (0..3)
            .map(|i| steps[i] * rate[i] / 60.0)
            .fold(0.0, f64::max)
    }

    /// Bytes of the chip that change from one to the other, checksums counted.
    pub(super) fn bytes_to(&self, after: &Memory) -> usize {
        let values = TABLE.iter().zip(self.values.iter().zip(&after.values));
        let bytes: usize = values
            .map(|((_, kind, _), (b, a))| match kind {
                Kind::Byte | Kind::Switch => usize::from(b != a),
                Kind::Whole | Kind::Decimal => changed(*b, *a),
            })
            .sum();
        let places = self.places.iter().zip(&after.places);
        let moved: usize = places
            .map(|(b, a)| {
                let of_place: usize = b.iter().zip(a).map(|(b, a)| changed(*b, *a)).sum();
                of_place + usize::from(of_place > 0)
            })
            .sum();
        let texts = self.startup.iter().zip(&after.startup);
        let texts = texts.chain([(&self.build_text, &after.build_text)]);
        let written: usize = texts
            .map(|(b, a)| if b == a { 0 } else { a.len().max(1) + 1 })
            .sum();
        bytes + usize::from(bytes > 0) + moved + written
    }

    /// Back to the defaults (`$RST=$`).
    pub fn restore(&mut self) {
        self.values = TABLE.map(|t| t.2);
    }

    /// The lines of `$$`.
    pub fn lines(&self) -> Vec<String> {
        TABLE
            .iter()
            .zip(&self.values)
            .map(|((number, kind, _), value)| match kind {
                Kind::Decimal => format!("${number}={:.3}", as_printed(*value, 3)),
                _ => format!("${number}={:.0}", as_printed(*value, 0)),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn refuses_as_the_firmware_does() {
        let mut m = Memory::default();
        assert_eq!(m.store(0.0, 2.0), Err(6));
        assert_eq!(m.store(7.0, 1.0), Err(3));
        assert_eq!(m.store(140.0, 1.0), Err(3));
        assert_eq!(m.store(300.0, 1.0), Err(3));
        assert_eq!(m.store(1.0, -1.0), Err(4));
        assert_eq!(m.store(20.0, 1.0), Err(10));
        assert_eq!(m.store(22.0, 1.0), Ok(()));
        assert_eq!(m.store(20.0, 1.0), Ok(()));
        assert_eq!(m.store(22.0, 0.0), Ok(()));
        assert_eq!(m.get(20), 0.0);
    }

    #[test]
    fn bytes_wrap_and_switches_switch() {
        let mut m = Memory::default();
        m.store(1.0, 256.0).unwrap();
        assert_eq!(m.get(1), 0.0);
        m.store(13.0, 2.0).unwrap();
        assert_eq!(m.get(13), 1.0);
        m.store(1.5, 1.0).unwrap();
        assert_eq!(m.get(1), 1.0);
        assert_eq!(m.lines()[8], "$11=0.010");
        assert_eq!(m.lines()[0], "$0=10");
    }
}
