//! The processors for what is compared on one, or on two.
//!
//! Two ends on two processors are measured by how soon the second one wakes, which is another thing on each
//! machine. On one processor the same work shows in every program alike.

use std::io;
use std::thread;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use crate::contender::Lack;

/// Processors that this process may use.
#[derive(Clone, Debug)]
pub(crate) struct Processors(CpuSet);

impl Processors {
    /// The last ones, as many as there are up to `count`: interrupts are mostly served by the first.
    ///
    /// # Errors
    /// If the kernel does not say.
    pub(crate) fn last(count: usize) -> io::Result<Processors> {
        let allowed = sched_getaffinity(None)?;
        let mut last = CpuSet::new();
        (0..CpuSet::MAX_CPU)
            .rev()
            .filter(|processor| allowed.is_set(*processor))
            .take(count)
            .for_each(|processor| last.set(processor));
        Ok(Processors(last))
    }

    /// Runs something on a thread of its own that only uses these processors, as all processes and threads do that
    /// it starts.
    ///
    /// # Errors
    /// If the kernel does not grant it, or what it runs fails.
    pub(crate) fn run<T: Send>(
        &self,
        run: impl FnOnce() -> Result<T, Lack> + Send,
    ) -> Result<T, Lack> {
        let pinned = || {
            sched_setaffinity(None, &self.0).map_err(io::Error::from)?;
            run()
        };
        thread::scope(|scope| match scope.spawn(pinned).join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }
}
