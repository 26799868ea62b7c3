//! The loop with a constant delay in ticks: its step response, and the longest round trip at which it
//! is stable.
//!
//! A network can only make these results worse. Variable delays, lost or reordered messages, and the
//! two clocks are left to the ends that run the loop.

use std::collections::VecDeque;
use std::num::NonZeroUsize;

use crate::law::Law;
use crate::margin::{InvalidDeadTime, Margins, of_scan};
use crate::open_loop::OpenLoop;
use crate::plant::SampledPlant;
use crate::scan::{Scan, Unsure};
use crate::signals::Signals;
use crate::winding::unstable_poles;

/// Number of ticks from a plant output to the first output that depends on a command computed from
/// it, if every message has the same round trip and both ends run every `h_ns`.
///
/// The controller sends at each of its deadlines and computes from its newest answer. An answer is
/// ceil(RTT/h) deadlines old when it is used, and at least one, since no message can use its own
/// answer. The command then waits for the plant's next tick. The sum is ceil(RTT/h) + 1, whatever the
/// phase between the two ends and however the round trip is divided between the directions.
///
/// # Panics
/// If `h_ns` is 0.
#[must_use]
pub fn loop_delay_ticks(rtt_ns: u64, h_ns: u64) -> NonZeroUsize {
    let ticks = rtt_ns.div_ceil(h_ns).max(1).saturating_add(1);
    NonZeroUsize::new(usize::try_from(ticks).unwrap_or(usize::MAX)).unwrap_or(NonZeroUsize::MAX)
}

/// The first `ticks` values of the first output of `plant`, from rest, under `law` with reference `r`, if each
/// command is computed from the outputs `delay` ticks earlier (from 0 before the first).
#[must_use]
pub fn step_response(
    plant: &SampledPlant,
    law: impl Into<Law>,
    r: f64,
    delay: NonZeroUsize,
    ticks: usize,
) -> Vec<f64> {
    let h_s = plant.h_s();
    let rest = Signals::zeros(plant.system.outputs());
    let (mut plant, mut law) = (plant.stepper(), law.into());
    // The outputs that the controller has not yet received, oldest first; 0 before the start.
    let mut under_way = VecDeque::from(vec![rest; delay.get().min(ticks)]);
    let mut response = Vec::with_capacity(ticks);
    while let Some(seen) = under_way.pop_front() {
        if response.len() == ticks {
            break;
        }
        let y = plant.step_all(law.update(r, seen, h_s));
        under_way.push_back(y);
        response.push(y.first);
    }
    response
}

/// The longest constant round trip, in seconds, at which the loop is stable, as at every shorter one:
/// a multiple of h, by [`loop_delay_ticks`]. `system` is plant and controller in series, both with h.
///
/// Infinite if no delay can make the loop unstable. `None` if not even the shortest round trip (two
/// ticks) can be shown to be stable.
#[must_use]
pub fn largest_stable_round_trip_s(system: impl Into<OpenLoop>) -> Option<f64> {
    Analysis::of(&system.into())
        .ok()
        .and_then(|found| found.longest_s)
}

/// What is computed of a sampled loop: margins, and the longest round trip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Analysis {
    /// The margins of the loop without a network, which itself takes two ticks.
    pub margins: Margins,
    /// The longest constant round trip at which the loop is stable, as at every shorter one, in seconds;
    /// infinite if none makes it unstable, `None` if it is unstable even at the shortest.
    pub longest_s: Option<f64>,
}

impl Analysis {
    /// Ticks around a loop without a network: two free-running ends.
    pub const SHORTEST_TICKS: usize = 2;

