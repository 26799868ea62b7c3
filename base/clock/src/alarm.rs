//! Deadlines for a task. The runtime's own timers round to a millisecond, so this is a `timerfd` on
//! the run's clock, and for the last moment the task yields in turn to the others of its runtime.
#![allow(
    unsafe_code,
    reason = "registering a descriptor with the runtime; see `Alarm::new`"
)]

use std::{io, os::fd::OwnedFd};

use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, timerfd_create, timerfd_settime,
};
use tokio::io::{Interest, unix::AsyncFd};

use crate::guard::Guard;
use crate::now::{now_ns, timespec};
use crate::scheduling::Granted;

/// An alarm that rings once for each setting.
#[derive(Debug)]
pub struct Alarm {
    timer: AsyncFd<OwnedFd>,
    guard: Guard,
    /// When to ring.
    due_ns: u64,
    /// When the timer wakes the runtime for it.
    wake_ns: u64,
}

/// The setting of an alarm that never rings.
const NEVER_NS: u64 = u64::MAX;

impl Alarm {
    /// An alarm that is not set, for a runtime of one thread that was granted this. Needs the runtime's context.
    ///
    /// # Errors
    /// The system's error if it has no timer or no file descriptor left.
    pub fn new(granted: &Granted) -> io::Result<Self> {
        let flags = TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC;
        let timer = timerfd_create(TimerfdClockId::Monotonic, flags)?;
        // SAFETY: the descriptor is open, an `OwnedFd` keeps it open and never changes it, and the
        // `AsyncFd` owns it from here on until it is dropped.
        let timer = unsafe { AsyncFd::register_with_interest(timer, Interest::READABLE) }?;
        Ok(Self {
            timer,
            guard: Guard::of(granted),
            due_ns: NEVER_NS,
            wake_ns: NEVER_NS,
        })
    }

    /// Sets the alarm to `t_ns` of the run's clock, in place of an earlier setting; it rings at once
    /// if that time has passed.
    ///
    /// # Errors
    /// None for a valid timer; otherwise the system's.
    pub fn set(&mut self, t_ns: u64) -> io::Result<()> {
        if t_ns == self.due_ns {
            return Ok(());
        }
        let now = now_ns();
        self.due_ns = t_ns;
        self.wake_ns = self.guard.wake_rested_ns(now, t_ns);
        if now < self.wake_ns {
            let once = Itimerspec {
                it_interval: timespec(0),
                it_value: timespec(self.wake_ns),
            };
            timerfd_settime(&self.timer, TimerfdTimerFlags::ABSTIME, &once)?;
        }
        Ok(())
    }

    /// Waits until the alarm rings. Dropping this future early loses nothing. A real-time thread is awake for
    /// the last moment before, and the runtime goes on serving its other tasks and sockets.
    ///
    /// # Errors
    /// None for a valid timer; otherwise the system's.
    pub async fn rung(&mut self) -> io::Result<()> {
        while now_ns() < self.wake_ns {
            self.woken().await?;
            // A ring of an earlier setting that nobody waited for is no wake of this one.
            let now = now_ns();
            if now >= self.wake_ns {
                self.guard.learn(now - self.wake_ns);
            }
        }
        while now_ns() < self.due_ns {
            tokio::task::yield_now().await;
        }
        (self.due_ns, self.wake_ns) = (NEVER_NS, NEVER_NS);
        Ok(())
    }

    /// Waits for the timer.
    async fn woken(&self) -> io::Result<()> {
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
    use std::{future::Future, time::Duration};

    /// Runs a task in a runtime of one thread.
    fn run(task: impl Future<Output = ()>) {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build();
        runtime.expect("a runtime").block_on(task);
    }

    fn both() -> [Granted; 2] {
        let fifo = Granted {
            fifo_priority: Some(1),
            ..Granted::ordinary()
        };
        [Granted::ordinary(), fifo]
    }

    #[test]
    fn it_rings_at_its_last_setting_and_never_before() {
        for granted in both() {
            run(async {
                let mut alarm = Alarm::new(&granted).expect("a timer");
                let due_ns = now_ns() + 5_000_000;
                for t_ns in [now_ns() + 1_000_000, due_ns, due_ns] {
                    alarm.set(t_ns).expect("a valid timer");
                }
                alarm.rung().await.expect("a valid timer");
                assert!(now_ns() >= due_ns);
                alarm.set(0).expect("a valid timer");
                alarm.rung().await.expect("a past time rings at once");
            });
        }
    }

    #[test]
    fn one_that_rang_is_silent_until_it_is_set_again() {
        for granted in both() {
            run(async {
                let mut alarm = Alarm::new(&granted).expect("a timer");
                alarm.set(now_ns() + 300_000).expect("a valid timer");
                alarm.rung().await.expect("a valid timer");
                let silence = tokio::time::timeout(Duration::from_millis(5), alarm.rung());
                assert!(silence.await.is_err(), "it rings once");
                let due_ns = now_ns() + 300_000;
                alarm.set(due_ns).expect("a valid timer");
                // Given up and asked again, within the guard too.
                while now_ns() < due_ns {
                    let now = tokio::time::timeout(Duration::ZERO, alarm.rung()).await;
                    assert_eq!(now.is_ok(), now_ns() >= due_ns && now.is_ok());
                }
                alarm.set(due_ns).expect("a valid timer");
                alarm.rung().await.expect("a valid timer");
            });
        }
    }

    /// A ring that nobody waited for wakes nobody later: a real-time thread that is awake for nothing takes the
    /// processor from whatever would answer it.
    #[test]
    fn a_ring_that_nobody_waited_for_is_forgotten() {
        let [_, fifo] = both();
        run(async {
            let mut alarm = Alarm::new(&fifo).expect("a timer");
            let due_ns = now_ns() + 300_000;
            alarm.set(due_ns).expect("a valid timer");
            while now_ns() < due_ns {}
            alarm.rung().await.expect("a valid timer");
            let before_ns = processor_ns();
            let silence = tokio::time::timeout(Duration::from_millis(50), alarm.rung());
            assert!(silence.await.is_err(), "it rings once");
            let took_ns = processor_ns() - before_ns;
            assert!(took_ns < 25_000_000, "{took_ns} ns awake");
        });
    }

    /// What this thread has taken of a processor.
    fn processor_ns() -> u64 {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
    }

    /// While it waits within its guard, other tasks of the runtime go on.
    #[test]
    fn the_runtime_serves_others_to_the_last_moment() {
        let [_, fifo] = both();
        run(async {
            let mut alarm = Alarm::new(&fifo).expect("a timer");
            let turns = std::rc::Rc::new(std::cell::Cell::new(0_u64));
            let local = tokio::task::LocalSet::new();
            let counted = std::rc::Rc::clone(&turns);
            local.spawn_local(async move {
                loop {
                    counted.set(counted.get() + 1);
                    tokio::task::yield_now().await;
                }
            });
            local
                .run_until(async {
                    let due_ns = now_ns() + 400_000;
                    alarm.set(due_ns).expect("a valid timer");
                    // Within the guard from now on.
                    while now_ns() < alarm.wake_ns {}
                    let before = turns.get();
                    alarm.rung().await.expect("a valid timer");
                    assert!(turns.get() > before || now_ns() > due_ns + 50_000);
                })
                .await;
        });
    }
}
