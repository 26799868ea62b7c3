//! `ro-crate-metadata.json`: which program made what from which plan, as an RO-Crate 1.1 with the
//! profile Process Run Crate 0.5.
//!
//! A run of a cell is an action: webloop is its instrument, the plan its object, the cell's folder
//! its result. The files in a cell's folder are listed in its manifest, with length and checksum, and
//! not repeated here. Agents are left out: nothing in the folder says who they were.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use analysis::Run;
use jiff::{SignedDuration, Timestamp};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use plan::Verdict;
use record::{FileFact, Manifest, file};
use serde::Serialize;
use serde_json::Value;

use super::{LICENCE, PLAN, REPORT, SUMMARY, package, slashed};
use crate::report::Report;

/// The name of the file.
pub const FILE: &str = "ro-crate-metadata.json";

const CRATE: &str = "https://w3id.org/ro/crate/1.1";
const CONTEXT: &str = "https://w3id.org/ro/crate/1.1/context";
const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.5";

/// The characters that are escaped if a path is used as an address.
const PATH: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'.')
    .remove(b'_')
    .remove(b'~')
    .remove(b'/');

#[derive(Serialize)]
struct Crate {
    #[serde(rename = "@context")]
    context: &'static str,
    #[serde(rename = "@graph")]
    graph: Vec<Entity>,
}

/// An entity that the crate describes.
#[derive(Serialize)]
struct Entity {
    #[serde(rename = "@id")]
    id: String,
    #[serde(rename = "@type")]
    kind: &'static str,
    #[serde(flatten)]
    properties: BTreeMap<&'static str, Value>,
}

impl Entity {
    fn new(id: impl Into<String>, kind: &'static str) -> Entity {
        Entity {
            id: id.into(),
            kind,
            properties: BTreeMap::new(),
        }
    }

    fn with(mut self, name: &'static str, value: impl Into<Value>) -> Entity {
        self.properties.insert(name, value.into());
        self
    }

    /// Adds a property if it has a value.
    fn maybe(self, name: &'static str, value: Option<impl Into<Value>>) -> Entity {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }
}

/// The text of `ro-crate-metadata.json`; `files` are [`Report::files`].
#[must_use]
pub fn json(report: &Report<'_>, files: &[(PathBuf, Vec<u8>)]) -> String {
    let runs: Vec<(&Run, &Manifest)> = report
        .campaign
        .runs
        .iter()
        .filter_map(|run| Some((run, run.manifest.as_ref()?)))
        .collect();
    let mut parts = of_the_folder(report);
    parts.extend(files.iter().map(|(name, content)| {
        let name = slashed(&Path::new(REPORT).join(name));
        file(
            &name,
            "A part of the report.",
            FileFact::of(content.as_slice()).ok(),
        )
    }));
    parts.extend(runs.iter().map(|(run, manifest)| result(run, manifest)));
    let actions: Vec<Entity> = runs.iter().map(|(run, of)| action(run, of)).collect();
    let mut programs: Vec<&str> = runs.iter().map(|(_, of)| of.webloop.as_str()).collect();
    programs.sort_unstable();
    programs.dedup();

    let ended = runs.iter().filter_map(|(_, manifest)| ended(manifest));
    let root = Entity::new("./", "Dataset")
        .with("conformsTo", reference(PROFILE))
        .with("name", super::title(report.campaign))
        .with("description", super::description(report.campaign))
        .with("license", reference(LICENCE.url))
        .maybe("datePublished", ended.max().map(iso))
        .with("hasPart", references(&parts))
        .with("mentions", references(&actions));
    let descriptor = Entity::new(FILE, "CreativeWork")
        .with("conformsTo", reference(CRATE))
        .with("about", reference("./"));
    let graph = [descriptor, root]
        .into_iter()
        .chain(contexts())
        .chain(programs.into_iter().map(program))
        .chain(parts)
        .chain(actions)
        .collect();
    let metadata = Crate {
        context: CONTEXT,
        graph,
    };
    // Plain data of strings: serialising it cannot fail.
    serde_json::to_string_pretty(&metadata).unwrap_or_default() + "\n"
}

/// The profile and the licence.
fn contexts() -> [Entity; 2] {
    [
        Entity::new(PROFILE, "CreativeWork")
            .with("name", "Process Run Crate")
            .with("version", "0.5"),
        Entity::new(LICENCE.url, "CreativeWork")
            .with("name", LICENCE.title)
            .with(
                "description",
                "The terms of webloop itself, unless who publishes this folder says otherwise.",
            ),
    ]
}

/// A version of webloop.
fn program(version: &str) -> Entity {
    Entity::new(program_id(version), "SoftwareApplication")
        .with("name", "webloop")
        .with("softwareVersion", version)
        .with(
            "description",
            "Closes real control loops over real HTTP across emulated links.",
        )
}

fn program_id(version: &str) -> String {
    format!("#webloop-{}", address(version))
}

/// The files in the results folder itself. The package has no checksum here, since it is written
/// beside this file and not before it.
fn of_the_folder(report: &Report<'_>) -> Vec<Entity> {
    let found =
        |name: &str| FileFact::of(file::open(&report.campaign.folder.join(name)).ok()?).ok();
    let plan = "The experiment resolved into cells, with every setting, seed and link profile.";
    let mut files = vec![
        file(PLAN, plan, found(PLAN)),
        file(
            package::FILE,
            "Every CSV file, with columns and units.",
            None,
        ),
    ];
    if let Some(fact) = found(SUMMARY) {
        let about = "A row for each cell: what was measured.";
        files.push(file(SUMMARY, about, Some(fact)));
    }
    files
}

fn file(name: &str, description: &str, fact: Option<FileFact>) -> Entity {
    let (bytes, sha256) = fact.map(|fact| (fact.bytes, fact.sha256)).unzip();
    Entity::new(address(name), "File")
        .with("name", name)
        .with("description", description)
        .maybe("encodingFormat", media_type(name))
        .maybe("contentSize", bytes.map(|bytes| bytes.to_string()))
        .maybe("sha256", sha256)
}

fn media_type(name: &str) -> Option<&'static str> {
    let (_, extension) = name.rsplit_once('.')?;
    match extension {
        "csv" => Some("text/csv"),
        "html" => Some("text/html"),
        "json" => Some("application/json"),
        "md" => Some("text/markdown"),
        "pdf" => Some("application/pdf"),
        "png" => Some("image/png"),
        "svg" => Some("image/svg+xml"),
        "txt" => Some("text/plain"),
        "xml" => Some("application/xml"),
        _ => None,
    }
}

