//! Continuous or sampled: this difference must never be confused, so it is part of the type.

use nalgebra::Complex;
use thiserror::Error;

/// How a system's complex frequency relates to real frequency, and where its stable poles lie.
pub trait Timebase: Copy + PartialEq {
    /// The point of the complex plane for the frequency `omega_rad_s`: jω, or e^(jωh).
    fn point(self, omega_rad_s: f64) -> Complex<f64>;

    /// The frequency (rad/s) at which a pole or zero bends the magnitude; zero for an integrator.
    fn corner_rad_s(self, root: Complex<f64>) -> f64;

    /// Whether a mode with this pole decays.
    fn is_stable(self, pole: Complex<f64>) -> bool;

    /// The highest possible frequency, π/h, if there is one.
    fn nyquist_rad_s(self) -> Option<f64>;

    /// The sample time in seconds, if there is one.
    fn sample_time_s(self) -> Option<f64>;
}

/// Continuous time: the variable is s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Continuous;

/// Sampled time: the variable is z, and the sample time is `h_s` seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete {
    h_s: f64,
}

/// A sample time that is not a positive finite number of seconds.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "the sample time h is {h_s} s; give a positive finite number of seconds, for example 0.003"
)]
pub struct InvalidSampleTime {
    /// The given sample time in seconds.
    pub h_s: f64,
}

impl Discrete {
    /// A sample time of `h_s` seconds.
    ///
    /// # Errors
    /// [`InvalidSampleTime`] unless `h_s` is finite and positive.
    pub fn try_new(h_s: f64) -> Result<Self, InvalidSampleTime> {
        if h_s.is_finite() && h_s > 0.0 {
            Ok(Self { h_s })
        } else {
            Err(InvalidSampleTime { h_s })
        }
    }

    /// The sample time in seconds.
    #[must_use]
    pub fn h_s(self) -> f64 {
        self.h_s
    }
}

/// Nanoseconds as seconds.
#[must_use]
pub fn seconds(ns: u64) -> f64 {
    // A quotient of two exact numbers, so 3 ms is exactly the f64 nearest to 0.003.
    ns as f64 / 1e9
}

/// A pole closer to 1 than this is an integrator: rounding of the coefficients moves it by about this much.
const INTEGRATOR: f64 = 1e-9;

impl Timebase for Continuous {
    fn point(self, omega_rad_s: f64) -> Complex<f64> {
        Complex::new(0.0, omega_rad_s)
    }

    fn corner_rad_s(self, root: Complex<f64>) -> f64 {
        root.norm()
    }

    fn is_stable(self, pole: Complex<f64>) -> bool {
        pole.re < 0.0
    }

    fn nyquist_rad_s(self) -> Option<f64> {
        None
    }

    fn sample_time_s(self) -> Option<f64> {
        None
    }
}

impl Timebase for Discrete {
    fn point(self, omega_rad_s: f64) -> Complex<f64> {
        Complex::from_polar(1.0, omega_rad_s * self.h_s)
    }

    /// The corner of the continuous root that is sampled to this one: |ln z| / h. A root at the
    /// origin has none.
    fn corner_rad_s(self, root: Complex<f64>) -> f64 {
        if root.norm() == 0.0 || (root - 1.0).norm() < INTEGRATOR {
            0.0
        } else {
            root.ln().norm() / self.h_s
        }
    }

    fn is_stable(self, pole: Complex<f64>) -> bool {
        pole.norm() < 1.0
    }

    fn nyquist_rad_s(self) -> Option<f64> {
        Some(std::f64::consts::PI / self.h_s)
    }

    fn sample_time_s(self) -> Option<f64> {
        Some(self.h_s)
    }
}
