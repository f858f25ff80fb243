//! Expressions: numbers, R parameters, variables, operators, functions. Angles in degrees.
//!
//! Priorities as in "Job planning", table of the operators: NOT; * / DIV MOD; + -; AND; XOR; OR; comparisons last. So comparisons that are
//! joined need parentheses, and without them the types tell.

use super::*;

/// Parentheses, signs and functions inside each other.
const DEEPEST: u32 = 40;

/// What an expression comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Truth(bool),
}

/// A number.
pub(super) fn number(job: &mut Job, name: &str) -> Result<f64, Fault> {
    let at = job.scan.blanks().at();
    let value = value(job)?;
    as_number(value, name, at)
}

/// A condition.
pub(super) fn condition(job: &mut Job) -> Result<bool, Fault> {
    let at = job.scan.blanks().at();
    let value = value(job)?;
    as_truth(value, "IF", at)
}

/// An expression, whatever it comes to.
pub(super) fn value(job: &mut Job) -> Result<Value, Fault> {
    comparison(job, 0)
}

fn as_number(value: Value, name: &str, at: u32) -> Result<f64, Fault> {
    match value {
        Value::Number(n) => Ok(n),
        Value::Truth(_) => {
            let (name, what) = (Name::of(name), "numbers");
            wrong(at, Wrong::Kind { name, what })
        }
    }
}

fn as_truth(value: Value, name: &str, at: u32) -> Result<bool, Fault> {
    match value {
        Value::Truth(t) => Ok(t),
        Value::Number(_) => {
            let (name, what) = (Name::of(name), "conditions");
            wrong(at, Wrong::Kind { name, what })
        }
    }
}

fn finite(value: f64, name: &str, at: u32) -> Result<Value, Fault> {
    if value.is_finite() && value.abs() <= 1e15 {
        Ok(Value::Number(value))
    } else {
        let name = Name::of(name);
        wrong(at, Wrong::NoNumber { name })
    }
}

/// A comparison operator, if one stands here.
fn comparator(scan: &mut Scan) -> Option<&'static str> {
    ["==", "<>", ">=", "<=", ">", "<"]
        .into_iter()
        .find(|o| scan.take_text(o))
}

/// Past an operator written in letters, if it stands here and is a whole word.
fn word(scan: &mut Scan, name: &'static str) -> bool {
    let mut ahead = scan.clone();
    let run = ahead.run(|b| b.is_ascii_alphanumeric() || b == b'_');
    let same = run.eq_ignore_ascii_case(name);
    if same {
        *scan = ahead;
    }
    same
}

fn comparison(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    let left = either(job, depth)?;
    let at = job.scan.blanks().at();
    if job.scan.rest().starts_with("<<") {
        return refuse(at, "<<", "texts are not joined; write one text");
    }
    let Some(operator) = comparator(&mut job.scan) else {
        return Ok(left);
    };
    let right = either(job, depth)?;
    if comparator(&mut job.scan.blanks().clone()).is_some() {
        let what = "a pair of parentheses around each comparison";
        return wrong(job.scan.at(), Wrong::Expected { what });
    }
    if let (Value::Truth(a), Value::Truth(b), "==" | "<>") = (left, right, operator) {
        return Ok(Value::Truth((a == b) == (operator == "==")));
    }
    let a = as_number(left, operator, at)?;
    let b = as_number(right, operator, at)?;
    Ok(Value::Truth(match operator {
        "==" => a == b,
        "<>" => a != b,
        ">=" => a >= b,
        "<=" => a <= b,
        ">" => a > b,
        _ => a < b,
    }))
}

/// A chain of one logical operator, its operands read by `next`.
fn chain(
    job: &mut Job,
    depth: u32,
    name: &'static str,
    next: fn(&mut Job, u32) -> Result<Value, Fault>,
    join: fn(bool, bool) -> bool,
) -> Result<Value, Fault> {
    let mut left = next(job, depth)?;
    loop {
        let at = job.scan.blanks().at();
        if !word(&mut job.scan, name) {
            return Ok(left);
        }
        let right = next(job, depth)?;
        let (a, b) = (as_truth(left, name, at)?, as_truth(right, name, at)?);
        left = Value::Truth(join(a, b));
    }
}

fn either(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    chain(job, depth, "OR", exclusive, |a, b| a || b)
}

fn exclusive(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    chain(job, depth, "XOR", both, |a, b| a != b)
}

fn both(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    chain(job, depth, "AND", sum, |a, b| a && b)
}

fn sum(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    let mut left = product(job, depth)?;
    loop {
        let at = job.scan.blanks().at();
        let minus = job.scan.take(b'-');
        if !minus && !job.scan.take(b'+') {
            return Ok(left);
        }
        let name = if minus { "-" } else { "+" };
        let right = product(job, depth)?;
        let (a, b) = (as_number(left, name, at)?, as_number(right, name, at)?);
        left = finite(if minus { a - b } else { a + b }, name, at)?;
    }
}

fn product(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    let mut left = unary(job, depth)?;
    loop {
        let at = job.scan.blanks().at();
        let name = if job.scan.take(b'*') {
            "*"
        } else if job.scan.take(b'/') {
            "/"
        } else if word(&mut job.scan, "DIV") {
            "DIV"
        } else if word(&mut job.scan, "MOD") {
            "MOD"
        } else {
            return Ok(left);
        };
        let right = unary(job, depth)?;
        let (a, b) = (as_number(left, name, at)?, as_number(right, name, at)?);
        let whole = a.fract() == 0.0 && b.fract() == 0.0;
        if matches!(name, "DIV" | "MOD") && !whole {
            return range(at, name, "whole numbers");
        }
        let value = match name {
            "*" => a * b,
            "/" => a / b,
            "DIV" => (a / b).trunc(),
            _ => a % b,
        };
        left = finite(value, name, at)?;
    }
}

