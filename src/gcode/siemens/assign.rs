//! R parameters and variables: reading them, DEF, assignments.

use super::expression::Value;
use super::*;

/// R parameters above this are refused (the control's default is R0 to R99; machines are set up for more).
const LAST_R: u32 = 9999;

/// The number of an R parameter, behind its R: `5` or `[R2+1]`.
pub(super) fn r_number(job: &mut Job, depth: u32) -> Result<u32, Fault> {
    let at = job.scan.blanks().at();
    let value = if job.scan.take(b'[') {
        if depth > 20 {
            return wrong(at, Wrong::TooDeep);
        }
        let value = bracketed(job)?;
        if !job.scan.blanks().take(b']') {
            let what = "a closing bracket";
            return wrong(job.scan.at(), Wrong::Expected { what });
        }
        value
    } else {
        match job.scan.run(|b| b.is_ascii_digit()).parse::<u32>() {
            Ok(number) => f64::from(number),
            Err(_) => -1.0,
        }
    };
    if value.fract() != 0.0 || !(0.0..=f64::from(LAST_R)).contains(&value) {
        return range(at, "R", "a number from 0 to 9999");
    }
    Ok(value as u32)
}

/// What stands in an index: a number or an R parameter, with one operation at most, so that indices do not nest.
fn bracketed(job: &mut Job) -> Result<f64, Fault> {
    let operand = |job: &mut Job| -> Result<f64, Fault> {
        let at = job.scan.blanks().at();
        if job.scan.take_text("R") {
            let digits = job.scan.run(|b| b.is_ascii_digit()).parse::<u32>();
            let Ok(number) = digits else {
                return range(at, "R", "a number from 0 to 9999");
            };
            return r_value(job, number, at);
        }
        match job.scan.number(false) {
            Some(value) => Ok(value),
            None => {
                let what = "a number or an R parameter (indices are read simple)";
                wrong(at, Wrong::Expected { what })
            }
        }
    };
    let a = operand(job)?;
    job.scan.blanks();
    if job.scan.take(b'+') {
        return Ok(a + operand(job)?);
    }
    if job.scan.take(b'-') {
        return Ok(a - operand(job)?);
    }
    Ok(a)
}

/// The value of an R parameter. What an earlier program left in it is not known.
pub(super) fn r_value(job: &Job, number: u32, at: u32) -> Result<f64, Fault> {
    let set = job.set_r.iter().rev().find(|(n, _)| *n == number);
    match set.map(|s| s.1).or_else(|| job.r.get(&number).copied()) {
        Some(value) => Ok(value),
        None => {
            let name = Name::of(&format!("R{number}"));
            wrong(at, Wrong::Unset { name })
        }
    }
}

/// The variable of this name that the running program defined.
fn find(job: &Job, name: &str) -> Option<Variable> {
    let key = (Name::of(name), job.modes.depth);
    let all = job.set.iter().rev().chain(job.variables);
    all.into_iter().find(|v| (v.name, v.depth) == key).copied()
}

/// A variable's value.
pub(super) fn variable(job: &Job, name: &str, at: u32) -> Result<Value, Fault> {
    match find(job, name) {
        Some(v) => Ok(v.value),
        None => {
            let name = Name::of(name);
            wrong(at, Wrong::Undefined { name })
        }
    }
}

/// `R5=...`, behind the equals sign.
pub(super) fn set_r(job: &mut Job, number: u32) -> Result<(), Fault> {
    let value = expression::number(job, "R")?;
    job.set_r.push((number, value));
    Ok(())
}

/// `NAME=...`, behind the equals sign.
pub(super) fn set(job: &mut Job, name: &str, at: u32) -> Result<(), Fault> {
    let Some(old) = find(job, name) else {
        let name = Name::of(name);
        return wrong(at, Wrong::Undefined { name });
    };
    let place = job.scan.blanks().at();
    let value = expression::value(job)?;
    let value = converted(old.kind, value, name, place)?;
    job.set.push(Variable { value, ..old });
    Ok(())
}

/// A value as a variable of this type keeps it: whole numbers are rounded.
fn converted(kind: Kind, value: Value, name: &str, at: u32) -> Result<Value, Fault> {
    match (kind, value) {
        (Kind::Real, Value::Number(_)) | (Kind::Bool, Value::Truth(_)) => Ok(value),
        (Kind::Int, Value::Number(n)) => Ok(Value::Number(n.round())),
        (Kind::Bool, Value::Number(n)) if n == 0.0 || n == 1.0 => Ok(Value::Truth(n == 1.0)),
        (kind, _) => {
            let name = Name::of(name);
            let what = match kind {
                Kind::Bool => "conditions",
                _ => "numbers",
            };
            wrong(at, Wrong::Kind { name, what })
        }
    }
}

/// `DEF REAL A, B=5`.
pub(super) fn define(job: &mut Job, at: u32) -> Result<(), Fault> {
    let kind = job.scan.blanks().run(|b| b.is_ascii_alphabetic());
    let kind = match kind.to_ascii_uppercase().as_str() {
        "REAL" => Kind::Real,
        "INT" => Kind::Int,
        "BOOL" => Kind::Bool,
        "STRING" | "CHAR" | "AXIS" | "FRAME" | "CHAN" | "NCK" | "SYNR" | "SYNW" | "SYNRW" => {
            return refuse(at, "DEF of this type", "REAL, INT and BOOL are read");
        }
        _ => return missing(at, "DEF", "a type (REAL, INT or BOOL)"),
    };
    loop {
        let at = job.scan.blanks().at();
        let name = job.scan.run(|b| b.is_ascii_alphanumeric() || b == b'_');
        let name = name.to_ascii_uppercase();
        let letters = |b: u8| b.is_ascii_alphabetic() || b == b'_';
        let sound = name.len() <= 31 && name.bytes().take(2).filter(|b| letters(*b)).count() == 2;
        if !sound {
            return missing(
                at,
                "DEF",
                "a name that begins with two letters, 31 characters at most",
            );
        }
        if job.scan.blanks().peek() == Some(b'[') {
            return refuse(at, "an array", "define single variables");
        }
        let value = if job.scan.take(b'=') {
            let place = job.scan.blanks().at();
            let value = expression::value(job)?;
            converted(kind, value, &name, place)?
        } else if kind == Kind::Bool {
            Value::Truth(false)
        } else {
            Value::Number(0.0)
        };
        job.set.push(Variable {
            name: Name::of(&name),
            kind,
            value,
            depth: job.modes.depth,
        });
        if !job.scan.blanks().take(b',') {
            return job.end_of_block();
        }
    }
}
