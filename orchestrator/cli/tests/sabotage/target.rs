//! A running cell as its machine sees it: processes in `/proc`, and their network namespaces.

use std::fs::{self, File};
use std::os::fd::AsFd;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use clock::now::now_ns;
use link::Way;
use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};

const MS: u64 = 1_000_000;

/// How long before the controller's start commands switch a disturbance on. It starts at 1.3 s of
/// link time, and the last echo before is at 1.1 s.
const AHEAD_NS: u64 = 100 * MS;

/// How long before the end of the loop it is switched off, so that it is off before the echoes
/// after the run.
const BEHIND_NS: u64 = 50 * MS;

/// No excuse for a cell that came to its end: then the search does not fit how its processes are
/// started.
pub(crate) const NOT_THERE: &str = "the cell ended before its controller was there";

/// The processes of a cell that has begun, and the time of its controller's part.
pub(crate) struct Target<'a> {
    pub(crate) controller: u32,
    pub(crate) plant: u32,
    /// `None` over loopback.
    pub(crate) player: Option<u32>,
    /// When the first message is due, on the monotonic clock.
    pub(crate) start_ns: u64,
    pub(crate) duration_ns: u64,
    /// Set when the cell has ended, whether by itself or not.
    ended: &'a AtomicBool,
}

impl<'a> Target<'a> {
    /// Waits for the processes of the cell whose results go into `folder`.
    pub(crate) fn find(
        folder: &Path,
        duration_ns: u64,
        ended: &'a AtomicBool,
    ) -> Result<Self, String> {
        let folder = folder.display().to_string();
        while !ended.load(Ordering::Relaxed) {
            // The controller is started last, whichever client it is.
            let roles: Vec<_> = processes()
                .filter(|(_, words)| words.iter().any(|word| word.contains(&folder)))
                .collect();
            let of = |role: &str| {
                roles
                    .iter()
                    .find(|(_, words)| words.windows(2).any(|pair| pair == ["serve", role]))
                    .map(|(number, _)| *number)
            };
            let started = roles
                .iter()
                .find_map(|(number, _)| Some((*number, start_ns(*number)?)));
            if let (Some(plant), Some((controller, start_ns))) = (of("plant"), started) {
                return Ok(Self {
                    controller,
                    plant,
                    player: of("link"),
                    start_ns,
                    duration_ns,
                    ended,
                });
            }
            thread::sleep(Duration::from_millis(2));
        }
        Err(NOT_THERE.to_owned())
    }

    /// The process at the end from which the packets of `way` come.
    pub(crate) fn source(&self, way: Way) -> u32 {
        match way {
            Way::Up => self.controller,
            Way::Down => self.plant,
        }
    }

    /// The process at the end to which the packets of `way` go.
    pub(crate) fn sink(&self, way: Way) -> u32 {
        match way {
            Way::Up => self.plant,
            Way::Down => self.controller,
        }
    }

    /// The interface of either end that leads to the other one.
    pub(crate) fn device(&self) -> &'static str {
        match self.player {
            Some(_) => shaper::END_INTERFACE,
            None => "lo",
        }
    }

    /// The processes of both ends, or one in the namespace that they share.
    pub(crate) fn ends(&self) -> Vec<u32> {
        match self.player {
            Some(_) => vec![self.controller, self.plant],
            None => vec![self.plant],
        }
    }

    /// Waits until commands have to switch the disturbance on.
    pub(crate) fn await_beginning(&self) -> Result<(), String> {
        self.wait_until(self.start_ns - AHEAD_NS)
    }

    /// Waits until they have to switch it off again.
    pub(crate) fn await_end(&self) -> Result<(), String> {
        self.wait_until(self.end_ns())
    }

    /// When everything has to be as it was.
    pub(crate) fn end_ns(&self) -> u64 {
        self.start_ns + self.duration_ns - BEHIND_NS
    }

    /// How far the controller's part has come, in words: commands take their time.
    pub(crate) fn now(&self) -> String {
        let since_ns = now_ns() as f64 - self.start_ns as f64;
        format!("from {:.0} ms of the loop on", since_ns / 1e6)
    }

    /// Whether the cell has ended.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    fn wait_until(&self, due_ns: u64) -> Result<(), String> {
        while !self.has_ended() {
            let Some(left_ns) = due_ns.checked_sub(now_ns()) else {
                return Ok(());
            };
            thread::sleep(Duration::from_nanos(left_ns.min(20 * MS)));
        }
        Err("the cell ended early".to_owned())
    }
}

/// `process` and all its descendants.
pub(crate) fn family(process: u32) -> Vec<u32> {
    let parents: Vec<_> = processes()
        .filter_map(|(number, _)| Some((number, parent(number)?)))
        .collect();
    let mut family = vec![process];
    let mut next = 0;
    while let Some(&member) = family.get(next) {
        let children = parents.iter().filter(|(_, parent)| *parent == member);
        family.extend(children.map(|(number, _)| *number));
        next += 1;
    }
    family
}

fn parent(process: u32) -> Option<u32> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("PPid:"))?;
    line.trim().parse().ok()
}

/// When a role begins, according to its settings; `None` unless it is a controller.
fn start_ns(process: u32) -> Option<u64> {
    let settings = fs::read(format!("/proc/{process}/fd/0")).ok()?;
    let settings: serde_json::Value = serde_json::from_slice(&settings).ok()?;
    // A plant knows the start too, but not for how long messages are due.
    settings.get("duration_ns")?;
    settings.get("start_ns")?.as_u64()
}

/// Every process with its command line, word by word.
fn processes() -> impl Iterator<Item = (u32, Vec<String>)> {
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(|entry| {
            let number = entry.file_name().to_str()?.parse().ok()?;
            let line = fs::read(entry.path().join("cmdline")).ok()?;
            let words = line.split(|byte| *byte == 0);
            Some((
                number,
                words
                    .map(|word| String::from_utf8_lossy(word).into_owned())
                    .collect(),
            ))
        })
}

/// Runs an action in the network namespace of `process`, on a thread of its own.
pub(crate) fn inside<T: Send>(
    process: u32,
    action: impl FnOnce() -> Result<T, String> + Send,
) -> Result<T, String> {
    thread::scope(|scope| {
        let thread = scope.spawn(|| {
            enter(process)?;
            action()
        });
        thread
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Moves the calling thread into the network namespace of `process`.
pub(crate) fn enter(process: u32) -> Result<(), String> {
    let fail = |problem| format!("cannot enter the namespace of {process}: {problem}");
    let namespace = File::open(format!("/proc/{process}/ns/net")).map_err(fail)?;
    move_into_link_name_space(namespace.as_fd(), Some(LinkNameSpaceType::Network))
        .map_err(|problem| fail(problem.into()))
}

/// Runs the command `line` in the namespace of the calling thread. Returns its output, or its
/// complaint as an error.
pub(crate) fn tool(line: &str) -> Result<String, String> {
    let mut words = line.split_whitespace();
    let output = Command::new(words.next().unwrap_or_default())
        .args(words)
        .stdin(Stdio::null())
        .output()
        .map_err(|problem| format!("`{line}`: {problem}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!(
            "`{line}`: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        ))
    }
}
