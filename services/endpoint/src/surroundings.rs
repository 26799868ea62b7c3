//! What lies between a plant's model and its two sides: an actuator with limits of its own, a disturbance at the input,
//! a sensor with noise and a resolution.
//!
//! Noise is drawn from the number of the step and the seed alone, so a run can be repeated, and real and
//! virtual time draw the same.

use control::{Signals, seconds};

use crate::model::Model;
use crate::noise::Draws;

/// What surrounds a model; by default nothing does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// The least and the greatest input that the actuator gives, of each input.
    pub limits: (f64, f64),
    /// The greatest change of each input that the actuator gives, in units of u per second.
    pub rate_per_s: f64,
    /// What is added to the first input behind the actuator.
    pub disturbance: Option<Disturbance>,
    /// Standard deviation of the sensors' noise, which is normal and independent from step to step.
    pub noise: f64,
    /// The sensor shows whole multiples of this; 0 for any number.
    pub resolution: f64,
    /// Whether the model stands still until the loop's start, since its state is none of rest.
    pub stands_still: bool,
}

/// A step at the plant's input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// How great it is, in units of u.
    pub size: f64,
    /// From when on, ns after the loop's start.
    pub from_ns: u64,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self {
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            rate_per_s: f64::INFINITY,
            disturbance: None,
            noise: 0.0,
            resolution: 0.0,
            stands_still: false,
        }
    }
}

/// A model within its surroundings.
#[derive(Debug, Clone)]
pub struct Surrounded<M> {
    model: M,
    surroundings: Surroundings,
    draws: Draws,
    /// The loop's start on the clock of the ticks, ns; the first tick's where it is not known.
    start_ns: Option<u64>,
    /// Number of steps done.
    steps: u64,
    /// What the actuator gave last, and when.
    applied: Signals,
    applied_ns: Option<u64>,
}

impl<M: Model> Surrounded<M> {
    /// `model` within `surroundings`; `seed` is the noise's.
    #[must_use]
    pub fn new(model: M, surroundings: Surroundings, seed: u64, start_ns: Option<u64>) -> Self {
        // Another stream than that of the ticks' noise, which may have the same seed.
        const STREAM: u64 = 0x5e75_0a11_0f4e_0157;
        Self {
            surroundings,
            draws: Draws::new(seed ^ STREAM),
            start_ns,
            steps: 0,
            applied: Signals::zeros(model.inputs()),
            applied_ns: None,
            model,
        }
    }

    /// The model itself.
    #[must_use]
    pub fn model(&self) -> &M {
        &self.model
    }

    /// What the actuator gives of the inputs `u`.
    fn actuate(&mut self, u: Signals, due_ns: u64) {
        let Surroundings {
            limits: (least, greatest),
            rate_per_s,
            ..
        } = self.surroundings;
        let passed_ns = self
            .applied_ns
            .map_or(0, |last_ns| due_ns.saturating_sub(last_ns));
        let most = if rate_per_s.is_finite() {
            rate_per_s * seconds(passed_ns)
        } else {
            f64::INFINITY
        };
        // Not `clamp`, which panics on limits that are no numbers. An input that is no number is none: `max`
        // would make the least of it.
        let within = |u: f64, last: f64| {
            let u = if u.is_nan() { last } else { u };
            u.max(last - most).min(last + most).max(least).min(greatest)
        };
        let last = self.applied;
        self.applied = Signals {
            first: within(u.first, last.first),
            second: u
                .second
                .map(|second| within(second, last.second.unwrap_or_default())),
        };
        self.applied_ns = Some(due_ns);
    }
}

impl<M: Model> Model for Surrounded<M> {
    fn step(&mut self, u: Signals, due_ns: u64) -> Signals {
        let start_ns = *self.start_ns.get_or_insert(due_ns);
        self.actuate(u, due_ns);
        if self.surroundings.stands_still && due_ns < start_ns {
            self.steps += 1;
            return self.model.at_rest();
        }
        let acting = self
            .surroundings
            .disturbance
            .filter(|one| due_ns >= start_ns.saturating_add(one.from_ns));
        self.steps += 1;
        let mut input = self.applied;
        // Adding nothing would make a plain zero of -0.
        if let Some(disturbance) = acting {
            input.first += disturbance.size;
        }
        self.model.step(input, due_ns)
    }

    fn measured(&mut self, y: Signals) -> Signals {
        let Surroundings {
            noise, resolution, ..
        } = self.surroundings;
        let mut shown = self.model.measured(y);
        if noise > 0.0 {
            shown.first += noise * self.draws.normal(self.steps);
            if let Some(second) = &mut shown.second {
                // Steps count up from 0, so these draws are of no step's.
                *second += noise * self.draws.normal(!self.steps);
            }
        }
        if resolution > 0.0 {
            shown = shown.map(|y| (y / resolution).round() * resolution);
        }
        shown
    }

    fn applied(&self) -> Option<Signals> {
        Some(self.applied)
    }

    fn reset(&mut self) -> bool {
        self.applied = self.applied.map(|_| 0.0);
        self.model.reset()
    }

    fn can_reset(&self) -> bool {
        self.model.can_reset()
    }

    fn at_rest(&self) -> Signals {
        self.model.at_rest()
    }

