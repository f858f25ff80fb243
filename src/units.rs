//! Units as types, for the borders where a bare number could be mistaken: machine data, feeds, times.
//!
//! Geometry inside the program is plain `f64` millimetres (see [`crate::geom`]); names carry the unit where a type does not.

use serde::{Deserialize, Serialize};

macro_rules! unit {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub f64);
    };
}

unit!(
    /// A length, mm.
    Mm
);
unit!(
    /// A speed, mm/min (what F words and GRBL settings speak).
    MmPerMin
);
unit!(
    /// An acceleration, mm/s².
    MmPerSec2
);
unit!(
    /// A duration, s.
    Seconds
);
unit!(
    /// A spindle speed, revolutions per minute.
    Rpm
);

impl MmPerMin {
    /// The same speed in mm/s.
    pub fn mm_per_s(self) -> f64 {
        self.0 / 60.0
    }
}

impl std::ops::Div<MmPerMin> for Mm {
    type Output = Seconds;
    fn div(self, v: MmPerMin) -> Seconds {
        Seconds(self.0 / v.mm_per_s())
    }
}

impl std::ops::Add for Seconds {
    type Output = Seconds;
    fn add(self, o: Seconds) -> Seconds {
        Seconds(self.0 + o.0)
    }
}

impl std::ops::AddAssign for Seconds {
    fn add_assign(&mut self, o: Seconds) {
        self.0 += o.0;
    }
}

impl std::iter::Sum for Seconds {
    fn sum<I: Iterator<Item = Seconds>>(iter: I) -> Seconds {
        Seconds(iter.map(|s| s.0).sum())
    }
}
