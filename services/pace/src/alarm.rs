//! Deadlines for a task. The runtime's own timers round to a millisecond, so this is a `timerfd` on
//! the run's clock.
#![allow(
    unsafe_code,
    reason = "registering a descriptor with the runtime; see `Alarm::new`"
)]

use std::{io, os::fd::OwnedFd};

use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, timerfd_create, timerfd_settime,
};
use tokio::io::{Interest, unix::AsyncFd};

use crate::timespec;

/// An alarm that rings once for each setting.
#[derive(Debug)]
pub struct Alarm {
    timer: AsyncFd<OwnedFd>,
}

impl Alarm {
    /// An alarm that is not set. Needs the runtime's context.
    ///
    /// # Errors
    /// The system's error if it has no timer or no file descriptor left.
    pub fn new() -> io::Result<Self> {
        let flags = TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC;
        let timer = timerfd_create(TimerfdClockId::Monotonic, flags)?;
        // SAFETY: the descriptor is open, an `OwnedFd` keeps it open and never changes it, and the
        // `AsyncFd` owns it from here on until it is dropped.
        let timer = unsafe { AsyncFd::register_with_interest(timer, Interest::READABLE) }?;
        Ok(Self { timer })
    }

    /// Sets the alarm to `t_ns` of the run's clock, in place of an earlier setting; it rings at once
    /// if that time has passed.
    ///
    /// # Errors
    /// None for a valid timer; otherwise the system's.
    pub fn set(&self, t_ns: u64) -> io::Result<()> {
        let once = Itimerspec {
            it_interval: timespec(0),
            // A time of 0 would unset the timer.
            it_value: timespec(t_ns.max(1)),
        };
        timerfd_settime(&self.timer, TimerfdTimerFlags::ABSTIME, &once)?;
        Ok(())
    }

    /// Waits until the alarm rings. Dropping this future early loses nothing.
    ///
    /// # Errors
    /// None for a valid timer; otherwise the system's.
    pub async fn rung(&self) -> io::Result<()> {
        loop {
            let mut ready = self.timer.readable().await?;
            let mut times = [0; 8];
            let read = |timer: &AsyncFd<OwnedFd>| Ok(rustix::io::read(timer, &mut times)?);
            if let Ok(result) = ready.try_io(read) {
                return result.map(|_| ());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::now_ns;

    #[test]
    fn it_rings_at_its_last_setting_and_never_before() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .expect("a runtime");
        runtime.block_on(async {
            let alarm = Alarm::new().expect("a timer");
            let due_ns = now_ns() + 5_000_000;
            alarm.set(now_ns() + 1_000_000).expect("a valid timer");
            alarm.set(due_ns).expect("a valid timer");
            alarm.rung().await.expect("a valid timer");
            assert!(now_ns() >= due_ns);
            alarm.set(0).expect("a valid timer");
            alarm.rung().await.expect("a past time rings at once");
        });
    }
}
