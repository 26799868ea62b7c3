//! Gain, phase and delay margin of a loop L, continuous or sampled, with dead time.
//!
//! python-control's `stability_margins` finds crossovers as roots of polynomials. A dead time has no
//! polynomial, and for sampled loops with a short h the method fails. This module therefore scans the
//! frequency response itself, densely around the corners of poles and zeros, and bisects every change
//! of sign to the last bit. A response that only touches the unit circle or the real axis has no
//! crossover there.

use std::f64::consts::PI;

use nalgebra::Complex;
use thiserror::Error;

use crate::timebase::Timebase;
use crate::transfer::TransferFunction;

/// The margins of a loop, in python-control's order gm, pm, wpc, wgc, and the delay margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// `gm`: the gain factor nearest to 1 that brings L to -1; infinite if there is none.
    pub gain: f64,
    /// `pm` in degrees: the phase lag nearest to 0 that brings L to -1; infinite if there is none.
    pub phase_deg: f64,
    /// `wpc`: the frequency of `gain`, rad/s (NaN if there is none).
    pub phase_crossover_rad_s: f64,
    /// `wgc`: the frequency of `phase_deg`, rad/s (NaN if there is none).
    pub gain_crossover_rad_s: f64,
    /// The shortest additional dead time that brings L to -1, in seconds; infinite if there is none.
    /// For a loop that is stable without it, the least delay that makes it unstable.
    pub delay_s: f64,
}

/// A dead time for which margins cannot be found.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidDeadTime {
    /// The dead time is negative or not finite.
    #[error("the dead time is {dead_time_s} s; give a finite number of seconds, 0 or more")]
    Invalid {
        /// The dead time in seconds.
        dead_time_s: f64,
    },
    /// The phase turns too often below the highest frequency of interest to examine every turn.
    #[error(
        "a dead time of {dead_time_s} s turns the phase by {radians:.1e} rad below {end_rad_s} rad/s; shorten it"
    )]
    TooLong {
        /// The dead time in seconds.
        dead_time_s: f64,
        /// The highest frequency of interest.
        end_rad_s: f64,
        /// Dead time times frequency, in radians.
        radians: f64,
    },
}

/// Points per decade between corners: without a corner nearby a response bends over a whole decade.
const POINTS_PER_DECADE: f64 = 200.0;
/// The scan extends beyond the outermost corners by this factor; there the magnitude is a power law.
const BEYOND_CORNERS: f64 = 1e3;
/// Most decades by which the scan may grow to find an outer crossover: a gain of 10^30 has one there.
const MOST_DECADES: usize = 30;
/// Around each corner the points approach it to this power of ten of its frequency, so that lightly
/// damped resonances are found.
const CLOSEST_DECADES: i32 = 8;
/// Phase of the dead time between two points, rad: thirty points per turn.
const TURN_PER_POINT: f64 = 0.2;
/// The greatest phase of a dead time, rad (five million points, about a second).
const MOST_TURN: f64 = 1e6;

/// The margins of `system` followed by a dead time of `dead_time_s` seconds, in the loop with
/// negative feedback.
///
/// # Errors
/// [`InvalidDeadTime`] if the dead time is negative, not finite, or too long to follow its phase.
pub fn margins<T: Timebase>(
    system: &TransferFunction<T>,
    dead_time_s: f64,
) -> Result<Margins, InvalidDeadTime> {
    if !(dead_time_s.is_finite() && dead_time_s >= 0.0) {
        return Err(InvalidDeadTime::Invalid { dead_time_s });
    }
    let response = |omega: f64| {
        system.frequency_response(omega) * Complex::from_polar(1.0, -omega * dead_time_s)
    };
    let grid = grid(system);
    let gain_crossovers = crossings(grid.iter().copied(), |omega| response(omega).norm() - 1.0);

    let end_rad_s = end_of_interest(system, &grid, &gain_crossovers, dead_time_s);
    let radians = end_rad_s * dead_time_s;
    if radians > MOST_TURN {
        return Err(InvalidDeadTime::TooLong {
            dead_time_s,
            end_rad_s,
            radians,
        });
    }
    let fine = refined(&grid, end_rad_s, dead_time_s);
    let mut phase_crossovers = crossings(fine, |omega| response(omega).im);
    phase_crossovers.push(0.0);
    phase_crossovers.extend(system.timebase().nyquist_rad_s());
    phase_crossovers.retain(|omega| on_negative_axis(response(*omega)));

    let gain = phase_crossovers
        .into_iter()
        .map(|omega| (response(omega).norm().recip(), omega))
        .min_by(|a, b| a.0.ln().abs().total_cmp(&b.0.ln().abs()));
    let phases = gain_crossovers
        .iter()
        .map(|omega| (response(*omega).arg().to_degrees() + 180.0, *omega));
    let lags = phases
        .clone()
        .map(|(lead_deg, omega)| lead_deg.rem_euclid(360.0).to_radians() / omega);
    let phase = phases
        .map(|(lead_deg, omega)| ((lead_deg + 180.0).rem_euclid(360.0) - 180.0, omega))
        .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let absent = (f64::INFINITY, f64::NAN);
    let (gain, phase_crossover_rad_s) = gain.unwrap_or(absent);
    let (phase_deg, gain_crossover_rad_s) = phase.unwrap_or(absent);
    let delay_s = lags.fold(f64::INFINITY, f64::min);
    Ok(Margins {
        gain,
        phase_deg,
        phase_crossover_rad_s,
        gain_crossover_rad_s,
        delay_s,
    })
}

