//! The figures of a step response, with the names and definitions of python-control's `step_info`
//! (0.10).
//!
//! Times are those of samples, without interpolation, and t counts from the caller's start.

use thiserror::Error;

/// When a response counts as risen and as settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// Python's `RiseTimeLimits`: the rise is timed between these parts of the final value.
    pub rise_limits: (f64, f64),
    /// Python's `SettlingTimeThreshold`: half the width of the band, as a part of the final value.
    pub settling_threshold: f64,
    /// Python's `yfinal`; `None` uses the last sample.
    pub final_value: Option<f64>,
}

/// 10 to 90 %, 2 %, and the last sample: python-control's defaults.
impl Default for StepSettings {
    fn default() -> Self {
        Self {
            rise_limits: (0.1, 0.9),
            settling_threshold: 0.02,
            final_value: None,
        }
    }
}

/// The figures. A figure that does not exist is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepInfo {
    /// `RiseTime`: from the first sample at 10 % to the first at 90 % of the final value. NaN if it
    /// never gets there (python-control raises an `IndexError`).
    pub rise_time: f64,
    /// `SettlingTime`: the first time from which every sample is within 2 % of the final value; NaN
    /// if even the last sample is not.
    pub settling_time: f64,
    /// `SettlingMin`: the smallest of the final value and the samples after the rise.
    pub settling_min: f64,
    /// `SettlingMax`: the largest of the final value and the samples after the rise.
    pub settling_max: f64,
    /// `Overshoot`: how far the response exceeds the final value, in percent of it.
    pub overshoot: f64,
    /// `Undershoot`: how far it goes to the other side of zero, in percent of the final value.
    pub undershoot: f64,
    /// `Peak`: the largest magnitude.
    pub peak: f64,
    /// `PeakTime`: when the peak is first reached.
    pub peak_time: f64,
    /// `SteadyStateValue`: the final value.
    pub steady_state_value: f64,
}

/// A series that is not a response.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidResponse {
    /// There are no samples.
    #[error("the response has no samples")]
    Empty,
    /// There is not one value for each time.
    #[error("{t} times but {y} values; there must be one value for each time")]
    Lengths {
        /// Number of times.
        t: usize,
        /// Number of values.
        y: usize,
    },
    /// A value is not a number.
    #[error("sample {index} is not a number")]
    NotANumber {
        /// Index in the series, from 0.
        index: usize,
    },
}

/// The figures of the response `y` at the times `t` (seconds, or any unit; the figures use the same).
///
/// As in python-control, if the final value is infinite or not a number, every figure is NaN and the peak and
/// its time are infinite. Unlike in python-control, a final value that is given as 0 is used.
///
/// # Errors
/// [`InvalidResponse`] if there are no samples, the lengths differ, or a value is not a number.
pub fn step_info(
    t: &[f64],
    y: &[f64],
    settings: &StepSettings,
) -> Result<StepInfo, InvalidResponse> {
    if t.len() != y.len() {
        return Err(InvalidResponse::Lengths {
            t: t.len(),
            y: y.len(),
        });
    }
    if let Some(index) = t.iter().position(|t| t.is_nan()) {
        let before = y.iter().take(index).position(|y| y.is_nan());
        return Err(InvalidResponse::NotANumber {
            index: before.unwrap_or(index),
        });
    }
    figures(|k| t.get(k).copied().unwrap_or(f64::NAN), y, settings)
}

/// The figures of a response sampled every `h`, from time 0 on; times have the unit of `h`. See
/// [`step_info`].
///
/// # Errors
/// [`InvalidResponse`] if there are no samples, or a value is not a number.
pub fn sampled_step_info(
    h: f64,
    y: &[f64],
    settings: &StepSettings,
) -> Result<StepInfo, InvalidResponse> {
    figures(|k| k as f64 * h, y, settings)
}

/// The figures of `y`, whose sample k was taken at `t(k)`.
fn figures(
    t: impl Fn(usize) -> f64,
    y: &[f64],
    settings: &StepSettings,
) -> Result<StepInfo, InvalidResponse> {
    // Without a way out of the loop it is several times as fast, and nearly always there is no such value.
    if y.iter().fold(false, |any, y| any | y.is_nan()) {
        let index = y.iter().position(|y| y.is_nan()).unwrap_or_default();
        return Err(InvalidResponse::NotANumber { index });
    }
    let last = *y.last().ok_or(InvalidResponse::Empty)?;
    let end = settings.final_value.unwrap_or(last);
    if !end.is_finite() {
        return Ok(StepInfo::nowhere());
    }
    let sign = if end == 0.0 { 0.0 } else { end.signum() };
    let reached = |part: f64| y.iter().position(|y| sign * (y - part * end) >= 0.0);
    let (low, high) = settings.rise_limits;
    let (lower, upper) = (reached(low), reached(high));
    let rise_time = lower
        .zip(upper)
        .map_or(f64::NAN, |(from, to)| t(to) - t(from));
    let (settling_min, settling_max) = upper.map_or((f64::NAN, f64::NAN), |from| {
        let after = &y[from..];
        (
            end.min(-greatest(after, |y| -y)),
            end.max(greatest(after, |y| y)),
        )
    });
    let inside = settled_from(y, end, settings.settling_threshold);
    let settling_time = if inside < y.len() {
        t(inside)
    } else {
        f64::NAN
    };
    let peak = greatest(y, f64::abs);
    let peak_at = y.iter().position(|y| y.abs() == peak).unwrap_or_default();
    let peak_time = t(peak_at);
    let (overshoot, undershoot) = overshoots(y, end, sign);
    Ok(StepInfo {
        rise_time,
        settling_time,
        settling_min,
        settling_max,
        overshoot,
        undershoot,
        peak,
        peak_time,
        steady_state_value: end,
    })
}

