//! Settings of a visit, and why it may fail. [`endpoint::report::Visit`] is its report.

use std::{
    io,
    net::SocketAddr,
    path::PathBuf,
    process::{Command, ExitStatus},
    time::Duration,
};

use endpoint::{
    ControllerSettings, InvalidSetting, PageSettings,
    report::{Engine, Version},
};

use crate::engine::Missing;

/// Ties a command to this process before it is started, so that the command cannot outlive the
/// process. A function, because another crate has to do this between fork and exec.
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
    /// How the page sends and waits: its thread, its timer, its kind of request.
    pub page: PageSettings,
    /// The first deadline on the run's clock; if not given, the page begins soon after loading.
    pub start_ns: Option<u64>,
    /// Time from the first deadline to the end of the deadlines.
    pub duration_ns: u64,
    /// Where the folder of the browser's own files is created, and removed.
    pub scratch: PathBuf,
    /// Ties the browser to this process.
    pub leash: Leash,
    /// How long to wait for each step.
    pub limits: Limits,
}

/// How long to wait for each step. Every visit ends within their sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Until a plant that is still starting answers.
    pub plant: Duration,
    /// From the browser's start until the page holds the session. On a slow disk the browser alone
    /// takes ten seconds.
    pub open: Duration,
    /// How long a page may be silent beyond its own time-out.
    pub silence: Duration,
    /// From the last deadline plus a time-out until the page has ended: it sends its last rows over
    /// the run's link.
    pub finish: Duration,
    /// Interval between queries of the session. They cross the run's link too.
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

/// Why a visit was not completed. Each reason has a name of one word for manifests:
/// [`VisitError::name`].
#[derive(Debug, thiserror::Error)]
pub enum VisitError {
    /// This machine has no such browser.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// No page can follow the settings.
    #[error("a page cannot be the controller with these settings: {0}")]
    Settings(#[from] InvalidSetting),
    /// The plant did not answer before the start of the browser.
    #[error(
        "no plant answers at http://{plant} after {waited_s} s: {why}; start it, or correct the \
         address"
    )]
    Unreachable {
        /// The plant's address.
        plant: SocketAddr,
        /// How long it was waited for.
        waited_s: u64,
        /// The result of the last attempt.
        why: String,
    },
    /// Another client controls the plant.
    #[error(
        "the plant at http://{plant} is controlled by `{client}`; wait for the end of that session"
    )]
    Taken {
        /// Address of the plant.
        plant: SocketAddr,
        /// The name that this client gives itself.
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
        /// Its exit status.
        status: ExitStatus,
        /// Its last output.
        words: String,
    },
    /// The page never took the session.
    #[error(
        "{version} runs, but no page of it took control of the plant within {waited_s} s; its last \
         output: {words}; open {url} by hand to see more"
    )]
    NeverOpened {
        /// The browser's version.
        version: Version,
        /// How long it was waited for.
        waited_s: u64,
        /// The browser's last output.
        words: String,
        /// The address that it should have opened.
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
        /// At least how long it was silent.
        silent_s: u64,
        /// Number of commands before that.
        commands: u64,
    },
    /// The page did not end.
    #[error(
        "the page in {version} has not ended {late_s} s after its last deadline; {seen}; is the link too slow for its rows?"
    )]
    Unfinished {
        /// The browser's version.
        version: Version,
        /// How late it was.
        late_s: u64,
        /// Its progress when last seen.
        seen: String,
    },
    /// The page itself reports that it did not do what was asked.
    #[error("the page in {version} ended as {outcome}: {reason}")]
    Page {
        /// The browser's version.
        version: Version,
        /// The page's word for its outcome: `late`, `failed` or `stopped`.
        outcome: String,
        /// Its reason.
        reason: String,
    },
    /// The system refused a folder, a process or a signal handler.
    #[error("cannot run {engine}: {what}: {source}")]
    System {
        /// The browser that failed.
        engine: Engine,
        /// What could not be done.
        what: &'static str,
        /// The system's error.
        source: io::Error,
    },
}

/// Makes an error of what the system refused.
pub(crate) fn refused(engine: Engine, what: &'static str) -> impl Fn(io::Error) -> VisitError {
    move |source| VisitError::System {
        engine,
        what,
        source,
    }
}

impl VisitError {
    /// The name of the reason.
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