/// Whether a point where the imaginary part changes sign lies on the negative real axis. At a pole on
/// the frequency axis the sign changes through infinity instead.
fn on_negative_axis(l: Complex<f64>) -> bool {
    const ROUNDING: f64 = 1e-6;
    l.is_finite() && l.re < 0.0 && l.im.abs() <= ROUNDING * l.re.abs()
}

/// The frequencies to examine, in ascending order: evenly spaced on a log scale, and denser around
/// every corner.
fn grid<T: Timebase>(system: &TransferFunction<T>) -> Vec<f64> {
    let timebase = system.timebase();
    let mut corners: Vec<f64> = system
        .poles()
        .into_iter()
        .chain(system.zeros())
        .map(|root| timebase.corner_rad_s(root))
        .collect();
    corners.retain(|corner| corner.is_finite() && *corner > 0.0);
    let first = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let last = corners.iter().copied().fold(0.0, f64::max);
    let (first, last) = if corners.is_empty() {
        (1.0, 1.0)
    } else {
        (first, last)
    };

    let level = |omega: f64| system.frequency_response(omega).norm().ln();
    let low = walk(first / BEYOND_CORNERS, 0.1, level);
    let high = match timebase.nyquist_rad_s() {
        Some(nyquist) => nyquist,
        None => walk(last * BEYOND_CORNERS, 10.0, level),
    };
    let low = low.min(high / BEYOND_CORNERS);
    let points = ((high / low).log10() * POINTS_PER_DECADE).ceil();
    let mut grid: Vec<f64> = (0..=points as usize)
        .map(|i| low * (high / low).powf(i as f64 / points))
        .collect();
    for corner in corners {
        let steps = (1..=4 * CLOSEST_DECADES).map(|k| 10f64.powf(-f64::from(k) / 4.0));
        grid.extend(steps.flat_map(|step| [corner * (1.0 - step), corner * (1.0 + step)]));
    }
    grid.retain(|omega| (low..=high).contains(omega));
    grid.sort_by(f64::total_cmp);
    grid
}

/// Moves from an outermost frequency outward, decade by decade, as long as the magnitude approaches one.
fn walk(from: f64, factor: f64, level: impl Fn(f64) -> f64) -> f64 {
    // A smaller change per decade is no slope: a slope is at least one power of ten.
    const FLAT: f64 = 0.1;
    let mut omega = from;
    for _ in 0..MOST_DECADES {
        let (here, next) = (level(omega), level(omega * factor));
        let approaching = if here > 0.0 {
            next < here - FLAT
        } else {
            next > here + FLAT
        };
        if !approaching {
            break;
        }
        omega *= factor;
    }
    omega
}

/// Beyond the last corner and the last gain crossover the magnitude only falls. Of the many phase
/// crossovers that a dead time causes there, only the first can be the margin; two turns contain it.
fn end_of_interest<T: Timebase>(
    system: &TransferFunction<T>,
    grid: &[f64],
    gain: &[f64],
    dead_time_s: f64,
) -> f64 {
    let high = grid.last().copied().unwrap_or(0.0);
    if dead_time_s == 0.0 || system.timebase().nyquist_rad_s().is_some() {
        return high;
    }
    let last_corner = high / BEYOND_CORNERS;
    let last_gain = gain.last().copied().unwrap_or(0.0);
    (10.0 * last_corner).max(2.0 * last_gain) + 4.0 * PI / dead_time_s
}

/// The grid up to `end`, with each gap divided so finely that no turn of the dead time is missed.
fn refined(grid: &[f64], end: f64, dead_time_s: f64) -> impl Iterator<Item = f64> {
    let first = grid.first().copied().into_iter();
    let last = grid.last().copied().filter(|last| *last < end);
    let stretched = last.map(|last| [last, end]);
    let pairs = grid
        .windows(2)
        .map(|pair| [pair[0], pair[1]])
        .chain(stretched);
    let gaps = pairs
        .take_while(move |pair| pair[0] < end)
        .flat_map(move |[from, to]| {
            let to = to.min(end);
            let parts = ((to - from) * dead_time_s / TURN_PER_POINT).ceil().max(1.0);
            (1..=parts as usize).map(move |i| from + (to - from) * (i as f64 / parts))
        });
    first.chain(gaps)
}

