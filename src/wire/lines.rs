//! Bytes to lines: replies arrive in arbitrary pieces.

/// Longest line kept, bytes. GRBL's longest is under 200; a stream of noise without line ends must not eat the memory.
const LINE_LIMIT: usize = 1024;

/// Collects bytes and hands out whole lines, without their line ends and without empty ones. Bytes that are not UTF-8 come out
/// as the replacement character, so damage stays visible; a line over 1024 bytes is cut there.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    partial: Vec<u8>,
}

impl Lines {
    /// Takes in what arrived and returns the lines it completed, oldest first.
    pub fn feed(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut whole = Vec::new();
        for &byte in bytes {
            if byte == b'\n' || byte == b'\r' {
                if !self.partial.is_empty() {
                    let line = String::from_utf8_lossy(&self.partial).trim().to_string();
                    if !line.is_empty() {
                        whole.push(line);
                    }
                    self.partial.clear();
                }
            } else if self.partial.len() < LINE_LIMIT {
                self.partial.push(byte);
            }
        }
        whole
    }

    /// Forgets a half-received line (after a reset).
    pub fn clear(&mut self) {
        self.partial.clear();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn noise_without_line_ends_is_bounded() {
        let mut lines = Lines::default();
        for _ in 0..100 {
            assert!(lines.feed(&[b'x'; 1000]).is_empty());
        }
        assert_eq!(lines.feed(b"\n")[0].len(), LINE_LIMIT);
    }

    proptest! {
        /// The lines do not depend on how the bytes were cut.
        #[test]
        fn chunking_does_not_matter(cuts in proptest::collection::vec(1usize..9, 0..60)) {
            let text = b"\r\nGrbl 1.1h ['$' for help]\r\nok\r\nerror:20\r\n<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\nok\r\n";
            let want = Lines::default().feed(text);
            let (mut lines, mut got, mut at) = (Lines::default(), Vec::new(), 0);
            for cut in cuts {
                let end = (at + cut).min(text.len());
                got.extend(lines.feed(&text[at..end]));
                at = end;
            }
            got.extend(lines.feed(&text[at..]));
            prop_assert_eq!(got, want);
        }
    }
}
