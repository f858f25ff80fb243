//! A list of so many numbers, each with its place: no more and no fewer.
//!
//! Crosses the border: a TOML list in, an array out. A longer list is refused, not cut: what stands behind would be dropped in silence.

use serde::de::{Deserialize, Deserializer, Error};
use toml::Spanned;

/// `N` numbers: three for X, Y, Z; two for the lowest and the highest.
pub(super) struct Row<const N: usize>(pub [Spanned<f64>; N]);

impl<'de, const N: usize> Deserialize<'de> for Row<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let all = Vec::<Spanned<f64>>::deserialize(from)?;
        let count = all.len();
        let what = match N {
            2 => "the lowest and the highest",
            _ => "X, Y and Z",
        };
        all.try_into()
            .map(Row)
            .map_err(|_| D::Error::custom(format!("needs {N} numbers, {what}, and has {count}")))
    }
}
