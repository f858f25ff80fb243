//! Spoils an input: bytes, words, numbers and lines, and what a format's dictionary holds.

use super::random::Random;
use std::ops::Range;

/// Inputs do not grow beyond this by mutation.
const LONGEST: usize = 1 << 16;
/// ... but once in a while one line is as long as this.
const VERY_LONG: usize = 1 << 20;

/// Numbers that break things.
const NUMBERS: [&str; 34] = [
    "0",
    "-0",
    "1",
    "-1",
    "+1",
    "0.0001",
    ".5",
    "5.",
    ".",
    "-",
    "1e9",
    "1e308",
    "1e400",
    "-1e400",
    "1e-400",
    "nan",
    "inf",
    "-inf",
    "NaN",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551616",
    "99999999999999999999999999999999999999999",
    "0.00000000000000000000000000000000000000001",
    "1,5",
];

/// Bytes that break things: ends of lines, a NUL, a byte order mark, Latin-1, half a character, other spaces.
const ODD: [&[u8]; 14] = [
    b"\r\n",
    b"\r",
    b"\n\n",
    b"\0",
    b"\xef\xbb\xbf",
    b"\xfc",
    b"\xc3",
    b"\xf0\x9f",
    b"\t",
    b"\x0b",
    b"\x1a",
    b"\xe2\x80\xa8",
    b"\xff\xfe",
    b" \\\n",
];

/// A spoilt input: one of `seeds`, changed from once to a dozen times, sometimes with parts of another. `words` is the dictionary.
pub fn spoilt(random: &mut Random, seeds: &[Vec<u8>], words: &[&str]) -> Vec<u8> {
    let mut out = random.pick(seeds).cloned().unwrap_or_default();
    let other = random.pick(seeds).cloned().unwrap_or_default();
    let times = if random.once_in(3) {
        1
    } else {
        1 + random.below(12)
    };
    for _ in 0..times {
        once(random, &mut out, &other, words);
        out.truncate(LONGEST);
    }
    if random.once_in(2000) {
        stretch(random, &mut out, words);
    }
    out
}

fn once(random: &mut Random, out: &mut Vec<u8>, other: &[u8], words: &[&str]) {
    match random.below(18) {
        0 => {
            let at = random.below(out.len());
            if let Some(b) = out.get_mut(at) {
                *b ^= 1 << random.below(8);
            }
        }
        1 => {
            let at = random.below(out.len());
            if let Some(b) = out.get_mut(at) {
                *b = random.next() as u8;
            }
        }
        2 => out.truncate(random.below(out.len() + 1)),
        3 => {
            let span = short_span(random, out.len());
            out.drain(span);
        }
        4 => repeat(random, out),
        5 => {
            let span = line(random, out);
            let new = other.get(line(random, other)).unwrap_or_default().to_vec();
            out.splice(span, new);
        }
        6 => {
            let (a, b) = (line(random, out), line(random, out));
            swap(out, a, b);
        }
        7 => {
            let text = out.get(line(random, out)).unwrap_or_default().to_vec();
            let at = line(random, out).start;
            insert(out, at, &text);
        }
        8 => {
            let span = line(random, out);
            out.drain(span);
        }
        9 => {
            let (a, b) = (word(random, out), word(random, out));
            swap(out, a, b);
        }
        10 => {
            let span = word(random, out);
            let new = other.get(word(random, other)).unwrap_or_default().to_vec();
            out.splice(span, new);
        }
        11 | 12 => {
            let span = number(random, out);
            let new = random.pick(&NUMBERS).copied().unwrap_or_default();
            out.splice(span, new.bytes());
        }
        13 | 14 => {
            let at = random.below(out.len() + 1);
            let new = random.pick(words).copied().unwrap_or_default();
            insert(out, at, new.as_bytes());
        }
        15 => {
            let at = random.below(out.len() + 1);
            let new = random.pick(&ODD).copied().unwrap_or_default();
            insert(out, at, new);
        }
        16 => {
            let from = random.below(other.len() + 1);
            out.truncate(random.below(out.len() + 1));
            out.extend_from_slice(other.get(from..).unwrap_or_default());
        }
        _ => binary_number(random, out),
    }
}

