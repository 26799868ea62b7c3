//! A reference that moves.
//!
//! [`Shape`] is how a system describes it: a step, a square wave, a sine, or points. [`Reference`] is what
//! every controller gets: the times at which r changes. Following it needs no arithmetic, so that
//! clients in all languages have the same r to the last bit. A reference that rests is no [`Reference`]: it
//! is `r` in the settings.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sample_time::SampleTime;

/// Most changes of a reference in a run: a sine at 1 kHz for 20 s.
pub const CHANGES_MAX: usize = 20_000;

/// How a reference moves. Times count from the controller's first deadline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    tag = "shape",
    rename_all = "kebab-case",
    rename_all_fields = "snake_case",
    deny_unknown_fields
)]
pub enum Shape {
    /// One step.
    Step {
        /// r before it.
        from: f64,
        /// r from it on.
        to: f64,
        /// When it is.
        at_ns: u64,
    },
    /// Half a period `high`, then half a period `low`.
    Square {
        /// The lower value.
        low: f64,
        /// The upper value.
        high: f64,
        /// Its period.
        period_ns: u64,
    },
    /// A sine that begins in the middle, and rises; r changes every h.
    Sine {
        /// Its least value.
        low: f64,
        /// Its greatest value.
        high: f64,
        /// Its period.
        period_ns: u64,
    },
    /// Any changes.
    Points {
        /// Times and values, as those of a [`Reference`].
        changes: Reference,
    },
}

impl Shape {
    /// The changes of a run with this sample time and duration. A shape rests at a value until its next change.
    ///
    /// # Errors
    /// [`InvalidReference`] if there are too many changes, or a value is not finite.
    pub fn over(&self, h: SampleTime, duration_ns: u64) -> Result<Reference, InvalidReference> {
        let every = |step_ns: u64, r: &dyn Fn(u64) -> f64| {
            let step_ns = step_ns.max(1);
            if duration_ns.div_ceil(step_ns) > CHANGES_MAX as u64 {
                return Err(InvalidReference::TooMany);
            }
            let steps = 0..duration_ns.div_ceil(step_ns).max(1);
            Reference::try_from(
                steps
                    .map(|n| (n * step_ns, r(n * step_ns)))
                    .collect::<Vec<_>>(),
            )
        };
        match *self {
            Self::Step { to, at_ns: 0, .. } => Reference::try_from(vec![(0, to)]),
            Self::Step { from, to, at_ns } => Reference::try_from(vec![(0, from), (at_ns, to)]),
            Self::Square {
                low,
                high,
                period_ns,
            } => {
                let half_ns = (period_ns / 2).max(1);
                every(half_ns, &|t_ns| {
                    if (t_ns / half_ns) & 1 == 0 { high } else { low }
                })
            }
            Self::Sine {
                low,
                high,
                period_ns,
            } => every(h.ns(), &|t_ns| {
                let turn = (t_ns % period_ns.max(1)) as f64 / period_ns.max(1) as f64;
                f64::midpoint(low, high) + (high - low) / 2.0 * (TAU * turn).sin()
            }),
            Self::Points { ref changes } => Ok(changes.clone()),
        }
    }
}

/// When r changes, in ns from the controller's first deadline, and to what; the first is at 0. As JSON it is
/// `[[0, 1.0], [2000000000, 0.5]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<(u64, f64)>")]
pub struct Reference(Vec<(u64, f64)>);

/// Why a list of changes is not a reference.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InvalidReference {
    /// There is no value for the first deadline.
    #[error("the first change is not at 0; begin with the value that r has at the start")]
    Start,
    /// A change is not after the one before it.
    #[error("the change at {t_ns} ns is not after the one before it; give times that rise")]
    Order {
        /// When it is.
        t_ns: u64,
    },
    /// A value is not finite.
    #[error("r at {t_ns} ns is {r}; give a finite number")]
    Value {
        /// When it is.
        t_ns: u64,
        /// The value.
        r: f64,
    },
    /// There are more than [`CHANGES_MAX`].
    #[error(
        "r changes more than {CHANGES_MAX} times in this run; use a shorter duration, or a longer h or period"
    )]
    TooMany,
}

impl TryFrom<Vec<(u64, f64)>> for Reference {
    type Error = InvalidReference;

