//! A role of webloop running as a child process: plant, controller or link.
//!
//! A role prints `ready` on its standard output once it can be used, writes its report as a JSON
//! file into the run's folder, and ends on SIGTERM. It logs to `<name>.log` there.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use rustix::fs::{MemfdFlags, memfd_create};

use crate::error::Error;
use crate::exit::UNSUPPORTED;
use crate::freezer::{Freezer, Stop};
use crate::lookout::{Lookout, Seen};
use crate::spawn;

/// The environment variable with the secret of who starts roles for an orchestrator. Roles do not get it.
pub const SECRET: &str = "WEBLOOP_TOKEN";

/// How long a role may take from its start to `ready`. On a busy two-core machine a role of one
/// process needs some 50 ms, and a browser up to half a minute.
pub const READY_WITHIN: Duration = Duration::from_secs(40);

/// How long a role may take from SIGTERM to its end; it has rows to flush.
pub const STOP_WITHIN: Duration = Duration::from_secs(5);

/// How long a role may take to write its rows before it is killed, if its run is given up. Three
/// roles, one after another, still end within 5 s of an interruption.
const GIVE_UP_WITHIN: Duration = Duration::from_secs(1);

/// How often to check whether a role is ready or has ended.
pub const POLL: Duration = Duration::from_millis(5);

/// What to start: `PROGRAM serve ROLE --settings - --out FOLDER`.
#[derive(Clone, Copy, Debug)]
pub struct Launch<'a> {
    /// Path of webloop's own program.
    pub program: &'a Path,
    /// The role, as `webloop serve` calls it.
    pub role: &'a str,
    /// The name that its log and its errors use.
    pub name: &'a str,
    /// Its settings, passed on standard input.
    pub settings: &'a serde_json::Value,
    /// The folder for its rows and its log.
    pub folder: &'a Path,
    /// Whether to watch it from outside while it runs.
    pub is_watched: bool,
}

/// A started role. Dropping it ends the process; even if the run is given up, the rows are kept.
#[derive(Debug)]
pub struct Role {
    name: String,
    /// The folder with its log.
    folder: PathBuf,
    child: Child,
    ready: mpsc::Receiver<String>,
    lookout: Option<Lookout>,
    freezer: Option<Freezer>,
}

