//! Checks that an experiment could have produced a plan. `matrix` makes only valid plans, but a plan
//! read from a file can contain anything.
//!
//! Names in a plan become names of folders and files, so they must not be paths.

use std::collections::{BTreeMap, BTreeSet};

use crate::system::System;
use endpoint::SampleTime;
use text::{WEEK_NS, is_device, is_name};

use crate::cell::Cell;
use crate::file_name;
use crate::limit::{CELLS_MAX, ID_MAX, TOGETHER_MAX};
use crate::plan::Plan;
use crate::seed::link_seed;
use crate::stall::stalling_seed;
use crate::unsound::{Unsound, UnsoundCell, UnsoundName};

/// Longest name of a file on any Linux file system, bytes.
const NAME_MAX: usize = 255;

impl Plan {
    /// Checks that an experiment can produce this plan.
    ///
    /// # Errors
    /// [`Unsound`]: the first thing that is wrong, with its cell.
    pub(crate) fn check(&self) -> Result<(), Unsound> {
        if !is_name(&self.experiment) {
            return Err(Unsound::Name(self.experiment.clone()));
        }
        if self.cells.len() > CELLS_MAX {
            return Err(Unsound::Cells);
        }
        self.check_profiles()?;
        self.check_sweep()?;
        self.check_systems()?;
        self.check_programs()?;
        self.check_faults()?;
        let (mut ids, mut indices) = (BTreeSet::new(), BTreeSet::new());
        for cell in &self.cells {
            let wrong = |problem| Unsound::Cell {
                index: cell.index,
                id: cell.id.clone(),
                problem,
            };
            self.check_cell(cell).map_err(wrong)?;
            if !ids.insert(&cell.id) {
                return Err(wrong(UnsoundCell::SameId));
            }
            if !indices.insert(cell.index) {
                return Err(wrong(UnsoundCell::SameIndex));
            }
        }
        // Last, since what is wrong with its fields is the cause.
        if let Some(cell) = self.cells.iter().find(|cell| !cell.is_identified()) {
            return Err(Unsound::Unidentified {
                index: cell.index,
                id: cell.id.clone(),
            });
        }
        let mut expected = self.expect.iter().flat_map(|of| &of.cells);
        if let Some(index) = expected.find(|index| !indices.contains(index)) {
            return Err(Unsound::Expected(*index));
        }
        Ok(())
    }

    fn check_sweep(&self) -> Result<(), Unsound> {
        match self.swept() {
            Ok(Some(_)) if !self.cells.is_empty() => Err(Unsound::CellsBesideSweep),
            Ok(_) => Ok(()),
            Err(problem) => Err(Unsound::Sweep(problem.title())),
        }
    }

    fn check_profiles(&self) -> Result<(), Unsound> {
        for (name, text) in &self.profiles {
            let profile = text.profile(name).map_err(|findings| {
                let first = findings.first();
                Unsound::Profile {
                    name: name.clone(),
                    problem: first.map_or(String::new(), |first| first.problem.clone()),
                }
            })?;
            if profile.name() != name {
                return Err(Unsound::Called {
                    what: "profile",
                    name: name.clone(),
                    own: profile.name().to_owned(),
                });
            }
            let other = |trace: &&String| !is_file_name(trace) || is_ours(trace);
            if let Some(trace) = text.traces.keys().find(other) {
                return Err(Unsound::Trace {
                    name: name.clone(),
                    trace: trace.escape_debug().to_string(),
                });
            }
            let mut folded = BTreeSet::new();
            let twin = |trace: &&String| !folded.insert(trace.to_lowercase());
            if let Some(trace) = text.traces.keys().find(twin) {
                return Err(Unsound::Twins {
                    name: name.clone(),
                    trace: trace.escape_debug().to_string(),
                });
            }
        }
        Ok(())
    }

    fn check_systems(&self) -> Result<(), Unsound> {
        for (name, text) in &self.systems {
            let system = System::read(text).map_err(|fault| Unsound::System {
                name: name.clone(),
                fault: fault.inside(),
            })?;
            if system.name() != name || name == System::PAPER {
                return Err(Unsound::Called {
                    what: "system",
                    name: name.clone(),
                    own: system.name().to_owned(),
                });
            }
            if system.plant_program().is_some() != self.plants.contains_key(name) {
                return Err(Unsound::Plant(name.clone()));
            }
        }
        // The design of a system for an h is checked once, not for each cell that has both.
        let mut known: BTreeMap<(&str, SampleTime), ()> = BTreeMap::new();
        for cell in &self.cells {
            let pair = (cell.system.as_str(), cell.settings.h);
            if known.insert(pair, ()).is_none() {
                let system = self.system(cell).map_err(UnsoundName::from);
                let fit = system.and_then(|system| Ok(system.law_at(cell.settings.h)?));
                fit.map_err(|problem| Unsound::Named {
                    index: cell.index,
                    problem,
                })?;
            }
        }
        Ok(())
    }

