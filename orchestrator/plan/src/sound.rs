//! Checks that an experiment could have produced a plan. `matrix` makes only valid plans, but a plan
//! read from a file can contain anything.
//!
//! Names in a plan become names of folders and files, so they must not be paths.

use std::collections::{BTreeMap, BTreeSet};

use endpoint::{DURATION_MAX_NS, SampleTime};
use system::{System, is_name};

use crate::matrix::{CELLS_MAX, TOGETHER_MAX};
use crate::stall::stalling_seed;
use crate::{Cell, Plan, file_name, link_seed};

/// Longest id, bytes: a file system allows 255, and a folder that is moved aside gets a suffix.
const ID_MAX: usize = 200;
/// Longest name of a file on any Linux file system, bytes.
const NAME_MAX: usize = 255;

impl Plan {
    /// Checks that an experiment can produce this plan.
    ///
    /// # Errors
    /// A sentence about the first thing that is wrong, with its cell.
    pub(crate) fn check(&self) -> Result<(), String> {
        if !is_name(&self.experiment) {
            return Err(format!(
                "`{}` is not a valid name of a results folder; use up to 40 of a-z, 0-9 and -",
                self.experiment
            ));
        }
        if self.cells.len() > CELLS_MAX {
            return Err(format!("it has more than {CELLS_MAX} cells"));
        }
        self.check_profiles()?;
        self.check_systems()?;
        self.check_programs()?;
        self.check_faults()?;
        let (mut ids, mut indices) = (BTreeSet::new(), BTreeSet::new());
        for cell in &self.cells {
            let place = format!("cell {}, {}", cell.index, cell.id.escape_debug());
            self.check_cell(cell)
                .map_err(|problem| format!("{place}: {problem}"))?;
            if !ids.insert(&cell.id) {
                return Err(format!(
                    "{place}: another cell has the same id, so the same folder"
                ));
            }
            if !indices.insert(cell.index) {
                return Err(format!("{place}: another cell has this index"));
            }
        }
        let mut expected = self.expect.iter().flat_map(|of| &of.cells);
        if let Some(index) = expected.find(|index| !indices.contains(index)) {
            return Err(format!(
                "it expects something of cell {index}, which it does not have"
            ));
        }
        Ok(())
    }

    fn check_profiles(&self) -> Result<(), String> {
        for (name, text) in &self.profiles {
            let profile = text.profile(name).map_err(|findings| {
                let first = findings.first();
                let words = first.map_or(String::new(), |first| first.message.clone());
                format!("its profile `{name}` cannot be played: {words}")
            })?;
            if profile.name() != name {
                return Err(format!(
                    "its profile `{name}` calls itself `{}`",
                    profile.name()
                ));
            }
            let other = |trace: &&String| !is_file_name(trace) || is_ours(trace);
            if let Some(trace) = text.traces.keys().find(other) {
                return Err(format!(
                    "its profile `{name}` has a trace `{}`, a name that a run's own files may \
                     have; call it something like {name}-trace.csv",
                    trace.escape_debug()
                ));
            }
        }
        Ok(())
    }

    fn check_systems(&self) -> Result<(), String> {
        for (name, text) in &self.systems {
            let system =
                System::read(text).map_err(|fault| format!("its system `{name}`, line {fault}"))?;
            if system.name() != name || name == System::PAPER {
                return Err(format!(
                    "its system `{name}` calls itself `{}`",
                    system.name()
                ));
            }
            if system.plant_program().is_some() != self.plants.contains_key(name) {
                return Err(format!(
                    "its system `{name}` and its `plants` do not agree on whether the plant is a program"
                ));
            }
        }
        // The design of a system for an h is checked once, not for each cell that has both.
        let mut known: BTreeMap<(&str, SampleTime), ()> = BTreeMap::new();
        for cell in &self.cells {
            let pair = (cell.system.as_str(), cell.settings.h);
            if known.insert(pair, ()).is_none() {
                let fit = self.system(cell).and_then(|system| {
                    system
                        .law_at(cell.settings.h)
                        .map_err(|unfit| unfit.to_string())
                });
                fit.map_err(|problem| format!("cell {}: {problem}", cell.index))?;
            }
        }
        Ok(())
    }

