//! PI and PID control by backward Euler, in parallel form: kp + ki/s + kd N s/(s + N).
//!
//! The integral includes the error of the same update, according to s = (z - 1)/(z h). The elapsed
//! time is an argument of every update, so a client may integrate over h or over the time that has
//! really passed.

use thiserror::Error;

use crate::polynomial::{product, sum};
use crate::timebase::{Continuous, Discrete};
use crate::transfer::{InvalidTransferFunction, TransferFunction};

/// Gains of the parallel form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Proportional gain kp.
    pub kp: f64,
    /// Integral gain, 1/s.
    pub ki: f64,
    /// Derivative gain, s.
    pub kd: f64,
    /// N, the pole of the derivative's filter in rad/s; infinite means an unfiltered difference.
    pub filter_rad_s: f64,
}

impl Gains {
    /// PI: no derivative.
    #[must_use]
    pub fn pi(kp: f64, ki: f64) -> Self {
        Self {
            kp,
            ki,
            kd: 0.0,
            filter_rad_s: f64::INFINITY,
        }
    }

    /// The law as a transfer function, without poles for absent terms.
    ///
    /// # Errors
    /// [`InvalidTransferFunction`] if a gain is not finite, or `kd` is not zero and has no filter.
    pub fn transfer_function(&self) -> Result<TransferFunction, InvalidTransferFunction> {
        let Self {
            kp,
            ki,
            kd,
            filter_rad_s: n,
        } = *self;
        let (num, den) = match (ki != 0.0, kd != 0.0) {
            (false, false) => (vec![kp], vec![1.0]),
            (true, false) => (vec![kp, ki], vec![1.0, 0.0]),
            (false, true) if n.is_infinite() => (vec![kd, kp], vec![1.0]),
            (true, true) if n.is_infinite() => (vec![kd, kp, ki], vec![1.0, 0.0]),
            (false, true) => (vec![kp + kd * n, kp * n], vec![1.0, n]),
            (true, true) => (vec![kp + kd * n, kp * n + ki, ki * n], vec![1.0, n, 0.0]),
        };
        TransferFunction::try_new(num, den, Continuous)
    }

    /// Number of its poles: one each for an integral and a derivative term.
    pub(crate) fn order(&self) -> usize {
        usize::from(self.ki != 0.0) + usize::from(self.kd != 0.0)
    }

    /// The law sampled every `h_s`, from the error to the command, within its limits: each term by
    /// backward Euler, without poles for absent terms.
    ///
    /// # Errors
    /// [`InvalidTransferFunction`] if h is not finite and positive, or a gain is not finite.
    pub fn sampled(&self, h_s: f64) -> Result<TransferFunction<Discrete>, InvalidTransferFunction> {
        let timebase = Discrete::try_new(h_s).map_err(|_| InvalidTransferFunction::Timebases)?;
        let (mut num, mut den) = (vec![self.kp], vec![1.0]);
        let mut add = |part_num: &[f64], part_den: &[f64]| {
            num = sum(&product(&num, part_den), &product(part_num, &den));
            den = product(&den, part_den);
        };
        if self.ki != 0.0 {
            add(&[self.ki * h_s, 0.0], &[1.0, -1.0]);
        }
        if self.kd != 0.0 {
            let lag_s = self.filter_rad_s.recip();
            add(&[self.kd, -self.kd], &[lag_s + h_s, -lag_s]);
        }
        TransferFunction::try_new(num, den, timebase)
    }
}

/// Limits of the actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saturation {
    /// The smallest command.
    pub min: f64,
    /// The largest command.
    pub max: f64,
    /// Behaviour of the integral while the command is limited.
    pub anti_windup: AntiWindup,
}

impl Saturation {
    /// Rejects an empty range.
    pub(crate) fn check(&self) -> Result<(), InvalidPid> {
        let Self { min, max, .. } = *self;
        if min.is_nan() || max.is_nan() || min >= max {
            Err(InvalidPid::EmptyRange { min, max })
        } else {
            Ok(())
        }
    }
}

/// Behaviour of the integral while the command is limited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AntiWindup {
    /// The integral continues, and winds up.
    Off,
    /// The integral stops while the error would drive the command further beyond its limit (clamping).
    Conditional,
    /// The integral is driven back by `gain_per_s` times the part of the command that was cut off
    /// (also by backward Euler, so that any positive gain is stable).
    BackCalculation {
        /// The tracking gain in 1/s: the inverse of MATLAB's and Åström's tracking time constant.
        gain_per_s: f64,
    },
}

