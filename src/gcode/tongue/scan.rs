//! A line read from left to right. Offsets are bytes from the line's front.

/// Numbers above this are taken for mistakes: no axis, feed or counter reaches it.
pub(in crate::gcode) const LARGEST: f64 = 1e9;

/// Where reading stands in a line.
#[derive(Clone, Debug)]
pub(in crate::gcode) struct Scan<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Scan<'a> {
    /// At the front of a line.
    pub fn new(text: &'a str) -> Scan<'a> {
        Scan { text, at: 0 }
    }

    /// Bytes read.
    pub fn at(&self) -> u32 {
        u32::try_from(self.at).unwrap_or(u32::MAX)
    }

    /// What is left.
    pub fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// The whole line.
    pub fn whole(&self) -> &'a str {
        self.text
    }

    /// Past so many bytes, which must end between characters.
    pub fn skip(&mut self, bytes: usize) {
        if self.text.is_char_boundary(self.at + bytes) {
            self.at += bytes;
        }
    }

    /// Back to an offset read before.
    pub fn back(&mut self, at: u32) {
        self.at = at as usize;
    }

    /// The byte here.
    pub fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// The byte so many places on.
    pub fn ahead(&self, places: usize) -> Option<u8> {
        self.text.as_bytes().get(self.at + places).copied()
    }

    /// The character here, for messages.
    pub fn character(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Past blanks and tabs.
    pub fn blanks(&mut self) -> &mut Scan<'a> {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        self
    }

    /// Past this ASCII byte, if it stands here.
    pub fn take(&mut self, byte: u8) -> bool {
        let here = self.peek() == Some(byte);
        self.at += usize::from(here);
        here
    }

    /// Past this ASCII text (upper case), in whatever case it stands here.
    pub fn take_text(&mut self, upper: &str) -> bool {
        let here = self.text.as_bytes().get(self.at..self.at + upper.len());
        let same = here.is_some_and(|h| h.eq_ignore_ascii_case(upper.as_bytes()));
        if same {
            self.at += upper.len();
        }
        same
    }

    /// The bytes here for which something holds, which must hold for ASCII only.
    pub fn run(&mut self, holds: impl Fn(u8) -> bool) -> &'a str {
        let from = self.at;
        while self.peek().is_some_and(|b| b.is_ascii() && holds(b)) {
            self.at += 1;
        }
        self.text.get(from..self.at).unwrap_or_default()
    }

    /// To the line's end.
    pub fn finish(&mut self) {
        self.at = self.text.len();
    }

    /// A text in double quotes; `None` (and nothing read) when there is none or it is not closed.
    pub fn quoted(&mut self) -> Option<&'a str> {
        let inner = self.rest().strip_prefix('"')?;
        let length = inner.find('"')?;
        self.at += length + 2;
        inner.get(..length)
    }

    /// Digits with at most one decimal point (or comma, where the language writes one), no sign. `None`, and nothing read, when no
    /// digit stands here or the number is above [`LARGEST`].
    pub fn number(&mut self, comma: bool) -> Option<f64> {
        let from = self.at;
        let (mut digits, mut point) = (0usize, None);
        while let Some(b) = self.peek() {
            match b {
                b'0'..=b'9' => digits += 1,
                b'.' if point.is_none() => point = Some(self.at),
                b',' if comma && point.is_none() => point = Some(self.at),
                _ => break,
            }
            self.at += 1;
        }
        let text = self.text.get(from..self.at).unwrap_or_default();
        let value = match point {
            _ if digits == 0 => None,
            Some(p) if self.text.as_bytes().get(p) == Some(&b',') => {
                text.replace(',', ".").parse::<f64>().ok()
            }
            _ => text.parse::<f64>().ok(),
        };
        let value = value.filter(|v| *v <= LARGEST);
        if value.is_none() {
            self.at = from;
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_point_or_comma() {
        let number = |text: &str, comma| {
            let mut s = Scan::new(text);
            let value = s.number(comma);
            (value, s.rest().len())
        };
        assert_eq!(number("10.5X", false), (Some(10.5), 1));
        assert_eq!(number("10,5X", true), (Some(10.5), 1));
        assert_eq!(number("10,5", false), (Some(10.0), 2));
        assert_eq!(number(".5", false), (Some(0.5), 0));
        assert_eq!(number("5.", false), (Some(5.0), 0));
        assert_eq!(number("1.2.3", false), (Some(1.2), 2));
        assert_eq!(number(".", false), (None, 1));
        assert_eq!(number(&"9".repeat(400), false), (None, 400));
    }

    #[test]
    fn texts_in_quotes() {
        let mut s = Scan::new("\"a;b\" x");
        assert_eq!((s.quoted(), s.rest()), (Some("a;b"), " x"));
        assert_eq!(Scan::new("\"open").quoted(), None);
    }
}
