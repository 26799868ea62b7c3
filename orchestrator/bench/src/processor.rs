//! The processors that this process may use, and a thread on one of them.
//!
//! Two ends on two processors are measured by how soon the second one wakes, which is another thing on each
//! machine. On one processor the same work shows in every program alike.

use std::io;
use std::thread;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// The processors that this process may use.
#[derive(Clone, Copy, Debug)]
pub struct Processors {
    last: usize,
}

impl Processors {
    /// Those that the kernel allows.
    ///
    /// # Errors
    /// If the kernel does not say.
    pub fn of_this_process() -> io::Result<Processors> {
        let allowed = sched_getaffinity(None)?;
        let last = (0..CpuSet::MAX_CPU)
            .rev()
            .find(|processor| allowed.is_set(*processor))
            .ok_or_else(|| io::Error::other("this process may use no processor"))?;
        Ok(Processors { last })
    }

    /// Runs something on a thread of its own that only uses one processor, as all processes and threads do
    /// that it starts. They are all on the last: interrupts are mostly served by the first.
    ///
    /// # Errors
    /// If the kernel does not grant it.
    pub(crate) fn on_one<T: Send>(
        self,
        run: impl FnOnce() -> Result<T, crate::Lack> + Send,
    ) -> Result<T, crate::Lack> {
        let pinned = || {
            let mut one = CpuSet::new();
            one.set(self.last);
            sched_setaffinity(None, &one).map_err(io::Error::from)?;
            run()
        };
        thread::scope(|scope| match scope.spawn(pinned).join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }
}