/// Writes four bytes that mean something extreme, mostly where a 32-bit number begins in a binary STL.
fn binary_number(random: &mut Random, out: &mut [u8]) {
    let value: [u8; 4] = match random.below(8) {
        0 => 0u32.to_le_bytes(),
        1 => u32::MAX.to_le_bytes(),
        2 => (1u32 << random.below(32)).to_le_bytes(),
        3 => f32::NAN.to_le_bytes(),
        4 => f32::INFINITY.to_le_bytes(),
        5 => f32::MAX.to_le_bytes(),
        6 => f32::MIN_POSITIVE.to_le_bytes(),
        _ => (random.next() as u32).to_le_bytes(),
    };
    let at = match random.below(3) {
        0 => 80,
        1 => 84 + 50 * random.below(out.len() / 50 + 1) + 4 * random.below(12),
        _ => random.below(out.len()),
    };
    if let Some(place) = out.get_mut(at..at + 4) {
        place.copy_from_slice(&value);
    }
}

/// Repeats a piece up to 64 times.
fn repeat(random: &mut Random, out: &mut Vec<u8>) {
    let span = if random.once_in(2) {
        short_span(random, out.len())
    } else {
        word(random, out)
    };
    let piece = out.get(span.clone()).unwrap_or_default().to_vec();
    let new = piece.repeat(1 + random.below(64));
    insert(out, span.end, &new);
}

/// Makes one line, or one nesting, enormous.
fn stretch(random: &mut Random, out: &mut Vec<u8>, words: &[&str]) {
    let piece: Vec<u8> = match random.below(3) {
        0 => out.get(word(random, out)).unwrap_or_default().to_vec(),
        1 => random.pick(words).copied().unwrap_or_default().into(),
        _ => vec![*random.pick(b"[({9-+ \"#;a").unwrap_or(&b'0')],
    };
    let times = VERY_LONG / piece.len().max(16);
    let at = random.below(out.len() + 1);
    insert(out, at, &piece.repeat(times));
}

fn insert(out: &mut Vec<u8>, at: usize, new: &[u8]) {
    let at = at.min(out.len());
    out.splice(at..at, new.iter().copied());
}

/// Swaps two pieces that do not overlap.
fn swap(out: &mut Vec<u8>, a: Range<usize>, b: Range<usize>) {
    let (first, second) = if a.start <= b.start { (a, b) } else { (b, a) };
    if first.end > second.start {
        return;
    }
    let one = out.get(first.clone()).unwrap_or_default().to_vec();
    let two = out.get(second.clone()).unwrap_or_default().to_vec();
    out.splice(second, one);
    out.splice(first, two);
}

fn short_span(random: &mut Random, length: usize) -> Range<usize> {
    let start = random.below(length + 1);
    let most = if random.once_in(4) { length } else { 16 };
    start..(start + random.below(most + 1)).min(length)
}

/// The bytes round a random place that satisfy `belongs`.
fn run(random: &mut Random, text: &[u8], belongs: impl Fn(u8) -> bool) -> Range<usize> {
    let from = random.below(text.len());
    let after = text.get(from..).unwrap_or_default();
    let Some(skip) = after.iter().position(|b| belongs(*b)) else {
        return text.len()..text.len();
    };
    let at = from + skip;
    let before = text.get(..at).unwrap_or_default();
    let start = before
        .iter()
        .rposition(|b| !belongs(*b))
        .map_or(0, |i| i + 1);
    let rest = text.get(at..).unwrap_or_default();
    let end = rest
        .iter()
        .position(|b| !belongs(*b))
        .map_or(text.len(), |i| at + i);
    start..end
}

/// A line with its end.
fn line(random: &mut Random, text: &[u8]) -> Range<usize> {
    let span = run(random, text, |b| b != b'\n');
    span.start..(span.end + 1).min(text.len())
}

fn word(random: &mut Random, text: &[u8]) -> Range<usize> {
    run(random, text, |b| {
        b.is_ascii_alphanumeric() || b"._-+".contains(&b)
    })
}

fn number(random: &mut Random, text: &[u8]) -> Range<usize> {
    run(random, text, |b| b.is_ascii_digit() || b".-+".contains(&b))
}
