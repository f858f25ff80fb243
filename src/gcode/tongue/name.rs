//! A short name inside a message, without a place on the heap: complaints stay plain values.

use std::fmt;

/// So many bytes of a name are kept; longer ones are cut.
const LONGEST: usize = 31;

/// A name as messages show it: at most [`LONGEST`] bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name {
    bytes: [u8; LONGEST],
    length: u8,
}

impl Name {
    /// The front of a text, as much of it as fits.
    pub fn of(text: &str) -> Name {
        let mut bytes = [0; LONGEST];
        let mut length = 0;
        for c in text.chars() {
            let end = length + c.len_utf8();
            let Some(room) = bytes.get_mut(length..end) else {
                break;
            };
            c.encode_utf8(room);
            length = end;
        }
        let length = length as u8;
        Name { bytes, length }
    }

    /// The name's text.
    pub fn text(&self) -> &str {
        let bytes = self.bytes.get(..usize::from(self.length));
        std::str::from_utf8(bytes.unwrap_or_default()).unwrap_or_default()
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_between_characters() {
        assert_eq!(Name::of("CYCLE81").text(), "CYCLE81");
        let long = "\u{e4}".repeat(40);
        assert_eq!(Name::of(&long).text(), "\u{e4}".repeat(15));
        assert_eq!(format!("{} {:?}", Name::of("A"), Name::of("")), "A \"\"");
    }
}
