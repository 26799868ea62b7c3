//! Whether a loop is stable, judged by one response of finite length.
//!
//! Near its margin a loop rings for a long time whether it is stable or not, so settling is no criterion. The
//! criterion is whether its error dies out: over half of the run the slowest mode of a stable loop has
//! shrunk, that of an unstable one has grown. The error of the paper's loop, one sample of 1 ms from its
//! margin, changes by 4.5 % a second, that is by a fifth over half of ten seconds.
//!
//! With a link that varies, the same holds for the mean error: at rest a delay changes nothing, so
//! what a stall or a loss adds is proportional to the error at that time.

/// A response within this part of the reference has settled, and growth there means nothing; rounding
/// noise lies there too.
const BAND: f64 = 0.02;
/// An error that dies out loses at least this part of itself, so that a lasting oscillation does not.
const LOSS: f64 = 0.01;
/// A response is divided into four parts. The first contains the step itself; the third separates the
/// two parts that are compared.
const PARTS: usize = 4;

/// The largest error in the last quarter of the response over that in its second quarter: below 1 the
/// error dies out. Infinite if the response is no longer finite, or if there was no error in the
/// second quarter.
///
/// `None` if the response is too short to be divided into four.
#[must_use]
pub fn growth(y: &[f64], r: f64) -> Option<f64> {
    let (early, late) = errors(y, r)?;
    match late.is_finite() {
        true if late == 0.0 => Some(0.0),
        true => Some(late / early),
        false => Some(f64::INFINITY),
    }
}

/// Whether the error of a step response `y` to `r` dies out: its last quarter lies within 2 % of the
/// reference, or [`growth`] is at most 0.99. A response that is too short counts as not stable.
#[must_use]
pub fn is_stable(y: &[f64], r: f64) -> bool {
    errors(y, r).is_some_and(|(early, late)| {
        late.is_finite() && (late < BAND * r.abs() || late <= (1.0 - LOSS) * early)
    })
}

/// The largest errors in the second and in the last quarter; infinite if a value is not finite.
fn errors(y: &[f64], r: f64) -> Option<(f64, f64)> {
    if y.len() < PARTS {
        return None;
    }
    let worst = |part: usize| {
        let part = &y[y.len() * part / PARTS..y.len() * (part + 1) / PARTS];
        let errors = part.iter().map(|y| (y - r).abs());
        errors.fold(0.0, |worst: f64, e| {
            if e.is_finite() {
                worst.max(e)
            } else {
                f64::INFINITY
            }
        })
    };
    Some((worst(1), worst(PARTS - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ringing(rate_per_s: f64, rad_s: f64, s: f64) -> Vec<f64> {
        let h_s = 0.001;
        (0..(s / h_s) as usize)
            .map(|k| k as f64 * h_s)
            .map(|t| 1.0 - (rate_per_s * t).exp() * (rad_s * t).cos())
            .collect()
    }

    proptest! {
        #[test]
        fn what_rings_and_dies_out_is_stable_and_what_grows_is_not(
            rate_per_s in 0.01_f64..2.0,
            rad_s in 5.0_f64..60.0,
            s in 10.0_f64..30.0,
        ) {
            prop_assert!(is_stable(&ringing(-rate_per_s, rad_s, s), 1.0));
            prop_assert!(!is_stable(&ringing(rate_per_s, rad_s, s), 1.0));
        }
    }

    #[test]
    fn a_lasting_oscillation_is_not_stable_and_what_has_settled_is() {
        assert!(!is_stable(&ringing(0.0, 10.0, 10.0), 1.0));
        let settled: Vec<f64> = (0..1000).map(|k| 1.0 + 0.01 * f64::from(k % 2)).collect();
        assert!(is_stable(&settled, 1.0));
    }

    #[test]
    fn what_leaves_the_numbers_is_not_stable_and_what_is_too_short_not_shown_to_be() {
        let mut gone = vec![1.0; 100];
        gone[90] = f64::NAN;
        assert!(!is_stable(&gone, 1.0));
        assert_eq!(growth(&gone, 1.0), Some(f64::INFINITY));
        assert!(!is_stable(&[1.0, 1.0], 1.0));
        assert_eq!(growth(&[1.0], 1.0), None);
        assert_eq!(growth(&[1.0; 8], 1.0), Some(0.0));
    }
}
