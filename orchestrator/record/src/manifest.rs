//! The file `manifest.json`, written after everything else of a run.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use endpoint::report::Page;
use link::Epoch;
use link::certificate::{Certificate, LinkReport};
use plan::evidence::{Ends, Messages, Pulse, Watched};
use plan::{Cell, Disturbance, EndFaultDone, Verdict, is_file_name};
use schemars::{JsonSchema, schema_for};
use serde::ser::Error;
use serde::{Deserialize, Serialize, Serializer};

use crate::fact::FileFact;
use crate::file;
use crate::report::{ControllerReport, PlantReport};

/// The description of one run, complete enough to judge and to repeat it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "webloop manifest")]
pub struct Manifest {
    /// Version of this format.
    pub version: u32,
    /// How the run ended.
    pub verdict: Verdict,
    /// Why it is not `complete`; empty if it is.
    pub reasons: Vec<String>,
    /// What was done to the run that nobody asked for; empty if nothing was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disturbances: Vec<Disturbance>,
    /// What became of the tries before this one: a run that is disturbed is asked again, and the
    /// folders of those tries lie beside this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier: Vec<String>,
    /// The experiment's name.
    pub experiment: String,
    /// The campaign's seed.
    pub campaign_seed: u64,
    /// The cell, with every setting.
    pub cell: Cell,
    /// The link's profile: the file `profile.toml` beside this one is its text.
    pub profile: String,
    /// How the ends were connected: `netns`, `compose`, `attach` or `sim`.
    pub backend: String,
    /// The container engine and its Compose, where they are known.
    #[serde(default)]
    pub engine: Option<String>,
    /// What played the link: `user`, `tc`, `model` in virtual time, or `none` on loopback.
    pub player: String,
    /// Version of webloop.
    pub webloop: String,
    /// The machine.
    pub machine: Machine,
    /// How the right to make namespaces was had: `privileged` or `user-namespace`; empty where
    /// none were made.
    pub authority: String,
    /// Start of the run in UTC, RFC 3339. For people; every other time is monotonic.
    pub started: String,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Link time 0, in ns of `CLOCK_MONOTONIC`.
    #[serde(rename = "epoch_ns")]
    pub epoch: Epoch,
    /// When the controller's first message was due, in ns of `CLOCK_MONOTONIC`.
    pub start_ns: u64,
    /// Whether the link was the one asked for; `null` where there was nothing to judge.
    #[serde(serialize_with = "by_name")]
    pub certificate: Option<Certificate>,
    /// What the loop's own messages said of the link; `null` where the run did not come to its end.
    #[serde(default, serialize_with = "by_name")]
    pub messages: Option<Messages>,
    /// What a thread on each processor that wakes every millisecond saw of the machine.
    #[serde(default, serialize_with = "by_name")]
    pub pulse: Option<Pulse>,
    /// What was seen of the run's processes from outside while the controller ran, by their parts.
    #[serde(default, serialize_with = "by_name")]
    pub watched: Option<BTreeMap<String, Watched>>,
    /// What the experiment's fault did to the ends, in order; empty if nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub end_faults: Vec<EndFaultDone>,
    /// How far both ends were replayed by the plan's plant and law; absent in virtual time, where they are the
    /// plan's by construction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends: Option<Ends>,
    /// The plant's own report.
    #[serde(serialize_with = "by_name")]
    pub plant: Option<PlantReport>,
    /// The controller's own report.
    #[serde(serialize_with = "by_name")]
    pub controller: Option<ControllerReport>,
    /// The page's own report, where the client is a browser: which one, and how honest its clock
    /// and its timers are.
    #[serde(default, serialize_with = "by_name")]
    pub page: Option<Page>,
    /// The player's own report.
    #[serde(serialize_with = "by_name")]
    pub link: Option<LinkReport>,
    /// Length and checksum of every other file in the folder.
    pub files: BTreeMap<String, FileFact>,
}

