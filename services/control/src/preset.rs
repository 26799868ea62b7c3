//! The plant and the controller of the paper (S. L. Remy, "Web Standards as Standard Pieces in
//! Robotics").

use crate::discretise::Method;
use crate::pid::{Gains, Pid};
use crate::plant::Plant;
use crate::timebase::Continuous;
use crate::transfer::TransferFunction;

/// Gain of the motor's numerator.
pub const MOTOR_B0: f64 = 2029.826;
/// The motor's fast pole, rad/s (the sign is in the denominator).
pub const MOTOR_C0: f64 = 26.29;
/// The motor's slow pole, rad/s.
pub const MOTOR_C1: f64 = 2.296;
/// Proportional gain of the paper's controller.
pub const PAPER_A0: f64 = 0.1701;
/// Integral gain of the paper's controller, 1/s.
pub const PAPER_A1: f64 = 0.378;

/// The paper's plant, b0 / ((s + c0)(s + c1)).
#[must_use]
pub fn motor() -> TransferFunction {
    TransferFunction::try_new(
        [MOTOR_B0],
        [1.0, MOTOR_C0 + MOTOR_C1, MOTOR_C0 * MOTOR_C1],
        Continuous,
    )
    .expect("the paper's constants are finite and the motor is proper")
}

/// The paper's plant and its sampling: without dead time, by backward Euler.
#[must_use]
pub fn paper_plant() -> Plant {
    Plant::new(&motor(), Method::BackwardEuler)
}

/// The gains of the paper's controller, (a0 s + a1)/s.
#[must_use]
pub fn paper_gains() -> Gains {
    Gains::pi(PAPER_A0, PAPER_A1)
}

/// The paper's controller at rest: no saturation, no anti-windup.
#[must_use]
pub fn paper_pi() -> Pid {
    Pid::try_new(paper_gains(), None).expect("the paper's gains are finite")
}

/// Settling time (2 %, seconds) of the paper's loop without a network, at h = 1 ms, with the shortest
/// round trip that two free-running ends can have: two ticks (see [`crate::loop_delay_ticks`]).
pub const BARE_SETTLING_1MS_S: f64 = 0.313;
/// The same at h = 3 ms.
#[expect(
    clippy::approx_constant,
    reason = "a time in seconds that happens to look like 1/pi"
)]
pub const BARE_SETTLING_3MS_S: f64 = 0.318;