/// Settings that do not give a controller.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidPid {
    /// A gain or a limit is not finite.
    #[error("{field} is {value}; it must be a finite number")]
    NotFinite {
        /// The field's name.
        field: &'static str,
        /// The given value.
        value: f64,
    },
    /// The derivative filter or the back-calculation gain is not positive.
    #[error("{field} is {value}; it must be positive")]
    NotPositive {
        /// The field's name.
        field: &'static str,
        /// The given value.
        value: f64,
    },
    /// The range of the limits is empty.
    #[error("saturation from {min} to {max} is empty; min must be below max")]
    EmptyRange {
        /// The smallest command.
        min: f64,
        /// The largest command.
        max: f64,
    },
}

/// A running controller, at rest when new.
#[derive(Debug, Clone, PartialEq)]
pub struct Pid {
    gains: Gains,
    saturation: Option<Saturation>,
    memory: Memory,
    output: f64,
}

/// The values that an update passes to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Memory {
    integral: f64,
    derivative: f64,
    error: f64,
}

impl Pid {
    /// A controller at rest; `None` leaves the command unlimited, as in the paper.
    ///
    /// # Errors
    /// [`InvalidPid`] if a number is not finite (the filter may be infinite), if the filter or the
    /// back-calculation gain is not positive, or if min is not below max. Limits may be infinite on one side.
    pub fn try_new(gains: Gains, saturation: Option<Saturation>) -> Result<Self, InvalidPid> {
        for (field, value) in [("kp", gains.kp), ("ki", gains.ki), ("kd", gains.kd)] {
            if !value.is_finite() {
                return Err(InvalidPid::NotFinite { field, value });
            }
        }
        positive("filter_rad_s", gains.filter_rad_s)?;
        if let Some(limits) = saturation {
            limits.check()?;
            if let AntiWindup::BackCalculation { gain_per_s } = limits.anti_windup {
                if !gain_per_s.is_finite() {
                    return Err(InvalidPid::NotFinite {
                        field: "gain_per_s",
                        value: gain_per_s,
                    });
                }
                positive("gain_per_s", gain_per_s)?;
            }
        }
        Ok(Self {
            gains,
            saturation,
            memory: Memory::default(),
            output: 0.0,
        })
    }

    /// Returns the command u for the error `e` = r - y, `dt_s` seconds after the last update.
    ///
    /// An `e` that is not finite, a `dt_s` that is not positive and finite, or an update whose result
    /// would not be finite changes nothing: the last command is returned again (0 before the first).
    #[inline]
    pub fn update(&mut self, e: f64, dt_s: f64) -> f64 {
        if !(e.is_finite() && dt_s.is_finite() && dt_s > 0.0) {
            return self.output;
        }
        let (memory, output) = self.advanced(e, dt_s);
        if memory.integral.is_finite() && memory.derivative.is_finite() && output.is_finite() {
            self.memory = memory;
            self.output = output;
        }
        self.output
    }

    /// A controller at rest with all gains times `factor`, within the same limits; `None` if one is not finite then.
    pub(crate) fn times(&self, factor: f64) -> Option<Self> {
        let gains = Gains {
            kp: self.gains.kp * factor,
            ki: self.gains.ki * factor,
            kd: self.gains.kd * factor,
            ..self.gains
        };
        Self::try_new(gains, self.saturation).ok()
    }

    /// The gains of the law.
    #[must_use]
    pub fn gains(&self) -> Gains {
        self.gains
    }

    /// The last command, 0 before the first.
    #[must_use]
    pub fn output(&self) -> f64 {
        self.output
    }

    /// The integral term's part of the command.
    #[must_use]
    pub fn integral(&self) -> f64 {
        self.memory.integral
    }

    /// Returns to rest.
    pub fn reset(&mut self) {
        self.memory = Memory::default();
        self.output = 0.0;
    }

    #[inline]
    fn advanced(&self, e: f64, dt_s: f64) -> (Memory, f64) {
        let Gains { kp, ki, kd, .. } = self.gains;
        let derivative = if kd == 0.0 {
            0.0
        } else {
            self.derivative(e, dt_s)
        };
        let mut integral = self.memory.integral + ki * dt_s * e;
        let wanted = kp * e + integral + derivative;
        let Some(Saturation {
            min,
            max,
            anti_windup,
        }) = self.saturation
        else {
            return (
                Memory {
                    integral,
                    derivative,
                    error: e,
                },
                wanted,
            );
        };
        let output = wanted.clamp(min, max);
        match anti_windup {
            AntiWindup::Off => {}
            AntiWindup::Conditional => {
                if (wanted - output) * ki * e > 0.0 {
                    integral = self.memory.integral;
                }
            }
            AntiWindup::BackCalculation { gain_per_s } => {
                let pull = gain_per_s * dt_s;
                integral += pull / (1.0 + pull) * (output - wanted);
            }
        }
        (
            Memory {
                integral,
                derivative,
                error: e,
            },
            output,
        )
    }

