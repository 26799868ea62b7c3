//! Gain, phase and delay margin of a loop L, continuous or sampled, with dead time.
//!
//! python-control's `stability_margins` finds crossovers as roots of polynomials. A dead time has no
//! polynomial, and for sampled loops with a short h the coefficients lose all digits. This module therefore asks
//! the loop itself, frequency by frequency ([`crate::open_loop`]), and bisects every change of sign to the last
//! bit. A response that only touches the unit circle or the real axis has no crossover there.

use std::f64::consts::PI;

use nalgebra::Complex;
use thiserror::Error;

use crate::open_loop::OpenLoop;
use crate::scan::{Node, Scan, Unsure, level};

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

/// Why there are no margins.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidDeadTime {
    /// The dead time is negative or not finite.
    #[error("the dead time is {dead_time_s} s; give a finite number of seconds, 0 or more")]
    Invalid {
        /// The dead time in seconds.
        dead_time_s: f64,
    },
    /// The phase turns so often below the highest frequency of interest that its digits are lost.
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
    /// They cannot be known to the digits that would be printed.
    #[error(transparent)]
    Unsure(#[from] Unsure),
}

/// The greatest phase of a dead time, rad.
const MOST_TURN: f64 = 1e6;
/// A computation of which another that rounds differently differs by more than this part is not relied upon.
const MOST_DOUBT: f64 = 1e-6;

/// The margins of a loop followed by a dead time of `dead_time_s` seconds, with negative feedback. Of a loop with
/// two inputs and two outputs: what changes both channels at once.
///
/// # Errors
/// [`InvalidDeadTime`] if the dead time is negative, not finite, or too long to follow its phase, or if the
/// margins cannot be known to three digits.
pub fn margins(system: impl Into<OpenLoop>, dead_time_s: f64) -> Result<Margins, InvalidDeadTime> {
    if !(dead_time_s.is_finite() && dead_time_s >= 0.0) {
        return Err(InvalidDeadTime::Invalid { dead_time_s });
    }
    let of = system.into();
    let scan = Scan::new(&of, reach(&of, dead_time_s)?)?;
    of_scan(&scan, dead_time_s)
}

/// Of a continuous loop the dead time causes phase crossovers at all high frequencies, of which only the first
/// can be the margin; two turns beyond the last corner or gain crossover contain it.
fn reach(of: &OpenLoop, dead_time_s: f64) -> Result<f64, InvalidDeadTime> {
    let highest = of
        .corners()
        .iter()
        .fold(0.0, |most: f64, corner| most.max(corner.rad_s));
    let end_rad_s = of.nyquist_rad_s().unwrap_or(10.0 * highest);
    let radians = end_rad_s * dead_time_s;
    if radians > MOST_TURN {
        return Err(InvalidDeadTime::TooLong {
            dead_time_s,
            end_rad_s,
            radians,
        });
    }
    Ok(if dead_time_s > 0.0 && of.nyquist_rad_s().is_none() {
        end_rad_s + 4.0 * PI / dead_time_s
    } else {
        0.0
    })
}

/// The margins by a scan that is there.
pub(crate) fn of_scan(scan: &Scan<'_>, dead_time_s: f64) -> Result<Margins, InvalidDeadTime> {
    let dead_s = dead_time_s + scan.of.dead_time_s();
    let absent = (f64::INFINITY, f64::NAN);
    // Where L is that small, what rounding makes of it is no crossover.
    const FAINT: f64 = 1e9;
    let is_there = |&(gain, rad_s): &(f64, f64)| {
        gain < FAINT || rad_s == 0.0 || scan.of.doubt(rad_s) <= MOST_DOUBT
    };
    let (gain, phase_crossover_rad_s) = gain(scan, dead_s).filter(is_there).unwrap_or(absent);
    let leads = scan.crossovers.iter().map(|(node, locus)| {
        let angle = node.at.loci[*locus].arg() - node.rad_s * dead_s;
        (angle + PI, node.rad_s)
    });
    let lags = leads
        .clone()
        .map(|(lead, rad_s)| lead.rem_euclid(2.0 * PI) / rad_s);
    let delay_s = lags.fold(f64::INFINITY, f64::min);
    let phase = leads
        .map(|(lead, rad_s)| (((lead + PI).rem_euclid(2.0 * PI) - PI).to_degrees(), rad_s))
        .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let (phase_deg, gain_crossover_rad_s) = phase.unwrap_or(absent);
    let crossovers = scan.crossovers.iter().map(|(node, _)| node.rad_s);
    for rad_s in crossovers.chain(Some(phase_crossover_rad_s).filter(|x| *x > 0.0)) {
        let off = scan.of.doubt(rad_s);
        // A doubt that is no number is one.
        if off.is_nan() || off > MOST_DOUBT {
            return Err(Unsure::Rounding { rad_s, off }.into());
        }
    }
    Ok(Margins {
        gain,
        phase_deg,
        phase_crossover_rad_s,
        gain_crossover_rad_s,
        delay_s,
    })
}

/// A gap in which the phase passes -180 degrees, whole turns aside, and by how little the gain has to change there.
struct Passing {
    from: Node,
    to: Node,
    locus: usize,
    /// The odd number of half turns.
    half_turns: f64,
    least: f64,
}

