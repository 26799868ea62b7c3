//! Runs a sweep's points on many threads, and passes on their rows as they come.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use backend::Timings;
use endpoint::Thread;
use sim::Timing;
use sweep::{Bench, Machine, Row, Sweep, Unfit};

use crate::error::Error;

/// Runs that a thread takes at a time: consecutive points often use the same link, which is made once.
const SHARE: usize = 8;
/// Shares of runs that may wait to be written, for each thread.
const WAITING: usize = 4;

/// Makes the runs with these numbers on `threads` threads, until all are done or `stop` is set.
/// Calls `take` on this thread with their rows, in the order in which they come.
///
/// # Errors
/// The first error of `take`, or of a point that cannot be run.
pub fn run(
    sweep: &Sweep,
    numbers: &[usize],
    timings: &Timings,
    threads: usize,
    stop: &AtomicBool,
    mut take: impl FnMut(&[Row]) -> Result<(), Error>,
) -> Result<(), Error> {
    let next = AtomicUsize::new(0);
    let (give, rows) = mpsc::sync_channel(threads * WAITING);
    thread::scope(|scope| {
        for _ in 0..threads {
            let (give, next) = (give.clone(), &next);
            scope.spawn(move || {
                let mut bench = Bench::default();
                while !stop.load(Ordering::Relaxed) {
                    let from = next.fetch_add(SHARE, Ordering::Relaxed);
                    let share = numbers.get(from..).unwrap_or_default();
                    let share = &share[..share.len().min(SHARE)];
                    if share.is_empty() {
                        break;
                    }
                    let done = share
                        .iter()
                        .take_while(|_| !stop.load(Ordering::Relaxed))
                        .map(|number| one(sweep, *number, timings, &mut bench))
                        .collect::<Result<Vec<Row>, Unfit>>();
                    // The receiver is gone if taking the rows failed.
                    if give.send(done).is_err() {
                        break;
                    }
                }
            });
        }
        drop(give);
        // Moved in here, so that an error drops the receiver and thereby ends the threads.
        let rows = rows;
        for done in &rows {
            take(&done?)?;
        }
        Ok(())
    })
}

fn one(sweep: &Sweep, number: usize, timings: &Timings, bench: &mut Bench) -> Result<Row, Unfit> {
    let run = sweep.run(number);
    let point = sweep.grid.point(run.point);
    let timing = match point.client {
        Machine::Ideal => &Timing::IDEAL,
        // A browser in its best case: in a worker.
        Machine::Of(client) => timings.rates((client, Some(Thread::Worker))).near(point.h),
    };
    bench.run(sweep, run, &point, timing)
}
