//! Runs a sweep's points on many threads, and hands their rows on as they come.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use backend::Timings;
use endpoint::Thread;
use sim::Timing;
use sweep::{Bench, Machine, Row, Sweep, Unfit};

use crate::error::Error;

/// Runs that a thread takes at a time: points over one link follow each other, and share it.
const SHARE: usize = 8;
/// Shares that may wait to be written, for each thread.
const WAITING: usize = 4;

/// Runs those with these numbers on so many threads, until all are done or `stop` is set; `take`
/// is given their rows on this thread, in the order in which they come.
///
/// # Errors
/// The first of `take`, or of a point that cannot be run.
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
                    // Nobody takes it any more where something went wrong there.
                    if give.send(done).is_err() {
                        break;
                    }
                }
            });
        }
        drop(give);
        // Taken to the end of this scope only, so that threads are told by its being gone.
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
        // A browser as it does best: in a worker.
        Machine::Of(client) => timings.rates((client, Some(Thread::Worker))).near(point.h),
    };
    bench.run(sweep, run, &point, timing)
}
