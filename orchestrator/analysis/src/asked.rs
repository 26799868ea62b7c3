//! What is asked of an output: its band, its limits, and how much overshoot and effort a loop may take that holds
//! well.

use plan::system::{Band, Holding};

/// The band where a step is followed, as a part of the step: python-control's `SettlingTimeThreshold`.
pub const STEP_BAND: f64 = 0.02;
/// The band where y is brought back to 0, as a part of where it began.
pub const REST_BAND: f64 = 0.1;
/// Of normal noise, no sample in a million is farther than five standard deviations out.
const NOISE_SDS: f64 = 5.0;
/// The overshoot that is asked for, % of the step, if the system does not say.
pub const OVERSHOOT_PCT: f64 = 100.0;

/// What a loop is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// To bring y to a reference that differs from where it was.
    Tracking,
    /// To bring y back to 0, or to keep it where it is.
    Regulation,
}

/// What is asked of one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// Its band; `None` for the rule's own.
    pub band: Option<Band>,
    /// The least and the greatest value.
    pub limits: (f64, f64),
    /// What noise and resolution of the sensor add to the band, in units of y.
    pub noise: f64,
    /// The greatest overshoot, % of the step.
    pub overshoot_pct: f64,
    /// The greatest magnitude of the input.
    pub effort: f64,
}

impl Asked {
    /// What is asked of the output with this number, 0 the first, by a system's text; `noise` is the standard
    /// deviation of its sensor, and `resolution` the step between what it can show.
    #[must_use]
    pub fn of(holding: &Holding, output: usize, noise: f64, resolution: f64) -> Asked {
        Asked {
            band: holding.band_of(output),
            limits: holding
                .limits_of(output)
                .unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
            noise: NOISE_SDS * noise + resolution / 2.0,
            overshoot_pct: holding.overshoot_pct.unwrap_or(OVERSHOOT_PCT),
            effort: holding.effort.unwrap_or(f64::INFINITY),
        }
    }

    /// The half width of the band about a reference that is `step` away at first, in units of y. `None` if
    /// nothing gives the scale: there is no step, and no band in units of y is asked.
    #[must_use]
    pub fn band_for(&self, step: f64, task: Task) -> Option<f64> {
        let part = match (self.band, task) {
            (Some(Band::Absolute(band)), _) => return Some(band + self.noise),
            (Some(Band::OfStep(part)), _) => part,
            (None, Task::Tracking) => STEP_BAND,
            (None, Task::Regulation) => REST_BAND,
        };
        (step != 0.0).then(|| part * step.abs() + self.noise)
    }
}

/// Asks for what the rule asks by itself.
impl Default for Asked {
    fn default() -> Self {
        Asked::of(&Holding::default(), 0, 0.0, 0.0)
    }
}
