//! Who made a container: a process, named so that it cannot be confused with another one.

use std::fmt;
use std::fs;
use std::str::FromStr;

/// A process on a machine, as written in the label [`Owner::LABEL`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Owner {
    /// The machine's name.
    host: String,
    /// The process number, which the kernel may later give to another process.
    pid: u32,
    /// When it started, in clock ticks since boot: distinguishes it from a later process.
    start_ticks: u64,
}

impl Owner {
    /// The label that says who made a container or network; empty if a person did.
    pub const LABEL: &str = "webloop.owner";

    /// This process.
    ///
    /// # Errors
    /// When `/proc` does not show it.
    pub fn this() -> std::io::Result<Owner> {
        let pid = std::process::id();
        let start_ticks = start_ticks(pid)
            .ok_or_else(|| std::io::Error::other("/proc does not say when this process started"))?;
        Ok(Owner {
            host: host(),
            pid,
            start_ticks,
        })
    }

    /// Whether the process was on this machine, so that it can be looked for.
    pub(crate) fn is_here(&self) -> bool {
        self.host == host()
    }

    /// Whether the process still exists. Says nothing about a process of another machine.
    pub(crate) fn is_alive(&self) -> bool {
        start_ticks(self.pid) == Some(self.start_ticks)
    }

    /// The machine's name.
    #[must_use]
    pub fn host(&self) -> &str {
        &self.host
    }

    /// The process's number.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.pid
    }
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.host, self.pid, self.start_ticks)
    }
}

/// A label that names no process.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not an owner; write it like host:1234:567890")]
pub struct NoOwner(String);

impl FromStr for Owner {
    type Err = NoOwner;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts: Vec<&str> = text.split(':').collect();
        match parts[..] {
            [host, pid, ticks] if !host.is_empty() => pid.parse().ok().zip(ticks.parse().ok()),
            _ => None,
        }
        .map(|(pid, start_ticks)| Owner {
            host: parts[0].to_owned(),
            pid,
            start_ticks,
        })
        .ok_or_else(|| NoOwner(text.to_owned()))
    }
}

fn host() -> String {
    rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned()
}

/// When a process started; `None` if it does not exist, or has ended but has not been waited for.
fn start_ticks(pid: u32) -> Option<u64> {
    stat(&fs::read_to_string(format!("/proc/{pid}/stat")).ok()?)
}

/// The start time in `/proc/PID/stat`: field 22, counted from after the name in brackets, which may
/// itself contain spaces and brackets. Field 3 is the state.
fn stat(text: &str) -> Option<u64> {
    let (_, behind_the_name) = text.rsplit_once(')')?;
    let mut fields = behind_the_name.split_ascii_whitespace();
    match fields.next()? {
        "Z" | "X" => None,
        _ => fields.nth(22 - 3 - 1)?.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn this_process_is_here_and_alive_and_another_start_is_another_process() {
        let this = Owner::this().expect("/proc is there");
        assert!(this.is_here() && this.is_alive());
        let earlier = Owner {
            start_ticks: this.start_ticks - 1,
            ..this.clone()
        };
        assert!(!earlier.is_alive());
        let elsewhere = Owner {
            host: format!("{}-2", this.host),
            ..this
        };
        assert!(!elsewhere.is_here());
    }

    #[test]
    fn a_process_that_has_ended_is_gone_even_before_it_is_waited_for() {
        let mut child = std::process::Command::new("true").spawn().expect("true");
        let pid = child.id();
        let deadline = std::time::Instant::now() + std::time::Duration::from_secs(10);
        while start_ticks(pid).is_some() && std::time::Instant::now() < deadline {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert_eq!(start_ticks(pid), None);
        child.wait().expect("it ended");
    }

    #[test]
    fn a_name_with_brackets_and_spaces_does_not_hide_the_start() {
        let fields: Vec<String> = (4..=30).map(|field| field.to_string()).collect();
        let line = format!("77 (a) S 1 (b) S {}", fields.join(" "));
        assert_eq!(stat(&line), Some(22));
        assert_eq!(stat(&line.replace(") S 4", ") Z 4")), None);
    }

    proptest! {
        #[test]
        fn a_label_reads_back(host in "[a-zA-Z0-9.-]{1,20}", pid: u32, start_ticks: u64) {
            let owner = Owner { host, pid, start_ticks };
            prop_assert_eq!(owner.to_string().parse(), Ok(owner));
        }

        #[test]
        fn no_text_makes_it_panic(text in ".{0,40}") {
            let _ = text.parse::<Owner>();
            let _ = stat(&text);
        }
    }

    #[test]
    fn what_is_no_owner_is_said() {
        for text in ["", "here", "a:1", ":1:2", "a:b:2", "a:1:2:3", "a:-1:2"] {
            assert!(text.parse::<Owner>().is_err(), "{text}");
        }
    }
}