    fn check_programs(&self) -> Result<(), String> {
        let controllers = self.programs.iter();
        let controllers = controllers.map(|(name, program)| (name.as_str(), program));
        let plants = self.plants.iter();
        let plants = plants.map(|(name, program)| (name.as_str(), program));
        for (name, program) in controllers.chain(plants) {
            if program.is_empty() {
                return Err(format!("its program `{name}` has nothing to `run`"));
            }
        }
        for cell in &self.cells {
            if cell.client.is_own() && self.program(cell).is_none() {
                let client = cell.client;
                return Err(format!(
                    "cell {}: there is no program `{client}`",
                    cell.index
                ));
            }
        }
        Ok(())
    }

    fn check_cell(&self, cell: &Cell) -> Result<(), String> {
        if !is_id(&cell.id) {
            return Err(format!(
                "this id cannot name a folder; use up to {ID_MAX} letters, digits, `-`, `.` and \
                 `_`, and no dot at the beginning"
            ));
        }
        if !self.profiles.contains_key(&cell.topology) {
            return Err(format!(
                "there is no profile `{}`",
                cell.topology.escape_debug()
            ));
        }
        for (name, ns) in [
            ("duration_ns", cell.duration_ns),
            ("timeout_ns", cell.settings.timeout_ns),
        ] {
            if !(1..=DURATION_MAX_NS).contains(&ns) {
                return Err(format!("{name} {ns} is not between 0 and a week"));
            }
        }
        let h = cell.settings.h;
        if h.ns() > cell.duration_ns {
            return Err(format!("h = {h} is longer than the run"));
        }
        if cell.repeat == 0 {
            return Err("repeat 0; repeats count from 1".to_owned());
        }
        if !(1..=TOGETHER_MAX).contains(&cell.together) {
            return Err(format!(
                "together {} is not between 1 and {TOGETHER_MAX}",
                cell.together
            ));
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
            return Err(format!(
                "link_seed {} is not that of the plan's seed {}, which is {seed}",
                cell.link_seed, self.seed
            ));
        }
        let page = match (&cell.page, cell.client.is_browser()) {
            (Some(page), true) => page.check(&cell.settings),
            (None, false) => Ok(()),
            (Some(_), false) => return Err("only a browser has a page".to_owned()),
            (None, true) => return Err("a browser has a page".to_owned()),
        };
        page.and_then(|()| cell.settings.check())
            .map_err(|invalid| invalid.to_string())
    }
}

/// Whether `text` can name a cell's folder: it must not lead elsewhere, nor be a name that a run, or
/// collecting, leaves beside such a folder.
fn is_id(text: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_');
    (1..=ID_MAX).contains(&text.len())
        && !text.starts_with('.')
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
        && !text.starts_with('.')
        && !text.contains(|c: char| matches!(c, '/' | '\\') || c.is_control())
}

/// Whether a run may write a file of this name itself.
fn is_ours(name: &str) -> bool {
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
    ROWS.contains(&name)
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
    use crate::{Instead, ProfileText};

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
        Plan::from_json(&json.to_string()).unwrap_err()
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
        ] {
            assert!(
                said("/cells/0/id", json!(id)).contains("cannot name a folder"),
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
        ] {
            let mut plan = plan();
            let profile = plan.profiles.get_mut("couva").unwrap();
            profile.traces.insert(name.to_owned(), String::new());
            let said = plan.check().unwrap_err();
            assert!(said.contains("trace"), "{name}: {said}");
        }
        let mut plan = plan();
        let profile = plan.profiles.get_mut("couva").unwrap();
        profile
            .traces
            .insert("my link-trace.csv".to_owned(), String::new());
        assert_eq!(plan.check(), Ok(()));
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
