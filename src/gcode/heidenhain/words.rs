//! The words of a positioning block: coordinates, radius, direction, compensation, feed, M functions.
//!
//! Crosses the border: the rest of a block in; [`Words`] in the program's own units out.

use super::*;

/// The most M functions that a block may hold here (iTNC 530: four).
const MOST_FUNCTIONS: usize = 4;

/// A coordinate as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinate {
    pub value: f64,
    pub incremental: bool,
}

/// What F says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Feed {
    /// `F500`.
    Programmed(f64),
    /// `FMAX`, for this block.
    Max,
    /// `F AUTO`: what TOOL CALL said.
    Auto,
}

/// A positioning block's words. Places are byte offsets.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Words {
    /// X, Y, Z.
    pub axes: [Option<Coordinate>; 3],
    /// PR or IPR.
    pub polar_radius: Option<Coordinate>,
    /// PA or IPA.
    pub polar_angle: Option<Coordinate>,
    /// The R of CR, with its sign.
    pub radius: Option<f64>,
    /// DR-.
    pub clockwise: Option<bool>,
    pub feed: Option<Feed>,
    /// Where F stands.
    pub feed_at: u32,
    /// M functions, as they stand.
    pub functions: Vec<(u32, u32)>,
    /// Where the first coordinate stands.
    pub first_at: u32,
}

impl Words {
    /// A coordinate stands in the block.
    pub fn moves(&self) -> bool {
        self.axes.iter().any(Option::is_some)
    }
}

/// A sign, if there is one: true for minus.
fn sign(scan: &mut Scan) -> bool {
    scan.blanks();
    let minus = scan.take(b'-');
    if !minus {
        scan.take(b'+');
    }
    minus
}

/// A number or a Q parameter with its sign, behind a word.
pub(super) fn value(job: &mut Job, word: &str) -> Result<f64, Fault> {
    let minus = sign(&mut job.scan);
    let at = job.scan.blanks().at();
    let value = match job.scan.peek() {
        Some(b'Q' | b'q') => parameter::read(job)?,
        _ => match job.scan.number(true) {
            Some(value) => value,
            None => {
                let name = Name::of(word);
                return wrong(at, Wrong::NumberMissing { name });
            }
        },
    };
    Ok(if minus { -value } else { value })
}

/// A whole number from `least` to `most`, or a Q parameter that has such a value.
pub(super) fn whole(
    job: &mut Job,
    word: &str,
    most: u32,
    range: &'static str,
) -> Result<u32, Fault> {
    let at = job.scan.blanks().at();
    let v = value(job, word)?;
    if v.fract() != 0.0 || v < 0.0 || v > f64::from(most) {
        let name = Name::of(word);
        return wrong(at, Wrong::Range { name, range });
    }
    Ok(v as u32)
}

/// A word's letters: they end before a Q parameter (`FQ1`, `XQ2`).
fn letters<'a>(scan: &mut Scan<'a>) -> &'a str {
    let whole = scan.rest().as_bytes();
    let mut length = 0;
    while whole.get(length).is_some_and(u8::is_ascii_alphabetic) {
        let parameter = matches!(whole.get(length), Some(b'Q' | b'q'))
            && whole.get(length + 1).is_some_and(u8::is_ascii_digit);
        if parameter && length > 0 {
            break;
        }
        length += 1;
    }
    let word = scan.rest().get(..length).unwrap_or_default();
    scan.skip(length);
    word
}

