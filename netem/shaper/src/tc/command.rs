//! The program `tc`, run once, to query, to try out or to clean up; and the meaning of its errors.
//!
//! The commands that play a link go to a tc that [keeps running](crate::tc::batch).

use std::io;
use std::process::{Command, Output};

use link::{LinkTime, Profile, Setting, Staircase, Verb, Way};
use serde_json::Value;

use crate::error::{Doing, Error, Result};
use crate::tc::qdisc::{Owner, Root};

/// The program, found through `PATH`.
pub(crate) const TC: &str = "tc";

/// The queueing discipline at the root of an interface, and tc's listing.
pub(crate) struct Listing {
    pub(crate) root: Root,
    pub(crate) text: Value,
}

/// Checks by trial whether tc can play a link on `device`: adds a netem and removes it.
///
/// # Errors
/// [`Error::Unsupported`], with the remedy, if there is no tc, no netem in the kernel or no right to
/// use it; [`Error::Failed`] if the device does not exist or another program shapes it.
pub fn tc_available(device: &str) -> Result<()> {
    claim(device)?;
    let mut empty = Staircase::new(&Profile::empty(), 0, Way::Up);
    if let Some(change) = empty.next_before(LinkTime::ZERO.after(1)) {
        command(&change.setting.command(Verb::Add, device))?;
        command(&Setting::removal(device))?;
    }
    Ok(())
}

/// Makes sure that no other program shapes `device`, and removes a netem that a killed player of ours
/// has left there. Returns what was found.
pub(crate) fn claim(device: &str) -> Result<Listing> {
    let found = list(device)?;
    match found.root.owner() {
        Owner::Kernel => Ok(found),
        Owner::Ours => {
            tracing::info!(device, "removing the netem that a killed player left");
            command(&Setting::removal(device))?;
            Ok(found)
        }
        Owner::Foreign(qdisc) => Err(foreign(device, &qdisc)),
    }
}

fn foreign(device: &str, qdisc: &str) -> Error {
    let why = format!(
        "its root queueing discipline is `{qdisc}`, which is not webloop's and stays; remove it \
         with `tc qdisc del dev {device} root`, or choose another interface"
    );
    Error::Failed {
        action: format!("shape `{device}`"),
        source: io::Error::new(io::ErrorKind::AlreadyExists, why),
    }
}

/// tc's listing of the queueing disciplines of `device`, with counters.
pub(crate) fn list(device: &str) -> Result<Listing> {
    let output = run(&["-s", "-j"], &Setting::inquiry(device))?;
    let action = || format!("read the queueing disciplines of `{device}`");
    let text: Value = serde_json::from_slice(&output.stdout)
        .map_err(io::Error::from)
        .doing_with(action)?;
    let root = Root::of(&text).doing_with(action)?;
    Ok(Listing { root, text })
}

/// Executes one command that changes something.
pub(crate) fn command(line: &str) -> Result<()> {
    run(&[], line).map(|_| ())
}

/// The output of `tc -V`.
pub(crate) fn version() -> Result<String> {
    let output = run(&[], "-V")?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn run(options: &[&str], line: &str) -> Result<Output> {
    let output = Command::new(TC)
        .args(options)
        .args(line.split_whitespace())
        .output()
        .map_err(not_started)?;
    if output.status.success() {
        Ok(output)
    } else {
        Err(refused(line, &String::from_utf8_lossy(&output.stderr)))
    }
}

/// The error if tc cannot be started.
pub(crate) fn not_started(source: io::Error) -> Error {
    match source.kind() {
        io::ErrorKind::NotFound => Error::Unsupported {
            action: "run `tc`",
            remedy: "install iproute2 (apt-get install iproute2), or have the link played in \
                     user space",
            source,
        },
        _ => Error::Failed {
            action: "run `tc`".into(),
            source,
        },
    }
}

/// The error if tc has rejected the command `line` with these words.
pub(crate) fn refused(line: &str, words: &str) -> Error {
    let source = io::Error::other(
        words
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty())
            .collect::<Vec<_>>()
            .join("; "),
    );
    // tc has no codes for these errors, and the kernel's messages rarely change.
    let says = |what: &str| words.contains(what);
    if says("Operation not permitted") {
        return Error::Unsupported {
            action: "shape an interface with tc",
            remedy: "run webloop as root; in a container, give it --cap-add NET_ADMIN",
            source,
        };
    }
    // The second is the message of kernels before 5.8.
    if says("qdisc kind is unknown") || says("No such file or directory") {
        return Error::Unsupported {
            action: "shape an interface with tc's netem",
            remedy: "load the kernel module (modprobe sch_netem), use a kernel with \
                     CONFIG_NET_SCH_NETEM, or have the link played in user space",
            source,
        };
    }
    Error::Failed {
        action: format!("run `tc {line}`"),
        source,
    }
}

/// Removes the netem if the play ends early.
pub(crate) struct Restore {
    /// The interface; `None` if nothing is left to do.
    pub(crate) device: Option<String>,
}

impl Drop for Restore {
    fn drop(&mut self) {
        if let Some(device) = &self.device
            && let Err(error) = command(&Setting::removal(device))
        {
            // The netem may not have been created, or its interface may be gone.
            tracing::debug!(%error, device, "no netem was removed");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_says_what_to_do() {
        let unsupported = |words: &str| match refused("qdisc add dev eth0", words) {
            Error::Unsupported { remedy, .. } => Some(remedy),
            Error::Failed { .. } => None,
        };
        let netem = unsupported("Error: Specified qdisc kind is unknown.\n").expect("its remedy");
        assert!(netem.contains("modprobe sch_netem"));
        let right = unsupported("RTNETLINK answers: Operation not permitted\n");
        assert!(right.expect("its remedy").contains("NET_ADMIN"));
        let error = refused("qdisc add dev no", "Cannot find device \"no\"\n");
        assert_eq!(
            error.to_string(),
            "cannot run `tc qdisc add dev no`: Cannot find device \"no\""
        );
    }
}
