//! One record as one line of text, and back.

use super::record::Stamped;
use std::io::Write as _;

/// Longer lines are not ours: the longest, the first with all settings, has a few thousand bytes.
pub(super) const LONGEST: usize = 64 * 1024;

/// Appends the line of a record. One that cannot be written as JSON (there is none) leaves nothing.
pub(super) fn encode(number: u64, record: &Stamped, into: &mut Vec<u8>) {
    let Ok(json) = serde_json::to_string(record) else {
        return;
    };
    // Writing into memory cannot fail.
    let _ = writeln!(into, "{number} {:08x} {json}", checksum(number, &json));
}

/// Reads a line (without its end): its number and what it says. `None`: not a line that [`encode`] wrote.
pub(super) fn decode(line: &[u8]) -> Option<(u64, Stamped)> {
    let (number, json) = proven(line)?;
    let record: Stamped = serde_json::from_str(json).ok()?;
    Some((number, record))
}

/// Number and JSON of a line whose checksum is right.
fn proven(line: &[u8]) -> Option<(u64, &str)> {
    let text = std::str::from_utf8(line).ok()?;
    let (number, rest) = text.split_once(' ')?;
    let (sum, json) = rest.split_once(' ')?;
    let number: u64 = number.parse().ok()?;
    if sum.len() != 8 || u32::from_str_radix(sum, 16).ok()? != checksum(number, json) {
        return None;
    }
    Some((number, json))
}

/// The version that a first line tells, whatever else stands in it: a later one may tell more, or otherwise.
pub(super) fn format_of(line: &[u8]) -> Option<u32> {
    let (number, json) = proven(line)?;
    let value: serde_json::Value = serde_json::from_str(json).ok()?;
    let begins = number == 0 && value.get("event")?.as_str()? == "begin";
    let format = value.get("format")?.as_u64()?;
    begins.then_some(u32::try_from(format).ok()?)
}

fn checksum(number: u64, json: &str) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(number.to_string().as_bytes());
    sum.update(b" ");
    sum.update(json.as_bytes());
    sum.finalize()
}
