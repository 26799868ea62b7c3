//! The loop of a client with one request at a time: the longest constant round trip it survives.
//!
//! Such a client sends at the first deadline after its answer came, so a longer round trip does not
//! only delay its commands, it makes them rarer: one every ceil(RTT/h) deadlines, each held by the
//! plant over all ticks between. And a law that advances h a message, however long the message took,
//! is slower. From command to command that is a loop of its own, whose poles are worked out here.
//! Delays that vary are left to the ends that run the loop.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::law::Law;
use crate::plant::SampledPlant;
use crate::transfer::InvalidTransferFunction;

/// A plant that has forgotten its state to this share has forgotten it: what is held longer
/// changes nothing more.
const FORGOTTEN: f64 = 1e-12;
/// The most ticks between two commands; longer round trips are not examined.
const LONGEST_TICKS: usize = 1_000_000;
/// With more states than this the poles of every round trip take too long.
const MOST_STATES: usize = 60;

/// Why nothing can be said of a loop with one request at a time.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Untold {
    /// Too many states, as a dead time of hundreds of samples has.
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

/// The longest constant round trip, in seconds, with which a loop with one request at a time is
/// stable, every shorter one included: a multiple of h.
///
/// Infinite where no round trip makes it unstable; `None` where not even the shortest is stable.
///
/// With y read at a command's arrival, before it acts, n ticks to the next, and the law s' = F s + G
/// y, u = H s + E y,
///
/// ```text
/// x' = Aⁿ x + (Aⁿ⁻¹ + .. + 1) B u        y' = C (Aⁿ⁻¹ x + (Aⁿ⁻² + .. + 1) B u) + D u
/// s' = F s + G y                         u' = H s + E y
/// ```
///
/// # Errors
/// [`Untold`] where they are too many states, or too great numbers, to tell.
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
    // Aⁿ⁻¹ and (Aⁿ⁻² + .. + 1) B, from n = 1 on.
    let mut power = DMatrix::identity(order, order);
    let mut held = plant.b() * 0.0;
    for ticks in 1..=LONGEST_TICKS {
        let next_power = &power * plant.a();
        let next_held = plant.a() * &held + plant.b();
        let read = plant.c() * &power;
        let read_held = (plant.c() * &held)[0] + plant.d();

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
        step[(u, y)] = law.d();
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
