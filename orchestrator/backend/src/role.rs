//! A role of webloop running as a child process: plant, controller or link.
//!
//! A role says `ready` on its standard output when it can be used, writes its report as a JSON
//! file into the run's folder, and ends on SIGTERM. What it logs goes to `<name>.log` there.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read};
use std::os::fd::AsFd;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use crate::{RunError, spawn};

/// How long a role may take from its start to `ready`: a busy two-core machine needs some 50 ms.
const READY_WITHIN: Duration = Duration::from_secs(10);

/// How long a role may take from SIGTERM to its end; it has rows to flush.
const STOP_WITHIN: Duration = Duration::from_secs(5);

/// How long a role of a run that is given up may take to write its rows before it is killed:
/// three of them one after another still end within 5 s of an interruption.
const GIVE_UP_WITHIN: Duration = Duration::from_secs(1);

/// How often an ending is looked for.
const POLL: Duration = Duration::from_millis(5);

/// A started role. Dropping it ends the process: of a run that is given up, too, the rows are kept.
pub(crate) struct Role {
    name: &'static str,
    child: Child,
    ready: mpsc::Receiver<()>,
}

impl Role {
    /// Starts `webloop serve NAME ARGS..`, inside `namespace`.
    ///
    /// The child dies with the calling thread, so that thread has to live as long as the run.
    pub(crate) fn start(
        name: &'static str,
        args: &[String],
        namespace: Option<&impl AsFd>,
        folder: &Path,
    ) -> Result<Role, RunError> {
        let fail =
            |problem: std::io::Error| RunError::role(name, format!("cannot be started: {problem}"));
        let log = open_log(&folder.join(format!("{name}.log"))).map_err(fail)?;
        let mut command = Command::new(std::env::current_exe().map_err(fail)?);
        command
            .args(["serve", name])
            .args(args)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(log);
        spawn::bind(&mut command, namespace).map_err(fail)?;
        let mut child = command.spawn().map_err(fail)?;
        // Reading on a thread of its own, to the end, so that the role never blocks on a full pipe.
        let (sender, ready) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut stdout = BufReader::new(stdout);
                let mut line = String::new();
                while matches!(stdout.read_line(&mut line), Ok(n) if n > 0) {
                    if line.starts_with("ready") {
                        let _ = sender.send(());
                    }
                    line.clear();
                }
            });
        }
        Ok(Role { name, child, ready })
    }

    /// Waits until the role says that it can be used.
    pub(crate) fn wait_ready(&mut self) -> Result<(), RunError> {
        match self.ready.recv_timeout(READY_WITHIN) {
            Ok(()) => Ok(()),
            Err(mpsc::RecvTimeoutError::Timeout) => Err(RunError::role(
                self.name,
                format!("was not ready within {} s", READY_WITHIN.as_secs()),
            )),
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                let status = self
                    .child
                    .wait()
                    .map_err(|e| RunError::role(self.name, e.to_string()))?;
                Err(RunError::role(
                    self.name,
                    format!("ended before it was ready ({status})"),
                ))
            }
        }
    }

    /// Whether the role has ended, and if so whether well.
    pub(crate) fn ended(&mut self) -> Result<bool, RunError> {
        match self.child.try_wait() {
            Ok(None) => Ok(false),
            Ok(Some(status)) if status.success() => Ok(true),
            Ok(Some(status)) => Err(RunError::role(self.name, format!("ended with {status}"))),
            Err(problem) => Err(RunError::role(self.name, problem.to_string())),
        }
    }

    /// Asks the role to end by SIGTERM, waits, and insists by SIGKILL after [`STOP_WITHIN`].
    pub(crate) fn stop(mut self) -> Result<(), RunError> {
        self.terminate();
        let deadline = Instant::now() + STOP_WITHIN;
        while Instant::now() < deadline {
            if self.ended()? {
                return Ok(());
            }
            std::thread::sleep(POLL);
        }
        Err(RunError::role(
            self.name,
            format!(
                "did not end within {} s of SIGTERM and was killed",
                STOP_WITHIN.as_secs()
            ),
        ))
    }

    /// Sends SIGTERM, if the role still runs.
    pub(crate) fn terminate(&mut self) {
        spawn::terminate(&mut self.child);
    }
}

impl Drop for Role {
    fn drop(&mut self) {
        self.terminate();
        let deadline = Instant::now() + GIVE_UP_WITHIN;
        while matches!(self.child.try_wait(), Ok(None)) && Instant::now() < deadline {
            std::thread::sleep(POLL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn open_log(path: &Path) -> std::io::Result<File> {
    OpenOptions::new().create(true).append(true).open(path)
}

/// The last lines of a role's log, to be quoted in an error; empty where there is none.
pub(crate) fn last_words(folder: &Path, name: &str) -> String {
    const ENOUGH: u64 = 2_000;
    let Ok(mut file) = File::open(folder.join(format!("{name}.log"))) else {
        return String::new();
    };
    let length = file.metadata().map_or(0, |meta| meta.len());
    let _ = std::io::Seek::seek(
        &mut file,
        std::io::SeekFrom::Start(length.saturating_sub(ENOUGH)),
    );
    let mut text = Vec::new();
    let _ = file.read_to_end(&mut text);
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<_> = text
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    lines[lines.len().saturating_sub(3)..].join("\n")
}
