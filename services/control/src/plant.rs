//! A plant: a linear model with dead time, and how it is sampled.
//!
//! The dead time is at the input; from input and output alone one could not tell it from one at the output.

use nalgebra::DMatrix;

use crate::discretise::{InvalidDiscretisation, Method, discretise, held};
use crate::polynomial::product;
use crate::state_space::{InvalidStateSpace, StateSpace};
use crate::stepper::Stepper;
use crate::timebase::{Discrete, seconds};
use crate::transfer::{InvalidTransferFunction, TransferFunction};

/// A continuous plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// The model without its dead time.
    pub model: StateSpace,
    /// Time from an input to its first effect, ns.
    pub dead_time_ns: u64,
    /// How it is sampled.
    pub method: Method,
}

/// A plant sampled every h.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledPlant {
    /// The model, including the part of the dead time that is a fraction of a sample.
    pub system: StateSpace<Discrete>,
    /// The dead time in whole samples.
    pub delay_ticks: usize,
}

impl Plant {
    /// A plant without dead time.
    #[must_use]
    pub fn new(model: &TransferFunction, method: Method) -> Self {
        Self {
            model: StateSpace::from(model),
            dead_time_ns: 0,
            method,
        }
    }

    /// The plant, sampled every `h_ns`.
    ///
    /// # Errors
    /// [`InvalidDiscretisation`], also if the dead time is not a multiple of h and the method is not
    /// zero-order hold: only that method defines the input between samples.
    pub fn sampled(&self, h_ns: u64) -> Result<SampledPlant, InvalidDiscretisation> {
        let h_s = seconds(h_ns);
        let (ticks, rest_ns) = match h_ns {
            0 => (0, 0),
            h_ns => (self.dead_time_ns / h_ns, self.dead_time_ns % h_ns),
        };
        let system = match (rest_ns, self.method) {
            (0, method) => discretise(&self.model, method, h_s)?,
            (_, Method::ZeroOrderHold) => self.split(h_s, seconds(rest_ns))?,
            (_, method) => {
                return Err(InvalidDiscretisation::DeadTime {
                    dead_time_ns: self.dead_time_ns,
                    h_ns,
                    method,
                });
            }
        };
        Ok(SampledPlant {
            system,
            delay_ticks: usize::try_from(ticks).unwrap_or(usize::MAX),
        })
    }

    /// Zero-order hold if an input takes effect `rest_s` after a sample: until then the previous
    /// inputs act, which are additional states (K. J. Astrom and B. Wittenmark, Computer-Controlled
    /// Systems, 3.2).
    fn split(&self, h_s: f64, rest_s: f64) -> Result<StateSpace<Discrete>, InvalidDiscretisation> {
        let timebase = Discrete::try_new(h_s)?;
        let (n, m, p) = (
            self.model.order(),
            self.model.inputs(),
            self.model.outputs(),
        );
        let (whole, _) = held(&self.model, h_s);
        let (_, by_the_last) = held(&self.model, rest_s);
        let (after, by_the_next) = held(&self.model, h_s - rest_s);
        let mut a = DMatrix::zeros(n + m, n + m);
        a.view_mut((0, 0), (n, n)).copy_from(&whole);
        a.view_mut((0, n), (n, m)).copy_from(&(after * by_the_last));
        let mut b = DMatrix::zeros(n + m, m);
        b.rows_mut(0, n).copy_from(&by_the_next);
        b.rows_mut(n, m).fill_with_identity();
        let mut c = DMatrix::zeros(p, n + m);
        c.columns_mut(0, n).copy_from(self.model.c());
        c.columns_mut(n, m).copy_from(self.model.d());
        let d = DMatrix::zeros(p, m);
        StateSpace::try_new(a, b, c, d, timebase).map_err(|_: InvalidStateSpace| {
            // The shapes match by construction.
            InvalidDiscretisation::Overflow { h_s }
        })
    }
}

impl SampledPlant {
    /// A stepper that starts at rest.
    #[must_use]
    pub fn stepper(&self) -> Stepper {
        Stepper::delayed(&self.system, self.delay_ticks)
    }

    /// A stepper that starts in the state `x0` of the model; missing states are 0. Of a plant with a dead time
    /// or another sampling than the zero-order hold, states are not those of the model.
    #[must_use]
    pub fn stepper_from(&self, x0: &[f64]) -> Stepper {
        self.stepper().from_state(x0)
    }