    fn inputs(&self) -> usize {
        self.model.inputs()
    }

    fn is_broken(&self) -> bool {
        self.model.is_broken()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Gives its input back.
    #[derive(Clone)]
    struct Wire;

    impl Model for Wire {
        fn step(&mut self, u: Signals, _: u64) -> Signals {
            u
        }
    }

    #[test]
    fn nothing_around_a_model_changes_nothing() {
        let mut bare = Surrounded::new(Wire, Surroundings::default(), 7, None);
        for u in [0.0, -0.0, 1e300, -2.5e-9] {
            let y = bare.step(u.into(), 0);
            assert_eq!(bare.measured(y).first.to_bits(), u.to_bits());
        }
    }

    /// Counts its steps.
    #[derive(Clone)]
    struct Counter(f64);

    impl Model for Counter {
        fn step(&mut self, _: Signals, _: u64) -> Signals {
            self.0 += 1.0;
            self.0.into()
        }

        fn at_rest(&self) -> Signals {
            self.0.into()
        }
    }

    #[test]
    fn a_model_that_does_not_rest_stands_still_until_the_start() {
        let surroundings = Surroundings {
            stands_still: true,
            ..Surroundings::default()
        };
        let mut plant = Surrounded::new(Counter(5.0), surroundings, 0, Some(100));
        let seen = [80, 90, 100, 110].map(|due_ns| plant.step(0.0.into(), due_ns).first);
        assert_eq!(seen, [5.0, 5.0, 6.0, 7.0]);
    }

    #[test]
    fn a_disturbance_is_added_behind_the_limits_from_its_time_on() {
        let surroundings = Surroundings {
            limits: (-1.0, 1.0),
            disturbance: Some(Disturbance {
                size: 0.5,
                from_ns: 20,
            }),
            ..Surroundings::default()
        };
        let mut plant = Surrounded::new(Wire, surroundings, 0, Some(100));
        let steps = [(3.0, 90), (3.0, 110), (3.0, 120), (-3.0, 130)];
        let outputs = steps.map(|(u, due_ns)| plant.step(u.into(), due_ns).first);
        assert_eq!(outputs, [1.0, 1.0, 1.5, -0.5]);
    }

    #[test]
    fn an_actuator_moves_no_faster_than_its_rate_and_keeps_its_limits() {
        let surroundings = Surroundings {
            limits: (-1.0, 1.0),
            rate_per_s: 10.0,
            ..Surroundings::default()
        };
        let mut plant = Surrounded::new(Wire, surroundings, 0, None);
        let steps = [
            (3.0, 0),
            (3.0, 50),
            (3.0, 100),
            (3.0, 150),
            (f64::NAN, 200),
            (-3.0, 250),
        ];
        let outputs = steps.map(|(u, due_ms)| plant.step(u.into(), due_ms * 1_000_000).first);
        assert_eq!(outputs, [0.0, 0.5, 1.0, 1.0, 1.0, 0.5]);
        assert_eq!(plant.applied(), Some(0.5.into()));
    }

    #[test]
    fn noise_has_its_standard_deviation_and_is_the_seed_s() {
        let surroundings = Surroundings {
            noise: 0.1,
            ..Surroundings::default()
        };
        let shown = |seed| {
            let mut plant = Surrounded::new(Wire, surroundings, seed, None);
            let mut shown = Vec::new();
            for k in 0..20_000 {
                let y = plant.step(1.0.into(), k);
                shown.push(plant.measured(y).first);
            }
            shown
        };
        let one = shown(1);
        let mean = one.iter().sum::<f64>() / one.len() as f64;
        let squares: f64 = one.iter().map(|y| (y - mean).powi(2)).sum();
        let sd = (squares / one.len() as f64).sqrt();
        assert!((mean - 1.0).abs() < 0.003, "{mean}");
        assert!((sd - 0.1).abs() < 0.002, "{sd}");
        assert_eq!(one, shown(1));
        assert_ne!(one, shown(2));
    }

    #[test]
    fn both_of_two_signals_pass_actuator_and_sensor_and_have_noise_of_their_own() {
        let surroundings = Surroundings {
            limits: (-1.0, 1.0),
            noise: 0.1,
            ..Surroundings::default()
        };
        let mut plant = Surrounded::new(Wire, surroundings, 1, None);
        let y = plant.step([3.0, -3.0].into(), 0);
        assert_eq!(y, Signals::from([1.0, -1.0]));
        let shown = plant.measured(y);
        let off = [shown.first - 1.0, shown.second.expect("two") + 1.0];
        assert!(
            off[0] != 0.0 && off[1] != 0.0 && off[0] != off[1],
            "{off:?}"
        );
    }

    proptest! {
        #[test]
        fn a_sensor_shows_the_nearest_multiple_of_its_resolution(y in -1e3..1e3_f64, resolution in 1e-3..1.0_f64) {
            let surroundings = Surroundings { resolution, ..Surroundings::default() };
            let shown = Surrounded::new(Wire, surroundings, 0, None).measured(y.into()).first;
            prop_assert!((shown - y).abs() <= resolution * 0.500_001);
            prop_assert!((shown / resolution - (shown / resolution).round()).abs() < 1e-6);
        }
    }
}
