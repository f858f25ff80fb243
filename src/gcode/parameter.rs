//! Variables of word-address programs: numbered (`#100`) and named (`#<depth>`), local and common, and the few that mirror the machine's
//! state.
//!
//! Crosses the border: numbers and names in; values out, or why there is none. Lengths are in the program's units.
//!
//! Two families. *Macro B* (Fanuc Operator's Manual, Custom Macro; Haas Mill Operator's Manual, Macros): #1 to #33 local to a macro call and
//! vacant until set, #100 and above common. *RS274/NGC* (LinuxCNC, G-Code Overview): #1 to #30 local to a subroutine, #31 to #5000 common and
//! zero until set, named ones an error until set, names in lower case and without blanks.

use super::dialect::Dialect;
use super::event::Plane;
use super::expression::ExpressionComplaint;
use super::state::{Distance, FeedMode, State, Units};
use std::collections::HashMap;

/// Most named variables of one program.
const MOST_NAMES: usize = 10_000;
/// Highest local number of a macro; RS274/NGC has 30.
const LOCALS: usize = 34;

/// Which variable.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Parameter {
    /// `#100`.
    Number(u32),
    /// `#<depth>`: lower case, without blanks.
    Name(Box<str>),
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Parameter::Number(n) => write!(f, "#{n}"),
            Parameter::Name(name) => write!(f, "#<{name}>"),
        }
    }
}

/// Variables of one call.
#[derive(Clone, Debug, PartialEq)]
struct Locals {
    numbers: [Option<f64>; LOCALS],
    names: HashMap<Box<str>, f64>,
}

impl Locals {
    fn empty() -> Locals {
        Locals {
            numbers: [None; LOCALS],
            names: HashMap::new(),
        }
    }
}

/// All variables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Parameters {
    ngc: bool,
    linuxcnc: bool,
    locals: Vec<Locals>,
    common: HashMap<u32, f64>,
    named: HashMap<Box<str>, f64>,
}

impl Parameters {
    /// None set.
    pub fn new(dialect: Dialect) -> Parameters {
        let mut named = HashMap::new();
        let linuxcnc = dialect == Dialect::LinuxCnc;
        if linuxcnc {
            named.insert("_value".into(), 0.0);
            named.insert("_value_returned".into(), 0.0);
        }
        Parameters {
            ngc: super::expression::is_ngc(dialect),
            linuxcnc,
            locals: vec![Locals::empty()],
            common: HashMap::new(),
            named,
        }
    }

    /// Highest local number.
    fn last_local(&self) -> u32 {
        if self.ngc { 30 } else { 33 }
    }

    /// The value; `None`: vacant (Macro B only).
    pub fn get(
        &self,
        which: &Parameter,
        state: &State,
    ) -> Result<Option<f64>, ExpressionComplaint> {
        match which {
            Parameter::Number(n) => self.number(*n, state),
            Parameter::Name(name) => self.name(name, state).map(Some),
        }
    }

    fn number(&self, n: u32, state: &State) -> Result<Option<f64>, ExpressionComplaint> {
        let name = || Parameter::Number(n).to_string().into_boxed_str();
        if n == 0 {
            return match self.ngc {
                true => Err(ExpressionComplaint::NoSuch { name: name() }),
                false => Ok(None),
            };
        }
        if n <= self.last_local() {
            let local = self.locals.last().and_then(|l| l.numbers.get(n as usize));
            let value = local.copied().flatten();
            return match (value, self.ngc) {
                // LinuxCNC, Parameters: unused subroutine parameters are zero.
                (None, true) if self.linuxcnc => Ok(Some(0.0)),
                (None, true) => Err(ExpressionComplaint::Unset { name: name() }),
                (value, _) => Ok(value),
            };
        }
        if let Some(value) = self.common.get(&n) {
            return Ok(Some(*value));
        }
        let mm = state.units.mm();
        let axis = |first: u32| (n >= first && n < first + 3).then(|| (n - first) as usize);
        if self.linuxcnc {
            let offset = state.offset();
            if let Some(i) = axis(5420) {
                return Ok(Some(state.position[i] / mm));
            }
            if n == 5220 {
                return Ok(Some(state.work_offset as f64 + 1.0));
            }
            // Where the tool table has a part in it, the machine's own place is not known here.
            if let (Some(i), None) = (axis(5021), state.tool_length) {
                return Ok(Some((state.position[i] + offset[i]) / mm));
            }
            return match n {
                // LinuxCNC, Parameters: volatile numbered parameters are zero until set.
                31..=5000 => Ok(Some(0.0)),
                _ => Err(ExpressionComplaint::Unknown { name: name() }),
            };
        }
        if self.ngc {
            return Err(ExpressionComplaint::Unset { name: name() });
        }
        // Fanuc, Custom Macro, System Variables: #5001 ff. end point of the block before, in work coordinates; #5041 ff. the same place
        // while nothing is under way.
        if let Some(i) = axis(5001).or(axis(5041)) {
            return Ok(Some(state.position[i] / mm));
        }
        match n {
            100..=199 => Ok(None),
            _ => Err(ExpressionComplaint::Unknown { name: name() }),
        }
    }

    fn name(&self, name: &str, state: &State) -> Result<f64, ExpressionComplaint> {
        let scope = match name.starts_with('_') {
            true => Some(&self.named),
            false => self.locals.last().map(|l| &l.names),
        };
        if let Some(value) = scope.and_then(|s| s.get(name)) {
            return Ok(*value);
        }
        if self.linuxcnc
            && let Some(value) = predefined(name, state)
        {
            return Ok(value);
        }
        let name = format!("#<{name}>").into_boxed_str();
        Err(ExpressionComplaint::Unset { name })
    }