    fn check_programs(&self) -> Result<(), Unsound> {
        let controllers = self.programs.iter();
        let controllers = controllers.map(|(name, program)| (name.as_str(), program));
        let plants = self.plants.iter();
        let plants = plants.map(|(name, program)| (name.as_str(), program));
        for (name, program) in controllers.chain(plants) {
            if program.is_empty() {
                return Err(Unsound::Program(name.to_owned()));
            }
        }
        for cell in &self.cells {
            if cell.client.is_own() && self.program(cell).is_none() {
                return Err(Unsound::Named {
                    index: cell.index,
                    problem: UnsoundName::Program(cell.client.to_string()),
                });
            }
        }
        Ok(())
    }

    fn check_cell(&self, cell: &Cell) -> Result<(), UnsoundCell> {
        if !is_id(&cell.id) {
            return Err(UnsoundCell::Id);
        }
        if !self.profiles.contains_key(&cell.topology) {
            return Err(UnsoundCell::Profile(cell.topology.clone()));
        }
        for (field, ns) in [
            ("duration_ns", cell.duration_ns),
            ("timeout_ns", cell.settings.timeout_ns),
        ] {
            if !(1..=WEEK_NS).contains(&ns) {
                return Err(UnsoundCell::Time { field, ns });
            }
        }
        let h = cell.settings.h;
        if h.ns() > cell.duration_ns {
            return Err(UnsoundCell::SampleTime(h));
        }
        if cell.repeat == 0 {
            return Err(UnsoundCell::Repeat);
        }
        if !(1..=TOGETHER_MAX).contains(&cell.together) {
            return Err(UnsoundCell::Together(cell.together));
        }
        let seed = link_seed(self.seed, &cell.topology, cell.repeat);
        // The seed may also come from `stall_met`. That search takes milliseconds, so it is made only
        // if the usual seed does not match.
        let stalling = || {
            let profile = self.profiles.get(&cell.topology)?;
            let profile = profile.profile(&cell.topology).ok()?;
            stalling_seed(self.seed, &profile, &cell.topology, cell.repeat)
        };
        if cell.link_seed != seed && stalling() != Some(cell.link_seed) {
            return Err(UnsoundCell::Seed {
                found: cell.link_seed,
                seed: self.seed,
                due: seed,
            });
        }
        let page = match (&cell.page, cell.client.is_browser()) {
            (Some(page), true) => page.check(&cell.settings),
            (None, false) => Ok(()),
            (Some(_), false) => return Err(UnsoundCell::Page),
            (None, true) => return Err(UnsoundCell::NoPage),
        };
        page.and_then(|()| cell.client.check(&cell.settings, cell.lease))
            .map_err(|invalid| UnsoundCell::Setting(invalid.to_string()))
    }
}

/// Whether `text` can name a cell's folder: it must not lead elsewhere, nor be a name that a run, or
/// collecting, leaves beside such a folder.
fn is_id(text: &str) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.');
    (1..=ID_MAX).contains(&text.len())
        && text.starts_with(|c: char| c.is_ascii_alphanumeric())
        && text.chars().all(plain)
        && !text.ends_with(".partial")
        && ![".unfinished-", ".disturbed-"]
            .iter()
            .any(|aside| text.contains(aside))
}

/// Whether `text` names a file directly in a folder.
#[must_use]
pub fn is_file_name(text: &str) -> bool {
    (1..=NAME_MAX).contains(&text.len())
        && !text.starts_with(['.', '-'])
        && !text
            .contains(|c: char| matches!(c, '/' | '\\' | ':') || text::is_active(c) || c == '\t')
        && !text.contains('\n')
        && !is_device(text)
}

