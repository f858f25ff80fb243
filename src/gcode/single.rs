//! A figure as GRBL reads it: eight digits gathered as a whole number, then hundredths and tenths multiplied in, in single precision.
//!
//! It decides to which step a place belongs that lies half-way between two: `X0.91` at 250 steps/mm is 227 steps, not 228. Observed on
//! GRBL 1.1h. Text in, the value as f64 out; no units.

/// The value of sign, digits and one dot. Anything else in `figure` counts for nothing.
pub fn read_single(figure: &str) -> f64 {
    let (mut whole, mut digits, mut exponent, mut dot) = (0u32, 0, 0i32, false);
    for byte in figure.bytes() {
        match byte {
            b'.' => dot = true,
            b'0'..=b'9' if digits < 8 => {
                whole = whole * 10 + u32::from(byte - b'0');
                digits += 1;
                exponent -= i32::from(dot);
            }
            b'0'..=b'9' => exponent += i32::from(!dot),
            _ => {}
        }
    }
    let mut value = whole as f32;
    while exponent <= -2 {
        value *= 0.01;
        exponent += 2;
    }
    if exponent < 0 {
        value *= 0.1;
    }
    for _ in 0..exponent.max(0) {
        value *= 10.0;
    }
    let value = if figure.starts_with('-') {
        -value
    } else {
        value
    };
    f64::from(value.clamp(f32::MIN, f32::MAX))
}

/// The figure at the beginning of `text`, blanks between its characters left out.
pub(super) fn leading(text: &str) -> String {
    let mut dots = 0;
    let mut figure = String::new();
    for c in text.chars() {
        match c {
            ' ' | '\t' => continue,
            '+' | '-' if figure.is_empty() => {}
            '.' if dots == 0 => dots = 1,
            '0'..='9' => {}
            _ => break,
        }
        figure.push(c);
    }
    figure
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_go_where_the_firmware_sends_them() {
        // Recorded: the step counts of GRBL 1.1h at 250 steps/mm.
        for (text, steps) in [
            ("0.91", 227.0),
            ("+3.91", 977.0),
            ("2", 500.0),
            ("-0.5", -125.0),
        ] {
            let f = read_single(&leading(text)) as f32;
            assert_eq!((f * 250.0).round(), steps, "{text}");
        }
    }

    #[test]
    fn digits_behind_the_eighth_are_noughts() {
        assert_eq!(read_single("123456789"), f64::from(123_456_780.0f32));
        assert_eq!(read_single(""), 0.0);
        assert_eq!(leading("1.5.2X3"), "1.5");
        assert_eq!(leading("- 1 .5 Y2"), "-1.5");
    }
}