    /// The plant with its dead time, from its first input to its first output, as num/den: z^-d is d poles at
    /// the origin.
    ///
    /// # Errors
    /// [`InvalidTransferFunction::NotFinite`] if a coefficient overflows.
    pub fn transfer_function(&self) -> Result<TransferFunction<Discrete>, InvalidTransferFunction> {
        let core = self.system.transfer_function()?;
        let mut delay = vec![0.0; self.delay_ticks + 1];
        delay[0] = 1.0;
        TransferFunction::try_new(core.num(), product(core.den(), &delay), core.timebase())
    }

    /// The plant with its dead time, whose inputs under way are states.
    #[must_use]
    pub fn state_space(&self) -> StateSpace<Discrete> {
        let (n, d) = (self.system.order(), self.delay_ticks);
        if d == 0 {
            return self.system.clone();
        }
        let (m, p) = (self.system.inputs(), self.system.outputs());
        let all = n + d * m;
        let mut a = DMatrix::zeros(all, all);
        a.view_mut((0, 0), (n, n)).copy_from(self.system.a());
        a.view_mut((0, n), (n, m)).copy_from(self.system.b());
        for i in m..d * m {
            a[(n + i - m, n + i)] = 1.0;
        }
        let mut b = DMatrix::zeros(all, m);
        b.rows_mut(all - m, m).fill_with_identity();
        let mut c = DMatrix::zeros(p, all);
        c.columns_mut(0, n).copy_from(self.system.c());
        c.columns_mut(n, m).copy_from(self.system.d());
        StateSpace::try_new(a, b, c, DMatrix::zeros(p, m), self.system.timebase())
            .expect("finite parts in shapes that fit")
    }

    /// The sample time in seconds.
    #[must_use]
    pub fn h_s(&self) -> f64 {
        self.system.timebase().h_s()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timebase::Continuous;

    const MS: u64 = 1_000_000;

    fn lag(dead_time_ns: u64, method: Method) -> Plant {
        let model = TransferFunction::try_new([3.0], [1.0, 2.0], Continuous).expect("valid");
        Plant {
            dead_time_ns,
            ..Plant::new(&model, method)
        }
    }

    #[test]
    fn a_dead_time_between_samples_is_exact_for_a_held_input() {
        // y of 3/(s + 2) after a unit step that acts 25 ms after t = 0: 1.5 (1 - e^(-2 (t - 0.025))).
        let sampled = lag(25 * MS, Method::ZeroOrderHold)
            .sampled(10 * MS)
            .expect("sampled");
        assert_eq!(sampled.delay_ticks, 2);
        let mut stepper = sampled.stepper();
        for k in 0..50 {
            let t_s = f64::from(k) * 0.01 - 0.025;
            let expected = if t_s > 0.0 {
                1.5 * (1.0 - (-2.0 * t_s).exp())
            } else {
                0.0
            };
            assert!((stepper.step(1.0) - expected).abs() < 1e-13, "{k}");
        }
    }

    #[test]
    fn its_three_forms_are_one_plant() {
        for dead_time_ns in [0, 20 * MS, 33 * MS] {
            let sampled = lag(dead_time_ns, Method::ZeroOrderHold)
                .sampled(10 * MS)
                .expect("sampled");
            let mut whole = Stepper::new(&sampled.state_space());
            let mut stepper = sampled.stepper();
            let g = sampled.transfer_function().expect("finite");
            let mut by_polynomial = Stepper::new(&StateSpace::from(&g));
            for k in 0..40 {
                let u = f64::from(k % 7) - 2.5;
                let y = stepper.step(u);
                assert!((whole.step(u) - y).abs() < 1e-12);
                assert!((by_polynomial.step(u) - y).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn other_methods_take_whole_samples_of_dead_time_alone() {
        let plant = lag(25 * MS, Method::BackwardEuler);
        assert!(plant.sampled(5 * MS).is_ok());
        let error = plant.sampled(10 * MS).expect_err("two and a half samples");
        assert!(
            error.to_string().starts_with("a dead time of 25000000 ns"),
            "{error}"
        );
        assert!(plant.sampled(0).is_err());
    }
}