    fn try_from(changes: Vec<(u64, f64)>) -> Result<Self, InvalidReference> {
        if changes.first().is_none_or(|(t_ns, _)| *t_ns != 0) {
            return Err(InvalidReference::Start);
        }
        if changes.len() > CHANGES_MAX {
            return Err(InvalidReference::TooMany);
        }
        if let Some(pair) = changes.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            return Err(InvalidReference::Order { t_ns: pair[1].0 });
        }
        match changes.iter().find(|(_, r)| !r.is_finite()) {
            Some(&(t_ns, r)) => Err(InvalidReference::Value { t_ns, r }),
            None => Ok(Self(changes)),
        }
    }
}

impl Reference {
    /// r at this time after the first deadline.
    #[must_use]
    pub fn at(&self, t_ns: u64) -> f64 {
        self.0[self.place(t_ns)].1
    }

    /// The changes, in order.
    #[must_use]
    pub fn changes(&self) -> &[(u64, f64)] {
        &self.0
    }

    /// The last change that is not after this time, and the value before it; `None` for the first value,
    /// which changes nothing.
    #[must_use]
    pub fn last_change(&self, t_ns: u64) -> Option<(u64, f64)> {
        let place = self.place(t_ns);
        let before = place.checked_sub(1)?;
        Some((self.0[place].0, self.0[before].1))
    }

    /// Place of the value that holds at this time. There is one, since the first is at 0.
    fn place(&self, t_ns: u64) -> usize {
        self.0.partition_point(|(change_ns, _)| *change_ns <= t_ns) - 1
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const S: u64 = 1_000_000_000;

    fn h() -> SampleTime {
        SampleTime::try_new(10_000_000).expect("10 ms")
    }

    fn values(shape: &Shape, at_s: &[f64]) -> Vec<f64> {
        let reference = shape.over(h(), 4 * S).expect("few changes");
        at_s.iter()
            .map(|t_s| reference.at((t_s * 1e9) as u64))
            .collect()
    }

    #[test]
    fn each_shape_moves_as_it_says() {
        let step = Shape::Step {
            from: 0.5,
            to: 2.0,
            at_ns: S,
        };
        assert_eq!(values(&step, &[0.0, 0.999, 1.0, 9.0]), [0.5, 0.5, 2.0, 2.0]);
        let square = Shape::Square {
            low: -1.0,
            high: 1.0,
            period_ns: 2 * S,
        };
        assert_eq!(
            values(&square, &[0.0, 0.99, 1.0, 2.0, 3.5]),
            [1.0, 1.0, -1.0, 1.0, -1.0]
        );
        let sine = Shape::Sine {
            low: 0.0,
            high: 2.0,
            period_ns: 4 * S,
        };
        let seen = values(&sine, &[0.0, 1.0, 2.0, 3.0]);
        for (seen, wanted) in seen.iter().zip([1.0, 2.0, 1.0, 0.0]) {
            assert!((seen - wanted).abs() < 1e-15, "{seen} is not {wanted}");
        }
    }

    #[test]
    fn what_is_no_reference_is_refused_by_name() {
        let refused = |changes: &[(u64, f64)]| Reference::try_from(changes.to_vec()).err();
        assert_eq!(refused(&[]), Some(InvalidReference::Start));
        assert_eq!(refused(&[(1, 0.0)]), Some(InvalidReference::Start));
        let twice = refused(&[(0, 0.0), (5, 1.0), (5, 2.0)]);
        assert_eq!(twice, Some(InvalidReference::Order { t_ns: 5 }));
        assert!(matches!(
            refused(&[(0, f64::NAN)]),
            Some(InvalidReference::Value { t_ns: 0, .. })
        ));
        let sine = Shape::Sine {
            low: 0.0,
            high: 1.0,
            period_ns: S,
        };
        assert_eq!(sine.over(h(), 201 * S), Err(InvalidReference::TooMany));
    }

    proptest! {
        #[test]
        fn it_holds_the_newest_change(
            steps in prop::collection::vec((1u64..1000, -1e3..1e3), 1..50),
            t_ns in 0u64..60_000,
        ) {
            let mut changes = vec![(0, 7.0)];
            for (after_ns, r) in steps {
                changes.push((changes.last().expect("the first").0 + after_ns, r));
            }
            let newest = changes.iter().rfind(|(at_ns, _)| *at_ns <= t_ns).expect("the first").1;
            let reference = Reference::try_from(changes).expect("times that rise");
            prop_assert_eq!(reference.at(t_ns), newest);
        }
    }
}