/// Every zero of `f` between two neighbouring points with different signs.
fn crossings(points: impl Iterator<Item = f64>, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut found = Vec::new();
    let mut last: Option<(f64, f64)> = None;
    for omega in points {
        let value = f(omega);
        if value.is_nan() {
            continue;
        }
        if let Some((from, before)) = last.filter(|(_, before)| (*before < 0.0) != (value < 0.0)) {
            found.push(bisect(from, omega, before < 0.0, &f));
        }
        last = Some((omega, value));
    }
    found
}

fn bisect(mut from: f64, mut to: f64, starts_negative: bool, f: impl Fn(f64) -> f64) -> f64 {
    loop {
        let middle = from + (to - from) / 2.0;
        if middle <= from || middle >= to {
            return middle;
        }
        if (f(middle) < 0.0) == starts_negative {
            from = middle;
        } else {
            to = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timebase::{Continuous, Discrete};

    #[test]
    fn an_integrator_and_a_lag_have_the_margins_of_the_textbook() {
        // 1/(s(s+1)): |L| = 1 at w² = (sqrt 5 - 1)/2; the phase never reaches -180 degrees.
        let l = TransferFunction::try_new([1.0], [1.0, 1.0, 0.0], Continuous).expect("valid");
        let m = margins(&l, 0.0).expect("valid");
        let crossover = ((5f64.sqrt() - 1.0) / 2.0).sqrt();
        assert!((m.gain_crossover_rad_s - crossover).abs() < 1e-12);
        let phase_deg = 90.0 - crossover.atan().to_degrees();
        assert!((m.phase_deg - phase_deg).abs() < 1e-9);
        assert!((m.delay_s - phase_deg.to_radians() / crossover).abs() < 1e-10);
        assert!(m.gain.is_infinite() && m.phase_crossover_rad_s.is_nan());
    }

    #[test]
    fn an_integrator_with_dead_time_turns_over_at_a_quarter_turn() {
        // e^(-s T)/s: the phase is -180 degrees where w T = pi/2, and 1/w is the gain there. T =
        // 0.2: gm = pi/0.4.
        let l = TransferFunction::try_new([1.0], [1.0, 0.0], Continuous).expect("valid");
        let m = margins(&l, 0.2).expect("valid");
        assert!((m.gain - PI / 0.4).abs() < 1e-9);
        assert!((m.delay_s - (PI / 2.0 - 0.2)).abs() < 1e-9);
    }

    #[test]
    fn a_resonance_one_part_in_a_million_wide_is_not_overlooked() {
        // 1e-5/(s² + 2 z s + 1) with z = 1e-6 peaks at 1e-5/(2e-6) = 5: the unit circle is crossed
        // twice near w = 1.
        let l = TransferFunction::try_new([1e-5], [1.0, 2e-6, 1.0], Continuous).expect("valid");
        let m = margins(&l, 0.0).expect("valid");
        assert!((m.gain_crossover_rad_s - 1.0).abs() < 1e-5);
        // Past the peak, |L| = 1 where w² - 1 = sqrt(1e-10 - 4e-12), and there the phase is
        // asin(2e-6/1e-5) ahead of -180 degrees.
        assert!(
            (m.phase_deg - 0.2f64.asin().to_degrees()).abs() < 1e-3,
            "{}",
            m.phase_deg
        );
    }

    #[test]
    fn a_sampled_integrator_loses_its_margin_at_nyquist() {
        // h/(z - 1) is -h/2 at z = -1: the gain may grow by 2/h.
        let h = Discrete::try_new(0.5).expect("positive");
        let l = TransferFunction::try_new([0.5], [1.0, -1.0], h).expect("valid");
        let m = margins(&l, 0.0).expect("valid");
        assert!((m.gain - 4.0).abs() < 1e-12);
        assert!((m.phase_crossover_rad_s - PI / 0.5).abs() < 1e-12);
    }

    #[test]
    fn dead_times_that_are_none_or_endless_are_refused() {
        let l = TransferFunction::try_new([1.0], [1.0, 1.0, 0.0], Continuous).expect("valid");
        for dead_time_s in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                margins(&l, dead_time_s),
                Err(InvalidDeadTime::Invalid { .. })
            ));
        }
        assert!(matches!(
            margins(&l, 1e9),
            Err(InvalidDeadTime::TooLong { .. })
        ));
    }
}
