//! Settings of a visit, and why it may fail. What it reports at its end is
//! [`endpoint::report::Visit`].

use std::{
    io,
    net::SocketAddr,
    path::PathBuf,
    process::{Command, ExitStatus},
    time::Duration,
};

use endpoint::{ControllerSettings, InvalidSetting, PageSettings};

use crate::{Engine, Missing, Version};

/// Ties a command to this process before it is started, so that it cannot
/// outlive it. A function, because doing that between fork and exec is not this
/// crate's business.
pub type Leash = fn(&mut Command) -> io::Result<()>;

/// Settings of a visit.
#[derive(Clone, Debug)]
pub struct Config {
    /// The browser to start.
    pub engine: Engine,
    /// The plant, which serves the page.
    pub plant: SocketAddr,
    /// How the page sends.
    pub settings: ControllerSettings,
    /// How it goes about that.
    pub page: PageSettings,
    /// The first deadline on the run's clock; soon, if not given.
    pub start_ns: Option<u64>,
    /// Deadlines end this long after the first.
    pub duration_ns: u64,
    /// Where the folder of the browser's own files is made, and removed.
    pub scratch: PathBuf,
    /// Ties the browser to this process.
    pub leash: Leash,
    /// How long each thing is waited for.
    pub limits: Limits,
}

/// How long each thing is waited for. Every visit ends within their sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// A plant that is still starting.
    pub plant: Duration,
    /// From the browser's start until the page holds the session. On a slow
    /// disk a browser alone takes ten seconds.
    pub open: Duration,
    /// How long a page may be silent beyond its own time-out.
    pub silence: Duration,
    /// From the last deadline, and a time-out, until the page has ended: its
    /// last rows go over the run's link.
    pub finish: Duration,
    /// Between two looks at the session. They go over the run's link, too.
    pub look: Duration,
    /// From the signal to end a browser until it is killed.
    pub end: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            plant: Duration::from_secs(10),
            open: Duration::from_secs(30),
            silence: Duration::from_secs(10),
            finish: Duration::from_secs(60),
            look: Duration::from_millis(500),
            end: Duration::from_secs(2),
        }
    }
}

/// Why a visit did not come to its end. Each has a name of one word, for
/// manifests: [`VisitError::name`].
#[derive(Debug, thiserror::Error)]
pub enum VisitError {
    /// This machine has no such browser.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// The settings make no page.
    #[error("a page cannot be the controller with these settings: {0}")]
    Settings(#[from] InvalidSetting),
    /// The plant does not answer before the browser is started.
    #[error(
        "no plant answers at http://{plant} after {waited_s} s: {why}; start it, or correct the \
         address"
    )]
    Unreachable {
        /// What was asked.
        plant: SocketAddr,
        /// How long it was waited for.
        waited_s: u64,
        /// What the last attempt came to.
        why: String,
    },
    /// Somebody else has the plant.
    #[error(
        "the plant at http://{plant} is controlled by `{client}`; wait for the end of that session"
    )]
    Taken {
        /// Address of the plant.
        plant: SocketAddr,
        /// What that page calls itself.
        client: String,
    },
    /// The browser ended before the page did.
    #[error(
        "{version} ended before its page did, with {status}; its last output: {words}; start \
         {program} by hand to see more"
    )]
    Crashed {
        /// The browser's version.
        version: Version,
        /// Path of the browser's program.
        program: String,
        /// How it ended.
        status: ExitStatus,
        /// What it said last.
        words: String,
    },
    /// The page did not come to be.
    #[error(
        "{version} runs, but no page of it took control of the plant within {waited_s} s; its last \
         output: {words}; open {url} by hand to see more"
    )]
    NeverOpened {
        /// The browser's version.
        version: Version,
        /// How long it was waited for.
        waited_s: u64,
        /// What the browser said last.
        words: String,
        /// What it was to open.
        url: String,
    },
    /// The page fell silent.
    #[error(
        "the page in {version} hangs: the plant heard nothing from it for {silent_s} s after \
         {commands} commands; the plant has the rows that it sent before"
    )]
    Hung {
        /// The browser's version.
        version: Version,
        /// How long, at least.
        silent_s: u64,
        /// How many there were.
        commands: u64,
    },
    /// The page did not come to an end.
    #[error(
        "the page in {version} has not ended {late_s} s after its last deadline; {seen}; is the link too slow for its rows?"
    )]
    Unfinished {
        /// The browser's version.
        version: Version,
        /// How long it was waited for.
        late_s: u64,
        /// How far it was when it was seen last.
        seen: String,
    },
    /// The page says itself that it did not do what was asked.
    #[error("the page in {version} ended as {outcome}: {reason}")]
    Page {
        /// The browser's version.
        version: Version,
        /// The page's word for it: `late`, `failed` or `stopped`.
        outcome: String,
        /// What it says of it.
        reason: String,
    },
    /// The system refused a folder, a process or a signal handler.
    #[error("cannot run {engine}: {what}: {source}")]
    System {
        /// The browser that failed.
        engine: Engine,
        /// What could not be done.
        what: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

/// What the system refused.
pub(crate) fn refused(engine: Engine, what: &'static str) -> impl Fn(io::Error) -> VisitError {
    move |source| VisitError::System {
        engine,
        what,
        source,
    }
}

impl VisitError {
    /// The ending's name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Missing(_) => "missing",
            Self::Settings(_) => "settings",
            Self::Unreachable { .. } => "unreachable",
            Self::Taken { .. } => "taken",
            Self::Crashed { .. } => "crashed",
            Self::NeverOpened { .. } => "never-opened",
            Self::Hung { .. } => "hung",
            Self::Unfinished { .. } => "unfinished",
            Self::Page { outcome, .. } => outcome,
            Self::System { .. } => "system",
        }
    }
}
