//! One `tc -batch -` that keeps running: it gets one command per line and executes it at once,
//! without the milliseconds that it takes to start a program.
//!
//! It answers only inquiries. At its first error it ends, and its last output becomes our error. It
//! also ends when this process does, since it then reads the end of its input: no signal is needed.

use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::{Doing, Error, Result};
use crate::tc::command::{TC, not_started, refused};

/// How long tc may take at its end for the commands that it still has. A hundred commands take some
/// milliseconds.
const PATIENCE: Duration = Duration::from_secs(2);

/// The name of every action with tc in an error.
const ACTION: &str = "play the link through `tc -batch`";

/// The running program.
pub(crate) struct Batch {
    child: Child,
    /// `None` after the batch has been closed.
    commands: Option<ChildStdin>,
    answers: ChildStdout,
    /// The beginning of an incomplete answer.
    partial: Vec<u8>,
    /// The last command, for error messages.
    last: String,
}

impl Batch {
    /// Starts tc in the namespace of this thread, whose scheduling it inherits.
    pub(crate) fn start() -> Result<Self> {
        let mut child = Command::new(TC)
            .args(["-s", "-j", "-batch", "-"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(not_started)?;
        let missing = || io::Error::other("a pipe is missing");
        let commands = child.stdin.take().ok_or_else(missing).doing(ACTION)?;
        let answers = child.stdout.take().ok_or_else(missing).doing(ACTION)?;
        // A tc that does not keep up must not hold up the player.
        for pipe in [commands.as_fd(), answers.as_fd()] {
            rustix::io::ioctl_fionbio(pipe, true).doing(ACTION)?;
        }
        Ok(Self {
            child,
            commands: Some(commands),
            answers,
            partial: Vec::new(),
            last: String::new(),
        })
    }

    /// Sends a command to tc, which executes it some ten microseconds later.
    pub(crate) fn send(&mut self, command: &str) -> Result<()> {
        self.last.clear();
        self.last.push_str(command);
        let line = format!("{command}\n");
        let Some(commands) = &mut self.commands else {
            return Ok(());
        };
        // A pipe accepts a line as a whole or not at all.
        match commands.write_all(line.as_bytes()) {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(self.last_words()),
            Err(source) => Err(Error::Failed {
                action: ACTION.into(),
                source,
            }),
        }
    }

    /// The next complete answer, if one has come.
    pub(crate) fn answer(&mut self) -> Result<Option<Vec<u8>>> {
        loop {
            if let Some(end) = self.partial.iter().position(|&byte| byte == b'\n') {
                let rest = self.partial.split_off(end + 1);
                let mut line = std::mem::replace(&mut self.partial, rest);
                line.pop();
                if line.iter().any(|byte| !byte.is_ascii_whitespace()) {
                    return Ok(Some(line));
                }
                continue;
            }
            let mut bytes = [0; 4096];
            match self.answers.read(&mut bytes) {
                Ok(0) => return Err(self.last_words()),
                Ok(read) => self.partial.extend_from_slice(&bytes[..read]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(None),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(source) => {
                    return Err(Error::Failed {
                        action: ACTION.into(),
                        source,
                    });
                }
            }
        }
    }

    /// Ends tc once it has executed all its commands.
    pub(crate) fn finish(&mut self) -> Result<()> {
        self.commands = None;
        self.end().doing(ACTION)?;
        let mut words = String::new();
        self.read_words(&mut words);
        if words.is_empty() {
            Ok(())
        } else {
            Err(refused(&self.last, &words))
        }
    }

    /// Why tc has ended by itself.
    fn last_words(&mut self) -> Error {
        let mut words = String::new();
        self.commands = None;
        match self.end() {
            Ok(()) => self.read_words(&mut words),
            Err(error) => words = error.to_string(),
        }
        refused(&self.last, &words)
    }

    fn end(&mut self) -> io::Result<()> {
        let since = Instant::now();
        while self.child.try_wait()?.is_none() {
            if since.elapsed() > PATIENCE {
                self.child.kill()?;
                self.child.wait()?;
                return Err(io::Error::new(io::ErrorKind::TimedOut, "it did not end"));
            }
            thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }

    /// Reads tc's error output. tc has ended, so the output has an end too.
    fn read_words(&mut self, words: &mut String) {
        if let Some(mut stderr) = self.child.stderr.take() {
            let mut bytes = Vec::new();
            let _ = stderr.read_to_end(&mut bytes);
            words.push_str(&String::from_utf8_lossy(&bytes));
        }
    }
}

/// The descriptor of its answers, to poll.
impl AsFd for Batch {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.answers.as_fd()
    }
}

/// Ends tc if the batch is dropped without `finish`.
impl Drop for Batch {
    fn drop(&mut self) {
        self.commands = None;
        let _ = self.end();
    }
}