/// Whether a run may write a file of this name itself.
fn is_ours(name: &str) -> bool {
    // There are file systems on which `Ticks.csv` is the same file.
    let name = name.to_lowercase();
    const ROWS: [&str; 12] = [
        file_name::TICKS,
        file_name::SECOND,
        file_name::ARRIVALS,
        file_name::MESSAGES,
        file_name::PROBES,
        file_name::LINK,
        file_name::LINK_UP,
        file_name::LINK_DOWN,
        file_name::PACKETS,
        file_name::PACKETS_UP,
        file_name::PACKETS_DOWN,
        file_name::SIGHTINGS,
    ];
    ROWS.contains(&name.as_str())
        || ["messages-", "echoes-"]
            .iter()
            .any(|start| name.starts_with(start))
        || [".json", ".toml", ".log", ".partial"]
            .iter()
            .any(|end| name.ends_with(end))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;
    use serde_json::{Value, json};

    use super::*;
    use crate::instead::Instead;
    use crate::profile_text::ProfileText;

    /// A plan of two cells, one of them with a page.
    fn plan() -> Plan {
        let source = "name = \"mine\"\n[[cells]]\ntopology = [\"couva\"]\nclient = [\"native\", \"firefox\"]\n\
                      mode = \"closed\"\nh = [\"3ms\"]\nduration = \"1s\"\nsystem = [\"lag\"]\n";
        let profile = |name: &str| {
            Ok(ProfileText {
                source: link::Profile::builtin(name).unwrap().to_owned(),
                ..ProfileText::default()
            })
        };
        Plan::resolve(source, "mine.toml", &Instead::default(), profile).unwrap()
    }

    /// The error for the plan with `value` at the JSON pointer `at`.
    fn said(at: &str, value: Value) -> String {
        let mut json: Value = serde_json::from_str(&plan().to_json()).unwrap();
        // Indexing also adds a field that is left out because it has its default, such as `together`.
        let (object, field) = at.rsplit_once('/').unwrap();
        json.pointer_mut(object).unwrap()[field] = value;
        Plan::from_json(&json.to_string()).unwrap_err().to_string()
    }

    #[test]
    fn what_no_experiment_comes_to_is_refused_with_its_cell() {
        for id in [
            "",
            ".",
            "..",
            "../x",
            "/abs",
            "a/b",
            ".hidden",
            "a b",
            "a\u{e9}",
            "x.partial",
            "x.unfinished-1",
            "-rf",
            "--out",
            "CON",
            "A",
            "a\u{0}b",
            "a\nb",
            "a\\b",
        ] {
            assert!(
                said("/cells/0/id", json!(id)).contains("cannot name a folder"),
                "{id}"
            );
        }
        let good = plan().cells[0].id.clone();
        let (words, print) = good.rsplit_once('-').unwrap();
        for id in [
            "con".to_owned(),
            "nul.txt".to_owned(),
            words.to_owned(),
            format!("{words}-{print}0"),
            format!("{words}-xyzxyz"),
            good.replace("couva", "arima"),
        ] {
            assert!(
                said("/cells/0/id", json!(id)).contains("not that of such a cell"),
                "{id}"
            );
        }
        let long = "x".repeat(ID_MAX + 1);
        assert!(said("/cells/0/id", json!(long)).contains("cannot name a folder"));
        let other = plan().cells[1].id.clone();
        let cases = [
            ("/cells/0/id", json!(other), "another cell has the same id"),
            ("/cells/0/index", json!(1), "another cell has this index"),
            (
                "/cells/0/topology",
                json!("nowhere"),
                "no profile `nowhere`",
            ),
            ("/cells/0/system", json!("nothing"), "no system `nothing`"),
            ("/cells/0/duration_ns", json!(0), "duration_ns 0"),
            (
                "/cells/0/duration_ns",
                json!(604_800_000_000_001_u64),
                "a week",
            ),
            ("/cells/0/duration_ns", json!(1), "longer than the run"),
            ("/cells/0/settings/timeout_ns", json!(0), "timeout_ns 0"),
            ("/cells/0/settings/h", json!("0s"), "sample time"),
            ("/cells/0/repeat", json!(0), "repeat 0"),
            ("/cells/0/together", json!(0), "together 0"),
            ("/cells/0/link_seed", json!(7), "link_seed 7"),
            ("/cells/1/page", Value::Null, "a browser has a page"),
            ("/seed", json!(2), "the plan's seed 2"),
            (
                "/experiment",
                json!("../../x"),
                "is not a valid name of a results folder",
            ),
            (
                "/profiles/couva/source",
                json!(link::Profile::builtin("arima")),
                "calls itself `arima`",
            ),
            (
                "/profiles/couva/source",
                json!("name ="),
                "cannot be played",
            ),
            ("/systems/lag", json!("name ="), "line 1"),
            ("/cells/0/client", json!("mine"), "no program `mine`"),
            (
                "/programs",
                json!({"mine": {"run": []}}),
                "nothing to `run`",
            ),
        ];
        for (at, value, words) in cases {
            let said = said(at, value.clone());
            assert!(said.contains(words), "{at} = {value}: {said}");
        }
    }

    #[test]
    fn a_trace_is_a_plain_name_and_none_of_a_run_s_own() {
        for name in [
            "../x.csv",
            "/x.csv",
            ".x",
            "",
            "ticks.csv",
            "manifest.json",
            "link.log",
            "a/b",
            "-rf",
            "con.csv",
            "NUL",
            "Ticks.csv",
            "a:b",
            "a\tb",
            "a\u{202e}b",
        ] {
            let mut plan = plan();
            let profile = plan.profiles.get_mut("couva").unwrap();
            profile.traces.insert(name.to_owned(), String::new());
            let said = plan.check().unwrap_err().to_string();
            assert!(said.contains("trace"), "{name}: {said}");
        }
        let mut plan = plan();
        let profile = plan.profiles.get_mut("couva").unwrap();
        profile
            .traces
            .insert("my link-trace.csv".to_owned(), String::new());
        assert_eq!(plan.check(), Ok(()));
        let profile = plan.profiles.get_mut("couva").unwrap();
        profile
            .traces
            .insert("My link-trace.csv".to_owned(), String::new());
        assert!(
            plan.check()
                .unwrap_err()
                .to_string()
                .contains("upper and lower case")
        );
    }

    proptest! {
        #[test]
        fn whatever_an_id_is_its_folder_is_in_the_campaign_s(id in "\\PC{0,12}|[./a-]{0,6}") {
            if is_id(&id) {
                let path = std::path::Path::new("cells").join(&id);
                prop_assert_eq!(path.components().count(), 2);
                prop_assert_eq!(path.file_name(), Some(std::ffi::OsStr::new(&id)));
            }
        }
    }
}
