//! The launcher's report on the browser with the page, as seen from outside.

use std::{fmt, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Written;

/// What a visit tells when it has ended. What became of the deadlines only the
/// page knows, and tells the plant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Visit {
    /// Who was the controller.
    pub client: Engine,
    /// The first deadline on the run's clock, if the page was given one.
    pub start_ns: Option<u64>,
    /// Where the deadlines ended, likewise.
    pub stop_ns: Option<u64>,
    /// Whether it was stopped before its time. What the page had not sent
    /// to the plant by then is lost.
    pub interrupted: bool,
    /// Rows that the plant had of the page when it was looked at last.
    pub rows: Written,
    /// The page's session, from the plant's last answer.
    pub session: Option<Session>,
    /// The browser that ran the page.
    pub browser: Browser,
}

/// A page's session as the plant tells of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// What the page calls itself.
    pub client: String,
    /// Commands that came with it.
    pub commands: u64,
    /// Rows that the plant has of it.
    pub rows: u64,
}

/// The browser, and how it was started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Browser {
    /// Its own name and version.
    #[serde(flatten)]
    pub version: Version,
    /// Path of the browser's program.
    pub program: PathBuf,
    /// What it was started with.
    pub arguments: Vec<String>,
    /// How it is kept from the machine.
    pub sandbox: Sandbox,
    /// From its start until the page held the session; none if it never did.
    pub opened_ms: Option<u64>,
}

text::choice!(
    /// A browser's family.
    Engine, "browser", {
        /// Chromium, or Google's Chrome.
        Chromium = "chromium",
        /// Mozilla Firefox.
        Firefox = "firefox",
    }
);

/// A browser's own name and version.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Version {
    /// Name, such as `Chromium`.
    pub name: String,
    /// Version, such as `156.0.8078.79`.
    pub number: String,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name, self.number)
    }
}

/// What holds a page's process.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Confinement {
    /// No process of a page was seen.
    Unknown,
    /// It can do what its user can.
    None,
    /// It is kept from most system calls.
    Filter,
    /// That, and it is in namespaces of its own.
    Namespace,
}

/// A browser's sandbox.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sandbox {
    /// What holds the pages' processes: the least of them counts.
    pub kind: Confinement,
    /// The user that the browser runs as.
    pub user: u32,
    /// Why it is not more.
    pub reason: Option<String>,
}
