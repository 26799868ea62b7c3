//! A plan: an experiment resolved into cells, together with the profiles and systems that they need.
//!
//! It is one JSON file that can be taken to another machine: `run-cell --plan P --index I`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use system::System;

use crate::{Cell, Client, Expectation, Fault, Known, OwnName, Program};

/// A profile as text: its TOML and the traces that it names.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileText {
    /// The TOML.
    pub source: String,
    /// Text of each trace file, by the name that the TOML has for it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub traces: BTreeMap<String, String>,
}

impl ProfileText {
    /// Reads the profile that the text describes; `origin` names it in findings.
    ///
    /// # Errors
    /// The findings that prevent the link from being played.
    pub fn profile(&self, origin: &str) -> Result<link::Profile, Vec<link::Finding>> {
        let trace = |name: &str| {
            self.traces
                .get(name)
                .cloned()
                .ok_or_else(|| format!("there is no trace file `{name}`"))
        };
        let (profile, mut findings) = link::Profile::read(&self.source, origin, &trace);
        findings.retain(|finding| finding.severity == link::Severity::Error);
        profile.ok_or(findings)
    }
}

/// Everything that a campaign will run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "webloop plan")]
pub struct Plan {
    /// Version of this format.
    pub version: u32,
    /// The experiment's name.
    pub experiment: String,
    /// The experiment's question.
    pub about: String,
    /// The campaign's seed; the links' seeds are derived from it.
    pub seed: u64,
    /// The profiles, by their own names.
    pub profiles: BTreeMap<String, ProfileText>,
    /// The texts of the systems beside the paper's, by their own names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub systems: BTreeMap<String, String>,
    /// The programs of one's own that close a loop, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub programs: BTreeMap<OwnName, Program>,
    /// The programs of one's own that are a plant, by the names of their systems.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub plants: BTreeMap<String, Program>,
    /// The faults that cells meet, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub faults: BTreeMap<String, Fault>,
    /// What is expected of the runs; not part of what they are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub expect: Vec<Expectation>,
    /// The failures of expectations that are known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub known: Vec<Known>,
    /// The cells, in the order in which they are run.
    pub cells: Vec<Cell>,
}

impl Plan {
    /// Version of the format that this code writes and reads.
    pub const VERSION: u32 = 1;

    /// The cell with this index, if it is in the plan.
    #[must_use]
    pub fn cell(&self, index: usize) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.index == index)
    }

    /// Whether the profile of a topology says that there is no link; `false` if the plan has no valid
    /// profile of that name.
    #[must_use]
    pub fn is_loopback(&self, topology: &str) -> bool {
        let text = self.profiles.get(topology);
        text.and_then(|text| text.profile(topology).ok())
            .is_some_and(|profile| profile.is_loopback())
    }

    /// The system of a cell.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the plan.
    pub fn system(&self, cell: &Cell) -> Result<System, String> {
        if cell.system == System::PAPER {
            return Ok(System::paper());
        }
        let text = self
            .systems
            .get(&cell.system)
            .ok_or_else(|| format!("the plan has no system `{}`", cell.system))?;
        System::read(text)
            .map_err(|fault| format!("the plan's system `{}`, line {fault}", cell.system))
    }

    /// The program of a cell that one's own controls; `None` for webloop's clients.
    #[must_use]
    pub fn program(&self, cell: &Cell) -> Option<&Program> {
        match cell.client {
            Client::Own(name) => self.programs.get(&name),
            _ => None,
        }
    }

    /// The program that is a cell's plant; `None` for a model of webloop's.
    #[must_use]
    pub fn plant_program(&self, cell: &Cell) -> Option<&Program> {
        self.plants.get(&cell.system)
    }

    /// The plan as a JSON text.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Plain data of strings and finite numbers: serialising it cannot fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Reads a plan from JSON; refuses one that no experiment can produce.
    ///
    /// # Errors
    /// A sentence that says what is wrong, with line and column or with the cell.
    pub fn from_json(text: &str) -> Result<Plan, String> {
        let plan: Plan = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if plan.version != Plan::VERSION {
            return Err(format!(
                "this plan has format version {}, and this webloop reads version {}",
                plan.version,
                Plan::VERSION
            ));
        }
        plan.check()?;
        Ok(plan)
    }
}
