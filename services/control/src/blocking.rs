//! The loop of a client with one request at a time: the longest constant round trip it survives.
//!
//! Such a client sends at the first deadline after its answer came, so a longer round trip does not
//! only delay its commands, it makes them rarer: one every ceil(RTT/h) deadlines, each held by the
//! plant over all ticks between. And an integrator that advances h a message, however long the
//! message took, grows slower. From command to command that is a loop of its own, whose poles are
//! worked out here. Delays that vary are left to the ends that run the loop.

use nalgebra::DMatrix;

use crate::pid::Gains;
use crate::state_space::StateSpace;
use crate::timebase::Discrete;

/// A plant that has forgotten its state to this share has forgotten it: what is held longer
/// changes nothing more.
const FORGOTTEN: f64 = 1e-12;
/// Beyond this many ticks between two commands nobody asks.
const LONGEST_TICKS: usize = 1_000_000;

/// The longest constant round trip, in seconds, with which a loop with one request at a time is
/// stable, every shorter one included: a multiple of h. `plant` is sampled with h; the controller
/// is PI, and its integral advances h a message.
///
/// Infinite where no round trip makes it unstable; `None` where not even the shortest is stable.
///
/// With y read at a command's arrival, before it acts, and n ticks to the next,
///
/// ```text
/// x' = Aⁿ x + (Aⁿ⁻¹ + .. + 1) B u        y' = C (Aⁿ⁻¹ x + (Aⁿ⁻² + .. + 1) B u) + D u
/// I' = I - ki h y                        u' = I' - kp y
/// ```
#[must_use]
pub fn largest_stable_blocking_round_trip_s(
    plant: &StateSpace<Discrete>,
    gains: &Gains,
) -> Option<f64> {
    let order = plant.order();
    let h_s = plant.timebase().h_s();
    // Aⁿ⁻¹ and (Aⁿ⁻² + .. + 1) B, from n = 1 on.
    let mut power = DMatrix::identity(order, order);
    let mut held = plant.b() * 0.0;
    for ticks in 1..=LONGEST_TICKS {
        let next_power = &power * plant.a();
        let next_held = plant.a() * &held + plant.b();
        let read = plant.c() * &power;
        let read_held = (plant.c() * &held)[0] + plant.d();

        // The state is (x, y, I, u).
        let (y, i, u) = (order, order + 1, order + 2);
        let mut step = DMatrix::zeros(order + 3, order + 3);
        step.view_mut((0, 0), (order, order)).copy_from(&next_power);
        step.view_mut((0, u), (order, 1)).copy_from(&next_held);
        step.view_mut((y, 0), (1, order)).copy_from(&read);
        step[(y, u)] = read_held;
        // Without an integral there is none to remember.
        step[(i, i)] = if gains.ki == 0.0 { 0.0 } else { 1.0 };
        step[(i, y)] = -gains.ki * h_s;
        step[(u, i)] = 1.0;
        step[(u, y)] = -gains.kp - gains.ki * h_s;
        let poles = step.complex_eigenvalues();
        if poles.iter().any(|pole| pole.norm() >= 1.0) {
            return (ticks > 1).then(|| (ticks - 1) as f64 * h_s);
        }
        if next_power.norm() < FORGOTTEN {
            return Some(f64::INFINITY);
        }
        (power, held) = (next_power, next_held);
    }
    Some(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discretise::{Method, discretise};
    use crate::preset::{motor, paper_gains};

    fn sampled(h_s: f64) -> StateSpace<Discrete> {
        discretise(&StateSpace::from(&motor()), Method::BackwardEuler, h_s).expect("stable")
    }

    #[test]
    fn the_paper_s_loop_survives_less_from_a_client_that_waits() {
        for h_s in [0.001, 0.003] {
            let longest_s = largest_stable_blocking_round_trip_s(&sampled(h_s), &paper_gains())
                .expect("stable without a network");
            assert!((0.02..0.096).contains(&longest_s), "{longest_s} at {h_s}");
        }
    }

    #[test]
    fn a_quiet_controller_survives_every_round_trip_and_a_loud_one_none() {
        let plant = sampled(0.003);
        let quiet = Gains::pi(0.01, 0.0);
        assert_eq!(
            largest_stable_blocking_round_trip_s(&plant, &quiet),
            Some(f64::INFINITY)
        );
        let loud = Gains::pi(1e3, 0.0);
        assert_eq!(largest_stable_blocking_round_trip_s(&plant, &loud), None);
    }
}
