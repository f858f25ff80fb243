//! STL, binary and ASCII: bytes in, a triangle soup in the file's own units out.
//!
//! The two kinds are told apart by size, never by the word "solid": many programs start a *binary* header with it.
//!
//! ```text
//! binary   80 bytes header | u32 n | n x (12 bytes normal, 3 x 12 bytes corners, 2 bytes attribute), little endian
//! ASCII    solid NAME / facet normal i j k / outer loop / 3 x vertex x y z / endloop / endfacet / ... / endsolid NAME
//! ```
//!
//! Stored normals are ignored: they are often wrong, and the winding says the same. Knows nothing of files, units or frames.

use crate::geom::Point;

/// Triangles read from an STL file, in the file's own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct StlRead {
    /// Corners as they came.
    pub triangles: Vec<[Point; 3]>,
    /// True for the binary kind.
    pub binary: bool,
    /// What was tolerated, for the user to read.
    pub warnings: Vec<String>,
}

/// Why bytes are not a usable STL. The display says what and what to do; [`StlError::place`] says where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StlError {
    /// Fewer facets than the header promises.
    #[error(
        "truncated STL: the header promises {promised} triangles ({needed} bytes) but the file has {length} bytes, \
         room for {present}: copy or export it again"
    )]
    Truncated {
        /// Triangle count in the header.
        promised: u32,
        /// Bytes such a file would have.
        needed: u64,
        /// Bytes it has.
        length: u64,
        /// Whole facets in those bytes.
        present: u64,
    },
    /// A header of zero triangles followed by data.
    #[error(
        "the STL header promises 0 triangles but {0} bytes follow it: the program that wrote it was interrupted; export it again"
    )]
    ZeroCount(u64),
    /// Neither kind.
    #[error(
        "not an STL file: neither binary (its {0} bytes do not fit the count in the header) nor text that begins with \"solid\""
    )]
    NotStl(u64),
    /// UTF-16 text.
    #[error("this STL is text in UTF-16: save it as plain ASCII, or as binary STL")]
    Utf16,
    /// ASCII: the text ends too early.
    #[error("truncated STL: the text ends {0}: copy or export it again")]
    Ended(&'static str, u64),
    /// ASCII: a word where another belongs.
    #[error("expected \"{expected}\", found \"{found}\"")]
    Word {
        /// The word the format wants here.
        expected: &'static str,
        /// What stands there.
        found: String,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: u64,
    },
    /// ASCII: not a number.
    #[error(
        "\"{found}\" is not a number: a corner is written \"vertex x y z\", with decimal points"
    )]
    Number {
        /// What stands there.
        found: String,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: u64,
    },
}

impl StlError {
    /// Line and column (from 1) of the complaint, where there is one.
    pub fn place(&self) -> Option<(u64, u64)> {
        match *self {
            StlError::Word { line, column, .. } | StlError::Number { line, column, .. } => {
                Some((line, column))
            }
            StlError::Ended(_, line) => Some((line, 1)),
            _ => None,
        }
    }
}

const HEADER: usize = 84;
const FACET: usize = 50;

/// True when the length is exactly what a binary header at offset 80 promises, for at least one triangle.
pub fn is_exactly_binary(bytes: &[u8]) -> bool {
    promised(bytes).is_some_and(|n| {
        n > 0 && (HEADER as u64) + (FACET as u64) * u64::from(n) == bytes.len() as u64
    })
}

