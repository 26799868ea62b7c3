//! Waits for a command that may hang, and takes what it said.
#![allow(clippy::unwrap_used)]

use std::io::{Read, Seek};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How long a command may take on a busy machine before it hangs; it takes a fraction of a second.
const LONG: Duration = Duration::from_secs(120);

/// How a command ended.
pub(crate) struct Ended {
    /// `None` where a limit of the kernel's, or this test, killed it.
    pub(crate) code: Option<i32>,
    /// What it printed on both streams.
    pub(crate) said: String,
}

/// Runs a command to its end, or kills it.
pub(crate) fn ended(command: &mut Command) -> Ended {
    let mut said = tempfile::tempfile().unwrap();
    let mut child = command
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(Stdio::from(said.try_clone().unwrap()))
        .stderr(Stdio::from(said.try_clone().unwrap()))
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let code = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status.code(),
            None if begun.elapsed() > LONG => {
                child.kill().unwrap();
                child.wait().unwrap();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    let mut text = Vec::new();
    said.rewind().unwrap();
    said.read_to_end(&mut text).unwrap();
    let said = String::from_utf8_lossy(&text).into_owned();
    Ended { code, said }
}