    /// True if a named variable exists.
    pub fn exists(&self, name: &str, state: &State) -> bool {
        self.name(name, state).is_ok()
    }

    /// Checks that a variable can be set.
    pub fn may_set(&self, which: &Parameter) -> Result<(), ExpressionComplaint> {
        let name = || which.to_string().into_boxed_str();
        let ok = match which {
            Parameter::Number(n) if self.ngc => (1..=5000).contains(n),
            Parameter::Number(n) => matches!(n, 1..=33 | 100..=999),
            Parameter::Name(n) if n.starts_with('_') => {
                let probe = State::new(Dialect::LinuxCnc);
                let state = self.linuxcnc && predefined(n, &probe).is_some();
                let fixed = matches!(&**n, "_" | "_value" | "_value_returned");
                let machine = n.starts_with("_ini[") || n.starts_with("_hal[");
                !state && !fixed && !machine
            }
            Parameter::Name(n) => !n.is_empty(),
        };
        if !ok {
            return Err(ExpressionComplaint::ReadOnly { name: name() });
        }
        let names = self.named.len() + self.locals.iter().map(|l| l.names.len()).sum::<usize>();
        match which {
            Parameter::Name(_) if names >= MOST_NAMES => {
                Err(ExpressionComplaint::TooManyNames { limit: MOST_NAMES })
            }
            _ => Ok(()),
        }
    }

    /// Sets a variable that [`Parameters::may_set`]; `None` empties it (Macro B, `#1=#0`).
    pub fn set(&mut self, which: &Parameter, value: Option<f64>) {
        let last = self.last_local();
        let local = self.locals.last_mut();
        match (which, value) {
            (Parameter::Number(n), value) if *n <= last => {
                if let Some(place) = local.and_then(|l| l.numbers.get_mut(*n as usize)) {
                    *place = value;
                }
            }
            (Parameter::Number(n), Some(value)) => {
                self.common.insert(*n, value);
            }
            (Parameter::Number(n), None) => {
                self.common.remove(n);
            }
            (Parameter::Name(name), value) => {
                let scope = match name.starts_with('_') {
                    true => Some(&mut self.named),
                    false => local.map(|l| &mut l.names),
                };
                if let (Some(scope), Some(value)) = (scope, value) {
                    scope.insert(name.clone(), value);
                }
            }
        }
    }

    /// LinuxCNC: what `return` and `endsub` hand back.
    pub fn returned(&mut self, value: Option<f64>) {
        self.named.insert("_value".into(), value.unwrap_or(0.0));
        let flag = f64::from(u8::from(value.is_some()));
        self.named.insert("_value_returned".into(), flag);
    }

    /// A macro call (Macro B): locals are vacant but for these.
    pub fn enter_macro(&mut self, arguments: &[(u32, f64)]) {
        let mut locals = Locals::empty();
        for (n, value) in arguments {
            if let Some(place) = locals.numbers.get_mut(*n as usize) {
                *place = Some(*value);
            }
        }
        self.locals.push(locals);
    }

    /// A subroutine call (RS274/NGC): #1 ff. are the arguments, the numbered rest up to #30 is 0 (seen on LinuxCNC's interpreter
    /// itself, 2.10); no names.
    pub fn enter_subroutine(&mut self, arguments: &[f64]) {
        let mut locals = Locals::empty();
        for place in locals.numbers.iter_mut().skip(1).take(30) {
            *place = Some(0.0);
        }
        for (place, value) in locals.numbers.iter_mut().skip(1).zip(arguments) {
            *place = Some(*value);
        }
        self.locals.push(locals);
    }

    /// Behind either of them: the caller's own again.
    pub fn leave(&mut self) {
        if self.locals.len() > 1 {
            self.locals.pop();
        }
    }
}

/// Those of LinuxCNC's predefined names whose value the program alone decides (G-Code Overview, Predefined Named Parameters).
fn predefined(name: &str, state: &State) -> Option<f64> {
    let mm = state.units.mm();
    let flag = |yes: bool| Some(f64::from(u8::from(yes)));
    match name {
        "_x" => Some(state.position.x / mm),
        "_y" => Some(state.position.y / mm),
        "_z" => Some(state.position.z / mm),
        "_metric" => flag(state.units == Units::Mm),
        "_imperial" => flag(state.units == Units::Inch),
        "_absolute" => flag(state.distance == Distance::Absolute),
        "_incremental" => flag(state.distance == Distance::Incremental),
        "_inverse_time" => flag(state.feed_mode == FeedMode::InverseTime),
        "_units_per_minute" => flag(state.feed_mode == FeedMode::PerMinute),
        "_ijk_absolute_mode" => flag(state.arc_distance == Distance::Absolute),
        "_plane" => Some(match state.plane {
            Plane::Xy => 170.0,
            Plane::Zx => 180.0,
            Plane::Yz => 190.0,
        }),
        "_coord_system" if state.work_offset < 6 => Some(540.0 + 10.0 * state.work_offset as f64),
        "_spindle_on" => flag(state.spindle != 0),
        "_spindle_cw" => flag(state.spindle > 0),
        "_mist" => flag(state.mist),
        "_flood" => flag(state.flood),
        "_rpm" => Some(state.speed.0),
        "_feed" if state.feed_mode == FeedMode::PerMinute => Some(state.feed.0 / mm),
        _ => None,
    }
}