fn promised(bytes: &[u8]) -> Option<u32> {
    let b = bytes.get(80..84)?;
    Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Reads either kind. Coordinates may still be NaN or infinite: [`crate::part::load()`] checks them.
///
/// Cost: linear, about 0.1 s for a million binary facets. Memory is taken for facets that exist, never for promised ones.
pub fn read(bytes: &[u8]) -> Result<StlRead, StlError> {
    let length = bytes.len() as u64;
    let count = promised(bytes);
    if let Some(n) = count {
        let needed = HEADER as u64 + FACET as u64 * u64::from(n);
        if n > 0 && needed <= length {
            return Ok(read_binary(bytes, n, needed));
        }
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(StlError::Utf16);
    }
    // A broken binary file has bytes no text has, nearly always in its count or its first facets. A text has none.
    let looks_binary = bytes
        .iter()
        .take(4096)
        .any(|b| matches!(b, 0..=8 | 14..=31));
    let mut text = Text::new(bytes);
    let starts_solid = text
        .peek()
        .is_some_and(|t| t.eq_ignore_ascii_case(b"solid"));
    match count {
        Some(0) if looks_binary && length > HEADER as u64 => {
            Err(StlError::ZeroCount(length - HEADER as u64))
        }
        Some(0) if looks_binary => Ok(StlRead {
            triangles: Vec::new(),
            binary: true,
            warnings: Vec::new(),
        }),
        Some(n) if looks_binary => Err(StlError::Truncated {
            promised: n,
            needed: HEADER as u64 + FACET as u64 * u64::from(n),
            length,
            present: (length - HEADER as u64) / FACET as u64,
        }),
        _ if starts_solid => read_ascii(text),
        _ => Err(StlError::NotStl(length)),
    }
}

fn read_binary(bytes: &[u8], n: u32, needed: u64) -> StlRead {
    let mut warnings = Vec::new();
    let extra = bytes.len() as u64 - needed;
    if extra > 0 {
        warnings.push(format!(
            "{extra} bytes after the last triangle of the binary STL were ignored"
        ));
    }
    let triangles = bytes[HEADER..]
        .chunks_exact(FACET)
        .take(n as usize)
        .map(|facet| {
            let f = |at: usize| {
                f64::from(f32::from_le_bytes([
                    facet[at],
                    facet[at + 1],
                    facet[at + 2],
                    facet[at + 3],
                ]))
            };
            let corner = |at: usize| Point::new(f(at), f(at + 4), f(at + 8));
            [corner(12), corner(24), corner(36)]
        })
        .collect();
    StlRead {
        triangles,
        binary: true,
        warnings,
    }
}

/// Words of a text with their lines. Bytes, not characters: names may be in any code page.
struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    line_start: usize,
}

impl<'a> Text<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
            3
        } else {
            0
        };
        Text {
            bytes,
            at,
            line: 1,
            line_start: at,
        }
    }

    /// One line end: LF, CR LF, or a lone CR.
    fn newline(&mut self) {
        if self.bytes.get(self.at) == Some(&b'\r') && self.bytes.get(self.at + 1) == Some(&b'\n') {
            self.at += 1;
        }
        self.at += 1;
        self.line += 1;
        self.line_start = self.at;
    }

    fn skip_space(&mut self) {
        while let Some(&b) = self.bytes.get(self.at) {
            match b {
                b'\n' | b'\r' => self.newline(),
                b if b.is_ascii_whitespace() || b == 0x0b => self.at += 1,
                _ => break,
            }
        }
    }

    /// The next word, left in place.
    fn peek(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let end = rest
            .iter()
            .position(|b| b.is_ascii_whitespace() || *b == 0x0b)
            .unwrap_or(rest.len());
        (end > 0).then(|| &rest[..end])
    }

    fn take(&mut self) -> Option<&'a [u8]> {
        let word = self.peek()?;
        self.at += word.len();
        Some(word)
    }

    /// Leaves the rest of the line (a name) unread.
    fn skip_line(&mut self) {
        while let Some(&b) = self.bytes.get(self.at) {
            if b == b'\n' || b == b'\r' {
                self.newline();
                return;
            }
            self.at += 1;
        }
    }

    /// Leaves the name unread: the rest of the line, or what stands before "facet normal" where a whole solid is one line.
    fn skip_name(&mut self) {
        loop {
            while self
                .bytes
                .get(self.at)
                .is_some_and(|b| matches!(b, b' ' | b'\t' | 0x0b | 0x0c))
            {
                self.at += 1;
            }
            let (at, line, line_start) = (self.at, self.line, self.line_start);
            match self.bytes.get(self.at) {
                None => return,
                Some(b'\n' | b'\r') => return self.newline(),
                Some(_) => {}
            }
            let is =
                |w: Option<&[u8]>, word: &[u8]| w.is_some_and(|w| w.eq_ignore_ascii_case(word));
            let begins =
                is(self.take(), b"facet") && self.line == line && is(self.peek(), b"normal");
            if begins {
                (self.at, self.line, self.line_start) = (at, line, line_start);
                return;
            }
            // Looking at the word after may have gone to another line.
            if self.line != line {
                return;
            }
        }
    }

    fn word(&mut self, expected: &'static str, ended: &'static str) -> Result<(), StlError> {
        let found = self.take().ok_or(StlError::Ended(ended, self.line))?;
        if found.eq_ignore_ascii_case(expected.as_bytes()) {
            return Ok(());
        }
        Err(StlError::Word {
            expected,
            found: shown(found),
            line: self.line,
            column: self.column(found),
        })
    }

    fn column(&self, just_taken: &[u8]) -> u64 {
        (self.at - just_taken.len() - self.line_start) as u64 + 1
    }

    fn number(&mut self) -> Result<f64, StlError> {
        let found = self
            .take()
            .ok_or(StlError::Ended("inside a facet", self.line))?;
        std::str::from_utf8(found)
            .ok()
            .and_then(|t| t.parse().ok())
            .ok_or_else(|| StlError::Number {
                found: shown(found),
                line: self.line,
                column: self.column(found),
            })
    }
}