    /// Stability with two ticks and on both sides of the border is by the number of closed-loop poles outside the
    /// unit circle. Between them the delay margin is exact, since stability can only be lost where the delayed
    /// loop passes through -1. Beyond it a whole tick may hold again, if a pole that left at a fraction of it is back
    /// before: the border is the first whole tick that does not hold. If the gain at the Nyquist frequency is one or
    /// more, each further tick changes the sign of the response there, so no two consecutive delays are stable.
    ///
    /// # Errors
    /// [`InvalidDeadTime`] if the figures cannot be known to three digits.
    pub fn of(system: &OpenLoop) -> Result<Self, InvalidDeadTime> {
        let h_s = system.h_s().ok_or(Unsure::Border)?;
        let scan = Scan::new(system, 0.0)?;
        let margins = of_scan(&scan, Self::SHORTEST_TICKS as f64 * h_s)?;
        Ok(Self {
            margins,
            longest_s: longest_s(&scan, margins.delay_s, h_s)?,
        })
    }
}

/// So many times stability may be lost and be back between two whole ticks; then the longest that was shown counts.
const MOST_RETURNS: usize = 1000;
/// Ticks that are counted to the last one; a longer delay is said to be as long as these.
const MOST_TICKS: f64 = 1e15;
/// A delay as near as this part of it to one that puts a pole on the circle has it there.
const ON_CIRCLE: f64 = 1e-9;

fn longest_s(scan: &Scan<'_>, delay_s: f64, h_s: f64) -> Result<Option<f64>, InvalidDeadTime> {
    let shortest = Analysis::SHORTEST_TICKS;
    // With a pole on the border itself the loop is not stable.
    let is_stable = |ticks| match unstable_poles(scan, ticks) {
        Ok(count) => Ok(count == 0),
        Err(Unsure::Border) => Ok(false),
        Err(other) => Err(other),
    };
    if scan.of.grows_unseen() || !is_stable(shortest)? {
        return Ok(None);
    }
    let at_nyquist = scan.nodes.last().map(|node| node.at.loci);
    if at_nyquist.is_some_and(|loci| loci.iter().any(|l| l.norm() >= 1.0)) {
        return Ok(Some((shortest as f64 - 1.0) * h_s));
    }
    if !delay_s.is_finite() {
        return Ok(Some(f64::INFINITY));
    }
    // A further delay of exactly the margin leaves a pole on the unit circle, so that tick does not count.
    let mut further = ((delay_s / h_s).ceil() - 1.0).clamp(0.0, MOST_TICKS) as usize;
    let mut nearer = 0;
    while further > 0 && !is_stable(shortest + further)? {
        nearer += 1;
        if nearer > MOST_RETURNS {
            return Err(Unsure::Border.into());
        }
        further -= 1;
    }
    let own_s = scan.of.dead_time_s() + shortest as f64 * h_s;
    let mut lost_s = delay_s;
    for _ in 0..MOST_RETURNS {
        let next = further.saturating_add(1);
        let next_s = next as f64 * h_s;
        if next_s - lost_s <= ON_CIRCLE * next_s || !is_stable(shortest.saturating_add(next))? {
            break;
        }
        // Until a further delay puts a pole on the circle again, nothing changes.
        lost_s = next_crossing_s(scan, own_s, next_s);
        let ticks = (lost_s / h_s).ceil().min(MOST_TICKS) as usize;
        further = next.max(ticks.saturating_sub(1));
    }
    let longest = further.saturating_add(shortest - 1);
    Ok(Some(longest as f64 * h_s))
}

