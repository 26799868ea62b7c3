//! Work spread over threads, whose results one thread takes as they come: cells in virtual time, and a sweep's points.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use crate::error::Error;

/// Starts so many threads, each of which calls a `worker` of its own until that has no more to do. Meanwhile `take` gets
/// what they make, of which `waiting` may wait; once it returns, the threads end with what they have under way.
///
/// # Errors
/// That of `take`.
pub(crate) fn spread<T: Send, W: FnMut() -> Option<T>>(
    threads: usize,
    waiting: usize,
    worker: impl Fn() -> W + Sync,
    take: impl FnOnce(Receiver<T>) -> Result<(), Error>,
) -> Result<(), Error> {
    let (give, made) = sync_channel(waiting);
    thread::scope(|scope| {
        for _ in 0..threads {
            let (give, worker) = (give.clone(), &worker);
            scope.spawn(move || {
                let mut work = worker();
                while let Some(made) = work() {
                    // Nobody receives any more if this process cannot go on.
                    if give.send(made).is_err() {
                        break;
                    }
                }
            });
        }
        drop(give);
        // The receiver goes with it, so that an error ends the threads.
        take(made)
    })
}
