//! A browser as a process: started like a user's program, ended with all of its own.

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

use crate::{config::Leash, engine::Program, family::Family, words::Words};

/// How often an ending is looked for.
const POLL: Duration = Duration::from_millis(20);

/// A process that SIGKILL has not ended by then is stuck in the kernel.
const KILL_WITHIN: Duration = Duration::from_secs(5);

/// What a browser keeps in shared memory for a page is far below this. Some
/// containers have 64 MiB, in which larger pages crash.
const SHARED_MEMORY_BYTES: u64 = 128 << 20;

/// What of the environment a browser is given; whatever else is there is of
/// whoever started this, and no two runs' need be the same.
const PASSED_ON: &[&str] = &["PATH", "LD_LIBRARY_PATH", "FONTCONFIG_FILE"];

/// A browser that runs.
pub(crate) struct Process {
    child: Child,
    family: Family,
    words: Words,
    started: Instant,
}

impl Process {
    /// Starts `program` with its files in `home`, as another user if one is given.
    pub(crate) fn start(
        program: &Program,
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
            // Else it is looked for, and one may be started.
            .env("DBUS_SESSION_BUS_ADDRESS", "disabled:")
            .env("MOZ_CRASHREPORTER_DISABLE", "1")
            .current_dir(home)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // A Ctrl-C reaches whoever started it and not itself.
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

    /// How it ended, if it has.
    pub(crate) fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// All of its processes.
    pub(crate) fn members(&self) -> Vec<Pid> {
        self.family.members(self.number())
    }

    /// What it said last.
    pub(crate) fn last_words(&self) -> String {
        self.words.last(self.members().is_empty())
    }

    /// Ends it and all that it started: asks, waits for `within`, kills.
    ///
    /// # Errors
    /// If something is there that cannot be killed.
    pub(crate) fn end(&mut self, within: Duration) -> io::Result<()> {
        // Its number is not reused until it has been waited for.
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

/// Whether there is room for a browser where programs share memory.
pub(crate) fn has_shared_memory() -> bool {
    statvfs("/dev/shm")
        .is_ok_and(|volume| volume.f_bavail.saturating_mul(volume.f_frsize) >= SHARED_MEMORY_BYTES)
}

/// Gives up real-time scheduling that this thread was started with: a browser
/// would inherit it, and no user's has it.
fn leave_real_time() {
    /// Niceness 0 on the scale from 0 to 99 that the crate asks for.
    const ORDINARY: u8 = 47;
    if let (Ok(ThreadSchedulePolicy::Realtime(_)), Ok(ordinary)) = (
        thread_schedule_policy(),
        ThreadPriorityValue::try_from(ORDINARY),
    ) {
        let other = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        let ordinary = ThreadPriority::Crossplatform(ordinary);
        // Leaving the class is always granted; at worst a niceness stays.
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
            // Where it is not granted there is nothing to give up.
            pace::ask(Some(10));
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