/// A word for an error message: printable, and not a page long.
pub(super) fn shown(word: &[u8]) -> String {
    let mut s: String = word
        .iter()
        .take(40)
        .map(|&b| char::from(b))
        .map(|c| if c.is_control() { '?' } else { c })
        .collect();
    if word.len() > 40 {
        s.push_str("...");
    }
    s
}

fn read_ascii(mut text: Text<'_>) -> Result<StlRead, StlError> {
    const FACET_END: &str = "inside a facet";
    let mut triangles = Vec::new();
    let mut solids = 0usize;
    while text.peek().is_some() {
        text.word("solid", FACET_END)?;
        text.skip_name();
        solids += 1;
        loop {
            let word = text
                .take()
                .ok_or(StlError::Ended("before \"endsolid\"", text.line))?;
            if word.eq_ignore_ascii_case(b"endsolid") {
                text.skip_line();
                break;
            }
            if !word.eq_ignore_ascii_case(b"facet") {
                return Err(StlError::Word {
                    expected: "facet",
                    found: shown(word),
                    line: text.line,
                    column: text.column(word),
                });
            }
            text.word("normal", FACET_END)?;
            for _ in 0..3 {
                text.take().ok_or(StlError::Ended(FACET_END, text.line))?; // often "nan", never needed
            }
            text.word("outer", FACET_END)?;
            text.word("loop", FACET_END)?;
            let mut corners = [Point::origin(); 3];
            for corner in &mut corners {
                text.word("vertex", FACET_END)?;
                *corner = Point::new(text.number()?, text.number()?, text.number()?);
            }
            text.word("endloop", FACET_END)?;
            text.word("endfacet", FACET_END)?;
            triangles.push(corners);
        }
    }
    let warnings = if solids > 1 {
        vec![format!("{solids} solids in the file were read as one part")]
    } else {
        Vec::new()
    };
    Ok(StlRead {
        triangles,
        binary: false,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    pub(crate) fn binary(header: &str, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut out = header.as_bytes().to_vec();
        out.resize(80, b' ');
        out.extend((triangles.len() as u32).to_le_bytes());
        for t in triangles {
            out.extend([0u8; 12]);
            for v in t.iter().flatten() {
                out.extend(v.to_le_bytes());
            }
            out.extend([0u8; 2]);
        }
        out
    }

    const TRI: [[f32; 3]; 3] = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.25], [0.0, 1.0, -0.125]];

    fn ascii(body: &str) -> Result<StlRead, StlError> {
        read(body.as_bytes())
    }

    const FACET_TEXT: &str = "facet normal nan nan nan\n outer loop\n vertex 0 0 0.5\n vertex 1 0 .25\n \
                              vertex 0 1. -1.25e-1\n endloop\nendfacet\n";

    #[test]
    fn a_binary_header_that_says_solid_is_still_binary() {
        let r = read(&binary("solid made by a liar", &[TRI, TRI])).unwrap();
        assert!(r.binary && r.warnings.is_empty());
        assert_eq!(r.triangles.len(), 2);
        assert_eq!(r.triangles[1][2], Point::new(0.0, 1.0, -0.125));
    }

    #[test]
    fn trailing_bytes_are_tolerated_with_a_note() {
        let mut b = binary("x", &[TRI]);
        b.extend([7u8; 33]);
        let r = read(&b).unwrap();
        assert_eq!(r.triangles.len(), 1);
        assert_eq!(
            r.warnings,
            ["33 bytes after the last triangle of the binary STL were ignored"]
        );
    }

    #[test]
    fn truncated_and_boasting_files_are_refused_without_memory() {
        for header in ["x", "solid x"] {
            let mut b = binary(header, &[TRI, TRI, TRI]);
            b.truncate(84 + 120);
            assert_eq!(
                read(&b).unwrap_err().to_string(),
                "truncated STL: the header promises 3 triangles (234 bytes) but the file has 204 bytes, room for 2: copy \
                 or export it again"
            );
            b[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
            assert_eq!(
                read(&b).unwrap_err().to_string(),
                "truncated STL: the header promises 4294967295 triangles (214748364834 bytes) but the file has 204 bytes, \
                 room for 2: copy or export it again"
            );
            b[80..84].copy_from_slice(&[0; 4]);
            assert_eq!(
                read(&b).unwrap_err().to_string(),
                "the STL header promises 0 triangles but 120 bytes follow it: the program that wrote it was interrupted; \
                 export it again"
            );
        }
        let mut b = binary("solid x", &[TRI]);
        b.truncate(83);
        assert!(read(&b).is_err());
        b.truncate(40);
        assert!(read(&b).is_err());
        assert_eq!(
            read(b"hello").unwrap_err().to_string(),
            "not an STL file: neither binary (its 5 bytes do not fit the count in the header) nor text that begins with \"solid\""
        );
    }

    #[test]
    fn ascii_of_every_dress() {
        let want = [
            Point::new(0.0, 0.0, 0.5),
            Point::new(1.0, 0.0, 0.25),
            Point::new(0.0, 1.0, -0.125),
        ];
        for (text, count) in [
            (format!("solid\n{FACET_TEXT}endsolid"), 1),
            (
                format!(
                    "SOLID NAME facet\n{}ENDSOLID NAME\n",
                    FACET_TEXT.to_uppercase()
                ),
                1,
            ),
            (
                format!(
                    "\u{feff}solid a\r\n{}endsolid a\r\n",
                    FACET_TEXT.replace('\n', "\r\n")
                ),
                1,
            ),
            (
                format!("solid a\r{}endsolid a\r", FACET_TEXT.replace('\n', "\r")),
                1,
            ),
            (
                format!(
                    "  \tsolid\n{0}endsolid x\n\nsolid b\n{0}{0}endsolid",
                    FACET_TEXT
                ),
                3,
            ),
            ("solid nothing\nendsolid nothing".to_string(), 0),
            (
                format!("solid a facet {}endsolid a", FACET_TEXT.replace('\n', " ")),
                1,
            ),
            (format!("solid facet\x0b \n{FACET_TEXT}endsolid facet"), 1),
        ] {
            let r = ascii(&text).unwrap();
            assert!(!r.binary);
            assert_eq!(r.triangles, vec![want; count], "{text}");
        }
        let mut latin = b"solid Geh\xe4use \xff\n".to_vec();
        latin.extend(FACET_TEXT.as_bytes());
        latin.extend(b"endsolid Geh\xe4use");
        assert_eq!(read(&latin).unwrap().triangles.len(), 1);
    }

    #[test]
    fn ascii_complaints_say_where() {
        let whole = format!("solid a\n{FACET_TEXT}endsolid a\n");
        for (text, place, message) in [
            (
                whole.replace("1 0 .25", "1 zero .25"),
                (5, 11),
                "\"zero\" is not a number: a corner is written \"vertex x y z\", with decimal points",
            ),
            (
                whole.replace("0 1. -1", "0 1,5 -1"),
                (6, 11),
                "\"1,5\" is not a number: a corner is written \"vertex x y z\", with decimal points",
            ),
            (
                whole.replace(" endloop", " vertex 1 1 1\n endloop"),
                (7, 2),
                "expected \"endloop\", found \"vertex\"",
            ),
            (
                whole.replace("endsolid a", "facets"),
                (9, 1),
                "expected \"facet\", found \"facets\"",
            ),
            (
                whole.replace("endsolid a\n", ""),
                (9, 1),
                "truncated STL: the text ends before \"endsolid\": copy or export it again",
            ),
            (
                whole[..70].to_string(),
                (5, 1),
                "truncated STL: the text ends inside a facet: copy or export it again",
            ),
        ] {
            let e = ascii(&text).unwrap_err();
            assert_eq!(
                (e.place(), e.to_string().as_str()),
                (Some(place), message),
                "{text}"
            );
        }
        assert_eq!(
            read(b"\xff\xfes\0o\0l\0").unwrap_err().to_string(),
            "this STL is text in UTF-16: save it as plain ASCII, or as binary STL"
        );
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            let _ = read(&bytes);
        }

        #[test]
        fn no_cut_of_an_ascii_file_passes(cut in 1usize..150) {
            let whole = format!("solid a\n{FACET_TEXT}endsolid");
            prop_assume!(cut < whole.len());
            prop_assert!(read(&whole.as_bytes()[..cut]).is_err());
        }
    }
}
