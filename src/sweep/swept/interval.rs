//! Closed intervals of a row.

/// A closed interval; empty when `lo > hi`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) lo: f64,
    pub(super) hi: f64,
}

impl Interval {
    pub(super) const EMPTY: Interval = Interval {
        lo: f64::INFINITY,
        hi: f64::NEG_INFINITY,
    };

    #[inline]
    pub(super) fn is_empty(self) -> bool {
        self.lo > self.hi
    }
    #[inline]
    pub(super) fn meet(self, o: Interval) -> Interval {
        Interval {
            lo: self.lo.max(o.lo),
            hi: self.hi.min(o.hi),
        }
    }
    #[inline]
    pub(super) fn hull(self, o: Interval) -> Interval {
        if self.is_empty() {
            o
        } else if o.is_empty() {
            self
        } else {
            Interval {
                lo: self.lo.min(o.lo),
                hi: self.hi.max(o.hi),
            }
        }
    }
    #[inline]
    pub(super) fn moved(self, by: f64) -> Interval {
        Interval {
            lo: self.lo + by,
            hi: self.hi + by,
        }
    }
    /// Larger by `by` at both ends (smaller when negative); the empty interval stays empty.
    #[inline]
    pub(super) fn padded(self, by: f64) -> Interval {
        if self.is_empty() {
            return Interval::EMPTY;
        }
        Interval {
            lo: self.lo - by,
            hi: self.hi + by,
        }
    }
    /// What is left of `self` without the inside of `o`: the part below and the part above.
    #[inline]
    pub(super) fn minus(self, o: Interval) -> [Interval; 2] {
        if o.is_empty() {
            return [self, Interval::EMPTY];
        }
        [
            Interval {
                lo: self.lo,
                hi: self.hi.min(o.lo),
            },
            Interval {
                lo: self.lo.max(o.hi),
                hi: self.hi,
            },
        ]
    }
}