/// The gain nearest to 1, and its frequency.
fn gain(scan: &Scan<'_>, dead_s: f64) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64)> = None;
    let mut consider = |l: Complex<f64>, rad_s: f64| {
        let off = level(l).abs();
        if off.is_finite() && best.is_none_or(|(gain, _)| off < gain.ln().abs()) {
            best = Some((l.norm().recip(), rad_s));
        }
        best.map_or(f64::INFINITY, |(gain, _)| gain.ln().abs())
    };
    for (l, rad_s) in at_the_ends(scan, dead_s) {
        consider(l, rad_s);
    }
    let mut passings = passings(scan, dead_s);
    passings.sort_by(|a, b| a.least.total_cmp(&b.least));
    let mut least = f64::INFINITY;
    for passing in passings {
        // Between two nodes the gain lies between theirs, but for its slight bend.
        const BEND: f64 = 0.05;
        if passing.least > least + BEND {
            break;
        }
        let angle = |node: &Node| turned(&passing.from, node, passing.locus, dead_s);
        let is_below = |node: &Node| angle(node) < passing.half_turns * PI;
        let starts = is_below(&passing.from);
        let found = scan.bisect(passing.from, passing.to, |node| is_below(node) == starts);
        if let Some(node) = found {
            let off = angle(&node) - passing.half_turns * PI;
            // At a pole on the axis the phase jumps past.
            if off.abs() < 1e-3 {
                least = consider(node.at.loci[passing.locus], node.rad_s);
            }
        }
    }
    best
}

/// The phase of a node that is close to `from`, without a jump between the two.
fn turned(from: &Node, node: &Node, locus: usize, dead_s: f64) -> f64 {
    let (a, b) = (from.at.loci[locus], node.at.loci[locus]);
    a.arg() - from.rad_s * dead_s + (b / a).arg() - (node.rad_s - from.rad_s) * dead_s
}

/// The gaps in which the phase passes an odd number of half turns: the first and the last time in each.
fn passings(scan: &Scan<'_>, dead_s: f64) -> Vec<Passing> {
    let mut found = Vec::new();
    let mut add = |from: Node, to: Node, locus: usize| {
        let [a, b] = [from, to].map(|node| node.at.loci[locus]);
        if a.norm() == 0.0 || b.norm() == 0.0 {
            return;
        }
        let (start, end) = (
            turned(&from, &from, locus, dead_s),
            turned(&from, &to, locus, dead_s),
        );
        let (low, high) = (start.min(end) / PI, start.max(end) / PI);
        let first = 2.0 * ((low - 1.0) / 2.0).ceil() + 1.0;
        let last = 2.0 * ((high - 1.0) / 2.0).floor() + 1.0;
        if first > last {
            return;
        }
        let least = level(a).abs().min(level(b).abs());
        for half_turns in [first, last] {
            found.push(Passing {
                from,
                to,
                locus,
                half_turns,
                least,
            });
        }
    };
    for pair in scan.nodes.windows(2) {
        if let Some([a, b]) = pair.first_chunk::<2>() {
            for locus in 0..2 {
                add(*a, *b, locus);
            }
        }
    }
    for trio in scan.nodes.windows(3) {
        if let Some([a, b, c]) = trio.first_chunk::<3>() {
            for locus in 0..2 {
                if let Some(top) = turning(scan, [*a, *b, *c], locus, dead_s) {
                    add(*a, top, locus);
                    add(top, *c, locus);
                }
            }
        }
    }
    found
}

/// Where the phase turns back close to an odd number of half turns that no node reaches.
fn turning(scan: &Scan<'_>, [a, b, c]: [Node; 3], locus: usize, dead_s: f64) -> Option<Node> {
    const CLOSE_RAD: f64 = 0.1;
    let [x, y, z] = [a, b, c].map(|node| turned(&a, &node, locus, dead_s));
    let sign = match (y - x, z - y) {
        (up, down) if up > 0.0 && down < 0.0 => 1.0,
        (down, up) if down < 0.0 && up > 0.0 => -1.0,
        _ => return None,
    };
    let odd = 2.0 * ((y / PI - 1.0) / 2.0).round() + 1.0;
    if (y - odd * PI).abs() > CLOSE_RAD {
        return None;
    }
    let top = scan.extremum((a, c), |node| sign * turned(&a, node, locus, dead_s))?;
    let is_past = |node: &Node| sign * (turned(&a, node, locus, dead_s) - odd * PI) > 0.0;
    (is_past(&top) && ![a, b, c].iter().any(is_past)).then_some(top)
}

/// L at frequency 0 and at the highest there is, where it is a negative number.
fn at_the_ends(scan: &Scan<'_>, dead_s: f64) -> Vec<(Complex<f64>, f64)> {
    let mut ends = Vec::new();
    // With an integrator there is no gain at 0.
    const SAME: f64 = 0.5;
    if let (Some(first), Some(rest)) = (scan.nodes.first(), scan.of.at(0.0)) {
        for l in rest.loci {
            let is_near = |other: &Complex<f64>| (l / other - 1.0).norm() < SAME;
            if first.at.loci.iter().any(is_near) {
                ends.push((l, 0.0));
            }
        }
    }
    if let (Some(last), Some(_)) = (scan.nodes.last(), scan.of.nyquist_rad_s()) {
        let later = Complex::from_polar(1.0, -last.rad_s * dead_s);
        ends.extend(last.at.loci.map(|l| (l * later, last.rad_s)));
    }
    ends.retain(|(l, _)| on_negative_axis(*l));
    ends
}

fn on_negative_axis(l: Complex<f64>) -> bool {
    const ROUNDING: f64 = 1e-6;
    l.is_finite() && l.re < 0.0 && l.im.abs() <= ROUNDING * l.re.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timebase::{Continuous, Discrete};
    use crate::transfer::TransferFunction;

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
