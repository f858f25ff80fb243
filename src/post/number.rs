//! The only rounding on the way to text: a number becomes a whole count of its last decimal, and digits are written from that.
//!
//! No exponent, no locale, no `-0`, no trailing zeros; exact halves go away from zero, so that a path and its mirror image round
//! alike. Two numbers look equal in the program exactly when their counts are equal.

use super::definition::Numbers;

/// Most decimals that [`round`] and [`push`] take.
pub const MOST_DECIMALS: u8 = 9;

/// Counts above this many digits are refused: GRBL reads eight digits and ignores the rest.
pub const MOST_DIGITS: u32 = 8;

const POWERS: [f64; MOST_DECIMALS as usize + 1] =
    [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

/// `value` as a count of units of the last decimal: `round(1.25, 1)` is 13. Rounds the exact binary value; an exact half goes away
/// from zero. `None` when the value is not finite, the count has more than [`MOST_DIGITS`] digits, or `decimals` is above
/// [`MOST_DECIMALS`].
pub fn round(value: f64, decimals: u8) -> Option<i64> {
    let power = *POWERS.get(usize::from(decimals))?;
    let product = value.abs() * power;
    if !product.is_finite() || product >= 1e8 {
        return None;
    }
    let floor = product.floor();
    let over = product - floor; // exact, because product < 2^52
    // The product is itself rounded. That cannot carry it across a half, but it can land on one; then the exact error of the
    // product tells on which side the true value lies.
    let up = if over == 0.5 {
        value.abs().mul_add(power, -product) >= 0.0
    } else {
        over > 0.5
    };
    let count = floor as i64 + i64::from(up);
    if count >= 10_i64.pow(MOST_DIGITS) {
        return None;
    }
    Some(if value < 0.0 { -count } else { count })
}

/// Writes a count of units of the last decimal as a decimal number: `push(out, -1250, 3)` writes `-1.25`. Decimals above
/// [`MOST_DECIMALS`] are taken as that.
pub fn push(out: &mut String, count: i64, decimals: u8) {
    if count < 0 {
        out.push('-');
    }
    let mut rest = count.unsigned_abs();
    let mut places = decimals.min(MOST_DECIMALS);
    while places > 0 && rest.is_multiple_of(10) {
        rest /= 10;
        places -= 1;
    }
    // Digits from the last to the first; 20 digits and a point at most.
    let mut digits = [0_u8; 24];
    let mut at = digits.len();
    let mut written = 0;
    loop {
        if written == places && places > 0 {
            at -= 1;
            digits[at] = b'.';
        }
        at -= 1;
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        written += 1;
        if rest == 0 && written > places {
            break;
        }
    }
    out.extend(digits[at..].iter().map(|d| char::from(*d)));
}

/// The same in a dialect's manner: always with a point, all decimals, or with a plus sign.
pub fn push_as(out: &mut String, count: i64, decimals: u8, manner: Numbers) {
    if manner == Numbers::default() {
        return push(out, count, decimals);
    }
    if manner.plus && count >= 0 {
        out.push('+');
    }
    let start = out.len();
    push(out, count, decimals);
    let written = out.get(start..).unwrap_or_default();
    let places = written
        .find('.')
        .map(|point| written.len().saturating_sub(point + 1));
    if places.is_none() && (manner.point || (manner.trailing_zeros && decimals > 0)) {
        out.push('.');
    }
    if manner.trailing_zeros {
        for _ in places.unwrap_or(0)..usize::from(decimals.min(MOST_DECIMALS)) {
            out.push('0');
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn text(value: f64, decimals: u8) -> String {
        let mut s = String::new();
        push(&mut s, round(value, decimals).unwrap(), decimals);
        s
    }

    #[test]
    fn writes_as_a_machinist_would() {
        for (v, d, s) in [
            (0.0, 3, "0"),
            (-0.0, 3, "0"),
            (-0.0004, 3, "0"),
            (1.0, 3, "1"),
            (-1.25, 3, "-1.25"),
            (0.5, 3, "0.5"),
            (-0.001, 3, "-0.001"),
            (100.0, 0, "100"),
            (100.0, 3, "100"),
            (1500.0, 1, "1500"),
            (12.3456, 3, "12.346"),
            (99999.999, 3, "99999.999"),
            (1e-300, 3, "0"),
            (0.1 + 0.2 - 0.25, 9, "0.05"),
            (10.01, 4, "10.01"),
        ] {
            assert_eq!(text(v, d), s, "{v} with {d}");
        }
    }

    #[test]
    fn manners() {
        let manner = |point, trailing_zeros, plus| Numbers {
            point,
            trailing_zeros,
            plus,
        };
        for (count, decimals, m, s) in [
            (10_000, 3, manner(true, false, false), "10."),
            (10_500, 3, manner(true, false, false), "10.5"),
            (0, 3, manner(true, false, false), "0."),
            (-10_000, 3, manner(false, true, false), "-10.000"),
            (10_500, 3, manner(false, true, true), "+10.500"),
            (0, 3, manner(false, false, true), "+0"),
            (-1, 3, manner(true, false, true), "-0.001"),
            (500, 0, manner(true, true, false), "500."),
            (500, 0, manner(false, true, false), "500"),
        ] {
            let mut out = String::from("X");
            push_as(&mut out, count, decimals, m);
            assert_eq!(out, format!("X{s}"));
        }
    }

    #[test]
    fn halves_go_away_from_zero_but_only_true_halves() {
        // 1/16 is exact in binary: a true half of the third decimal.
        assert_eq!(text(0.0625, 3), "0.063");
        assert_eq!(text(-0.0625, 3), "-0.063");
        // 1.0005 is a shade below the half in binary, 1.0015 a shade above; times 1000 both land on the half in f64.
        assert_eq!(1.0005_f64 * 1000.0, 1000.5);
        assert_eq!(text(1.0005, 3), "1");
        assert_eq!(text(2.5, 0), "3");
        assert_eq!(text(0.499_999_999_999_999_94, 0), "0");
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        for bad in [
            f64::NAN,
            f64::INFINITY,
            -f64::INFINITY,
            1e5,
            -1e5,
            99999.9995,
            1e300,
        ] {
            assert_eq!(round(bad, 3), None, "{bad}");
        }
        assert_eq!(round(1.0, MOST_DECIMALS + 1), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        // An independent path: the standard library prints exact decimal expansions.
        #[test]
        fn agrees_with_exact_arithmetic(v in -99_999.0_f64..99_999.0, d in 0_u8..=3) {
            let back: f64 = text(v, d).parse().unwrap();
            prop_assert!((back - v).abs() <= 0.5 / POWERS[usize::from(d)] * (1.0 + 1e-9) + v.abs() * f64::EPSILON);
            let exact = format!("{v:.40}");
            let (whole, fraction) = exact.trim_start_matches('-').split_once('.').unwrap();
            let (kept, dropped) = fraction.split_at(usize::from(d));
            let mut count: i64 = format!("{whole}{kept}").parse().unwrap();
            count += i64::from(dropped.as_bytes()[0] >= b'5');
            prop_assert_eq!(round(v, d).unwrap(), if v < 0.0 { -count } else { count });
        }

        #[test]
        fn reading_back_gives_the_count(count in -99_999_999_i64..=99_999_999, d in 0_u8..=6) {
            let mut s = String::new();
            push(&mut s, count, d);
            prop_assert!(!s.contains(['e', 'E', '+']) && s != "-0");
            prop_assert!(!s.contains('.') || !s.ends_with(['0', '.']), "{}", s);
            prop_assert_eq!(round(s.parse().unwrap(), d), Some(count));
        }

        #[test]
        fn mirror_images_round_alike(v in -9_999.0_f64..9_999.0, d in 0_u8..=4) {
            prop_assert_eq!(round(v, d).unwrap(), -round(-v, d).unwrap());
        }
    }
}
