//! Formulas: `Q1 = Q2 + 3 * SIN 30`. Angles in degrees.
//!
//! Multiplication and division come before addition and subtraction, powers before both; functions take what stands right behind them
//! (TNC 640 manual, "Entering formulas directly").

use super::*;

/// Parentheses, signs and functions inside each other.
const DEEPEST: u32 = 40;

/// A formula's value.
pub(super) fn value(job: &mut Job) -> Result<f64, Fault> {
    sum(job, 0)
}

/// A result that is a number and not beyond all measure.
pub(super) fn sound(value: f64, what: &'static str, at: u32) -> Result<f64, Fault> {
    if value.is_finite() && value.abs() <= 1e15 {
        Ok(value)
    } else {
        wrong(at, Wrong::NoNumber { what })
    }
}

fn sum(job: &mut Job, depth: u32) -> Result<f64, Fault> {
    let mut value = product(job, depth)?;
    loop {
        let at = job.scan.blanks().at();
        let next = if job.scan.take(b'+') {
            value + product(job, depth)?
        } else if job.scan.take(b'-') {
            value - product(job, depth)?
        } else {
            return Ok(value);
        };
        value = sound(next, "the sum", at)?;
    }
}

fn product(job: &mut Job, depth: u32) -> Result<f64, Fault> {
    let mut value = power(job, depth)?;
    loop {
        let at = job.scan.blanks().at();
        let next = if job.scan.take(b'*') {
            value * power(job, depth)?
        } else if job.scan.take(b'/') {
            value / power(job, depth)?
        } else {
            return Ok(value);
        };
        value = sound(next, "the product or quotient", at)?;
    }
}

fn power(job: &mut Job, depth: u32) -> Result<f64, Fault> {
    let signed = matches!(job.scan.blanks().peek(), Some(b'-' | b'+'));
    let base = operand(job, depth)?;
    let at = job.scan.blanks().at();
    if !job.scan.take(b'^') {
        return Ok(base);
    }
    if signed {
        let what = "a base in parentheses when it has a sign";
        return wrong(at, Wrong::Expected { what });
    }
    let exponent = operand(job, depth)?;
    if job.scan.blanks().peek() == Some(b'^') {
        let what = "a pair of parentheses around one of the powers";
        return wrong(job.scan.at(), Wrong::Expected { what });
    }
    sound(base.powf(exponent), "the power", at)
}

fn operand(job: &mut Job, depth: u32) -> Result<f64, Fault> {
    let at = job.scan.blanks().at();
    if depth > DEEPEST {
        return wrong(at, Wrong::TooDeep);
    }
    match job.scan.peek() {
        Some(b'+') => {
            job.scan.take(b'+');
            operand(job, depth + 1)
        }
        Some(b'-') => {
            job.scan.take(b'-');
            Ok(-operand(job, depth + 1)?)
        }
        Some(b'(') => {
            job.scan.take(b'(');
            let value = sum(job, depth + 1)?;
            if !job.scan.blanks().take(b')') {
                let what = "a closing parenthesis";
                return wrong(job.scan.at(), Wrong::Expected { what });
            }
            Ok(value)
        }
        Some(b'Q' | b'q') => parameter::read(job),
        Some(b) if b.is_ascii_alphabetic() => function(job, depth),
        _ => match job.scan.number(true) {
            Some(value) => Ok(value),
            None => {
                let what = "a number or a Q parameter";
                wrong(at, Wrong::Expected { what })
            }
        },
    }
}

fn function(job: &mut Job, depth: u32) -> Result<f64, Fault> {
    let at = job.scan.at();
    let whole = job.scan.rest().as_bytes();
    let length = whole
        .iter()
        .take_while(|b| b.is_ascii_alphabetic() && **b != b'Q');
    let length = length.count();
    let name = job
        .scan
        .rest()
        .get(..length)
        .unwrap_or_default()
        .to_ascii_uppercase();
    // SQRT and SQ hold a Q themselves.
    let name = match name.as_str() {
        "S" if job.scan.take_text("SQRT") => "SQRT".to_string(),
        "S" if job.scan.take_text("SQ") => "SQ".to_string(),
        _ => {
            job.scan.skip(length);
            name
        }
    };
    if name == "PI" {
        return Ok(std::f64::consts::PI);
    }
    let known = [
        "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "SQ", "ABS", "INT", "FRAC", "NEG",
        "LN", "LOG", "EXP", "SGN",
    ];
    let Some(what) = known.into_iter().find(|k| *k == name) else {
        job.scan.back(at);
        return job.not_understood();
    };
    let v = operand(job, depth + 1)?;
    let value = match what {
        "SIN" => v.to_radians().sin(),
        "COS" => v.to_radians().cos(),
        "TAN" => v.to_radians().tan(),
        "ASIN" => v.asin().to_degrees(),
        "ACOS" => v.acos().to_degrees(),
        "ATAN" => v.atan().to_degrees(),
        "SQRT" => v.sqrt(),
        "SQ" => v * v,
        "ABS" => v.abs(),
        "INT" => v.trunc(),
        "FRAC" => v.fract(),
        "NEG" => -v,
        "LN" => v.ln(),
        "LOG" => v.log10(),
        "EXP" => v.exp(),
        _ if v == 0.0 => 0.0,
        _ => v.signum(),
    };
    sound(value, what, at)
}
