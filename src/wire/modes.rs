//! The active modes, as `$G` tells them: `[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]`.

/// The words of a `[GC:...]` line, in its order. F is in the unit of `$13` per minute, whatever G20 or G21 says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modes {
    /// Words as sent, such as `G54`.
    pub words: Vec<String>,
}

impl Modes {
    /// Reads what stands between `[GC:` and `]`.
    pub fn parse(text: &str) -> Modes {
        Modes {
            words: text.split_whitespace().map(str::to_string).collect(),
        }
    }

    /// True when this word is among them.
    pub fn has(&self, word: &str) -> bool {
        self.words.iter().any(|w| w == word)
    }

    /// The value of the first word with this letter.
    pub fn value(&self, letter: char) -> Option<f64> {
        let value = self.words.iter().find_map(|w| w.strip_prefix(letter))?;
        super::status::number(value)
    }

    /// The active work offset: 0 is G54, 5 is G59.
    pub fn work_offset(&self) -> Option<usize> {
        (0..6).find(|i| self.has(&format!("G{}", 54 + i)))
    }
}

impl std::fmt::Display for Modes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.words.join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_words_of_a_mode_line() {
        let m = Modes::parse("G1 G55 G17 G20 G91 G94 M3 M8 T2 F254.0 S1000");
        assert!(m.has("G20") && m.has("M3") && !m.has("G2"));
        assert_eq!(
            (m.work_offset(), m.value('F'), m.value('T')),
            (Some(1), Some(254.0), Some(2.0))
        );
        assert_eq!(
            m.to_string(),
            "G1 G55 G17 G20 G91 G94 M3 M8 T2 F254.0 S1000"
        );
        assert_eq!(Modes::parse("F1e999 X").value('F'), None);
    }
}
