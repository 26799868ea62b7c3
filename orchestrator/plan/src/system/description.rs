//! A valid system: its plant, its law and its reference. What it is at a sample time, `sampled` has.

use endpoint::{
    ControllerSettings, Integrate, InvalidReference, InvalidSetting, Reference, SampleTime, Shape,
    Surroundings,
};
use text::Diagnostic;

use crate::system::around;
use crate::system::fault::Source;
use crate::system::file::SystemFile;
use crate::system::holding::{self, Holding};
use crate::system::law::Recipe;
use crate::system::plant;
use crate::system::plant::PlantModel;
use crate::system::program::Program;
use crate::system::reference;

/// A plant, its law, and its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    pub(super) name: String,
    about: String,
    r: f64,
    reference: Option<Shape>,
    pub(super) plant: PlantModel,
    inputs: usize,
    surroundings: Option<Surroundings>,
    holding: Holding,
    x0: Vec<f64>,
    pub(super) recipe: Recipe,
    text: String,
}

macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../../../../services/systems/", $name, ".toml")))),+]
    };
}

/// The built-in systems, by name; the first is the paper's.
const BUILT_IN: [(&str, &str); 10] = built_in![
    "motor",
    "lag",
    "lag-smith",
    "double-integrator",
    "pendulum",
    "puma-joint",
    "quadrotor",
    "cart",
    "motor-load",
    "motor-kalman",
];

impl System {
    /// The paper's system, the default.
    pub const PAPER: &str = "motor";

