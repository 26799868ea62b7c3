//! Copies the files of a run from an agent as they grow.
//!
//! Files only grow, at the agent and here. The copy is a prefix of the original, to the byte: a row
//! that is half written there is half written here until the next look.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::name::Name;
use crate::remote::RemoteRun;

/// How often to ask the agent. Roles write ten times a second; even with a slow answer a row is
/// here within a second.
const LOOK_EVERY: Duration = Duration::from_millis(300);

/// How long an agent may leave requests unanswered before its files are given up.
const PATIENCE: Duration = Duration::from_secs(10);

/// A thread that copies files. Dropping it stops the copying without a last look.
#[derive(Debug)]
pub struct Follower {
    /// Sending on it asks for the last look; dropping it asks to stop at once.
    last: Option<mpsc::Sender<()>>,
    thread: Option<JoinHandle<Result<(), Error>>>,
}

impl RemoteRun {
    /// Copies `files` into `folder` from now on. Waits for files that do not exist at the agent
    /// yet; in `folder` they must not exist yet.
    ///
    /// # Errors
    /// [`Error`] when a name is not plain, or no thread can be started.
    pub fn follow(&self, files: &[&str], folder: &Path) -> Result<Follower, Error> {
        let names = files
            .iter()
            .map(|name| name.parse())
            .collect::<Result<Vec<Name>, _>>()?;
        let mut copying = Copying {
            run: self.clone(),
            folder: folder.to_owned(),
            names,
            copies: BTreeMap::new(),
        };
        let (last, asked) = mpsc::channel();
        let thread = thread::Builder::new()
            .name(format!("follow-{}", self.remote().name()))
            .spawn(move || copying.follow(&asked))?;
        Ok(Follower {
            last: Some(last),
            thread: Some(thread),
        })
    }
}

impl Follower {
    /// Whether it has given up; [`Follower::finish`] says why.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Copies what is still missing, and ends. The roles should have ended before.
    ///
    /// # Errors
    /// [`Error`] when the agent did not answer for 10 s, or a file could not be written here:
    /// then rows are missing.
    pub fn finish(mut self) -> Result<(), Error> {
        if let Some(last) = self.last.take() {
            let _ = last.send(());
        }
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(()),
        }
    }
}

impl Drop for Follower {
    fn drop(&mut self) {
        self.last = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What has been copied so far.
struct Copying {
    run: RemoteRun,
    folder: PathBuf,
    names: Vec<Name>,
    copies: BTreeMap<Name, Copied>,
}

/// A file here, and the bytes copied so far.
struct Copied {
    path: PathBuf,
    file: File,
    bytes: u64,
}

impl Copying {
    fn follow(&mut self, asked: &mpsc::Receiver<()>) -> Result<(), Error> {
        let mut heard = Instant::now();
        loop {
            let last = match asked.recv_timeout(LOOK_EVERY) {
                Err(RecvTimeoutError::Timeout) => false,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
                Ok(()) => true,
            };
            loop {
                match self.look() {
                    Ok(()) if last => return Ok(()),
                    Ok(()) => {
                        heard = Instant::now();
                        break;
                    }
                    // What has been copied stays valid, so asking again is safe.
                    Err(Error::Unanswered { .. }) if heard.elapsed() < PATIENCE => {
                        if !last {
                            break;
                        }
                        thread::sleep(LOOK_EVERY);
                    }
                    Err(error) => return Err(error),
                }
            }
        }
    }

    /// Copies every file up to its length when the look began.
    fn look(&mut self) -> Result<(), Error> {
        let there = self.run.files()?;
        for name in &self.names {
            let Some(size) = there.get(name.as_str()) else {
                continue;
            };
            let copy = match self.copies.get_mut(name) {
                Some(copy) => copy,
                None => self
                    .copies
                    .entry(name.clone())
                    .or_insert(Copied::create(self.folder.join(name.as_str()))?),
            };
            if copy.bytes > *size {
                return Err(Error::Shrunk {
                    agent: self.run.remote().name(),
                    file: name.to_string(),
                });
            }
            while copy.bytes < *size {
                let part = self.run.part(name.as_str(), copy.bytes)?;
                if part.bytes.is_empty() {
                    break;
                }
                copy.append(&part.bytes)?;
            }
        }
        Ok(())
    }
}

impl Copied {
    fn create(path: PathBuf) -> Result<Copied, Error> {
        let file = OpenOptions::new().append(true).create_new(true).open(&path);
        let file = file.map_err(|source| Error::write(&path, source))?;
        Ok(Copied {
            path,
            file,
            bytes: 0,
        })
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.file
            .write_all(bytes)
            .map_err(|source| Error::write(&self.path, source))?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }
}