fn unary(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    let at = job.scan.blanks().at();
    if depth > DEEPEST {
        return wrong(at, Wrong::TooDeep);
    }
    if job.scan.take(b'+') {
        return Ok(Value::Number(as_number(unary(job, depth + 1)?, "+", at)?));
    }
    if job.scan.take(b'-') {
        return Ok(Value::Number(-as_number(unary(job, depth + 1)?, "-", at)?));
    }
    if word(&mut job.scan, "NOT") {
        return Ok(Value::Truth(!as_truth(unary(job, depth + 1)?, "NOT", at)?));
    }
    if job.scan.take(b'(') {
        let value = comparison(job, depth + 1)?;
        close(job)?;
        return Ok(value);
    }
    if job.scan.peek() == Some(b'$') {
        return refuse(
            at,
            "$",
            "system variables are the control's, and not known here",
        );
    }
    if let Some(number) = job.scan.number(false) {
        return exponent(job, number, at);
    }
    name(job, depth)
}

/// `1EX3` is 1000.
fn exponent(job: &mut Job, number: f64, at: u32) -> Result<Value, Fault> {
    let mut ahead = job.scan.clone();
    if !ahead.take_text("EX") {
        return Ok(Value::Number(number));
    }
    let minus = ahead.take(b'-');
    if !minus {
        ahead.take(b'+');
    }
    let Ok(power) = ahead.run(|b| b.is_ascii_digit()).parse::<i32>() else {
        let what = "a whole exponent behind EX";
        return wrong(at, Wrong::Expected { what });
    };
    job.scan = ahead;
    let power = power.min(400);
    finite(
        number * 10f64.powi(if minus { -power } else { power }),
        "EX",
        at,
    )
}

fn close(job: &mut Job) -> Result<(), Fault> {
    if job.scan.blanks().take(b')') {
        return Ok(());
    }
    let what = "a closing parenthesis";
    wrong(job.scan.at(), Wrong::Expected { what })
}

/// An R parameter, a variable, a constant, a function.
fn name(job: &mut Job, depth: u32) -> Result<Value, Fault> {
    let at = job.scan.at();
    let run = job.scan.run(|b| b.is_ascii_alphanumeric() || b == b'_');
    let upper = run.to_ascii_uppercase();
    if upper.is_empty() {
        let what = "a number, an R parameter or a variable";
        return wrong(at, Wrong::Expected { what });
    }
    match upper.as_str() {
        "TRUE" => return Ok(Value::Truth(true)),
        "FALSE" => return Ok(Value::Truth(false)),
        "PI" => return Ok(Value::Number(std::f64::consts::PI)),
        _ => {}
    }
    if let Some(digits) = upper.strip_prefix('R')
        && digits.bytes().all(|b| b.is_ascii_digit())
        && (!digits.is_empty() || job.scan.blanks().peek() == Some(b'['))
    {
        job.scan.back(at + 1);
        let number = assign::r_number(job, depth)?;
        return assign::r_value(job, number, at).map(Value::Number);
    }
    if job.scan.blanks().peek() == Some(b'(') {
        return function(job, &upper, at, depth);
    }
    assign::variable(job, &upper, at)
}

fn function(job: &mut Job, name: &str, at: u32, depth: u32) -> Result<Value, Fault> {
    let arguments = match name {
        "SIN" | "COS" | "TAN" | "ASIN" | "ACOS" | "SQRT" | "ABS" | "POT" | "TRUNC" | "ROUND"
        | "ROUNDUP" | "LN" | "EXP" => 1,
        "ATAN2" | "MINVAL" | "MAXVAL" => 2,
        "BOUND" => 3,
        _ => {
            let name = Name::of(name);
            return wrong(at, Wrong::Undefined { name });
        }
    };
    job.scan.take(b'(');
    let mut v = [0.0; 3];
    for (i, slot) in v.iter_mut().take(arguments).enumerate() {
        if i > 0 && !job.scan.blanks().take(b',') {
            let what = "a comma and the function's next argument";
            return wrong(job.scan.at(), Wrong::Expected { what });
        }
        let place = job.scan.blanks().at();
        *slot = as_number(comparison(job, depth + 1)?, name, place)?;
    }
    close(job)?;
    let [a, b, c] = v;
    let value = match name {
        "SIN" => a.to_radians().sin(),
        "COS" => a.to_radians().cos(),
        "TAN" => a.to_radians().tan(),
        "ASIN" => a.asin().to_degrees(),
        "ACOS" => a.acos().to_degrees(),
        "ATAN2" => a.atan2(b).to_degrees(),
        "SQRT" => a.sqrt(),
        "ABS" => a.abs(),
        // The square, not a power.
        "POT" => a * a,
        "TRUNC" => a.trunc(),
        "ROUND" => a.round(),
        "ROUNDUP" => a.ceil(),
        "LN" => a.ln(),
        "EXP" => a.exp(),
        "MINVAL" => a.min(b),
        "MAXVAL" => a.max(b),
        // The value between a least and a greatest one.
        _ => {
            if a > b {
                return range(at, name, "a least value, a greatest one, and the value");
            }
            c.clamp(a, b)
        }
    };
    finite(value, name, at)
}
