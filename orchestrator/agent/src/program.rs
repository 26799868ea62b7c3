//! Supervises a controller of somebody's own: starts it confined, keeps what it prints, ends it when its time
//! is over, and says how it ended.
//!
//! What its messages were is seen at the plant, and judged elsewhere.

use std::ffi::OsString;
use std::fs;
use std::io::{self, PipeReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use pace::now_ns;

use crate::role::exit_code;
use crate::spawn;

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

/// A program to be supervised.
#[derive(Debug)]
pub struct Program<'a> {
    /// The program and its arguments.
    pub run: &'a [String],
    /// What its environment has in addition to this process's.
    pub environment: Vec<(&'static str, OsString)>,
    /// Port of its plant.
    pub plant_port: u16,
    /// When its last message was due, ns on the monotonic clock.
    pub stop_ns: u64,
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
/// The calling thread's later children are in the program's PID namespace, so there should be none.
///
/// # Errors
/// When namespaces are not allowed, or a process cannot be started.
pub fn supervise(
    program: &Program<'_>,
    ready: impl FnOnce(),
    stop: &AtomicBool,
) -> io::Result<Ended> {
    // One pipe for both, so that lines keep their order.
    let (printed, writer) = io::pipe()?;
    let mut command = Command::new("/proc/self/exe");
    command
        .args(["serve", "first", "--"])
        .args(program.run)
        .envs(
            program
                .environment
                .iter()
                .map(|(name, value)| (name, value)),
        )
        .stdin(Stdio::null())
        .stdout(writer.try_clone()?)
        .stderr(writer);
    let log = keep(printed)?;
    // From here on this thread can start no other.
    spawn::separate()?;
    spawn::confine(&mut command);
    let mut child = command.spawn()?;
    // It has this end of the pipe, and the log ends when all of its own are closed.
    drop(command);
    ready();
    let ended = watch(&mut child, program, stop);
    if ended.is_err() {
        let _ = child.kill();
        let _ = child.wait();
    }
    // With the first process all are gone that could write.
    let _ = log.join();
    ended
}

fn watch(child: &mut Child, program: &Program<'_>, stop: &AtomicBool) -> io::Result<Ended> {
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
