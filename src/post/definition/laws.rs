//! What a program cannot do without, whatever its dialect.

use super::file::{File, Lines};
use super::format::Spelling;
use super::{Post, Template};
use crate::machine::data::Reader;
use crate::post::template::Slot;

/// True when every line could be read: of one that could not the reader has complained already, and what it lacks means nothing.
fn whole(read: &[Template], written: &Lines) -> bool {
    read.len() == written.get_ref().len()
}

/// Notes a complaint for each law that a post breaks.
pub(super) fn check(post: &Post, f: &File, r: &mut Reader<'_>) {
    let p = &f.program;
    let lines = |l: &Lines| match l.get_ref().as_slice() {
        [] => "[]".to_string(),
        _ => "[...]".to_string(),
    };
    let once = |all: &[Template], slots: &[Slot]| {
        all.iter()
            .filter(|t| slots.iter().any(|s| t.has(*s)))
            .count()
            == 1
    };
    let start = whole(&post.program.start, &p.start);
    if start && !once(&post.program.start, &[Slot::Units]) {
        let problem = "must have {units} once: without it the machine reads the numbers in whatever it was left in";
        r.complain("start", &p.start, lines(&p.start), problem);
    }
    if post.unit_word(post.units).is_none() {
        let problem = "must have its word in unit_words";
        r.complain(
            "units",
            &f.units,
            format!("\"{}\"", f.units.get_ref()),
            problem,
        );
    }
    if start && post.spelling == Spelling::Words && !has_word(&post.program.start, 'G', 90.0) {
        let problem = "must have G90: the writer's coordinates are absolute";
        r.complain("start", &p.start, lines(&p.start), problem);
    }
    let turns = has_word(&post.spindle.cw, 'M', 3.0) && once(&post.spindle.cw, &[Slot::Speed]);
    if whole(&post.spindle.cw, &f.spindle.cw) && !turns {
        let problem = "must start the spindle clockwise at its speed, M3 S{speed}";
        r.complain("cw", &f.spindle.cw, lines(&f.spindle.cw), problem);
    }
    if let Some(ccw) = &f.spindle.ccw
        && whole(&post.spindle.ccw, ccw)
        && !(has_word(&post.spindle.ccw, 'M', 4.0) && once(&post.spindle.ccw, &[Slot::Speed]))
    {
        let problem = "must start the spindle counter-clockwise at its speed, M4 S{speed}";
        r.complain("ccw", ccw, lines(ccw), problem);
    }
    check_off(post, f, r);
    check_end(post, f, r);
    if let Some(dwell) = &f.dwell
        && whole(&post.dwell, dwell)
        && !once(&post.dwell, &[Slot::Seconds, Slot::Milliseconds])
    {
        let problem = "must have {seconds} or {milliseconds} once";
        r.complain("dwell", dwell, lines(dwell), problem);
    }
    if let Some(machine) = f.rapid.as_ref().and_then(|t| t.machine.as_ref())
        && whole(&post.machine_rapid, machine)
        && !once(&post.machine_rapid, &[Slot::Axes])
    {
        let problem = "must have {axes} once";
        r.complain("machine", machine, lines(machine), problem);
    }
    for z in [
        f.tool.as_ref().and_then(|t| t.retract_z_mm.as_ref()),
        p.retract_z_mm.as_ref(),
    ]
    .into_iter()
    .flatten()
    {
        let none = f.rapid.as_ref().is_none_or(|t| t.machine.is_none());
        if none {
            let problem = "needs [rapid] machine, the line of a rapid in machine coordinates";
            r.complain("retract_z_mm", z, z.get_ref().to_string(), problem);
        }
    }
    if let Some(tool) = &f.tool
        && !tool.change.get_ref().is_empty()
        && whole(&post.tool.change, &tool.change)
        && !once(&post.tool.change, &[Slot::Tool])
    {
        let problem = "must have {tool} once, or be [] where there is no tool change";
        r.complain("change", &tool.change, lines(&tool.change), problem);
    }
    if let Some(further) = f.work_offsets.as_ref().and_then(|t| t.further.as_ref())
        && post
            .work_offsets
            .further
            .as_ref()
            .is_some_and(|t| !t.has(Slot::Offset))
    {
        let problem = "must have {offset}";
        r.complain(
            "further",
            further,
            format!("\"{}\"", further.get_ref()),
            problem,
        );
    }
    let [least, most] = post.program.number;
    if let Some(v) = &p.highest_number
        && least > most
    {
        r.complain(
            "highest_number",
            v,
            most.to_string(),
            "must not be below lowest_number",
        );
    }
}

