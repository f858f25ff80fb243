//! The functions of expressions, angles in degrees.

use super::error::Fault;
use super::expression::{Evaluator, ExpressionComplaint, Value, fault};
use super::parameter::Parameter;

impl Evaluator<'_> {
    /// A function's name and its value in brackets.
    pub(super) fn function(&mut self) -> Result<Value, Fault> {
        let at = self.at;
        let function = self.letters();
        let known = [
            "ABS", "ACOS", "ASIN", "ATAN", "COS", "EXISTS", "EXP", "FIX", "FUP", "LN", "ROUND",
            "SIN", "SQRT", "TAN",
        ];
        let known = known.into_iter().filter(|k| *k != "EXISTS" || self.ngc);
        let Some(name) = known.into_iter().find(|k| *k == &*function) else {
            return Err(fault(at, ExpressionComplaint::NoFunction { function }));
        };
        self.at += name.len();
        if self.peek() != Some(b'[') {
            return Err(fault(at, ExpressionComplaint::FunctionBracket { function }));
        }
        if name == "EXISTS" {
            return self.exists(at);
        }
        let x = self.bracket()?.number()?;
        if name == "ATAN" {
            return self.atan(x, at);
        }
        let degrees = x.to_radians();
        let domain = |ok: bool| match ok {
            true => Ok(()),
            false => Err(fault(
                at,
                ExpressionComplaint::Domain {
                    function: name,
                    value: x,
                },
            )),
        };
        let value = match name {
            "ABS" => x.abs(),
            "ACOS" | "ASIN" => {
                domain((-1.0..=1.0).contains(&x))?;
                let angle = if name == "ACOS" { x.acos() } else { x.asin() };
                self.angle(name, angle.to_degrees(), at)?
            }
            "COS" => degrees.cos(),
            "SIN" => degrees.sin(),
            "TAN" => {
                domain(degrees.cos().abs() > 1e-12)?;
                degrees.tan()
            }
            "EXP" => x.exp(),
            "LN" => {
                domain(x > 0.0)?;
                x.ln()
            }
            "SQRT" => {
                domain(x >= 0.0)?;
                x.sqrt()
            }
            // RS274/NGC rounds down and up on the number line, Macro B towards zero and away from it.
            "FIX" if self.ngc => x.floor(),
            "FUP" if self.ngc => x.ceil(),
            "FIX" => x.trunc(),
            "FUP" => x.abs().ceil() * x.signum(),
            _ => x.round(),
        };
        self.finite(value, at)
    }

    /// Negative angles: whether Fanuc's family gives them as such or from 0 to 360 is a setting (parameter 6004).
    fn angle(&self, function: &'static str, angle: f64, at: usize) -> Result<f64, Fault> {
        if self.ngc || angle >= 0.0 {
            return Ok(angle);
        }
        let other = angle + 360.0;
        Err(fault(
            at,
            ExpressionComplaint::AngleRange {
                function,
                angle,
                other,
            },
        ))
    }

    fn atan(&mut self, y: f64, at: usize) -> Result<Value, Fault> {
        let slash = self.peek() == Some(b'/');
        if !slash && self.ngc {
            return Err(fault(at, ExpressionComplaint::AtanTwo));
        }
        if !slash {
            return self.finite(y.atan().to_degrees(), at);
        }
        let before = self.at;
        self.at += 1;
        if self.peek() != Some(b'[') {
            if self.ngc {
                return Err(fault(at, ExpressionComplaint::AtanTwo));
            }
            // One value, divided by what follows.
            self.at = before;
            return self.finite(y.atan().to_degrees(), at);
        }
        let x = self.bracket()?.number()?;
        if x == 0.0 && y == 0.0 {
            let (function, value) = ("ATAN[0]/[0]: the angle", 0.0);
            return Err(fault(at, ExpressionComplaint::Domain { function, value }));
        }
        let angle = self.angle("ATAN", y.atan2(x).to_degrees(), at)?;
        self.finite(angle, at)
    }

    fn exists(&mut self, at: usize) -> Result<Value, Fault> {
        let complaint = || Err(fault(at, ExpressionComplaint::ExistsName));
        if !self.take(b'[') || self.peek() != Some(b'#') {
            return complaint();
        }
        let Parameter::Name(name) = self.parameter()? else {
            return complaint();
        };
        if !self.take(b']') {
            return complaint();
        }
        let there = self.parameters.exists(&name, self.state);
        Ok(Value::Number(f64::from(u8::from(there))))
    }
}
