//! Expressions of word-address programs: numbers, variables, operators, functions.
//!
//! Crosses the border: the bytes of one line, the variables and the machine's state in; a value and the place behind it out. Angles are in
//! degrees, lengths in the program's units. Nothing that is not a number comes out: what has no value is refused with its place.
//!
//! Two families of rules. *RS274/NGC* (LinuxCNC, G-Code Overview, Binary Operators and Functions):
//!
//! ```text
//! **     * / MOD     + -     EQ NE GT GE LT LE     AND OR XOR      first to last; AND OR XOR take zero for false
//! ```
//!
//! *Macro B* (Fanuc Operator's Manual, Custom Macro, Arithmetic and Logic Operation; AND OR XOR work bit by bit):
//!
//! ```text
//!        * / AND MOD     + - OR XOR     EQ NE GT GE LT LE
//! ```

use super::dialect::Dialect;
use super::error::{Complaint, Fault};
pub use super::expression_complaint::ExpressionComplaint;
use super::parameter::{Parameter, Parameters};
use super::state::State;
use super::word::MAX_COLUMN;

/// Letters of the longest keyword, endrepeat.
const LONGEST_KEYWORD: usize = 9;
/// Deepest brackets; Fanuc's own limit is five (alarm 118).
const DEEPEST: u32 = 32;
const FANUC_DEEPEST: u32 = 5;
/// LinuxCNC, Equality and floating-point values.
const EQUAL_WITHIN: f64 = 1e-6;

/// The controllers that compute by the rules of RS274/NGC.
pub(super) fn is_ngc(dialect: Dialect) -> bool {
    use Dialect::{Eding, LinuxCnc, Mach3, Planet};
    matches!(dialect, LinuxCnc | Planet | Mach3 | Eding)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    Power,
    Times,
    Over,
    Mod,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
    And,
    Or,
    Xor,
}

/// A value, or a variable that is vacant and by what name.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Vacant { name: Box<str>, at: usize },
}

impl Value {
    /// The number; a vacant variable is refused.
    pub fn number(self) -> Result<f64, Fault> {
        match self {
            Value::Number(v) => Ok(v),
            Value::Vacant { name, at } => Err(fault(at, ExpressionComplaint::Unset { name })),
        }
    }
}

pub(super) fn fault(at: usize, complaint: ExpressionComplaint) -> Fault {
    Fault::at(at.min(MAX_COLUMN) as u32, Complaint::Expression(complaint))
}

/// Reads values out of a line.
pub(super) struct Evaluator<'a> {
    line: &'a [u8],
    /// Where reading goes on.
    pub at: usize,
    dialect: Dialect,
    pub(super) ngc: bool,
    pub(super) parameters: &'a Parameters,
    pub(super) state: &'a State,
    depth: u32,
}