    /// kd N s/(s + N) by backward Euler: `(1 + N h) d_k = d_(k-1) + kd N (e_k - e_(k-1))`. It is
    /// divided by N, so that an infinite N leaves the plain difference quotient.
    fn derivative(&self, e: f64, dt_s: f64) -> f64 {
        let Gains {
            kd, filter_rad_s, ..
        } = self.gains;
        let lag_s = filter_rad_s.recip();
        (lag_s * self.memory.derivative + kd * (e - self.memory.error)) / (lag_s + dt_s)
    }
}

fn positive(field: &'static str, value: f64) -> Result<(), InvalidPid> {
    if value > 0.0 {
        Ok(())
    } else {
        Err(InvalidPid::NotPositive { field, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limited(anti_windup: AntiWindup) -> Pid {
        let saturation = Saturation {
            min: -1.0,
            max: 1.0,
            anti_windup,
        };
        Pid::try_new(Gains::pi(0.0, 1.0), Some(saturation)).expect("valid")
    }

    #[test]
    fn what_is_not_a_number_leaves_the_integrator_and_repeats_the_last_command() {
        let mut pid = Pid::try_new(Gains::pi(2.0, 1.0), None).expect("valid");
        let before = pid.update(1.0, 0.5);
        assert_eq!(before, 2.5);
        for (e, dt_s) in [
            (f64::NAN, 0.5),
            (f64::INFINITY, 0.5),
            (1.0, 0.0),
            (1.0, -1.0),
            (1.0, f64::NAN),
            (1e300, 1e300),
        ] {
            assert_eq!(pid.update(e, dt_s), before);
            assert_eq!(pid.integral(), 0.5);
        }
        assert_eq!(pid.update(1.0, 0.5), 3.0);
    }

    #[test]
    fn without_anti_windup_the_integral_passes_the_limit_and_with_it_comes_back_at_once() {
        // Ten seconds of e = 1 wind the integral up to 10; then e = -1. Without anti-windup the
        // command stays at its limit for nine more seconds. With clamping the integral stops at 1,
        // and the first reversed second brings it to 0.
        let run = |anti_windup| {
            let mut pid = limited(anti_windup);
            for _ in 0..10 {
                assert_eq!(pid.update(1.0, 1.0), 1.0);
            }
            pid.update(-1.0, 1.0)
        };
        assert_eq!(run(AntiWindup::Off), 1.0);
        assert_eq!(run(AntiWindup::Conditional), 0.0);
        // A gain of 99/s removes 99 % of the excess every second: the integral settles at 1/0.99, 1 %
        // too high.
        assert!(run(AntiWindup::BackCalculation { gain_per_s: 99.0 }) < 0.02);
    }

    #[test]
    fn the_unfiltered_derivative_is_the_difference_quotient() {
        let gains = Gains {
            kp: 0.0,
            ki: 0.0,
            kd: 3.0,
            filter_rad_s: f64::INFINITY,
        };
        let mut pid = Pid::try_new(gains, None).expect("valid");
        assert_eq!(
            [(2.0, 0.5), (3.0, 0.25)].map(|(e, dt_s)| pid.update(e, dt_s)),
            [12.0, 12.0]
        );
    }

    #[test]
    fn settings_that_make_no_controller_are_refused_by_name() {
        let refuse = |gains, saturation| {
            Pid::try_new(gains, saturation)
                .expect_err("invalid")
                .to_string()
        };
        assert!(refuse(Gains::pi(f64::NAN, 0.0), None).starts_with("kp is NaN"));
        assert!(
            refuse(
                Gains {
                    filter_rad_s: 0.0,
                    ..Gains::pi(1.0, 0.0)
                },
                None
            )
            .starts_with("filter_rad_s is 0")
        );
        let empty = Saturation {
            min: 1.0,
            max: 1.0,
            anti_windup: AntiWindup::Off,
        };
        assert!(
            refuse(Gains::pi(1.0, 0.0), Some(empty)).starts_with("saturation from 1 to 1 is empty")
        );
    }
}
