//! Whether a cell's folder is whole: what its manifest has to say before any of its rows is believed.
//!
//! A manifest vouches for the files that it lists, so it has to list those that a run of its kind
//! leaves, and to be of this plan: its cell, its seed, the link's own text. The rows themselves are
//! held against it while they are read, in [`crate::metrics`], with what is gathered here. Whoever
//! makes all of it anew, and alike, is not found out.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use plan::{Cell, FileFact, Manifest, Plan, Verdict};
use serde_json::Value;

use crate::rows::{OTHER_BYTES, ReadError, other_length};

/// The four files of rows that metrics are made of.
pub(crate) const ROWS: [&str; 4] = ["ticks.csv", "arrivals.csv", "messages.csv", "probes.csv"];
/// The back-end of virtual time, which leaves no page and no rows of a link.
pub(crate) const VIRTUAL: &str = "sim";

/// A file that is not what its manifest says.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct Damage {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: String,
}

impl Damage {
    /// What is damaged in a cell's folder, of the files that its manifest names.
    #[must_use]
    pub fn of(folder: &Path, manifest: &Manifest) -> Vec<Damage> {
        Damage::among(folder, manifest, |_| true)
    }

    pub(crate) fn among(
        folder: &Path,
        manifest: &Manifest,
        is_asked: impl Fn(&str) -> bool,
    ) -> Vec<Damage> {
        let asked = manifest.files.iter().filter(|(name, _)| is_asked(name));
        asked
            .filter_map(|(name, fact)| {
                let path = folder.join(name);
                let problem = problem(&path, fact)?;
                Some(Damage { path, problem })
            })
            .collect()
    }
}

impl From<ReadError> for Damage {
    fn from(error: ReadError) -> Self {
        let (path, problem) = error.parts();
        Damage { path, problem }
    }
}

/// What is wrong with a file, held against what is known of it.
fn problem(path: &Path, asked: &FileFact) -> Option<String> {
    let found = file::open(path).and_then(|file| {
        // A file with holes can be longer than anybody would wait for.
        let bytes = file.metadata()?.len();
        match bytes == asked.bytes {
            true => FileFact::of(file).map(Ok),
            false => Ok(Err(bytes)),
        }
    });
    match found {
        Ok(Ok(found)) if found == *asked => None,
        Ok(Ok(found)) if found.bytes == asked.bytes => Some(OTHER_BYTES.to_owned()),
        Ok(Ok(FileFact { bytes, .. }) | Err(bytes)) => Some(other_length(bytes, asked)),
        Err(problem) if problem.kind() == ErrorKind::NotFound => Some("it is gone".to_owned()),
        Err(problem) => Some(problem.to_string()),
    }
}

/// What is wrong with a manifest for the plan's cell, a sentence each; nothing is wrong with a whole
/// one.
pub(crate) fn faults(manifest: &Manifest, plan: &Plan, cell: &Cell) -> Vec<String> {
    let mut faults = Vec::new();
    if !manifest.cell.is_same(cell) {
        faults.push("it is of another cell than the plan's of this name".to_owned());
    }
    if manifest.experiment != plan.experiment || manifest.campaign_seed != plan.seed {
        faults.push(format!(
            "it is of {}, seed {}, and the plan is of {}, seed {}",
            manifest.experiment, manifest.campaign_seed, plan.experiment, plan.seed
        ));
    }
    if manifest.profile != cell.topology {
        faults.push(format!(
            "its profile is {}, and the plan's {}",
            manifest.profile, cell.topology
        ));
    }
    faults.extend(other_texts(manifest, plan, cell));
    if !has_rows(manifest.verdict) {
        return faults;
    }
    if manifest.files.is_empty() {
        faults.push("its list of files is empty, so it vouches for nothing".to_owned());
        return faults;
    }
    let is_loopback = plan.is_loopback(&cell.topology);
    let is_own_system = plan.systems.contains_key(&cell.system);
    faults.extend(lacking(manifest, is_loopback, is_own_system).map(|name| {
        format!("it does not list {name}, which such a run leaves, so it does not vouch for it")
    }));
    if manifest.verdict == Verdict::Complete {
        faults.extend(contradictions(manifest, is_loopback));
    }
    faults
}

/// Whether a run that ended so left its rows: one that did not come to its end may have none at all.
pub(crate) fn has_rows(verdict: Verdict) -> bool {
    !matches!(verdict, Verdict::Failed | Verdict::Unsupported)
}

/// The texts that the plan has, and the run was made with others.
fn other_texts(manifest: &Manifest, plan: &Plan, cell: &Cell) -> Vec<String> {
    let profile = plan.profiles.get(&cell.topology);
    let own = profile.map(|text| ("profile.toml", &text.source));
    let traces = profile.into_iter().flat_map(|text| &text.traces);
    let system = plan
        .systems
        .get(&cell.system)
        .map(|text| ("system.toml", text));
    own.into_iter()
        .chain(traces.map(|(name, text)| (name.as_str(), text)))
        .chain(system)
        .filter(|(name, text)| {
            let listed = manifest.files.get(*name);
            let is_own =
                |fact: &FileFact| FileFact::of(text.as_bytes()).is_ok_and(|own| own == *fact);
            listed.is_some_and(|fact| !is_own(fact))
        })
        .map(|(name, _)| format!("its {name} is another than the plan's"))
        .collect()
}