impl Role {
    /// Starts a role, inside `namespace` if one is given.
    ///
    /// The child dies with the calling thread, so that thread has to live as long as the run.
    ///
    /// # Errors
    /// [`Error::Role`] when the log, the namespace or the process is not available.
    pub fn launch(launch: &Launch<'_>, namespace: Option<&impl AsFd>) -> Result<Role, Error> {
        let Launch { name, .. } = *launch;
        let fail = |problem: io::Error| unstarted(name, &problem);
        let log = open_log(&launch.folder.join(format!("{name}.log"))).map_err(fail)?;
        let settings = in_memory(launch.settings).map_err(fail)?;
        let mut command = Command::new(launch.program);
        command
            .args(["serve", launch.role, "--settings", "-", "--out"])
            .arg(launch.folder)
            .env_remove(SECRET)
            .stdin(settings)
            .stdout(Stdio::piped())
            .stderr(log);
        spawn::bind(&mut command, namespace).map_err(fail)?;
        let mut child = command.spawn().map_err(fail)?;
        // Read to the end on a thread of its own, so that the role never blocks on a full pipe.
        let (sender, ready) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut stdout = BufReader::new(stdout);
                let mut line = String::new();
                while matches!(stdout.read_line(&mut line), Ok(n) if n > 0) {
                    if let Some(what) = line.strip_prefix("ready") {
                        let _ = sender.send(what.trim().to_owned());
                    }
                    line.clear();
                }
            });
        }
        Ok(Role {
            name: name.to_owned(),
            folder: launch.folder.to_owned(),
            lookout: launch.is_watched.then(|| Lookout::start(child.id())),
            child,
            ready,
            freezer: None,
        })
    }

    /// Waits until the role says that it can be used. Returns what it says besides `ready`.
    ///
    /// # Errors
    /// [`Error::Role`] when it ends before, or is not ready after 40 s.
    pub fn wait_ready(&mut self) -> Result<String, Error> {
        match self.ready.recv_timeout(READY_WITHIN) {
            Ok(what) => Ok(what),
            Err(mpsc::RecvTimeoutError::Timeout) => Err(self.unready()),
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                let status = self
                    .child
                    .wait()
                    .map_err(|problem| Error::role(&self.name, problem.to_string()))?;
                Err(self.ended_unready(status))
            }
        }
    }

    /// [`Role::wait_ready`] without waiting; `None` if the role is not ready yet.
    pub fn try_ready(&mut self) -> Result<Option<String>, Error> {
        match self.ready.try_recv() {
            Ok(what) => Ok(Some(what)),
            // All its output has been read, so if it has ended, it ended without `ready`.
            Err(mpsc::TryRecvError::Disconnected) => match self.status()? {
                Some(status) => Err(self.ended_unready(status)),
                None => Ok(None),
            },
            Err(mpsc::TryRecvError::Empty) => Ok(None),
        }
    }

    /// Whether the role has ended.
    ///
    /// # Errors
    /// [`Error::Lacking`] when it says that something is missing, by exit code 3; [`Error::Role`] when it ended with
    /// another exit code than 0, or by a signal.
    pub fn ended(&mut self) -> Result<bool, Error> {
        match self.status()? {
            None => Ok(false),
            Some(status) if status.success() => Ok(true),
            Some(status) if status.code() == Some(UNSUPPORTED) => Err(Error::Lacking {
                role: self.name.clone(),
                words: last_words(&self.folder, &self.name),
            }),
            Some(status) => Err(Error::role(&self.name, format!("ended with {status}"))),
        }
    }

    /// Whether the role has ended because this machine lacks something: exit code 3.
    pub fn lacks_something(&mut self) -> bool {
        matches!(self.status(), Ok(Some(status)) if status.code() == Some(UNSUPPORTED))
    }

    /// How the role has ended; `None` if it still runs.
    pub fn status(&mut self) -> Result<Option<ExitStatus>, Error> {
        self.child
            .try_wait()
            .map_err(|problem| Error::role(&self.name, problem.to_string()))
    }

    /// What its process and its descendants have looked like from outside since the start; empty if
    /// it is not watched.
    #[must_use]
    pub fn seen(&self) -> Seen {
        let seen = self.lookout.as_ref().map(Lookout::seen);
        let frozen_ns = self.freezer.as_ref().map(Freezer::done);
        Seen {
            frozen_ns: frozen_ns.unwrap_or_default(),
            ..seen.unwrap_or_default()
        }
    }

    /// Will let its process and its descendants stand still at these times, which are in order;
    /// [`Seen::frozen_ns`] says when they did. Replaces what was asked for before.
    pub fn freeze(&mut self, stops: Vec<Stop>) {
        self.freezer = Some(Freezer::start(self.child.id(), stops));
    }

    /// Sends SIGTERM and waits 5 s. A role that still runs then is killed by being dropped.
    ///
    /// # Errors
    /// [`Error::Role`] when it had to be killed, or did not end well.
    pub fn stop(mut self) -> Result<(), Error> {
        self.terminate();
        let deadline = Instant::now() + STOP_WITHIN;
        while Instant::now() < deadline {
            if self.ended()? {
                return Ok(());
            }
            std::thread::sleep(POLL);
        }
        self.kill();
        Err(Error::role(
            &self.name,
            format!(
                "did not end within {} s of SIGTERM and was killed",
                STOP_WITHIN.as_secs()
            ),
        ))
    }

    /// Sends SIGTERM, if the role still runs; one that stands still goes on, so that it can end.
    pub fn terminate(&mut self) {
        if let Some(freezer) = &mut self.freezer {
            freezer.release();
        }
        spawn::terminate(&mut self.child);
    }

    /// Sends SIGKILL, if the role still runs, and waits until it is gone.
    pub fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// The error of a role that took too long to become ready.
    pub fn unready(&self) -> Error {
        Error::role(
            &self.name,
            format!("was not ready within {} s", READY_WITHIN.as_secs()),
        )
    }

    fn ended_unready(&self, status: ExitStatus) -> Error {
        Error::role(&self.name, format!("ended before it was ready ({status})"))
    }
}

impl Drop for Role {
    fn drop(&mut self) {
        self.terminate();
        let deadline = Instant::now() + GIVE_UP_WITHIN;
        while matches!(self.child.try_wait(), Ok(None)) && Instant::now() < deadline {
            std::thread::sleep(POLL);
        }
        self.kill();
    }
}

fn unstarted(name: &str, problem: &io::Error) -> Error {
    Error::role(name, format!("cannot be started: {problem}"))
}

/// A file in memory with a value's text. Unlike a pipe it takes all of the text at once.
fn in_memory(value: &serde_json::Value) -> io::Result<File> {
    let mut file = File::from(memfd_create("settings", MemfdFlags::CLOEXEC)?);
    serde_json::to_writer(&file, value)?;
    file.rewind()?;
    Ok(file)
}

fn open_log(path: &Path) -> io::Result<File> {
    OpenOptions::new().create(true).append(true).open(path)
}

/// The last lines of a role's log, to quote in an error; empty without a log.
#[must_use]
pub fn last_words(folder: &Path, name: &str) -> String {
    const ENOUGH: u64 = 2_000;
    let Ok(mut file) = File::open(folder.join(format!("{name}.log"))) else {
        return String::new();
    };
    let length = file.metadata().map_or(0, |meta| meta.len());
    let _ = io::Seek::seek(
        &mut file,
        io::SeekFrom::Start(length.saturating_sub(ENOUGH)),
    );
    let mut text = Vec::new();
    let _ = file.read_to_end(&mut text);
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<_> = text
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    text::plain(&lines[lines.len().saturating_sub(3)..].join("\n")).into_owned()
}