/// The last lines switch everything off: the writer relies on it.
fn check_off(post: &Post, f: &File, r: &mut Reader<'_>) {
    let p = &f.program;
    if whole(&post.spindle.off, &f.spindle.off) && !has_word(&post.spindle.off, 'M', 5.0) {
        let problem = "must stop the spindle, M5";
        r.complain("off", &f.spindle.off, "[...]".into(), problem);
    }
    if let Some(coolant) = &f.coolant
        && coolant.off.get_ref().is_empty()
    {
        r.complain(
            "off",
            &coolant.off,
            "[]".into(),
            "must switch the coolant off, usually M9",
        );
    }
    for (what, off) in [
        ("spindle", &post.spindle.off),
        ("coolant", &post.coolant.off),
    ] {
        let missing = off
            .iter()
            .flat_map(Template::words)
            .find(|(letter, number)| {
                number
                    .parse()
                    .is_ok_and(|n| !has_word(&post.program.end, *letter, n))
            });
        if let (Some((letter, number)), true) = (missing, whole(&post.program.end, &p.end)) {
            let problem = format!(
                "must have {letter}{number}, to switch the {what} off, as [{what}] off has it"
            );
            r.complain("end", &p.end, "[...]".into(), problem);
        }
    }
}

/// The word that ends the program stands in the last lines and nowhere else.
fn check_end(post: &Post, f: &File, r: &mut Reader<'_>) {
    let p = &f.program;
    let known = ["M2", "M30", "END PGM", ""];
    let end = r.word("ends_with", &p.ends_with, &known);
    let says = |t: &Template| {
        let text = t
            .pieces
            .iter()
            .any(|p| matches!(p, crate::post::template::Piece::Text(t) if t.contains("END PGM")));
        text || has_word(std::slice::from_ref(t), 'M', 2.0)
            || has_word(std::slice::from_ref(t), 'M', 30.0)
    };
    let number = end.strip_prefix('M').and_then(|n| n.parse().ok());
    let there = match number {
        Some(n) => has_word(&post.program.end, 'M', n),
        None => end.is_empty() || post.program.end.iter().any(says),
    };
    if !there && whole(&post.program.end, &p.end) {
        let problem = format!("must have {end}, to end the program, as ends_with says");
        r.complain("end", &p.end, "[...]".into(), problem);
    }
    let coolant = f.coolant.as_ref();
    let early = [
        ("first", &post.program.first, p.first.as_ref()),
        ("start", &post.program.start, Some(&p.start)),
        ("cw", &post.spindle.cw, Some(&f.spindle.cw)),
        ("ccw", &post.spindle.ccw, f.spindle.ccw.as_ref()),
        ("off", &post.spindle.off, Some(&f.spindle.off)),
        (
            "flood",
            &post.coolant.flood,
            coolant.and_then(|c| c.flood.as_ref()),
        ),
        (
            "mist",
            &post.coolant.mist,
            coolant.and_then(|c| c.mist.as_ref()),
        ),
        (
            "both",
            &post.coolant.both,
            coolant.and_then(|c| c.both.as_ref()),
        ),
        ("off", &post.coolant.off, coolant.map(|c| &c.off)),
        (
            "change",
            &post.tool.change,
            f.tool.as_ref().map(|t| &t.change),
        ),
        ("dwell", &post.dwell, f.dwell.as_ref()),
        ("pause", &post.pause, f.pause.as_ref()),
        (
            "optional_pause",
            &post.optional_pause,
            f.optional_pause.as_ref(),
        ),
        (
            "machine",
            &post.machine_rapid,
            f.rapid.as_ref().and_then(|t| t.machine.as_ref()),
        ),
    ];
    for (key, read, written) in early {
        let Some(written) = written.filter(|w| whole(read, w)) else {
            continue;
        };
        for (line, text) in read.iter().zip(written.get_ref()) {
            if says(line) {
                let problem = "M2 and M30 belong to the last lines, [program] end: here they would end the program before it cuts";
                r.complain(key, text, format!("\"{}\"", text.get_ref()), problem);
            }
        }
    }
}

fn has_word(lines: &[Template], letter: char, number: f64) -> bool {
    lines
        .iter()
        .flat_map(Template::words)
        .any(|(l, n)| l == letter && n.parse() == Ok(number))
}
