//! Which kind of line it is: header, comment, block with number and label, statement; and the ends of programs.

use super::*;

/// What a line opens with.
struct Front {
    /// The main word behind number and label, upper case; empty when none stands there.
    word: String,
    /// Where it stands.
    at: u32,
    label: Option<String>,
    number: Option<String>,
    skip: bool,
}

/// An identifier: letters, digits, underscores.
fn in_name(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_'
}

/// Past `/`, block number and label; the scan then stands on the statement.
fn front(scan: &mut Scan) -> Front {
    let mut skip = false;
    let mut number = None;
    let mut label = None;
    if scan.blanks().take(b'/') {
        skip = true;
        // Skip level.
        if scan.peek().is_some_and(|b| b.is_ascii_digit()) {
            scan.skip(1);
        }
        scan.blanks();
    }
    let digit = |b: Option<u8>| b.is_some_and(|b| b.is_ascii_digit());
    if matches!(scan.peek(), Some(b'N' | b'n' | b':')) && digit(scan.ahead(1)) {
        let colon = scan.peek() == Some(b':');
        scan.skip(1);
        let digits = scan.run(|b| b.is_ascii_digit());
        number = Some(format!("{}{digits}", if colon { ":" } else { "N" }));
        scan.blanks();
    }
    let mut ahead = scan.clone();
    let name = ahead.run(in_name);
    let letters = |b: u8| b.is_ascii_alphabetic() || b == b'_';
    let named = name.len() >= 2 && name.bytes().take(2).all(letters);
    if named && ahead.blanks().take(b':') {
        label = Some(name.to_ascii_uppercase());
        ahead.blanks();
        *scan = ahead;
    }
    let at = scan.at();
    let word = scan.clone().run(in_name).to_ascii_uppercase();
    Front {
        word,
        at,
        label,
        number,
        skip,
    }
}

/// The label of a line: see [`super::label`].
pub(super) fn label(text: &str) -> Option<Label> {
    let mut scan = Scan::new(text);
    if scan.blanks().peek() == Some(b'%') {
        let name = scan.rest().trim_end();
        let name = name.split([' ', '\t', ';']).next().unwrap_or_default();
        return Some(name.to_ascii_uppercase().into());
    }
    let front = front(&mut scan);
    front.label.or(front.number).map(Into::into)
}

/// Carries out one line.
pub(super) fn line(job: &mut Job) -> Said {
    let at = job.scan.blanks().at();
    match job.scan.peek() {
        None | Some(b';') => return Ok(Flow::Next),
        Some(b'%') => return header(job, at),
        _ => {}
    }
    let front = front(&mut job.scan);
    job.modes.began = true;
    if front.skip && job.desk.state.block_delete {
        return Ok(Flow::Next);
    }
    if job.modes.ifs.skips() {
        if matches!(front.word.as_str(), "IF" | "ELSE" | "ENDIF") {
            job.scan.skip(front.word.len());
        }
        control::passed(job, &front.word);
        return Ok(Flow::Next);
    }
    if front.label.as_deref() == Some("ENDLABEL") {
        return refuse(at, "ENDLABEL", "write the section as a subprogram");
    }
    if matches!(job.scan.peek(), None | Some(b';')) {
        return Ok(Flow::Next);
    }
    match statement(job, &front.word, front.at)? {
        Some(flow) => Ok(flow),
        None => block::block(job),
    }
}

/// Statements that stand in a block of their own. `None`: it is a block of words.
fn statement(job: &mut Job, word: &str, at: u32) -> Result<Option<Flow>, Fault> {
    let start = job.scan.at();
    job.scan.skip(word.len());
    let flow = match word {
        "IF" => control::if_(job, at)?,
        "ELSE" => control::else_(job, at)?,
        "ENDIF" => control::endif(job, at)?,
        "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" | "GOTOS" => {
            let flow = control::goto(job, word, at)?;
            job.modes.ifs.jump();
            flow
        }
        "REPEAT" => control::repeat(job, at)?,
        "WHILE" | "ENDWHILE" | "FOR" | "ENDFOR" | "LOOP" | "ENDLOOP" | "UNTIL" => {
            return refuse(at, word, control::LOOPS);
        }
        "CASE" | "REPEATB" => {
            return refuse(at, word, "write IF with GOTOF, or a subprogram");
        }
        "DEF" => {
            assign::define(job, at)?;
            Flow::Next
        }
        "PROC" => {
            procedure(job, at)?;
            Flow::Next
        }
        "RET" => {
            job.end_of_block()?;
            returned(job)
        }
        "MSG" => {
            message(job, at)?;
            // The control takes other words behind it, too.
            match job.scan.blanks().peek() {
                None | Some(b';') => Flow::Next,
                _ => return Ok(None),
            }
        }
        "WORKPIECE" | "GROUP_BEGIN" | "GROUP_END" => {
            arguments_past(job, at, word)?;
            job.end_of_block()?;
            Flow::Next
        }
        // Swivelling is switched off, and never was on.
        "CYCLE800" if job.scan.clone().blanks().take_text("()") => {
            job.scan.blanks().skip(2);
            job.end_of_block()?;
            Flow::Next
        }
        "TRANS" | "ATRANS" | "ROT" | "AROT" | "SCALE" | "ASCALE" | "MIRROR" | "AMIRROR" => {
            frame::programmable(job, word, at)?;
            Flow::Next
        }
        "MCALL" => {
            cycle::modal(job, at)?;
            Flow::Next
        }
        "CYCLE81" | "CYCLE82" => {
            let drilling = cycle::read(job, word, at)?;
            job.end_of_block()?;
            cycle::run(job, &drilling, at)?;
            Flow::Next
        }
        "CYCLE832" => {
            cycle::high_speed(job, at)?;
            job.end_of_block()?;
            Flow::Next
        }
        _ if subprogram_number(word) => control::call(job, word)?,
        _ if stands_alone(job) && keyword::is_name(word) => control::call(job, word)?,
        _ => {
            job.scan.back(start);
            return Ok(None);
        }
    };
    Ok(Some(flow))
}

