//! Runs a sweep's points on threads, and passes on their rows as they come.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use analysis::sweep::Row;
use backend::Timings;
use endpoint::Thread;
use plan::sweep::{Machine, Sweep};
use sim::Timing;

use crate::bench::{Bench, Unfit};
use crate::error::Error;
use crate::threads::spread;

/// Runs that a thread takes at a time: consecutive points often use the same link, which is made once.
const SHARE: usize = 8;
/// Shares of runs that may wait to be written, for each thread.
const WAITING: usize = 4;

/// Makes the runs with these numbers on `threads` threads, until all are done or `stop` is set.
/// Calls `take` on this thread with their rows, in the order in which they come.
///
/// # Errors
/// The first error of `take`, or of a point that cannot be run.
pub fn run_points(
    sweep: &Sweep,
    numbers: &[usize],
    timings: &Timings,
    threads: usize,
    stop: &AtomicBool,
    mut take: impl FnMut(&[Row]) -> Result<(), Error>,
) -> Result<(), Error> {
    let next = AtomicUsize::new(0);
    let is_going = || !stop.load(Ordering::Relaxed);
    let worker = || {
        let mut bench = Bench::default();
        let (next, is_going) = (&next, &is_going);
        move || {
            let from = next.fetch_add(SHARE, Ordering::Relaxed);
            let share = numbers.get(from..).unwrap_or_default();
            let share = &share[..share.len().min(SHARE)];
            let is_due = !share.is_empty() && is_going();
            is_due.then(|| {
                let due = share.iter().take_while(|_| is_going());
                due.map(|number| one(sweep, *number, timings, &mut bench))
                    .collect::<Result<Vec<Row>, Unfit>>()
            })
        }
    };
    spread(threads, threads * WAITING, worker, |rows| {
        for done in rows {
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
