//! A browser as a process: started like a user's program, and ended with all its children.

use std::{
    io,
    os::unix::process::CommandExt,
    path::Path,
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use rustix::{
    fs::statvfs,
    process::{Pid, Signal, kill_process_group},
};
use thread_priority::{
    NormalThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id, thread_schedule_policy,
};

use crate::{config::Leash, engine::Browser, family::Family, words::Words};

/// Interval at which the end is checked.
const POLL: Duration = Duration::from_millis(20);

/// A process that has not ended this long after SIGKILL is stuck in the kernel.
const KILL_WITHIN: Duration = Duration::from_secs(5);

/// A browser's shared memory for a page is far below this. Some containers have 64 MiB, in which
/// larger pages crash.
const SHARED_MEMORY_BYTES: u64 = 128 << 20;

/// Environment variables passed on to a browser; all others belong to whoever started webloop and may
/// differ between runs.
const PASSED_ON: &[&str] = &["PATH", "LD_LIBRARY_PATH", "FONTCONFIG_FILE"];

/// A running browser.
pub(crate) struct Process {
    child: Child,
    family: Family,
    words: Words,
    started: Instant,
}

impl Process {
    /// Starts `program` with its files in `home`, as another user if one is given.
    pub(crate) fn start(
        program: &Browser,
        arguments: &[String],
        home: &Path,
        user: Option<u32>,
        leash: Leash,
    ) -> io::Result<Self> {
        let mut command = Command::new(&program.path);
        command
            .args(arguments)
            .env_clear()
            .envs(
                PASSED_ON
                    .iter()
                    .filter_map(|name| Some((name, std::env::var_os(name)?))),
            )
            .env("HOME", home)
            .env("TMPDIR", home)
            .env("LANG", "C.UTF-8")
            // Without this the browser looks for a session bus and may start one.
            .env("DBUS_SESSION_BUS_ADDRESS", "disabled:")
            .env("MOZ_CRASHREPORTER_DISABLE", "1")
            .current_dir(home)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // A Ctrl-C reaches the launcher but not the browser.
            .process_group(0);
        if let Some(user) = user {
            command.uid(user).gid(user);
        }
        leash(&mut command)?;
        let family = Family::begin()?;
        leave_real_time();
        let mut child = command.spawn()?;
        let stderr = child.stderr.take().ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(Self {
            child,
            family,
            words: Words::of(stderr),
            started: Instant::now(),
        })
    }

    /// When it was started.
    pub(crate) fn started(&self) -> Instant {
        self.started
    }

    /// Its exit status, if it has ended.
    pub(crate) fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// All its processes.
    pub(crate) fn members(&self) -> Vec<Pid> {
        self.family.members(self.number())
    }

    /// Its last output.
    pub(crate) fn last_words(&self) -> String {
        if self.members().is_empty() {
            self.words.drain();
        }
        self.words.last()
    }

    /// Ends the browser and all processes that it started: sends SIGTERM, waits for `within`, then kills.
    ///
    /// # Errors
    /// If a process cannot be killed.
    pub(crate) fn end(&mut self, within: Duration) -> io::Result<()> {
        // Its pid is not reused until it has been waited for.
        if self.child.try_wait()?.is_none()
            && let Some(group) = Pid::from_raw(self.number())
        {
            let _ = kill_process_group(group, Signal::TERM);
        }
        if self.wait_until_gone(within, |_| {})? {
            return Ok(());
        }
        if self.wait_until_gone(KILL_WITHIN, |process| process.family.kill(process.number()))? {
            return Ok(());
        }
        let left: Vec<_> = self.members().iter().map(ToString::to_string).collect();
        let left = left.join(", ");
        Err(io::Error::other(format!("processes {left} do not end")))
    }

    fn wait_until_gone(&mut self, within: Duration, press: impl Fn(&Self)) -> io::Result<bool> {
        let deadline = Instant::now() + within;
        loop {
            press(self);
            if self.child.try_wait()?.is_some() && self.members().is_empty() {
                return Ok(true);
            }
            if Instant::now() > deadline {
                return Ok(false);
            }
            thread::sleep(POLL);
        }
    }

    fn number(&self) -> i32 {
        self.child.id().cast_signed()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if let Err(error) = self.end(Duration::ZERO) {
            tracing::warn!("{error}");
        }
    }
}

/// Whether there is enough shared memory for a browser.
pub(crate) fn has_shared_memory() -> bool {
    statvfs("/dev/shm")
        .is_ok_and(|volume| volume.f_bavail.saturating_mul(volume.f_frsize) >= SHARED_MEMORY_BYTES)
}

/// Gives up this thread's real-time scheduling: a browser would inherit it, and no user's browser has it.
fn leave_real_time() {
    /// Niceness 0 on the crate's scale from 0 to 99.
    const ORDINARY: u8 = 47;
    if let (Ok(ThreadSchedulePolicy::Realtime(_)), Ok(ordinary)) = (
        thread_schedule_policy(),
        ThreadPriorityValue::try_from(ORDINARY),
    ) {
        let other = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        let ordinary = ThreadPriority::Crossplatform(ordinary);
        // Leaving the real-time class is always permitted; at worst a niceness remains.
        let _ = set_thread_priority_and_policy(thread_native_id(), ordinary, other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_inherits_no_real_time_scheduling() {
        // In a thread of its own, since the scheduling stays with the thread.
        let (policy, niceness) = thread::spawn(|| {
            // If it is not granted, there is nothing to give up.
            clock::scheduling::ask(Some(10));
            leave_real_time();
            let niceness = rustix::process::getpriority_process(None);
            (thread_schedule_policy(), niceness)
        })
        .join()
        .expect("no panic");
        assert!(matches!(policy, Ok(ThreadSchedulePolicy::Normal(_))));
        let before = rustix::process::getpriority_process(None);
        assert_eq!(niceness, before);
    }
}