/// The files that a run of its kind leaves, and the manifest does not list.
fn lacking(
    manifest: &Manifest,
    is_loopback: bool,
    is_own_system: bool,
) -> impl Iterator<Item = &'static str> {
    let is_virtual = manifest.backend == VIRTUAL;
    let mut asked = ROWS.to_vec();
    asked.extend(["profile.toml", "plant.json", "controller.json"]);
    if manifest.cell.client.is_browser() && !is_virtual {
        asked.push("page.json");
    }
    if is_own_system {
        asked.push("system.toml");
    }
    if !is_loopback && is_virtual {
        asked.push("link.json");
    } else if !is_loopback {
        // One player of both ways, or one of each.
        asked.extend(match manifest.files.contains_key("link-up.json") {
            true => &[
                "link-up.json",
                "link-up.csv",
                "link-down.json",
                "link-down.csv",
            ][..],
            false => &["link.json", "link.csv"],
        });
    }
    asked
        .into_iter()
        .filter(|name| !manifest.files.contains_key(*name))
}

/// What a complete run cannot have in its manifest.
fn contradictions(manifest: &Manifest, is_loopback: bool) -> Vec<String> {
    let mut found = Vec::new();
    if let Some(reason) = manifest.reasons.first() {
        found.push(format!("it is complete and says why it is not: {reason}"));
    }
    let held = manifest
        .certificate
        .as_ref()
        .map(|of| of["verdict"] == "holds");
    match (is_loopback, held) {
        (false, None) => found.push("it is complete without its link's certificate".to_owned()),
        (false, Some(false)) => {
            found.push(
                "it is complete, and its certificate says that the link did not hold".to_owned(),
            );
        }
        (true, _) | (false, Some(true)) => {}
    }
    if (manifest.backend == VIRTUAL) != (manifest.player == "model") {
        found.push(format!(
            "it was run by {}, which has no player {}",
            manifest.backend, manifest.player
        ));
    }
    found
}

/// What the rows of a run are held against.
#[derive(Debug)]
pub(crate) struct Vouched<'a> {
    /// Length and checksum by name.
    pub(crate) files: &'a BTreeMap<String, FileFact>,
    /// How many rows whoever wrote them says that there are, by the file's name, with the report
    /// that says so. Echoes through the link are counted, not those of the empty one.
    pub(crate) counts: Vec<(&'static str, &'static str, u64)>,
    /// Whether rows are missing, as the run itself says: it is `invalid` then.
    pub(crate) has_gaps: bool,
}

impl<'a> Vouched<'a> {
    pub(crate) fn of(folder: &Path, manifest: &'a Manifest) -> Self {
        let from_file = |name: &str| -> Option<Value> {
            let text = file::text(&folder.join(name), file::REPORT_BYTES).ok()?;
            serde_json::from_str(&text).ok()
        };
        // The manifest has a copy of each: both have to be right.
        let plant = [from_file("plant.json"), manifest.plant.clone()];
        let controller = [from_file("controller.json"), manifest.controller.clone()];
        let is_page = manifest.cell.client.is_browser() && manifest.backend != VIRTUAL;
        let mut counts = Vec::new();
        for (origin, plant) in ["plant.json", "the plant's report"].into_iter().zip(&plant) {
            let Some(plant) = plant else { continue };
            let rows = |name: &str| plant[name]["rows"].as_u64();
            counts.extend(rows("tick_rows").map(|rows| ("ticks.csv", origin, rows)));
            counts.extend(rows("arrival_rows").map(|rows| ("arrivals.csv", origin, rows)));
            // The plant files a page's rows; those of several sessions are in several files.
            let of_page = rows("page_rows").filter(|_| is_page && plant["sessions"] == 1);
            counts.extend(of_page.map(|rows| ("messages.csv", origin, rows)));
        }
        let origins = ["controller.json", "the controller's report"];
        for (origin, controller) in origins.into_iter().zip(&controller) {
            let Some(controller) = controller else {
                continue;
            };
            let rows = controller["rows"]["rows"].as_u64().filter(|_| !is_page);
            counts.extend(rows.map(|rows| ("messages.csv", origin, rows)));
        }
        let sent = manifest
            .certificate
            .as_ref()
            .and_then(|of| of["sent"].as_u64());
        counts.extend(sent.map(|sent| ("probes.csv", "the certificate", sent)));
        let lost = |report: &Value| {
            ["tick_rows", "arrival_rows", "page_rows", "rows"]
                .iter()
                .any(|name| {
                    report[name]["overflow"]
                        .as_u64()
                        .is_some_and(|lost| lost > 0)
                })
        };
        Self {
            files: &manifest.files,
            counts,
            has_gaps: plant.iter().chain(&controller).flatten().any(lost),
        }
    }

    /// Whether a file has as many rows as were written.
    pub(crate) fn count(&self, name: &str, found: u64) -> Result<(), String> {
        let of_it = self.counts.iter().filter(|(file, ..)| *file == name);
        for (_, origin, rows) in of_it {
            if found != *rows {
                return Err(format!("it has {found} rows, and {origin} says {rows}"));
            }
        }
        Ok(())
    }
}
