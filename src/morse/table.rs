//! How many critical points each persistence threshold leaves, so that one can be chosen.

/// Rows of a table at most.
pub const ROWS: usize = 12;

/// Thresholds to try: nought, and from there one for each doubling within which some pair is cancelled, the noisier ones in one row
/// if there are too many. Each is a short decimal that cancels exactly the pairs of its doubling and below: a pair is cancelled
/// when its persistence is *below* the threshold. `persistence` in any order; infinite ones are never cancelled.
pub fn thresholds(persistence: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = persistence.filter(|p| p.is_finite() && *p >= 0.0).collect();
    all.sort_unstable_by(f64::total_cmp);
    let mut out = Vec::new();
    let mut at = 0;
    while at < all.len() {
        // One group: up to the next power of two. Nothing at all is a group of its own.
        let top = if all[at] > 0.0 {
            2f64.powi(all[at].log2().floor() as i32 + 1)
        } else {
            f64::MIN_POSITIVE
        };
        let end = at + all[at..].partition_point(|p| *p < top);
        let last = all[end.max(at + 1) - 1];
        let next = all.get(end).copied().unwrap_or(f64::INFINITY);
        out.push(between(last, next));
        at = end.max(at + 1);
    }
    let first = out.len().saturating_sub(ROWS - 1);
    out.drain(..first);
    out.insert(0, 0.0);
    out
}

/// The shortest decimal above `low` and not above `high`.
fn between(low: f64, high: f64) -> f64 {
    if low <= 0.0 {
        // Only ties are cancelled: anything up to the next will do.
        return if high.is_finite() {
            between(0.3 * high, high)
        } else {
            1e-9
        };
    }
    let exponent = low.log10().floor() as i32;
    for digits in 0..17 {
        let unit = 10f64.powi(exponent - digits);
        // Through its text, so that what is printed is what is meant.
        let text = format!("{:e}", ((low / unit).floor() + 1.0) * unit);
        let rounded = format!("{:.*e}", digits as usize + 1, text.parse().unwrap_or(high));
        let t: f64 = rounded.parse().unwrap_or(high);
        if t > low && t <= high {
            return t;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_cancels_its_doubling_and_no_more() {
        let p = [
            0.0011,
            0.0012,
            0.3,
            0.31,
            0.49,
            0.51,
            7.0,
            7.5,
            f64::INFINITY,
        ];
        let rows = thresholds(p.into_iter());
        let left = |t: f64| p.iter().filter(|p| **p >= t).count();
        assert_eq!(
            rows.iter().map(|t| left(*t)).collect::<Vec<_>>(),
            [9, 7, 4, 3, 1]
        );
        assert_eq!(rows, [0.0, 0.002, 0.5, 0.6, 8.0]);
    }

    #[test]
    fn there_are_never_more_rows_than_fit_and_they_rise() {
        let many: Vec<f64> = (0..4000).map(|k| 1e-9 * 1.01f64.powi(k)).collect();
        let rows = thresholds(many.iter().copied());
        assert_eq!(rows.len(), ROWS);
        assert!(rows.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(rows[0], 0.0);
        assert!(many.iter().all(|p| *p < rows[ROWS - 1]));
        assert_eq!(thresholds(std::iter::empty()), [0.0]);
        // Equal and vanishing ones.
        let rows = thresholds([0.0, 0.0, 2.0, 2.0].into_iter());
        assert_eq!(rows.len(), 3);
        assert!(rows[1] > 0.0 && rows[1] <= 2.0 && rows[2] > 2.0);
    }
}
