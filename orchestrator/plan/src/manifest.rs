//! What a run says of itself: `manifest.json`, written when everything else is in place.
//!
//! Only what it says; looking at a machine and reading files is the back-ends' and the analysis'.

use std::collections::BTreeMap;
use std::io::{self, Read};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::sound::is_file_name;
use crate::{Cell, Disturbance, Verdict};

/// The description of one run, complete enough to judge and to repeat it.
#[derive(Debug, Clone, Serialize, Deserialize)]
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
    /// How the ends were connected: `netns`, `compose` or `attach`.
    pub backend: String,
    /// The container engine and its Compose, where they are known.
    #[serde(default)]
    pub engine: Option<String>,
    /// What played the link: `user`, `tc`, or `none` on loopback.
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
    pub epoch_ns: u64,
    /// When the controller's first message was due, in ns of `CLOCK_MONOTONIC`.
    pub start_ns: u64,
    /// Whether the link was the one asked for; `null` where there was nothing to judge.
    pub certificate: Option<Value>,
    /// What the loop's own messages said of the link; `null` where the run did not come to its end.
    #[serde(default)]
    pub messages: Option<Value>,
    /// What a thread on each processor that wakes every millisecond saw of the machine.
    #[serde(default)]
    pub pulse: Option<Value>,
    /// What was seen of the run's processes from outside while the controller ran, by their parts.
    #[serde(default)]
    pub watched: Option<Value>,
    /// The plant's own report.
    pub plant: Option<Value>,
    /// The controller's own report.
    pub controller: Option<Value>,
    /// The page's own report, where the client is a browser: which one, and how honest its clock
    /// and its timers are.
    #[serde(default)]
    pub page: Option<Value>,
    /// The player's own report.
    pub link: Option<Value>,
    /// Length and checksum of every other file in the folder.
    pub files: BTreeMap<String, FileFact>,
}

impl Manifest {
    /// Version of the format that this code writes and reads.
    pub const VERSION: u32 = 1;
    /// The file's name in a cell's folder.
    pub const FILE: &'static str = "manifest.json";

    /// The manifest as a JSON text.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Plain data of strings and finite numbers: serialising it cannot fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Reads a manifest's JSON text. The files that it lists lie beside it.
    ///
    /// # Errors
    /// A sentence on what is wrong, with line and column, or with the name of a file.
    pub fn from_json(text: &str) -> Result<Manifest, String> {
        let manifest: Manifest = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if manifest.version != Manifest::VERSION {
            return Err(format!(
                "this manifest has format version {}, and this webloop reads version {}",
                manifest.version,
                Manifest::VERSION
            ));
        }
        let is_beside = |name: &str| is_file_name(name) && name != Manifest::FILE;
        match manifest.files.keys().find(|name| !is_beside(name)) {
            Some(name) => Err(format!(
                "`{}` is not the name of a file beside it",
                name.escape_debug()
            )),
            None => Ok(manifest),
        }
    }
}

/// The machine that a run was made on, in the words of its own kernel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
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
}

/// A file of a run, as the manifest knows it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileFact {
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256 in hex.
    pub sha256: String,
}

impl FileFact {
    /// The fact about a file's content.
    ///
    /// # Errors
    /// When it cannot be read to its end.
    pub fn of(mut content: impl Read) -> io::Result<FileFact> {
        let mut tally = Tally::default();
        let mut buffer = vec![0; 1 << 16];
        loop {
            match content.read(&mut buffer)? {
                0 => return Ok(tally.fact()),
                n => tally.push(&buffer[..n]),
            }
        }
    }
}

/// A file's fact under way, for whoever has its bytes in passing.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    hasher: Sha256,
    bytes: u64,
}

impl Tally {
    /// Takes the next bytes.
    pub fn push(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
        self.bytes += bytes.len() as u64;
    }

    /// The fact about all bytes so far.
    #[must_use]
    pub fn fact(self) -> FileFact {
        let sha256 = self.hasher.finalize();
        FileFact {
            bytes: self.bytes,
            sha256: sha256.iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}
