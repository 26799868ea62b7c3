//! The loop of a client with one request at a time: the longest constant round trip with which it is stable.
//!
//! Such a client sends at the first deadline after it has received its answer. A longer round trip
//! therefore not only delays its commands but makes them rarer: one every ceil(RTT/h) deadlines, held
//! by the plant over all ticks between. And a law that advances by h per message, however long the
//! message took, becomes slower. From command to command this is a loop of its own, whose poles are
//! computed here. Variable delays are left to the ends that run the loop.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::law::Law;
use crate::plant::SampledPlant;
use crate::transfer::InvalidTransferFunction;

/// Once the plant's response to its old state has decayed to this share, holding a command for longer
/// changes nothing.
const FORGOTTEN: f64 = 1e-12;
/// Most ticks between two commands; longer round trips are not examined.
const LONGEST_TICKS: usize = 1_000_000;
/// With more states than this, computing the poles for every round trip takes too long.
const MOST_STATES: usize = 60;

/// Why there is no result for a loop with one request at a time.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Untold {
    /// Too many states, for instance from a dead time of hundreds of samples.
    #[error(
        "plant and law have {states} states; the poles for every round trip can be computed for at \
         most {most}"
    )]
    States {
        /// States of plant and law together.
        states: usize,
        /// The limit.
        most: usize,
    },
    /// The law's numbers overflow.
    #[error(transparent)]
    Law(#[from] InvalidTransferFunction),
}

/// The longest constant round trip, in seconds, at which a loop with one request at a time is stable,
/// as at every shorter one: a multiple of h.
///
/// Infinite if no round trip makes it unstable; `None` if it is unstable even at the shortest.
///
/// With y read at a command's arrival before the command acts, n ticks to the next command, and the
/// law s' = F s + G y, u = H s + E y:
///
/// ```text
/// x' = Aⁿ x + (Aⁿ⁻¹ + .. + 1) B u        y' = C (Aⁿ⁻¹ x + (Aⁿ⁻² + .. + 1) B u) + D u
/// s' = F s + G y                         u' = H s + E y
/// ```
///
/// # Errors
/// [`Untold`] if there are too many states, or numbers overflow.
pub fn largest_stable_blocking_round_trip_s(
    plant: &SampledPlant,
    law: &Law,
) -> Result<Option<f64>, Untold> {
    let h_s = plant.h_s();
    let of_plant = plant.system.order().saturating_add(plant.delay_ticks);
    let states = of_plant.saturating_add(law.order());
    if states > MOST_STATES {
        return Err(Untold::States {
            states,
            most: MOST_STATES,
        });
    }
    let law = law.state_space(h_s)?;
    let plant = plant.state_space();
    let (order, of_law) = (plant.order(), law.order());
    // Aⁿ⁻¹ and (Aⁿ⁻² + .. + 1) B, for n = 1 first.
    let mut power = DMatrix::identity(order, order);
    let mut held = plant.b() * 0.0;
    for ticks in 1..=LONGEST_TICKS {
        let next_power = &power * plant.a();
        let next_held = plant.a() * &held + plant.b();
        let read = plant.c() * &power;
        let read_held = (plant.c() * &held)[0] + plant.d0();

        // The state is (x, y, s, u).
        let (y, s) = (order, order + 1);
        let u = s + of_law;
        let mut step = DMatrix::zeros(u + 1, u + 1);
        step.view_mut((0, 0), (order, order)).copy_from(&next_power);
        step.view_mut((0, u), (order, 1)).copy_from(&next_held);
        step.view_mut((y, 0), (1, order)).copy_from(&read);
        step[(y, u)] = read_held;
        step.view_mut((s, s), (of_law, of_law)).copy_from(law.a());
        step.view_mut((s, y), (of_law, 1)).copy_from(law.b());
        step.view_mut((u, s), (1, of_law)).copy_from(law.c());
        step[(u, y)] = law.d0();
        let poles = step.complex_eigenvalues();
        if poles.iter().any(|pole| pole.norm() >= 1.0) {
            return Ok((ticks > 1).then(|| (ticks - 1) as f64 * h_s));
        }
        if next_power.norm() < FORGOTTEN {
            return Ok(Some(f64::INFINITY));
        }
        (power, held) = (next_power, next_held);
    }
    Ok(Some(f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pid::{Gains, Pid};
    use crate::preset::{paper_pi, paper_plant};

    fn longest_s(h_ns: u64, law: Pid) -> Option<f64> {
        let plant = paper_plant().sampled(h_ns).expect("stable");
        largest_stable_blocking_round_trip_s(&plant, &law.into()).expect("few states")
    }

    #[test]
    fn a_dead_time_of_many_samples_is_left_untold_before_anything_is_worked_out() {
        let mut plant = paper_plant().sampled(1_000_000).expect("stable");
        for delay_ticks in [100, 1_000_000_000] {
            plant.delay_ticks = delay_ticks;
            let untold = largest_stable_blocking_round_trip_s(&plant, &paper_pi().into());
            assert_eq!(
                untold,
                Err(Untold::States {
                    states: delay_ticks + 3,
                    most: MOST_STATES
                })
            );
        }
    }

    #[test]
    fn the_paper_s_loop_survives_less_from_a_client_that_waits() {
        for h_ns in [1_000_000, 3_000_000] {
            let longest_s = longest_s(h_ns, paper_pi()).expect("stable without a network");
            assert!((0.02..0.096).contains(&longest_s), "{longest_s} at {h_ns}");
        }
    }

    #[test]
    fn a_quiet_controller_survives_every_round_trip_and_a_loud_one_none() {
        let with = |kp| Pid::try_new(Gains::pi(kp, 0.0), None).expect("finite");
        assert_eq!(longest_s(3_000_000, with(0.01)), Some(f64::INFINITY));
        assert_eq!(longest_s(3_000_000, with(1e3)), None);
    }
}