    /// The names of the built-in systems, the paper's first.
    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// The text of a built-in system.
    #[must_use]
    pub fn built_in(name: &str) -> Option<&'static str> {
        let found = BUILT_IN.iter().find(|(own, _)| *own == name);
        found.map(|(_, text)| *text)
    }

    /// The paper's motor under the paper's PI.
    ///
    /// # Panics
    /// Never; a test checks that.
    #[must_use]
    pub fn paper() -> Self {
        Self::read(BUILT_IN[0].1).expect("built in")
    }

    /// Reads a system's TOML.
    ///
    /// # Errors
    /// [`Diagnostic`], with line and column, if the text is not a valid system.
    pub fn read(text: &str) -> Result<Self, Diagnostic> {
        let source = Source(text);
        let file: SystemFile = source
            .text()
            .read("see `webloop system show motor` for an example")?;
        let name = source.text().name(&file.name)?;
        // By this name every end knows it, and asks for no text.
        if name == Self::PAPER && Self::built_in(&name) != Some(text) {
            return Err(source.fault(
                &file.name,
                format!("`{name}` is the name of the paper's system"),
                "give yours another `name`",
            ));
        }
        if let (Some(_), Some(reference)) = (&file.r, &file.reference) {
            return Err(source.fault(
                reference,
                "the system has both `r` and `[reference]`",
                "leave out the one that is not meant",
            ));
        }
        let shape = file.reference.as_ref();
        let plant = PlantModel::read(source, &file.plant)?;
        let r = reference::each(source, file.r.as_ref(), &plant)?;
        let (r, others) = r.split_first().unwrap_or((&1.0, &[]));
        Ok(Self {
            r: *r,
            reference: shape
                .map(|shape| reference::read(source, shape))
                .transpose()?,
            x0: plant::initial(source, &file.plant, &plant)?,
            inputs: plant::inputs(source, &file.plant, &plant)?,
            surroundings: around::read(source, &file.plant)?,
            holding: holding::read(source, &file.plant, &plant)?,
            recipe: Recipe::read(source, &file.controller, &plant, others)?,
            plant,
            about: file.about,
            name,
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

    /// The text, unless it is the paper's system, which every end already has.
    #[must_use]
    pub fn own_text(&self) -> Option<&str> {
        (!self.is_paper()).then_some(self.text.as_str())
    }

    /// A sentence that describes it; may be empty.
    #[must_use]
    pub fn about(&self) -> &str {
        &self.about
    }

    /// The reference for its first output, where that rests.
    #[must_use]
    pub fn r(&self) -> f64 {
        self.r
    }

    /// How its reference moves; `None` if it rests at [`System::r`].
    #[must_use]
    pub fn reference(&self) -> Option<&Shape> {
        self.reference.as_ref()
    }

    /// r at the first deadline of a run with this sample time and duration, and how it moves from there on.
    ///
    /// # Errors
    /// [`InvalidReference`] if it would change too often in that run.
    pub fn reference_over(
        &self,
        h: SampleTime,
        duration_ns: u64,
    ) -> Result<(f64, Option<Reference>), InvalidReference> {
        let Some(shape) = &self.reference else {
            return Ok((self.r, None));
        };
        let moving = shape.over(h, duration_ns)?;
        Ok((moving.at(0), Some(moving)))
    }

    /// The references of the outputs after the first; none where they have none.
    #[must_use]
    pub fn other_r(&self) -> &[f64] {
        self.recipe.other_r()
    }

    /// How many inputs its plant has: 1 or 2.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Whether its law gives a command for each input, which only that of a linear model does where there are two.
    #[must_use]
    pub fn gives_each_input(&self) -> bool {
        self.inputs == 1 || self.plant.linear().is_some()
    }

    /// Whether its plant is a linear model with one input and one output, as sweeps need it.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.plant
            .linear()
            .is_some_and(|plant| plant.model.is_single())
    }

    /// The plant: a continuous model, or a program.
    #[must_use]
    pub fn plant(&self) -> &PlantModel {
        &self.plant
    }

    /// The program that is the plant; `None` for a linear model.
    #[must_use]
    pub fn plant_program(&self) -> Option<&Program> {
        match &self.plant {
            PlantModel::Linear(_) => None,
            PlantModel::Program(program) => Some(program),
        }
    }

    /// What surrounds the plant's model; `None` for nothing.
    #[must_use]
    pub fn surroundings(&self) -> Option<Surroundings> {
        self.surroundings
    }

    /// What of its outputs counts as holding.
    #[must_use]
    pub fn holding(&self) -> &Holding {
        &self.holding
    }

    /// What a reader should know of it before a run, in sentences: see [`Holding::warnings`].
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let noise = self.surroundings.map_or(0.0, |around| around.noise);
        let moving = self.reference.is_some();
        let found = self.holding.warnings(self.r, self.y0(), noise);
        found.into_iter().filter(|_| !moving).collect()
    }

    /// The state of the plant's model at the loop's start; empty at rest.
    #[must_use]
    pub fn x0(&self) -> &[f64] {
        &self.x0
    }

    /// The first output at the loop's start.
    #[must_use]
    pub fn y0(&self) -> f64 {
        let output = |plant: &control::Plant| {
            let terms = plant
                .model
                .c()
                .row(0)
                .into_iter()
                .zip(&self.x0)
                .map(|(c, x)| c * x);
            // From 0, as the plant sums; the sum of no terms would be -0.
            terms.fold(0.0, |sum, term| sum + term)
        };
        self.plant.linear().map_or(0.0, output)
    }

    /// Whether it is the paper's: no other system has its name.
    #[must_use]
    pub fn is_paper(&self) -> bool {
        self.name == Self::PAPER
    }

    /// Checks whether its law can follow a client's settings.
    ///
    /// # Errors
    /// [`InvalidSetting`] if the law always advances by h and the settings ask for the elapsed time.
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

    /// Whether its law measures how old an output is. Margins are those for outputs as old as its `round_trip`.
    #[must_use]
    pub fn measures_age(&self) -> bool {
        self.recipe.measures_age()
    }

    /// Whether its law estimates the plant's states from the output, with a Kalman filter.
    #[must_use]
    pub fn has_estimator(&self) -> bool {
        self.recipe.has_estimator()
    }

    /// Whether its plant is unstable without control: a pole has a positive real part. An integrator
    /// has none, and of a program it is not known.
    #[must_use]
    pub fn is_unstable(&self) -> bool {
        // The eigenvalue of a pole at 0 is off by rounding.
        const NOISE_PER_S: f64 = 1e-6;
        self.plant
            .linear()
            .is_some_and(|plant| plant.model.poles().iter().any(|pole| pole.re > NOISE_PER_S))
    }

    /// The same system with other gains; `None` if its law has no such gains, or they are not finite.
    #[must_use]
    pub fn with_gains(&self, kp: Option<f64>, ki: Option<f64>) -> Option<Self> {
        Some(Self {
            recipe: self.recipe.with_gains(kp, ki)?,
            ..self.clone()
        })
    }
}