/// The rest of a positioning block. `radius`: R is the radius of CR.
pub(super) fn read(job: &mut Job, radius: bool) -> Result<Words, Fault> {
    let mut words = Words::default();
    let mut compensation = false;
    loop {
        let at = job.scan.blanks().at();
        if matches!(job.scan.peek(), None | Some(b';')) {
            return Ok(words);
        }
        let word = letters(&mut job.scan).to_ascii_uppercase();
        let again = || {
            let name = Name::of(&word);
            wrong(at, Wrong::Repeated { name })
        };
        match word.as_str() {
            "X" | "Y" | "Z" | "IX" | "IY" | "IZ" => {
                let incremental = word.len() == 2;
                let axis = match word.as_bytes().last() {
                    Some(b'X') => 0,
                    Some(b'Y') => 1,
                    _ => 2,
                };
                if words.axes[axis].is_some() {
                    return again();
                }
                if !words.moves() {
                    words.first_at = at;
                }
                let value = value(job, &word)?;
                words.axes[axis] = Some(Coordinate { value, incremental });
            }
            "PR" | "IPR" | "PA" | "IPA" => {
                let incremental = word.len() == 3;
                let value = value(job, &word)?;
                let slot = match word.ends_with('R') {
                    true => &mut words.polar_radius,
                    false => &mut words.polar_angle,
                };
                if slot.replace(Coordinate { value, incremental }).is_some() {
                    return again();
                }
            }
            "DR" => {
                let clockwise = job.scan.blanks().take(b'-');
                if !clockwise && !job.scan.take(b'+') {
                    let (command, what) = ("DR", "a sign (DR+ or DR-)");
                    return wrong(at, Wrong::Missing { command, what });
                }
                if words.clockwise.replace(clockwise).is_some() {
                    return again();
                }
            }
            "RL" | "RR" => return refuse(at, &word, program_compensation()),
            "R" => {
                let rest = job.scan.rest().as_bytes();
                let zero = rest.first() == Some(&b'0')
                    && !matches!(rest.get(1), Some(b'0'..=b'9' | b'.' | b','));
                if zero {
                    job.scan.skip(1);
                    if std::mem::replace(&mut compensation, true) {
                        return again();
                    }
                } else if radius {
                    let value = value(job, "R")?;
                    if words.radius.replace(value).is_some() {
                        return again();
                    }
                } else if matches!(rest.first(), Some(b'+' | b'-')) {
                    return refuse(at, "R+ and R-", program_compensation());
                } else {
                    job.scan.back(at);
                    return job.not_understood();
                }
            }
            "F" | "FMAX" | "FAUTO" => {
                let feed = feed(job, &word, at)?;
                words.feed_at = at;
                if words.feed.replace(feed).is_some() {
                    let name = Name::of("F");
                    return wrong(at, Wrong::Repeated { name });
                }
            }
            "FU" | "FZ" | "FT" | "FMAXT" => {
                return refuse(
                    at,
                    &word,
                    "write the feed in mm/min (in INCH programs 0.1 inch/min) with F",
                );
            }
            "M" => {
                let m = whole(job, "M", 9999, "a whole number")?;
                miscellany::check(m, at)?;
                if words.functions.iter().any(|f| f.0 == m) {
                    let name = Name::of(&format!("M{m}"));
                    return wrong(at, Wrong::Repeated { name });
                }
                if words.functions.len() == MOST_FUNCTIONS {
                    let (name, range) = (Name::of("M"), "at most four functions in a block");
                    return wrong(at, Wrong::Range { name, range });
                }
                words.functions.push((m, at));
            }
            "A" | "B" | "C" | "IA" | "IB" | "IC" => {
                return refuse(
                    at,
                    &word,
                    "this machine has no rotary axes; post the program for three axes",
                );
            }
            "U" | "V" | "W" | "IU" | "IV" | "IW" => {
                return refuse(
                    at,
                    &word,
                    "this machine has X, Y and Z only; post the program for three axes",
                );
            }
            _ => {
                job.scan.back(at);
                return job.not_understood();
            }
        }
    }
}

/// Why radius compensation is refused.
fn program_compensation() -> &'static str {
    "it moves the path sideways by the tool's radius; post the centre's path with R0"
}

/// F in one of its forms.
fn feed(job: &mut Job, word: &str, at: u32) -> Result<Feed, Fault> {
    match word {
        "FMAX" => return Ok(Feed::Max),
        "FAUTO" => return Ok(Feed::Auto),
        _ => {}
    }
    job.scan.blanks();
    if job.scan.take_text("MAX") {
        return Ok(Feed::Max);
    }
    if job.scan.take_text("AUTO") {
        return Ok(Feed::Auto);
    }
    let value = value(job, "F")?;
    if value <= 0.0 {
        let (name, range) = (Name::of("F"), "a feed above zero");
        return wrong(at, Wrong::Range { name, range });
    }
    Ok(Feed::Programmed(value))
}
