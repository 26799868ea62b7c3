//! A valid system, and its plant and law at a sample time.

use control::{Discrete, InvalidTransferFunction, Law, Plant, SampledPlant, TransferFunction};
use endpoint::{ControllerSettings, Integrate, InvalidSetting, SampleTime};

use crate::design::Design;
use crate::fault::{Fault, Source};
use crate::file::SystemFile;
use crate::law::Recipe;
use crate::obstacle::Obstacle;
use crate::plant;

/// A plant, its law, and its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    name: String,
    about: String,
    r: f64,
    plant: Plant,
    recipe: Recipe,
    text: String,
}

/// A system at a sample time.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// What the plant's end steps.
    pub plant: SampledPlant,
    /// What the controller's end runs, at rest.
    pub law: Law,
    /// The law in numbers, for clients in other languages.
    pub design: Design,
}

/// A system that cannot be run at a sample time.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("system {system} cannot run at h = {h}: {obstacle}")]
pub struct Unfit {
    /// Name of the system.
    pub system: String,
    /// The sample time.
    pub h: SampleTime,
    /// Why it cannot run.
    pub obstacle: Obstacle,
}

/// Testing stability compares all coefficients with all: with this many it takes seconds.
const PLANT_TICKS: usize = 50_000;
/// Margins are searched for around a law's poles, each of which must be found first.
const LAW_ORDER: usize = 1_000;

/// A loop that cannot be written down as one transfer function.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotOpened {
    /// A coefficient overflows.
    #[error(transparent)]
    Overflow(#[from] InvalidTransferFunction),
    /// It would have too many coefficients.
    #[error(
        "its {what} has order {order}, and margins can be computed up to order {most}; use a longer h"
    )]
    Order {
        /// The plant or the law.
        what: &'static str,
        /// The order that it would have.
        order: usize,
        /// The limit.
        most: usize,
    },
}

macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../systems/", $name, ".toml")))),+]
    };
}

/// What the binary carries, by name; the first is the paper's.
const BUILT_IN: [(&str, &str); 7] = built_in![
    "motor",
    "lag",
    "lag-smith",
    "double-integrator",
    "pendulum",
    "puma-joint",
    "quadrotor",
];

impl System {
    /// The paper's system: what is meant where none is named.
    pub const PAPER: &str = "motor";

    /// The names of those that the binary carries, the paper's first.
    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// The text of one that the binary carries.
    #[must_use]
    pub fn built_in(name: &str) -> Option<&'static str> {
        let found = BUILT_IN.iter().find(|(own, _)| *own == name);
        found.map(|(_, text)| *text)
    }

    /// The paper's motor under the paper's PI.
    ///
    /// # Panics
    /// Never, as a test shows.
    #[must_use]
    pub fn paper() -> Self {
        Self::read(BUILT_IN[0].1).expect("built in")
    }

    /// Reads a system's TOML.
    ///
    /// # Errors
    /// [`Fault`], with line and column, for what is no system.
    pub fn read(text: &str) -> Result<Self, Fault> {
        let file: SystemFile = toml::from_str(text).map_err(|error| {
            Fault::new(
                text,
                error.span().unwrap_or(0..0),
                error.message(),
                "see `webloop system show motor` for an example",
            )
        })?;
        let source = Source(text);
        let name = file.name.get_ref();
        if !is_name(name) {
            return Err(source.fault(
                &file.name,
                format!("`{name}` is not a valid system name"),
                "use up to 40 of a-z, 0-9 and -",
            ));
        }
        Ok(Self {
            r: match &file.r {
                Some(r) => source.finite("r", r)?,
                None => 1.0,
            },
            plant: plant::plant(source, &file.plant)?,
            recipe: Recipe::read(source, &file.controller)?,
            about: file.about,
            name: name.clone(),
            text: text.to_owned(),
        })
    }

    /// Name of the system.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text that it was read from.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text, where it is not the paper's, which whoever runs an end has already.
    #[must_use]
    pub fn own_text(&self) -> Option<&str> {
        (!self.is_paper()).then_some(self.text.as_str())
    }

    /// A sentence on what it is; may be empty.
    #[must_use]
    pub fn about(&self) -> &str {
        &self.about
    }

    /// The reference that its output is to reach.
    #[must_use]
    pub fn r(&self) -> f64 {
        self.r
    }

    /// The plant, continuous.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Whether it is the paper's: no other may have its name.
    #[must_use]
    pub fn is_paper(&self) -> bool {
        self.name == Self::PAPER
    }

    /// Whether its law can do what a client's settings ask of it.
    ///
    /// # Errors
    /// [`InvalidSetting`] where it advances by h alone, and the time that has really passed is asked for.
    pub fn check(&self, settings: &ControllerSettings) -> Result<(), InvalidSetting> {
        if settings.integrate == Integrate::Elapsed && !self.recipe.takes_elapsed() {
            return Err(InvalidSetting {
                name: "integrate",
                problem: format!("the law of {} always advances by h", self.name),
                remedy: "leave `elapsed` out",
            });
        }
        Ok(())
    }

    /// Whether its law estimates the plant's states from the output, with a Kalman filter.
    #[must_use]
    pub fn has_estimator(&self) -> bool {
        self.recipe.has_estimator()
    }

    /// Whether its plant, left alone, runs away: a pole has a positive real part. An integrator has none.
    #[must_use]
    pub fn is_unstable(&self) -> bool {
        // Of a pole at 0 the eigenvalues are as far off as their arithmetic.
        const NOISE_PER_S: f64 = 1e-6;
        let poles = self.plant.model.poles();
        poles.iter().any(|pole| pole.re > NOISE_PER_S)
    }

    /// The same with other gains; `None` where its law has no such gains, or they are not finite.
    #[must_use]
    pub fn with_gains(&self, kp: Option<f64>, ki: Option<f64>) -> Option<Self> {
        Some(Self {
            recipe: self.recipe.with_gains(kp, ki)?,
            ..self.clone()
        })
    }

    /// The system at a sample time.
    ///
    /// # Errors
    /// [`Unfit`] where it cannot be sampled with this h, or its law does not come out.
    pub fn at(&self, h: SampleTime) -> Result<Loop, Unfit> {
        self.sampled(h).map_err(|obstacle| Unfit {
            system: self.name.clone(),
            h,
            obstacle,
        })
    }

    fn sampled(&self, h: SampleTime) -> Result<Loop, Obstacle> {
        let plant = self.plant.sampled(h.ns())?;
        let (law, design) = self.recipe.at(&plant, h.ns())?;
        Ok(Loop { plant, law, design })
    }
}

/// Whether a text can name a system, an experiment or a sweep, and so a results folder: up to 40 of
/// a-z, 0-9 and -.
#[must_use]
pub fn is_name(text: &str) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (1..=40).contains(&text.len()) && text.chars().all(plain)
}

impl Loop {
    /// The loop cut open: the plant and behind it the law, from an error to the next command's
    /// effect, without a network.
    ///
    /// # Errors
    /// [`NotOpened`] where a coefficient overflows, or there are too many of them to be of use.
    pub fn open(&self) -> Result<TransferFunction<Discrete>, NotOpened> {
        for (what, order, most) in [
            ("plant", self.plant.delay_ticks, PLANT_TICKS),
            ("law", self.law.order(), LAW_ORDER),
        ] {
            if order > most {
                return Err(NotOpened::Order { what, order, most });
            }
        }
        let law = self.law.transfer_function(self.plant.h_s())?;
        Ok(self.plant.transfer_function()?.series(&law)?)
    }
}
