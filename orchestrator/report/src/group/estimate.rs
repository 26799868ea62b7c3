//! Estimates other than medians: of a single value, a share, a mean, or a ratio of two others.

use super::Estimate;

/// 95 % of a normal distribution lie within this many standard deviations.
const NORMAL_95: f64 = 1.96;

impl Estimate {
    /// A number that needs no interval: a count, or a value of the very run that the claim is about.
    /// It is based on `n` rows.
    pub fn exact(value: f64, n: u64) -> Estimate {
        Estimate {
            value,
            low: value,
            high: value,
            n,
        }
    }

    /// `part` divided by `whole`, with its 95 % interval by Wilson's score, which stays between 0 and
    /// 1 and is not empty if `part` is 0 or `whole`.
    ///
    /// Assumes that the counted events are independent. `None` if `whole` is 0.
    pub fn share(part: u64, whole: u64) -> Option<Estimate> {
        let n = whole as f64;
        let value = analysis::statistics::share(part, whole)?;
        let z2 = NORMAL_95 * NORMAL_95;
        let middle = (value + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half =
            NORMAL_95 / (1.0 + z2 / n) * (value * (1.0 - value) / n + z2 / (4.0 * n * n)).sqrt();
        let ends = (
            (middle - half).clamp(0.0, value),
            (middle + half).clamp(value, 1.0),
        );
        Some(Estimate::within(value, ends, whole))
    }

    /// The values of single runs, from the least to the greatest, with their median. A claim about
    /// what one run did is compared with each run: nothing is inferred, so one run is enough. `None`
    /// without runs.
    pub fn of_each(values: &[f64]) -> Option<Estimate> {
        let median = Estimate::median(values)?;
        Some(Estimate {
            low: values.iter().copied().fold(f64::INFINITY, f64::min),
            high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ..median
        })
    }

    /// A mean with its 95 % interval from the standard deviation of `n` independent values.
    pub fn mean(value: f64, sd: f64, n: u64) -> Estimate {
        Estimate::around(value, NORMAL_95 * sd / (n.max(1) as f64).sqrt(), n)
    }

    /// A value with half the width of its interval.
    pub fn around(value: f64, half: f64, n: u64) -> Estimate {
        Estimate::within(value, (value - half, value + half), n)
    }

    /// The ratio of two positive estimates, from the least quotient of their ends to the greatest. If
    /// both intervals are 95 % certain, the ratio's is at least 90 % certain, and mostly more, since
    /// large errors seldom coincide. Unlike a bootstrap, it needs no randomness.
    ///
    /// It has no interval if one of the two has none. `None` if `that` is zero or infinite.
    pub fn times(self, that: Estimate) -> Option<Estimate> {
        (that.value.is_finite() && that.value > 0.0).then(|| self.over(that))
    }

    fn over(self, that: Estimate) -> Estimate {
        let value = self.value / that.value;
        let (low, high) = if self.has_interval() && that.has_interval() {
            (self.low / that.high, self.high / that.low)
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        Estimate {
            value,
            low,
            high,
            n: self.n.min(that.n),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::INTERVAL_MIN;
    use proptest::prelude::*;

    #[test]
    fn wilson_s_interval_is_the_textbooks() {
        let none = Estimate::share(0, 10).expect("ten");
        assert_eq!((none.value, none.low), (0.0, 0.0));
        assert!((none.high - 0.2775).abs() < 1e-3, "{none:?}");
        let half = Estimate::share(5, 10).expect("ten");
        assert!((half.low - 0.2366).abs() < 1e-3 && (half.high - 0.7634).abs() < 1e-3);
        assert_eq!(Estimate::share(0, 0), None);
    }

    #[test]
    fn a_quotient_of_what_has_no_interval_has_none() {
        let few = Estimate::median(&[1.0, 2.0]).expect("two");
        let many = Estimate::around(3.0, 1.0, 20);
        for quotient in [few.over(many), many.over(few)] {
            assert!(
                quotient.value > 0.0 && !quotient.has_interval(),
                "{quotient:?}"
            );
        }
    }

    proptest! {
        #[test]
        fn a_share_lies_in_its_interval_unless_it_is_of_too_few_for_one(part in 0u64..1000, more in 0u64..1000) {
            if let Some(share) = Estimate::share(part, part + more) {
                prop_assert_eq!(share.has_interval(), share.n >= INTERVAL_MIN);
                prop_assert!(share.low <= share.value && share.value <= share.high);
                prop_assert!(!share.has_interval() || 0.0 <= share.low && share.high <= 1.0);
            }
        }

        #[test]
        fn a_quotient_s_interval_holds_the_quotient_of_any_two_inside(
            a in (1.0f64..9.0, 0.0f64..0.9), b in (1.0f64..9.0, 0.0f64..0.9), at in (0.0f64..1.0, 0.0f64..1.0),
        ) {
            let [over, under] = [a, b].map(|(value, half)| Estimate::around(value, half, 6));
            let between = |e: Estimate, t: f64| e.low + t * (e.high - e.low);
            let quotient = between(over, at.0) / between(under, at.1);
            let whole = over.over(under);
            prop_assert!(whole.low <= quotient + 1e-12 && quotient <= whole.high + 1e-12);
        }
    }
}