/// The result of a run: its folder.
fn result(run: &Run, manifest: &Manifest) -> Entity {
    let description = format!(
        "{}, {}: {}. Its manifest.json lists its files.",
        run.cell.topology,
        crate::outcome::words(run),
        manifest.verdict
    );
    Entity::new(folder(run), "Dataset")
        .with("name", run.cell.id.as_str())
        .with("description", description)
}

/// The action of a run. A run whose link did not hold is completed all the same, and its description
/// says why it does not count. Only a run that broke off has an error.
fn action(run: &Run, manifest: &Manifest) -> Entity {
    let completed = matches!(
        manifest.verdict,
        Verdict::Complete | Verdict::Disturbed | Verdict::Invalid
    );
    // Strings and not references, as the profile's validator requires.
    let status = if completed {
        "http://schema.org/CompletedActionStatus"
    } else {
        "http://schema.org/FailedActionStatus"
    };
    let reasons = (!manifest.reasons.is_empty()).then(|| manifest.reasons.join("; "));
    let machine = &manifest.machine;
    let mut description = format!(
        "back-end {}, link played by {}, {} on {}",
        manifest.backend, manifest.player, machine.kernel, machine.processor
    );
    if let (true, Some(reasons)) = (completed, &reasons) {
        description += &format!("; {}: {reasons}", manifest.verdict);
    }
    let id = format!("#run-{}", address(&run.cell.id));
    Entity::new(id, "CreateAction")
        .with("name", format!("Run of {}", run.cell.id))
        .with("description", description)
        .with("instrument", reference(&program_id(&manifest.webloop)))
        .with("object", reference(PLAN))
        .with("result", reference(&folder(run)))
        .maybe("startTime", started(manifest).map(iso))
        .maybe("endTime", ended(manifest).map(iso))
        .with("actionStatus", status)
        .maybe("error", reasons.filter(|_| !completed))
}

/// When a run began; `None` if its manifest has no valid time.
fn started(manifest: &Manifest) -> Option<Timestamp> {
    manifest.started.parse().ok()
}

/// When a run ended; `None` if its manifest has no valid times.
fn ended(manifest: &Manifest) -> Option<Timestamp> {
    let lasted = SignedDuration::try_from_secs_f64(manifest.wall_s).ok()?;
    started(manifest)?.checked_add(lasted).ok()
}

/// ISO 8601 to a millisecond, the finest that readers accept.
fn iso(time: Timestamp) -> String {
    time.strftime("%Y-%m-%dT%H:%M:%S%.3f+00:00").to_string()
}

/// The address of a cell's folder.
fn folder(run: &Run) -> String {
    address(&slashed(&run.cell.folder())) + "/"
}

fn address(path: &str) -> String {
    utf8_percent_encode(path, PATH).to_string()
}

fn reference(id: &str) -> Value {
    Value::Object([("@id".to_owned(), id.into())].into_iter().collect())
}

fn references(entities: &[Entity]) -> Vec<Value> {
    entities
        .iter()
        .map(|entity| reference(&entity.id))
        .collect()
}