impl<'a> Evaluator<'a> {
    /// From the beginning of a line.
    pub fn new(line: &'a str, parameters: &'a Parameters, state: &'a State) -> Evaluator<'a> {
        Evaluator {
            line: line.as_bytes(),
            at: 0,
            dialect: state.dialect,
            ngc: is_ngc(state.dialect),
            parameters,
            state,
            depth: 0,
        }
    }

    /// The next byte that is no blank.
    pub fn peek(&mut self) -> Option<u8> {
        while self.line.get(self.at).is_some_and(|b| *b <= b' ') {
            self.at += 1;
        }
        self.line.get(self.at).copied()
    }

    /// Steps over a byte if it comes next.
    pub fn take(&mut self, byte: u8) -> bool {
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    /// The character at the place, for messages.
    fn found(&self) -> Option<char> {
        let rest = self.line.get(self.at..).unwrap_or_default();
        let front = rest.get(..rest.len().min(4)).unwrap_or_default();
        String::from_utf8_lossy(front).chars().next()
    }

    /// The letters that come next, upper case: as many as the longest keyword has, and one, so that a line of letters is read in one go.
    pub fn letters(&mut self) -> Box<str> {
        self.peek();
        let rest = self.line.get(self.at..).unwrap_or_default();
        let count = rest
            .iter()
            .take(LONGEST_KEYWORD + 1)
            .take_while(|b| b.is_ascii_alphabetic())
            .count();
        let letters = rest.get(..count).unwrap_or_default();
        String::from_utf8_lossy(letters)
            .to_ascii_uppercase()
            .into_boxed_str()
    }

    pub(super) fn no_value(&mut self) -> Fault {
        self.peek();
        let complaint = match self.found() {
            Some(found) => ExpressionComplaint::NoValue { found },
            None => ExpressionComplaint::Ends,
        };
        fault(self.at, complaint)
    }

    /// A value by itself: a number, a variable, brackets, a function, any of them with a sign.
    pub fn value(&mut self) -> Result<Value, Fault> {
        let start = self.at;
        let negative = match self.peek() {
            Some(b'-') => true,
            Some(b'+') => false,
            _ => return self.unsigned(),
        };
        self.at += 1;
        if let Some(b'+' | b'-') = self.peek() {
            return Err(self.no_value());
        }
        let value = self.unsigned()?.number()?;
        self.finite(if negative { -value } else { value }, start)
    }

    pub(super) fn finite(&self, value: f64, at: usize) -> Result<Value, Fault> {
        match value.is_finite() {
            true => Ok(Value::Number(value)),
            false => Err(fault(at, ExpressionComplaint::NotFinite)),
        }
    }

    fn unsigned(&mut self) -> Result<Value, Fault> {
        match self.peek() {
            Some(b'[') => self.bracket(),
            Some(b'#') => {
                let at = self.at;
                let which = self.parameter()?;
                match self.parameters.get(&which, self.state) {
                    Ok(Some(value)) => Ok(Value::Number(value)),
                    Ok(None) => {
                        let name = which.to_string().into_boxed_str();
                        Ok(Value::Vacant { name, at })
                    }
                    Err(complaint) => Err(fault(at, complaint)),
                }
            }
            Some(b) if b.is_ascii_digit() || b == b'.' => self.literal(),
            Some(b) if b.is_ascii_alphabetic() => self.function(),
            _ => Err(self.no_value()),
        }
    }

    fn literal(&mut self) -> Result<Value, Fault> {
        let start = self.at;
        let rest = self.line.get(start..).unwrap_or_default();
        let (mut count, mut dots) = (0, 0);
        for b in rest {
            match b {
                b'0'..=b'9' => {}
                b'.' if dots == 0 => dots += 1,
                _ => break,
            }
            count += 1;
        }
        let digits = rest.get(..count).unwrap_or_default();
        let text = std::str::from_utf8(digits).unwrap_or_default();
        match text.parse::<f64>() {
            Ok(value) => {
                self.at += count;
                self.finite(value, start)
            }
            Err(_) => Err(self.no_value()),
        }
    }

    /// Brackets, and what is in them.
    pub fn bracket(&mut self) -> Result<Value, Fault> {
        let open = self.at;
        let limit = match self.dialect {
            Dialect::Fanuc => FANUC_DEEPEST,
            _ => DEEPEST,
        };
        if self.depth >= limit {
            return Err(fault(open, ExpressionComplaint::TooDeep { limit }));
        }
        if !self.take(b'[') {
            return Err(self.no_value());
        }
        self.depth += 1;
        let value = self.expression(0)?;
        self.depth -= 1;
        if self.take(b']') {
            return Ok(value);
        }
        let complaint = match self.found() {
            Some(found) => ExpressionComplaint::NoOperator { found },
            None => return Err(fault(open, ExpressionComplaint::Open)),
        };
        Err(fault(self.at, complaint))
    }

    /// Values joined by operators that bind at least so tightly.
    pub fn expression(&mut self, least: u8) -> Result<Value, Fault> {
        let mut left = self.value()?;
        while let Some((operator, length)) = self.operator() {
            let tightness = self.tightness(operator);
            if tightness < least {
                break;
            }
            let at = self.at;
            self.at += length;
            let right = self.expression(tightness + 1)?;
            left = self.apply(operator, left, right, at)?;
        }
        Ok(left)
    }

    fn operator(&mut self) -> Option<(Operator, usize)> {
        self.peek()?;
        let rest = self.line.get(self.at..).unwrap_or_default();
        let word = |name: &str| {
            rest.get(..name.len())
                .is_some_and(|w| w.eq_ignore_ascii_case(name.as_bytes()))
        };
        let found = match rest.first()? {
            b'*' if rest.get(1) == Some(&b'*') && self.ngc => (Operator::Power, 2),
            b'*' => (Operator::Times, 1),
            b'/' => (Operator::Over, 1),
            b'+' => (Operator::Plus, 1),
            b'-' => (Operator::Minus, 1),
            _ if word("MOD") => (Operator::Mod, 3),
            _ if word("AND") => (Operator::And, 3),
            _ if word("XOR") => (Operator::Xor, 3),
            _ if word("OR") => (Operator::Or, 2),
            _ if word("EQ") => (Operator::Equal, 2),
            _ if word("NE") => (Operator::NotEqual, 2),
            _ if word("GT") => (Operator::Greater, 2),
            _ if word("GE") => (Operator::GreaterEqual, 2),
            _ if word("LT") => (Operator::Less, 2),
            _ if word("LE") => (Operator::LessEqual, 2),
            _ => return None,
        };
        Some(found)
    }

    fn tightness(&self, operator: Operator) -> u8 {
        use Operator::{And, Minus, Mod, Or, Over, Plus, Power, Times, Xor};
        match (operator, self.ngc) {
            (Power, _) => 4,
            (Times | Over | Mod, _) | (And, false) => 3,
            (Plus | Minus, _) | (Or | Xor, false) => 2,
            (And | Or | Xor, true) => 0,
            _ => 1,
        }
    }

    fn apply(
        &self,
        operator: Operator,
        left: Value,
        right: Value,
        at: usize,
    ) -> Result<Value, Fault> {
        use Operator as O;
        let truth = |yes: bool| Ok(Value::Number(f64::from(u8::from(yes))));
        // Fanuc, Custom Macro, Undefined Variable: whether a variable is vacant is asked by comparing it with #0, and only so.
        let null = |v: &Value| matches!(v, Value::Vacant { name, .. } if &**name == "#0");
        if matches!(operator, O::Equal | O::NotEqual) && (null(&left) || null(&right)) {
            let both = matches!(
                (&left, &right),
                (Value::Vacant { .. }, Value::Vacant { .. })
            );
            return truth(both == (operator == O::Equal));
        }
        let (a, b) = (left.number()?, right.number()?);
        let value = match operator {
            O::Power => a.powf(b),
            O::Times => a * b,
            O::Over | O::Mod if b == 0.0 => {
                return Err(fault(at, ExpressionComplaint::DivisionByZero));
            }
            O::Over => a / b,
            // RS274/NGC: never negative.
            O::Mod if self.ngc => a.rem_euclid(b),
            O::Mod => a % b,
            O::Plus => a + b,
            O::Minus => a - b,
            O::Equal => return truth(self.equal(a, b)),
            O::NotEqual => return truth(!self.equal(a, b)),
            O::Greater => return truth(a > b),
            O::GreaterEqual => return truth(a >= b),
            O::Less => return truth(a < b),
            O::LessEqual => return truth(a <= b),
            O::And if self.ngc => return truth(a != 0.0 && b != 0.0),
            O::Or if self.ngc => return truth(a != 0.0 || b != 0.0),
            O::Xor if self.ngc => return truth((a != 0.0) != (b != 0.0)),
            O::And | O::Or | O::Xor => {
                let (a, b) = (bits(a, at)?, bits(b, at)?);
                f64::from(match operator {
                    O::And => a & b,
                    O::Or => a | b,
                    _ => a ^ b,
                })
            }
        };
        self.finite(value, at)
    }

    fn equal(&self, a: f64, b: f64) -> bool {
        match self.ngc {
            true => (a - b).abs() < EQUAL_WITHIN,
            false => a == b,
        }
    }

    /// `#1`, `##1`, `#[...]`, `#<name>`: which variable, not its value.
    pub fn parameter(&mut self) -> Result<Parameter, Fault> {
        let at = self.at;
        if !self.take(b'#') {
            return Err(self.no_value());
        }
        if self.ngc && self.peek() == Some(b'<') {
            return self.named(at);
        }
        if self.depth >= DEEPEST {
            return Err(fault(at, ExpressionComplaint::TooDeep { limit: DEEPEST }));
        }
        self.depth += 1;
        let number = match self.peek() {
            Some(b'[' | b'#') => self.unsigned(),
            Some(b) if b.is_ascii_digit() => self.literal(),
            _ => Err(self.no_value()),
        };
        self.depth -= 1;
        let value = number?.number()?;
        let whole = value.round();
        if (value - whole).abs() > 1e-4 || !(0.0..=99_999.0).contains(&whole) {
            return Err(fault(at, ExpressionComplaint::NotWhole { value }));
        }
        Ok(Parameter::Number(whole as u32))
    }

    fn named(&mut self, at: usize) -> Result<Parameter, Fault> {
        let rest = self.line.get(self.at + 1..).unwrap_or_default();
        let Some(length) = rest.iter().position(|b| *b == b'>') else {
            return Err(fault(at, ExpressionComplaint::NameOpen));
        };
        let name = rest.get(..length).unwrap_or_default();
        let name: String = String::from_utf8_lossy(name)
            .chars()
            .filter(|c| !c.is_whitespace())
            .map(|c| c.to_ascii_lowercase())
            .collect();
        self.at += length + 2;
        Ok(Parameter::Name(name.into_boxed_str()))
    }
}

/// A whole number from zero, as its bits.
fn bits(value: f64, at: usize) -> Result<u32, Fault> {
    match value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
        true => Ok(value as u32),
        false => Err(fault(at, ExpressionComplaint::Bits { value })),
    }
}

#[cfg(test)]
#[path = "expression_tests.rs"]
mod tests;
