//! A system at a sample time: its plant and its law, and why it may have none.

use control::{InvalidDiscretisation, Law, OpenLoop, Plant, SampledPlant};
use endpoint::SampleTime;

use crate::system::description::System;
use crate::system::design::Design;
use crate::system::obstacle::Obstacle;

/// A system at a sample time.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// The plant that the plant's end steps.
    pub plant: SampledPlant,
    /// The law that the controller's end runs, at rest.
    pub law: Law,
    /// The law as numbers, for clients in other languages.
    pub design: Design,
    /// The plant before it was sampled, with all its digits.
    model: Plant,
    h_ns: u64,
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

impl System {
    /// The system at a sample time.
    ///
    /// # Errors
    /// [`Unfit`] if it cannot be sampled with this h, its law cannot be computed, or its plant is a program.
    pub fn at(&self, h: SampleTime) -> Result<Loop, Unfit> {
        self.loop_at(h).map_err(|obstacle| self.unfit(h, obstacle))
    }

    /// Its law at a sample time, with its numbers, whatever the plant is.
    ///
    /// # Errors
    /// [`Unfit`] if the law cannot be computed, or needs a model that there is not.
    pub fn law_at(&self, h: SampleTime) -> Result<(Law, Design), Unfit> {
        self.sampled(h)
            .and_then(|plant| self.recipe.at(plant.as_ref(), h.ns()))
            .map_err(|obstacle| self.unfit(h, obstacle))
    }

    fn loop_at(&self, h: SampleTime) -> Result<Loop, Obstacle> {
        let what = "computing the loop";
        let model = self.plant.linear().ok_or(Obstacle::NoModel { what })?;
        let plant = model.sampled(h.ns())?;
        let (law, design) = self.recipe.at(Some(&plant), h.ns())?;
        Ok(Loop {
            plant,
            law,
            design,
            model: model.clone(),
            h_ns: h.ns(),
        })
    }

    /// The plant at a sample time; `None` if it is a program.
    fn sampled(&self, h: SampleTime) -> Result<Option<SampledPlant>, Obstacle> {
        let sampled = self.plant.linear().map(|plant| plant.sampled(h.ns()));
        Ok(sampled.transpose()?)
    }

    fn unfit(&self, h: SampleTime, obstacle: Obstacle) -> Unfit {
        Unfit {
            system: self.name.clone(),
            h,
            obstacle,
        }
    }
}

impl Loop {
    /// The open loop: the plant followed by the law, from an error to the next command's effect,
    /// without a network.
    ///
    /// # Errors
    /// [`InvalidDiscretisation`] if a number overflows.
    pub fn open(&self) -> Result<OpenLoop, InvalidDiscretisation> {
        OpenLoop::new(&self.model, &self.law, self.h_ns)
    }
}
