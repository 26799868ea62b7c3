//! A plan: an experiment resolved into cells, together with the profiles and systems that they need.
//!
//! It is one JSON file that can be taken to another machine: `run-cell --plan P --index I`.

use std::collections::BTreeMap;

use crate::system::{Program, System};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cell::Cell;
use crate::client::Client;
use crate::expect::Expectation;
use crate::fault::Fault;
use crate::known::Known;
use crate::own::OwnName;
use crate::profile_text::ProfileText;
use crate::selection::Selection;
use crate::sweep::SweepText;
use crate::unsound::{NoSystem, NotAPlan};

/// Everything that a campaign will run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// The sweep that it has in place of cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepText>,
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

    /// The cells that `selection` includes, in the order in which they are run.
    #[must_use]
    pub fn chosen(&self, selection: &Selection) -> Vec<&Cell> {
        self.cells
            .iter()
            .filter(|cell| selection.takes(cell))
            .collect()
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
    /// [`NoSystem`] if the plan has none of that name, or its text cannot be read.
    pub fn system(&self, cell: &Cell) -> Result<System, NoSystem> {
        if cell.system == System::PAPER {
            return Ok(System::paper());
        }
        let text = self
            .systems
            .get(&cell.system)
            .ok_or_else(|| NoSystem::Missing(cell.system.clone()))?;
        System::read(text).map_err(|fault| NoSystem::Unread {
            name: cell.system.clone(),
            fault: fault.inside(),
        })
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
    /// [`NotAPlan`] with what is wrong, and line and column or the cell.
    pub fn from_json(text: &str) -> Result<Plan, NotAPlan> {
        let plan: Plan =
            serde_json::from_str(text).map_err(|error| NotAPlan::Json(error.to_string()))?;
        if plan.version != Plan::VERSION {
            return Err(NotAPlan::Version {
                found: plan.version,
                known: Plan::VERSION,
            });
        }
        plan.check()?;
        Ok(plan)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::instead::Instead;
    use link::{Link, LinkTime, Profile};

    const TRACED: &str = "name = 'traced'\nabout = ''\n[both.trace]\nfile = 'walk.csv'\n";
    const WALK: &str = "t_ms,delay_ms\n0,5\n100,9\n200,30\n";

    fn plan() -> Plan {
        let source = "name = \"mine\"\n[[cells]]\ntopology = [\"traced\", \"couva\"]\nclient = [\"native\"]\n\
                      mode = \"closed\"\nh = [\"3ms\"]\nduration = \"1s\"\nrepeats = 2\n";
        let profile = |name: &str| {
            Ok(match Profile::builtin(name) {
                Some(source) => ProfileText {
                    source: source.to_owned(),
                    ..ProfileText::default()
                },
                None => ProfileText {
                    source: TRACED.to_owned(),
                    traces: [("walk.csv".to_owned(), WALK.to_owned())].into(),
                    ..ProfileText::default()
                },
            })
        };
        Plan::resolve(source, "mine.toml", &Instead::default(), profile).unwrap()
    }

    #[test]
    fn a_plan_names_the_edition_of_a_link_with_a_trace_and_of_no_other() {
        let json: Value = serde_json::from_str(&plan().to_json()).unwrap();
        assert_eq!(json["profiles"]["traced"]["edition"], "second");
        assert_eq!(json["profiles"]["couva"]["edition"], Value::Null);
        let read = Plan::from_json(&json.to_string()).unwrap();
        assert_eq!(read, plan());
    }

    #[test]
    fn a_plan_of_before_there_were_editions_means_what_it_meant() {
        let mut json: Value = serde_json::from_str(&plan().to_json()).unwrap();
        let traced = json["profiles"]["traced"].as_object_mut().unwrap();
        traced.remove("edition").unwrap();
        let old = Plan::from_json(&json.to_string()).unwrap();
        let levels = |plan: &Plan, t_ms: u64| {
            let profile = plan.profiles["traced"].profile("traced").unwrap();
            let t = LinkTime::from_ns(t_ms * 1_000_000);
            let delays = plan.cells.iter().map(|cell| {
                let state = Link::new(&profile, cell.link_seed).up.state_at(t);
                state.delay_ns
            });
            delays.collect::<Vec<_>>()
        };
        // From its first step, the last one held, whatever the repeat.
        assert_eq!(levels(&old, 50), [5_000_000; 4]);
        assert_eq!(levels(&old, 90_000), [30_000_000; 4]);
        // Now each repeat begins elsewhere.
        let new = levels(&plan(), 50);
        assert_ne!(new[0], new[1]);
    }

    #[test]
    fn traces_that_a_plan_has_no_room_for_are_refused() {
        let source = "name = \"mine\"\n[[cells]]\ntopology = [\"a\", \"b\", \"c\", \"d\", \"e\"]\nclient = [\"native\"]\n\
                      mode = \"closed\"\nh = [\"3ms\"]\nduration = \"1s\"\n";
        let long = format!("{WALK}# {}\n", "x".repeat(14 << 20));
        let profile = |name: &str| {
            Ok(ProfileText {
                source: TRACED.replace("'traced'", &format!("'{name}'")),
                traces: [("walk.csv".to_owned(), long.clone())].into(),
                ..ProfileText::default()
            })
        };
        let refused = Plan::resolve(source, "mine.toml", &Instead::default(), profile);
        let said = refused.map(|_| ()).unwrap_err();
        assert!(
            format!("{said:?}").contains("a plan has room for"),
            "{said:?}"
        );
    }
}