/// Why a text is no manifest that can be read.
#[derive(Debug, thiserror::Error)]
pub enum NotAManifest {
    /// It is not JSON, or not a manifest's.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// It was written by another version.
    #[error(
        "this manifest has format version {found}, and this webloop reads version {}",
        Manifest::VERSION
    )]
    Version {
        /// Its format's version.
        found: u32,
    },
    /// It lists a file that does not lie beside it.
    #[error("`{}` is not the name of a file beside it", .0.escape_debug())]
    Elsewhere(String),
}

/// Why a cell's manifest, which is there, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Unreadable {
    /// By this process.
    #[error("{}: {problem}", .path.display())]
    Closed {
        /// The file, or the folder in its way.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// By this version.
    #[error("{}: {problem}", .path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: NotAManifest,
    },
}

impl Manifest {
    /// Version of the format that this code writes and reads.
    pub const VERSION: u32 = 1;
    /// The file's name in a cell's folder.
    pub const FILE: &'static str = "manifest.json";

    /// The JSON schema of a manifest, for other programs; committed as
    /// `orchestrator/record/manifest.schema.json`.
    #[must_use]
    pub fn schema() -> String {
        format!("{:#}\n", schema_for!(Manifest).as_value())
    }

    /// The manifest as a JSON text.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Plain data of strings and finite numbers: serialising it cannot fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Reads a manifest's JSON text. The files that it lists lie beside it.
    ///
    /// # Errors
    /// What is wrong, with line and column or with the name of a file.
    pub fn from_json(text: &str) -> Result<Manifest, NotAManifest> {
        let manifest: Manifest = serde_json::from_str(text)?;
        if manifest.version != Manifest::VERSION {
            return Err(NotAManifest::Version {
                found: manifest.version,
            });
        }
        let is_beside = |name: &str| is_file_name(name) && name != Manifest::FILE;
        match manifest.files.keys().find(|name| !is_beside(name)) {
            Some(name) => Err(NotAManifest::Elsewhere(name.clone())),
            None => Ok(manifest),
        }
    }

    /// The manifest in a cell's folder, whatever its verdict; `None` if the cell has not been run there. Neither the
    /// folder nor the one that it is in may be a link: it leads elsewhere.
    ///
    /// # Errors
    /// If there is one that cannot be read.
    pub fn read(folder: &Path) -> Result<Option<Manifest>, Unreadable> {
        for path in [folder.parent().unwrap_or(folder), folder] {
            file::check_folder(path).map_err(|problem| Unreadable::Closed {
                path: path.to_owned(),
                problem,
            })?;
        }
        let path = folder.join(Manifest::FILE);
        match file::text(&path, file::MANIFEST_BYTES) {
            Ok(text) => Manifest::from_json(&text)
                .map(Some)
                .map_err(|problem| Unreadable::Unknown { path, problem }),
            Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
            Err(problem) => Err(Unreadable::Closed { path, problem }),
        }
    }
}

/// Writes a part with its fields sorted by name, whatever their order in its type. So manifests read
/// and compare alike, whichever version of a role wrote the part.
fn by_name<T: Serialize, S: Serializer>(part: &Option<T>, to: S) -> Result<S::Ok, S::Error> {
    serde_json::to_value(part)
        .map_err(S::Error::custom)?
        .serialize(to)
}

/// The machine that a run was made on, in the words of its own kernel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Kernel name and release, such as `Linux 6.1.0`.
    pub kernel: String,
    /// Instruction set, such as `x86_64`.
    pub architecture: String,
    /// Processor model, as the kernel names it.
    pub processor: String,
    /// Processors that the run could use.
    pub cores: usize,
    /// Memory in MiB.
    pub memory_mib: u64,
    /// Where the kernel takes its time from, such as `tsc`.
    pub clock_source: String,
    /// Whether its processors were kept from halting meanwhile, as `--awake` asks.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub awake: bool,
}
