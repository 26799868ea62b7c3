//! Processes items in parallel and returns the results in order, so that they are the same on any machine.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, SyncSender};
use std::thread;

/// Results of each thread that may wait to be copied.
const AHEAD: usize = 16;

/// Applies `work` to each item, on every core that this process may use. Returns the results in the
/// order of the items.
pub fn each<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    gathered(items, work, |result| result)
}

/// As [`each`], with results that the calling thread copies to a place of its own. Among the passing memory of the
/// threads that made them, each of a hundred thousand small ones would keep a hole open: half as much again.
pub fn each_apart<T: Sync, R: Send + Clone>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    // The other threads' memory is freed as soon as the copy is made.
    gathered(items, work, |result| result.clone())
}

/// The results of all threads, each of which the calling thread keeps as `keep` has it.
fn gathered<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
    keep: impl Fn(R) -> R,
) -> Vec<R> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    // Items take different times: a thread that is done takes the next one. Each result goes to its place at once: of a
    // hundred thousand, a second copy would not fit.
    let next = AtomicUsize::new(0);
    let mut done: Vec<Option<R>> = items.iter().map(|_| None).collect();
    let share = |send: SyncSender<(usize, R)>| {
        let taken = || {
            let at = next.fetch_add(1, Ordering::Relaxed);
            items.get(at).map(|item| (at, item))
        };
        // Nobody is there to take a result only where the calling thread panics.
        while let Some((at, item)) = taken()
            && send.send((at, work(item))).is_ok()
        {}
    };
    thread::scope(|scope| {
        let (send, results) = mpsc::sync_channel(cores * AHEAD);
        let share = &share;
        let threads: Vec<_> = (0..cores.min(items.len()))
            .map(|_| {
                let send = send.clone();
                scope.spawn(move || share(send))
            })
            .collect();
        drop(send);
        for (at, result) in results {
            if let Some(place) = done.get_mut(at) {
                *place = Some(keep(result));
            }
        }
        for thread in threads {
            thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        }
    });
    // All are there. Unlike `flatten`, this collects into the memory that they lie in.
    done.into_iter().map_while(|result| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_items_and_none_is_left_out() {
        let items: Vec<u64> = (0..1000).collect();
        let squares: Vec<u64> = items.iter().map(|x| x * x).collect();
        assert_eq!(each(&items, |x| x * x), squares);
        assert_eq!(each_apart(&items, |x| x * x), squares);
        assert!(each(&[], |x: &u64| *x).is_empty());
        assert!(each_apart(&[], |x: &u64| *x).is_empty());
    }
}