/// `L10`: a subprogram by its number.
fn subprogram_number(word: &str) -> bool {
    let digits = word.strip_prefix('L').unwrap_or_default();
    !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
}

/// Nothing but a count of repetitions follows.
fn stands_alone(job: &Job) -> bool {
    let mut ahead = job.scan.clone();
    match ahead.blanks().peek() {
        None | Some(b';') => true,
        Some(b'P' | b'p') => matches!(ahead.ahead(1), Some(b'0'..=b'9' | b'=' | b' ')),
        _ => false,
    }
}

/// `%_N_NAME_MPF`. The first opens the file; a later one ends the program before it.
fn header(job: &mut Job, at: u32) -> Said {
    let name = job.scan.rest().trim_end().to_ascii_uppercase();
    let sub = name.ends_with("_SPF");
    if !(name.starts_with("%_N_") && (sub || name.ends_with("_MPF"))) {
        // A lone % opens or closes a transfer.
        if name == "%" {
            return Ok(Flow::Next);
        }
        return job.not_understood();
    }
    if job.modes.ifs.skips() {
        let line = job.modes.ifs.since();
        return wrong(at, Wrong::IfOpen { line });
    }
    if !std::mem::replace(&mut job.modes.began, true) {
        return if sub {
            wrong(at, Wrong::MainFirst)
        } else {
            Ok(Flow::Next)
        };
    }
    if job.modes.depth > 0 {
        return wrong(at, Wrong::ReturnMissing);
    }
    job.modes.over = true;
    Ok(Flow::End)
}

/// M17 or RET: back to the caller; at the top, the end.
pub(super) fn returned(job: &mut Job) -> Flow {
    job.modes.ifs.jump();
    if job.modes.depth == 0 {
        job.desk.end();
        job.modes.over = true;
        return Flow::End;
    }
    job.modes.depth -= 1;
    Flow::Return
}

/// `PROC NAME`: the first block of a subprogram.
fn procedure(job: &mut Job, at: u32) -> Result<(), Fault> {
    if job.scan.blanks().run(in_name).is_empty() {
        return missing(at, "PROC", "the subprogram's name");
    }
    if job.scan.blanks().take(b'(') && !job.scan.blanks().take(b')') {
        return refuse(at, "PROC with parameters", "use R parameters");
    }
    loop {
        let at = job.scan.blanks().at();
        match job.scan.run(in_name).to_ascii_uppercase().as_str() {
            "" => return job.end_of_block(),
            "DISPLOF" | "DISPLON" | "SBLOF" | "SBLON" => {}
            other => return refuse(at, other, "this reader does not carry it out; remove it"),
        }
    }
}

/// `MSG("text")`: shown to the operator.
pub(super) fn message(job: &mut Job, at: u32) -> Result<(), Fault> {
    if !job.scan.blanks().take(b'(') {
        return missing(at, "MSG", "a text in parentheses and quotation marks");
    }
    if job.scan.blanks().peek() == Some(b'"') && job.scan.quoted().is_none() {
        return missing(job.scan.at(), "MSG", "a closing quotation mark");
    }
    if job.scan.blanks().take(b',') {
        job.scan.blanks().run(|b| b.is_ascii_digit());
    }
    if !job.scan.blanks().take(b')') {
        let what = "one text in quotation marks and a closing parenthesis";
        return wrong(job.scan.at(), Wrong::Expected { what });
    }
    Ok(())
}

/// Arguments that nothing here uses, up to the parenthesis that closes them.
fn arguments_past(job: &mut Job, at: u32, name: &str) -> Result<(), Fault> {
    if !job.scan.blanks().take(b'(') {
        return missing(at, name, "its arguments in parentheses");
    }
    let mut depth = 1u32;
    while depth > 0 {
        match job.scan.peek() {
            Some(b'"') => {
                if job.scan.quoted().is_none() {
                    return missing(job.scan.at(), name, "a closing quotation mark");
                }
                continue;
            }
            Some(b'(') => depth = depth.saturating_add(1),
            Some(b')') => depth -= 1,
            None | Some(b';') => return missing(job.scan.at(), name, "a closing parenthesis"),
            _ => {}
        }
        let length = job.scan.character().map_or(1, char::len_utf8);
        job.scan.skip(length);
    }
    Ok(())
}
