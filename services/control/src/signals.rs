//! The inputs or the outputs of a plant at one instant: a number, or two.
//!
//! What is sent, stepped and controlled has this type; rows and step metrics are of the first.

use std::{fmt, num::ParseFloatError, str::FromStr};

use serde::{Deserialize, Serialize};

/// One value, or two of the same instant.
///
/// As JSON it is a number or a list of two, as text `0.35` or `0.35,0.1`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Form", into = "Form")]
pub struct Signals {
    /// The first input or output; of most plants it is the only one.
    pub first: f64,
    /// The second, if the plant has two.
    pub second: Option<f64>,
}

impl Signals {
    /// Most inputs or outputs of a plant.
    pub const MOST: usize = 2;

    /// Zero for each of `count` inputs or outputs.
    #[must_use]
    pub fn zeros(count: usize) -> Self {
        Self {
            first: 0.0,
            second: (count > 1).then_some(0.0),
        }
    }

    /// How many there are: 1 or 2.
    #[must_use]
    pub fn count(&self) -> usize {
        1 + usize::from(self.second.is_some())
    }

    /// Each of them, the first one first.
    pub fn iter(&self) -> impl Iterator<Item = f64> {
        std::iter::once(self.first).chain(self.second)
    }

    /// Each of them by the same function.
    #[inline]
    #[must_use]
    pub fn map(self, mut each: impl FnMut(f64) -> f64) -> Self {
        Self {
            first: each(self.first),
            second: self.second.map(each),
        }
    }

    /// Whether all are finite numbers.
    #[inline]
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.first.is_finite() && self.second.is_none_or(f64::is_finite)
    }
}

impl From<f64> for Signals {
    #[inline]
    fn from(first: f64) -> Self {
        Self {
            first,
            second: None,
        }
    }
}

/// One value, and this one.
impl PartialEq<f64> for Signals {
    fn eq(&self, other: &f64) -> bool {
        *self == Self::from(*other)
    }
}

impl From<[f64; 2]> for Signals {
    fn from([first, second]: [f64; 2]) -> Self {
        Self {
            first,
            second: Some(second),
        }
    }
}

/// With the fewest digits that read back to the same numbers.
impl fmt::Display for Signals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // `{:?}` of an f64 has the fewest digits that read back, like `{}`, but uses an exponent where `{}`
        // would write 300 zeros.
        write!(f, "{:?}", self.first)?;
        self.second
            .map_or(Ok(()), |second| write!(f, ",{second:?}"))
    }
}

/// Any number that an f64 can be, so also `inf` and `NaN`.
impl FromStr for Signals {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, ParseFloatError> {
        let (first, second) = match text.split_once(',') {
            None => (text, None),
            Some((first, second)) => (first, Some(second)),
        };
        Ok(Self {
            first: first.trim().parse()?,
            second: second.map(|second| second.trim().parse()).transpose()?,
        })
    }
}

/// The form in JSON.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Form {
    One(f64),
    Two([f64; 2]),
}

impl From<Form> for Signals {
    fn from(form: Form) -> Self {
        match form {
            Form::One(first) => first.into(),
            Form::Two(both) => both.into(),
        }
    }
}

impl From<Signals> for Form {
    fn from(Signals { first, second }: Signals) -> Self {
        second.map_or(Self::One(first), |second| Self::Two([first, second]))
    }
}
