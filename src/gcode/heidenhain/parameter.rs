//! Q parameters: reading them, FN functions, assignments.

use super::*;

/// A Q parameter's number; the scan stands on its Q.
fn number(job: &mut Job) -> Result<u32, Fault> {
    let at = job.scan.at();
    job.scan.take_text("Q");
    if job.scan.peek().is_some_and(|b| b.is_ascii_alphabetic()) {
        return refuse(
            at,
            "QL (or QR, QS)",
            "only Q parameters with a number are read",
        );
    }
    let digits = job.scan.run(|b| b.is_ascii_digit());
    match digits.parse() {
        Ok(number) if number <= 1999 => Ok(number),
        _ => {
            let (name, range) = (Name::of("Q"), "a number from 0 to 1999 right behind it");
            wrong(at, Wrong::Range { name, range })
        }
    }
}

/// The value of the parameter that stands here.
pub(super) fn read(job: &mut Job) -> Result<f64, Fault> {
    let at = job.scan.at();
    let number = number(job)?;
    if (100..200).contains(&number) {
        return refuse(
            at,
            &format!("Q{number}"),
            "the control sets Q100 to Q199, and what it holds is not known",
        );
    }
    job.q(number, at)
}

/// A parameter that is assigned to.
fn target(job: &mut Job) -> Result<u32, Fault> {
    let at = job.scan.blanks().at();
    if !matches!(job.scan.peek(), Some(b'Q' | b'q')) {
        let what = "a Q parameter";
        return wrong(at, Wrong::Expected { what });
    }
    let number = number(job)?;
    if (100..200).contains(&number) {
        return refuse(
            at,
            &format!("Q{number}"),
            "the control sets Q100 to Q199; use another one",
        );
    }
    if !job.scan.blanks().take(b'=') {
        let what = "=";
        return wrong(job.scan.at(), Wrong::Expected { what });
    }
    Ok(number)
}

/// `Q1 = ...`.
pub(super) fn formula(job: &mut Job, at: u32) -> Result<(), Fault> {
    job.scan.back(at);
    let q = target(job)?;
    let value = formula::value(job)?;
    job.end_of_block()?;
    job.set.push((q, value));
    Ok(())
}

/// `FN n: ...`.
pub(super) fn function(job: &mut Job, at: u32) -> Said {
    let n = words::whole(job, "FN", 99, "a whole number")?;
    if !job.scan.blanks().take(b':') {
        let (command, what) = ("FN", "a colon behind its number");
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    if (9..=12).contains(&n) {
        return branch(job, n);
    }
    if !matches!(n, 0..=8 | 13) {
        return refuse(
            at,
            &format!("FN {n}"),
            "it speaks with the control, not with the tool; remove it",
        );
    }
    let q = target(job)?;
    let value = result(job, n)?;
    job.end_of_block()?;
    job.set.push((q, value));
    Ok(Flow::Next)
}

/// What FN 0 to FN 8 and FN 13 compute.
fn result(job: &mut Job, n: u32) -> Result<f64, Fault> {
    let at = job.scan.blanks().at();
    let keyword = |job: &mut Job, word: &'static str| -> Result<(), Fault> {
        if job.scan.blanks().take_text(word) {
            return Ok(());
        }
        wrong(job.scan.at(), Wrong::Expected { what: word })
    };
    match n {
        5 => keyword(job, "SQRT")?,
        6 => keyword(job, "SIN")?,
        7 => keyword(job, "COS")?,
        _ => {}
    }
    let a = words::value(job, "FN")?;
    let (value, what) = match n {
        0 => (a, "FN 0"),
        5 => (a.sqrt(), "SQRT"),
        6 => (a.to_radians().sin(), "SIN"),
        7 => (a.to_radians().cos(), "COS"),
        _ => {
            keyword(
                job,
                match n {
                    1 => "+",
                    2 => "-",
                    3 => "*",
                    4 => "DIV",
                    8 => "LEN",
                    _ => "ANG",
                },
            )?;
            let b = words::value(job, "FN")?;
            match n {
                1 => (a + b, "FN 1"),
                2 => (a - b, "FN 2"),
                3 => (a * b, "FN 3"),
                4 => (a / b, "FN 4 (DIV)"),
                8 => (a.hypot(b), "FN 8 (LEN)"),
                // The angle of a (over) b, 0 to 360 degrees.
                _ => (a.atan2(b).to_degrees().rem_euclid(360.0), "FN 13 (ANG)"),
            }
        }
    };
    formula::sound(value, what, at)
}

/// `FN 9: IF +Q1 EQU +5 GOTO LBL 3`.
fn branch(job: &mut Job, n: u32) -> Said {
    let expect = |job: &mut Job, words: &[&str], what: &'static str| -> Result<(), Fault> {
        job.scan.blanks();
        if words.iter().any(|w| job.scan.take_text(w)) {
            return Ok(());
        }
        wrong(job.scan.at(), Wrong::Expected { what })
    };
    expect(job, &["IF"], "IF")?;
    let a = words::value(job, "IF")?;
    let (name, holds): (&'static str, fn(f64, f64) -> bool) = match n {
        9 => ("EQU", |a, b| a == b),
        10 => ("NE", |a, b| a != b),
        11 => ("GT", |a, b| a > b),
        _ => ("LT", |a, b| a < b),
    };
    expect(job, &[name], name)?;
    let b = words::value(job, name)?;
    expect(job, &["GOTO"], "GOTO LBL")?;
    expect(job, &["LBL"], "GOTO LBL")?;
    let label = jump::target(job, "GOTO LBL")?;
    job.end_of_block()?;
    Ok(match holds(a, b) {
        true => Flow::Goto {
            label,
            forward: None,
        },
        false => Flow::Next,
    })
}
