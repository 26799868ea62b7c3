//! Supervises a controller of somebody's own: starts it confined, keeps what it prints, ends it when its time
//! is over, and says how it ended.
//!
//! What its messages were is seen at the plant, and judged elsewhere.

use std::ffi::OsString;
use std::fs;
use std::io::{self, PipeReader, Read, Write};
use std::os::fd::OwnedFd;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use clock::now::now_ns;
use rustix::process::{Pid, Signal, WaitOptions, getpid, kill_process, set_child_subreaper, wait};

use crate::exit::exit_code;
use crate::look::family;
use crate::python_path::PythonPath;
use crate::shelter::{Hidden, Shelter};
use crate::spawn;

/// How long before its first message is due a program is started at the earliest, ns. A run may have to wait for
/// its neighbours, and a plant closes a connection on which nothing comes for 5 s.
const EARLY_NS: u64 = 4_000_000_000;

/// How long a program may take to end by itself after its last message was due, ns.
const OVERTIME_NS: u64 = 2_000_000_000;

/// How long it may take from SIGTERM to its end, ns.
const STOP_WITHIN_NS: u64 = 1_000_000_000;

/// How often to look at it.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Number of looks from one count of its unread answers to the next.
const LOOKS_PER_COUNT: u64 = 10;

/// Most of what it prints that is kept, bytes.
const LOG_BYTES: usize = 1 << 20;

/// The folder for its own files, in the run's folder.
pub const OWN: &str = "own";

/// A program to be supervised.
#[derive(Debug)]
pub struct Supervised<'a> {
    /// The program and its arguments.
    pub run: &'a [String],
    /// What its environment has in addition to this process's, and to the package `webloop` on Python's path.
    pub environment: Vec<(&'static str, OsString)>,
    /// Port of its plant.
    pub plant_port: u16,
    /// When its first message is due, ns on the monotonic clock.
    pub start_ns: u64,
    /// When its last message was due, ns on the monotonic clock.
    pub stop_ns: u64,
    /// What it must not see, where this user may make namespaces.
    pub hidden: Option<Hidden>,
}

/// How a program ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ended {
    /// Its exit code; for one that a signal ended, 128 and the signal's number, as a shell has it.
    pub code: i32,
    /// When it had ended, ns on the monotonic clock.
    pub t_ns: u64,
    /// Whether it was sent SIGTERM.
    pub is_told: bool,
    /// Whether it did not end on SIGTERM, and was killed.
    pub is_killed: bool,
    /// Most bytes of answers that it had left unread at one time.
    pub unread_bytes: u64,
}

/// Starts a program, waits for its end, and ends it when its time is over or `stop` is set. Nothing of it
/// is left afterwards. What it prints goes to standard error, up to 1 MiB.
///
/// The calling thread's later children are in the program's PID namespace, so there should be none. Where
/// namespaces are not allowed, all children of this process are taken for the program's.
///
/// # Errors
/// When a process cannot be started; of the kind `PermissionDenied` when this machine does not let anything be
/// hidden from it.
pub fn supervise(
    program: &Supervised<'_>,
    ready: impl FnOnce(),
    stop: &AtomicBool,
) -> io::Result<Ended> {
    // One pipe for both, so that lines keep their order.
    let (printed, writer) = io::pipe()?;
    // Open until the program has ended, since its path leads to this descriptor.
    let package = PythonPath::new()?;
    let mut command = Command::new("/proc/self/exe");
    command
        .args(["serve", "first", "--not-before-ns"])
        .arg(program.start_ns.saturating_sub(EARLY_NS).to_string())
        .arg("--")
        .args(program.run)
        .envs(
            program
                .environment
                .iter()
                .map(|(name, value)| (name, value)),
        )
        .envs([package.variable()])
        .stdin(Stdio::null())
        .stdout(writer.try_clone()?)
        .stderr(writer);
    let log = keep(printed)?;
    // From here on this thread can start no other.
    let is_separate = match spawn::separate() {
        Ok(()) => {
            spawn::confine(&mut command, Shelter::find(program.hidden.as_ref())?);
            true
        }
        // In a container nobody may, and its end is the end of all that is in it.
        Err(problem) if problem.kind() == io::ErrorKind::PermissionDenied => {
            set_child_subreaper(Some(getpid()))?;
            spawn::bind(&mut command, None::<&OwnedFd>)?;
            false
        }
        Err(problem) => return Err(problem),
    };
    let spawned = command.spawn();
    let mut child = match is_separate {
        true => spawned.map_err(unsheltered)?,
        false => spawned?,
    };
    // It has this end of the pipe, and the log ends when all of its own are closed.
    drop(command);
    ready();
    let ended = watch(&mut child, program, stop);
    if ended.is_err() {
        let _ = child.kill();
        let _ = child.wait();
    }
    if !is_separate {
        end_descendants();
    }
    // With the first process all are gone that could write.
    let _ = log.join();
    ended
}

