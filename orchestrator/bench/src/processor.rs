//! The processor for what is compared on one.
//!
//! Two ends on two processors are measured by how soon the second one wakes, which is another thing on each
//! machine. On one processor the same work shows in every program alike.

use std::io;
use std::thread;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use crate::contender::Lack;

/// A processor that this process may use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Processor(usize);

impl Processor {
    /// The last: interrupts are mostly served by the first.
    ///
    /// # Errors
    /// If the kernel does not say.
    pub(crate) fn last() -> io::Result<Processor> {
        let allowed = sched_getaffinity(None)?;
        let last = (0..CpuSet::MAX_CPU)
            .rev()
            .find(|processor| allowed.is_set(*processor));
        last.map(Processor)
            .ok_or_else(|| io::Error::other("this process may use no processor"))
    }

    /// Runs something on a thread of its own that only uses this processor, as all processes and threads do that
    /// it starts.
    ///
    /// # Errors
    /// If the kernel does not grant it, or what it runs fails.
    pub(crate) fn run<T: Send>(
        self,
        run: impl FnOnce() -> Result<T, Lack> + Send,
    ) -> Result<T, Lack> {
        let pinned = || {
            let mut one = CpuSet::new();
            one.set(self.0);
            sched_setaffinity(None, &one).map_err(io::Error::from)?;
            run()
        };
        thread::scope(|scope| match scope.spawn(pinned).join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }
}
