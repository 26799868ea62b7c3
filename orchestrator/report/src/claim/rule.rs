//! The one rule that decides every number of a claim.
//!
//! A number has an interval, and agrees within limits:
//!
//! - the whole interval is within the limits: it agrees;
//! - the whole interval is beyond one limit: it differs;
//! - the interval is on both sides of a limit: it cannot be told. The runs support one verdict as
//!   well as the other, so neither is given, whichever side the middle is on.
//!
//! An interval needs [six values](INTERVAL_MIN) or more; fewer could mean anything, so it cannot be
//! told either. A limit may itself be measured, as when a share has to be above another's. Then the
//! limit is an interval too, and if the two overlap it cannot be told.
//!
//! Some numbers are exact and need no interval: that there are any, or none; what a run did, if the
//! claim is about what one run did; and a number compared with a band that already includes chance.
//! But if [fewer than three](COUNT_MIN) of something rare are expected, some cannot be distinguished
//! from none.

use super::Verdict;
use crate::group::{Estimate, INTERVAL_MIN};

/// If this many are expected, none is found in one of twenty runs (e^-3). If fewer are expected,
/// finding none says nothing.
pub const COUNT_MIN: f64 = 3.0;

/// The limits of a number that is only shown.
pub const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// The limits within which a number agrees. Each of them is a range in which it is known to lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    low: (f64, f64),
    high: (f64, f64),
    /// The limits as single numbers, for tables.
    shown: (f64, f64),
}

impl From<(f64, f64)> for Limits {
    /// From one number to another, both included; an open end is infinite.
    fn from((low, high): (f64, f64)) -> Limits {
        Limits {
            low: (low, low),
            high: (high, high),
            shown: (low, high),
        }
    }
}

impl Limits {
    /// Above a number that was itself measured.
    pub fn above(other: Estimate) -> Limits {
        Limits {
            low: (other.low, other.high.next_up()),
            high: (f64::INFINITY, f64::INFINITY),
            shown: (other.value, f64::INFINITY),
        }
    }

    /// Below a number that was itself measured.
    pub fn below(other: Estimate) -> Limits {
        Limits {
            low: (f64::NEG_INFINITY, f64::NEG_INFINITY),
            high: (other.low.next_down(), other.high),
            shown: (f64::NEG_INFINITY, other.value),
        }
    }

    /// The limits as single numbers.
    pub fn shown(&self) -> (f64, f64) {
        self.shown
    }
}

/// The verdict on a number; `None` was not run.
pub fn judge(ours: Option<Estimate>, limits: &Limits) -> Verdict {
    let Some(ours) = ours else {
        return Verdict::NotRun;
    };
    let is_within = ours.low >= limits.low.1 && ours.high <= limits.high.0;
    let is_beyond = ours.high < limits.low.0 || ours.low > limits.high.1;
    match (ours.has_interval(), is_within, is_beyond) {
        // Limits that are open at both ends accept anything.
        (_, true, _) => Verdict::Agrees,
        (true, false, true) => Verdict::Differs,
        _ => Verdict::CannotBeTold,
    }
}

/// Why a number has no interval; `None` if it has one.
pub fn too_few(ours: &Estimate) -> Option<String> {
    (!ours.has_interval()).then(|| format!("no interval is formed from fewer than {INTERVAL_MIN}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn known(low: f64, high: f64) -> Estimate {
        Estimate {
            value: f64::midpoint(low, high),
            low,
            high,
            n: 20,
        }
    }

    #[test]
    fn an_interval_on_both_sides_of_a_limit_cannot_be_told_whichever_side_its_middle_is_on() {
        let limits = Limits::from((3.0, 5.0));
        for (low, high, verdict) in [
            (3.0, 5.0, Verdict::Agrees),
            (4.0, 4.0, Verdict::Agrees),
            (2.0, 4.9, Verdict::CannotBeTold),
            (2.0, 3.1, Verdict::CannotBeTold),
            (4.0, f64::INFINITY, Verdict::CannotBeTold),
            (5.1, f64::INFINITY, Verdict::Differs),
            (1.0, 2.9, Verdict::Differs),
        ] {
            let ours = Some(known(low, high));
            assert_eq!(judge(ours, &limits), verdict, "{low} to {high}");
        }
        assert_eq!(judge(None, &limits), Verdict::NotRun);
    }

    #[test]
    fn five_values_cannot_tell_what_six_can() {
        let limits = Limits::from((3.0, 5.0));
        let of = |values: &[f64]| judge(Estimate::median(values), &limits);
        assert_eq!(of(&[4.0; 5]), Verdict::CannotBeTold);
        assert_eq!(of(&[4.0; 6]), Verdict::Agrees);
        assert_eq!(of(&[400.0; 5]), Verdict::CannotBeTold);
        assert_eq!(of(&[400.0; 6]), Verdict::Differs);
        // A number that is only shown has no limits that it could be on both sides of.
        let open = Limits::from((f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!(judge(Estimate::median(&[4.0]), &open), Verdict::Agrees);
    }

    proptest! {
        #[test]
        fn one_of_two_is_above_the_other_just_where_the_other_is_below_it(
            a in (-9.0f64..9.0, 0.0f64..3.0), b in (-9.0f64..9.0, 0.0f64..3.0),
        ) {
            let [a, b] = [a, b].map(|(low, width)| known(low, low + width));
            let above = judge(Some(a), &Limits::above(b));
            prop_assert_eq!(above, judge(Some(b), &Limits::below(a)));
            prop_assert_eq!(above == Verdict::Agrees, a.low > b.high);
            prop_assert_eq!(above == Verdict::Differs, a.high < b.low);
        }

        #[test]
        fn a_wider_interval_never_tells_more(
            low in -9.0f64..9.0, width in 0.0f64..5.0, more in 0.0f64..5.0,
            limit in -9.0f64..9.0, room in 0.0f64..5.0,
        ) {
            let limits = Limits::from((limit, limit + room));
            let narrow = judge(Some(known(low, low + width)), &limits);
            let wide = judge(Some(known(low - more, low + width + more)), &limits);
            prop_assert!(wide == narrow || wide == Verdict::CannotBeTold);
        }
    }
}