/// The error of a program that cannot be kept from what it must not see: the kernel forbids mounts, or something
/// like `AppArmor` in a container does.
#[allow(clippy::needless_pass_by_value)] // It is what `map_err` passes.
pub(crate) fn unsheltered(problem: io::Error) -> io::Error {
    io::Error::new(
        problem.kind(),
        format!(
            "the run's rows cannot be hidden from it: {problem}; allow webloop to mount in namespaces of its own (in \
             a container: --security-opt apparmor=unconfined)"
        ),
    )
}

/// Kills what a program left behind, all of which has become this process's, and waits for it.
fn end_descendants() {
    let own = std::process::id();
    let deadline = now_ns() + STOP_WITHIN_NS;
    loop {
        let left = family(own).into_iter().filter(|pid| *pid != own);
        for pid in left.filter_map(|pid| Pid::from_raw(i32::try_from(pid).ok()?)) {
            let _ = kill_process(pid, Signal::KILL);
        }
        while let Ok(Some(_)) = wait(WaitOptions::NOHANG) {}
        // No child is left, or one cannot be ended.
        if wait(WaitOptions::NOHANG).is_err() || now_ns() > deadline {
            return;
        }
        thread::sleep(LOOK_EVERY);
    }
}

fn watch(child: &mut Child, program: &Supervised<'_>, stop: &AtomicBool) -> io::Result<Ended> {
    let mut told_ns = None;
    let (mut is_killed, mut unread_bytes) = (false, 0);
    let mut looks = 0_u64;
    loop {
        let t_ns = now_ns();
        if let Some(status) = child.try_wait()? {
            return Ok(Ended {
                code: exit_code(status),
                t_ns,
                is_told: told_ns.is_some(),
                is_killed,
                unread_bytes,
            });
        }
        if looks.is_multiple_of(LOOKS_PER_COUNT) {
            unread_bytes = unread_bytes.max(unread(program.plant_port));
        }
        let is_over = t_ns > program.stop_ns.saturating_add(OVERTIME_NS);
        match told_ns {
            None if is_over || stop.load(Ordering::Relaxed) => {
                spawn::terminate(child);
                told_ns = Some(t_ns);
            }
            Some(told_ns) if !is_killed && t_ns > told_ns + STOP_WITHIN_NS => {
                child.kill()?;
                is_killed = true;
            }
            _ => {}
        }
        thread::sleep(LOOK_EVERY);
        looks += 1;
    }
}

/// Copies what a program prints to standard error, from a thread of its own, and drops what is too much.
pub(crate) fn keep(mut printed: PipeReader) -> io::Result<JoinHandle<()>> {
    thread::Builder::new()
        .name("log".to_owned())
        .spawn(move || {
            let (mut part, mut kept) = ([0; 8192], 0);
            while let Ok(length @ 1..) = printed.read(&mut part) {
                let room = length.min(LOG_BYTES - kept);
                let _ = io::stderr().write_all(part.get(..room).unwrap_or_default());
                kept += room;
                if room < length {
                    let _ = writeln!(
                        io::stderr(),
                        "\nIt printed more than 1 MiB; the rest is left out."
                    );
                    // Read to the end, so that it does not block.
                    let _ = io::copy(&mut printed, &mut io::sink());
                }
            }
        })
}

/// Bytes that have arrived from a plant's port in this network and that nobody has read.
fn unread(plant_port: u16) -> u64 {
    let text = fs::read_to_string("/proc/self/net/tcp").unwrap_or_default();
    text.lines()
        .skip(1)
        .filter_map(|line| unread_in(line, plant_port))
        .sum()
}

/// The same of one line: `N: local remote state sent:received …`, in hexadecimal digits.
fn unread_in(line: &str, plant_port: u16) -> Option<u64> {
    let mut fields = line.split_ascii_whitespace().skip(2);
    let (_, port) = fields.next()?.split_once(':')?;
    let (_, received) = fields.nth(1)?.split_once(':')?;
    let is_plant = u16::from_str_radix(port, 16).is_ok_and(|port| port == plant_port);
    is_plant
        .then(|| u64::from_str_radix(received, 16).ok())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unread_bytes_are_those_of_connections_to_the_plant() {
        let line =
            "   1: 0100007F:9C40 0100007F:1F90 01 00000000:00001A2B 00:00000000 00000000 0 0 77";
        assert_eq!(unread_in(line, 8080), Some(0x1a2b));
        assert_eq!(unread_in(line, 8081), None);
        assert_eq!(unread_in("", 8080), None);
    }
}