/// The least further delay beyond `after_s` at which a loop that waits `own_s` has a pole on the unit circle.
fn next_crossing_s(scan: &Scan<'_>, own_s: f64, after_s: f64) -> f64 {
    use std::f64::consts::PI;
    let crossings = scan.crossovers.iter().map(|(node, locus)| {
        let lead = node.at.loci[*locus].arg() - node.rad_s * own_s + PI;
        let beyond = (lead - node.rad_s * after_s).rem_euclid(2.0 * PI);
        after_s + beyond / node.rad_s
    });
    crossings.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial::{is_schur_stable, sum};
    use crate::preset::{
        BARE_SETTLING_1MS_S, BARE_SETTLING_3MS_S, paper_gains, paper_pi, paper_plant,
    };
    use crate::step_info::{StepSettings, step_info};
    use crate::timebase::Discrete;
    use crate::transfer::TransferFunction;

    /// Whether all poles of the closed loop, the roots of den(z) z^ticks + num(z), lie inside the unit circle.
    fn is_stable_with_delay(system: &TransferFunction<Discrete>, ticks: usize) -> bool {
        let mut delayed = system.den().to_vec();
        delayed.resize(delayed.len() + ticks, 0.0);
        is_schur_stable(&sum(&delayed, system.num()))
    }

    fn plant(h_s: f64) -> SampledPlant {
        paper_plant()
            .sampled((h_s * 1e9).round() as u64)
            .expect("stable, so never singular")
    }

    fn paper_loop(h_s: f64) -> TransferFunction<Discrete> {
        plant(h_s)
            .transfer_function()
            .expect("finite")
            .series(&paper_gains().sampled(h_s).expect("finite"))
            .expect("the same h")
    }

    #[test]
    fn the_delay_of_the_loop_counts_deadlines_and_one_tick() {
        let ticks = |rtt_ns| loop_delay_ticks(rtt_ns, 3_000_000).get();
        assert_eq!(
            [0, 1, 3_000_000, 3_000_001, 53_000_000].map(ticks),
            [2, 2, 2, 3, 19]
        );
    }

    #[test]
    fn the_longest_stable_round_trip_of_the_paper_is_where_jury_s_test_turns() {
        // 96 ms at 1 kHz and 93 ms at 333 Hz: numpy's roots of the closed loop's polynomial give the
        // same (fixtures).
        for (h_s, longest_s) in [(0.001, 0.096), (0.003, 0.093)] {
            let system = paper_loop(h_s);
            let found_s = largest_stable_round_trip_s(&system).expect("the paper's loop is stable");
            assert!(
                (found_s - longest_s).abs() < 1e-12,
                "{found_s} s at h = {h_s} s"
            );
            let ticks = (found_s / h_s).round() as usize + 1;
            assert!((2..=ticks).all(|ticks| is_stable_with_delay(&system, ticks)));
            assert!(!is_stable_with_delay(&system, ticks + 1));
        }
    }

    #[test]
    fn the_bare_loop_of_the_paper_settles_as_its_constants_say() {
        let delay = NonZeroUsize::new(2).expect("not 0");
        for (h_s, settling_s) in [(0.001, BARE_SETTLING_1MS_S), (0.003, BARE_SETTLING_3MS_S)] {
            let y = step_response(&plant(h_s), paper_pi(), 1.0, delay, (3.0 / h_s) as usize);
            let t: Vec<f64> = (0..y.len()).map(|k| k as f64 * h_s).collect();
            let to_one = StepSettings {
                final_value: Some(1.0),
                ..StepSettings::default()
            };
            let info = step_info(&t, &y, &to_one).expect("finite");
            assert!((info.settling_time - settling_s).abs() < 1e-9, "{info:?}");
        }
    }

    #[test]
    fn a_loop_whose_gain_never_reaches_one_survives_every_delay() {
        let h = Discrete::try_new(0.01).expect("positive");
        let quiet = TransferFunction::try_new([0.05], [1.0, -0.9], h).expect("valid");
        assert_eq!(largest_stable_round_trip_s(&quiet), Some(f64::INFINITY));
        let loud = TransferFunction::try_new([2.0], [1.0, -0.9], h).expect("valid");
        assert_eq!(largest_stable_round_trip_s(&loud), None);
    }

    #[test]
    fn a_loop_that_rings_at_the_nyquist_frequency_survives_the_shortest_round_trip_alone() {
        let h = Discrete::try_new(0.01).expect("positive");
        let ringing = TransferFunction::try_new([-0.15], [1.0, 0.9], h).expect("valid");
        assert!(is_stable_with_delay(&ringing, 2));
        assert!(!is_stable_with_delay(&ringing, 3));
        assert_eq!(largest_stable_round_trip_s(&ringing), Some(0.01));
    }
}