/// The number of the first sample from which on all are within the threshold of the final value.
fn settled_from(y: &[f64], end: f64, threshold: f64) -> usize {
    // Most samples are so well inside that the quotient, whose division takes most of the time, is too, however
    // it is rounded.
    let is_plain = threshold > 1e-6 && end.abs() > 1e-200;
    let well_inside = if is_plain {
        0.99 * threshold * end.abs()
    } else {
        -1.0
    };
    let outside = y
        .iter()
        .rposition(|y| (y - end).abs() > well_inside && (y / end - 1.0).abs() >= threshold);
    outside.map_or(0, |last| last + 1)
}

/// The overshoot and the undershoot, in percent of the final value, which has this sign.
fn overshoots(y: &[f64], end: f64, sign: f64) -> (f64, f64) {
    // In the direction of the final value.
    let (highest, lowest) = (greatest(y, |y| sign * y), -greatest(y, |y| -(sign * y)));
    let beyond = highest.abs() - end.abs();
    let overshoot = if beyond > 0.0 {
        (100.0 * beyond / end).abs()
    } else {
        0.0
    };
    let undershoot = if lowest < 0.0 {
        -100.0 * lowest / end.abs()
    } else {
        0.0
    };
    (overshoot, undershoot)
}

/// The greatest of a figure of all samples, without those for which it is no number; of none, negative infinity.
pub fn greatest(y: &[f64], figure: impl Fn(f64) -> f64) -> f64 {
    /// Greatest values are kept side by side, so that none waits for the one before.
    const LANES: usize = 8;
    let larger = |most: f64, y: f64| if y > most { y } else { most };
    let (parts, rest) = y.as_chunks::<LANES>();
    let mut most = [f64::NEG_INFINITY; LANES];
    for part in parts {
        for (most, y) in most.iter_mut().zip(part) {
            *most = larger(*most, figure(*y));
        }
    }
    let rest = rest.iter().map(|y| figure(*y));
    most.into_iter().chain(rest).fold(f64::NEG_INFINITY, larger)
}

impl StepInfo {
    fn nowhere() -> Self {
        let nan = f64::NAN;
        Self {
            rise_time: nan,
            settling_time: nan,
            settling_min: nan,
            settling_max: nan,
            overshoot: nan,
            undershoot: nan,
            peak: f64::INFINITY,
            peak_time: f64::INFINITY,
            steady_state_value: nan,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_response_worked_out_by_hand() {
        // Final value 1: 10 % at t = 1, 90 % at t = 3, 20 % overshoot at t = 4, within 2 % from t = 6 on.
        let t = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let y = [-0.05, 0.2, 0.6, 0.95, 1.2, 0.97, 1.01, 1.0];
        let info = step_info(&t, &y, &StepSettings::default()).expect("valid");
        assert_eq!((info.rise_time, info.settling_time), (2.0, 6.0));
        assert_eq!((info.settling_min, info.settling_max), (0.95, 1.2));
        assert!((info.overshoot - 20.0).abs() < 1e-12 && (info.undershoot - 5.0).abs() < 1e-12);
        assert_eq!(
            (info.peak, info.peak_time, info.steady_state_value),
            (1.2, 4.0, 1.0)
        );
    }

    #[test]
    fn a_response_that_never_arrives_has_no_rise_and_no_settling() {
        let settings = StepSettings {
            final_value: Some(1.0),
            ..StepSettings::default()
        };
        let info = step_info(&[0.0, 1.0], &[0.0, 0.5], &settings).expect("valid");
        assert!(
            info.rise_time.is_nan() && info.settling_time.is_nan() && info.settling_min.is_nan()
        );
        assert_eq!((info.overshoot, info.peak), (0.0, 0.5));
    }

    #[test]
    fn a_response_that_leaves_the_numbers_has_no_figures_and_an_infinite_peak() {
        let info =
            step_info(&[0.0, 1.0], &[0.0, f64::INFINITY], &StepSettings::default()).expect("valid");
        assert!(info.overshoot.is_nan() && info.steady_state_value.is_nan());
        assert_eq!(info.peak, f64::INFINITY);
    }

    #[test]
    fn series_that_are_no_response_are_refused() {
        let settings = StepSettings::default();
        assert_eq!(step_info(&[], &[], &settings), Err(InvalidResponse::Empty));
        assert_eq!(
            step_info(&[0.0], &[], &settings),
            Err(InvalidResponse::Lengths { t: 1, y: 0 })
        );
        assert_eq!(
            step_info(&[0.0], &[f64::NAN], &settings),
            Err(InvalidResponse::NotANumber { index: 0 })
        );
    }
}
