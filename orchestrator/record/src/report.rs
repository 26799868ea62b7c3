//! The reports of plant and controller, whichever program they were, and how any role's report is read.

use std::io::{self, ErrorKind};
use std::path::Path;

use endpoint::Counts;
use endpoint::report::{ControllerGranted, Native, Own, Plant, Python, Scheduling, Visit, Written};
use schemars::JsonSchema;
use serde::de::{DeserializeOwned, Error, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use sim::Timing;

use crate::file;

/// The report that a role left in a cell's folder as `name`; `None` if it left none.
///
/// # Errors
/// If it is no file that can be read, or says something else than such a report.
pub fn read<R: DeserializeOwned>(folder: &Path, name: &str) -> io::Result<Option<R>> {
    match file::text(&folder.join(name), file::REPORT_BYTES) {
        Ok(text) => Ok(Some(serde_json::from_str(&text)?)),
        Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
        Err(problem) => Err(problem),
    }
}

/// A plant's report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum PlantReport {
    /// Of a process.
    Real(Box<Plant>),
    /// Of virtual time.
    Model(ModelPlant),
}

/// What virtual time says of its plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelPlant {
    /// Rows of `arrivals.csv`.
    pub arrival_rows: Written,
    /// Rows of `second.csv`, where there is a second input or output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_rows: Option<Written>,
    /// Rows of `ticks.csv`.
    pub tick_rows: Written,
}

impl PlantReport {
    /// The report of a process; `None` in virtual time.
    #[must_use]
    pub fn real(&self) -> Option<&Plant> {
        match self {
            Self::Real(plant) => Some(plant),
            Self::Model(_) => None,
        }
    }

    /// Rows of `ticks.csv`.
    #[must_use]
    pub fn tick_rows(&self) -> Written {
        match self {
            Self::Real(plant) => plant.tick_rows,
            Self::Model(plant) => plant.tick_rows,
        }
    }

    /// Rows of `second.csv`; `None` if there is no second input or output.
    #[must_use]
    pub fn second_rows(&self) -> Option<Written> {
        match self {
            Self::Real(plant) => plant.second_rows,
            Self::Model(plant) => plant.second_rows,
        }
    }

    /// Rows of `arrivals.csv`.
    #[must_use]
    pub fn arrival_rows(&self) -> Written {
        match self {
            Self::Real(plant) => plant.arrival_rows,
            Self::Model(plant) => plant.arrival_rows,
        }
    }

    /// Rows that pages sent, over all sessions; `None` in virtual time.
    #[must_use]
    pub fn page_rows(&self) -> Option<Written> {
        self.real().map(|plant| plant.page_rows)
    }

    /// Requests that were refused. A command that came and was dropped as stale or aged is none.
    #[must_use]
    pub fn refused(&self) -> u64 {
        let dropped = |plant: &Plant| {
            let of = |kind| plant.refusals.get(kind).copied().unwrap_or_default();
            of("stale") + of("aged")
        };
        self.real()
            .map_or(0, |plant| plant.refused.saturating_sub(dropped(plant)))
    }

    /// Number of sessions that pages have held.
    #[must_use]
    pub fn sessions(&self) -> u64 {
        self.real().map_or(0, |plant| plant.sessions)
    }

    /// The scheduling granted to the thread that steps the model; `None` in virtual time.
    #[must_use]
    pub fn ticker(&self) -> Option<&Scheduling> {
        self.real().map(|plant| &plant.granted.ticker)
    }

    /// Number of rows, over all files, that found their ring full and were lost.
    #[must_use]
    pub fn overflow(&self) -> u64 {
        let page = self.page_rows().unwrap_or_default();
        let second = self.second_rows().unwrap_or_default();
        let all = [self.tick_rows(), second, self.arrival_rows(), page];
        all.iter().map(|rows| rows.overflow).sum()
    }
}

impl<'de> Deserialize<'de> for PlantReport {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct PlantMark {
            address: Option<IgnoredAny>,
        }
        let report = Value::deserialize(deserializer)?;
        let kind = PlantMark::deserialize(&report).map_err(D::Error::custom)?;
        match kind.address {
            Some(_) => Plant::deserialize(report).map(|plant| Self::Real(plant.into())),
            None => ModelPlant::deserialize(report).map(Self::Model),
        }
        .map_err(D::Error::custom)
    }
}

/// A controller's report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum ControllerReport {
    /// Of the native controller.
    Native(Box<Native>),
    /// Of Python's.
    Python(Box<Python>),
    /// Of whoever started a browser on the page, which has a report of its own.
    Visit(Box<Visit>),
    /// Of whoever supervised a program of one's own.
    Own(Box<Own>),
    /// Of virtual time.
    Model(Box<ModelController>),
}

/// What virtual time says of its controller, whichever client it stands for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelController {
    /// Connections opened.
    pub connections: u64,
    /// What became of the deadlines.
    pub counts: Counts,
    /// Packets that were lost and sent again.
    pub resent: u64,
    /// Rows of `messages.csv`.
    pub rows: Written,
    /// What the machine's programs were said to take.
    pub timing: Timing,
}

impl ControllerReport {
    /// Rows of `messages.csv`, as far as the controller knows: for a page, the plant counts them, and for a
    /// program of one's own they are made from the plant's.
    #[must_use]
    pub fn rows(&self) -> Written {
        match self {
            Self::Native(native) => native.rows,
            Self::Python(python) => python.rows,
            Self::Visit(visit) => visit.rows,
            Self::Own(_) => Written::default(),
            Self::Model(model) => model.rows,
        }
    }

    /// What became of the deadlines; `None` for a page, whose own report has them, and for a program of
    /// one's own.
    #[must_use]
    pub fn counts(&self) -> Option<&Counts> {
        match self {
            Self::Native(native) => Some(&native.counts),
            Self::Python(python) => Some(&python.counts),
            Self::Visit(_) | Self::Own(_) => None,
            Self::Model(model) => Some(&model.counts),
        }
    }

    /// The scheduling granted to the controller's thread; `None` for a page, for a program of one's own and
    /// in virtual time.
    #[must_use]
    pub fn scheduling(&self) -> Option<&Scheduling> {
        let granted: &ControllerGranted = match self {
            Self::Native(native) => &native.granted,
            Self::Python(python) => &python.granted,
            Self::Visit(_) | Self::Own(_) | Self::Model(_) => return None,
        };
        Some(&granted.controller)
    }
}

/// Finds the kind first, by a field that only this kind has, so that an error names what is wrong
/// within the kind.
impl<'de> Deserialize<'de> for ControllerReport {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct ControllerMark {
            python: Option<IgnoredAny>,
            browser: Option<IgnoredAny>,
            timing: Option<IgnoredAny>,
            run: Option<IgnoredAny>,
        }
        let report = Value::deserialize(deserializer)?;
        let kind = ControllerMark::deserialize(&report).map_err(D::Error::custom)?;
        if kind.python.is_some() {
            Python::deserialize(report).map(|python| Self::Python(python.into()))
        } else if kind.browser.is_some() {
            Visit::deserialize(report).map(|visit| Self::Visit(visit.into()))
        } else if kind.run.is_some() {
            Own::deserialize(report).map(|own| Self::Own(own.into()))
        } else if kind.timing.is_some() {
            ModelController::deserialize(report).map(|model| Self::Model(model.into()))
        } else {
            Native::deserialize(report).map(|native| Self::Native(native.into()))
        }
        .map_err(D::Error::custom)
    }
}
