//! Decides when each cell starts. The cells of a batch run together.
//!
//! Starting a cell takes more of a machine than running it, above all for a browser. So all cells
//! of a batch are up before the first of them is measured, and the next batch begins when all of
//! this one have ended. Batches begin in the plan's order. Within a batch, the cells that take
//! longest to start begin first, so that the others wait less with an open connection. `jobs` runs
//! the cells.

use std::cmp::Reverse;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use plan::Cell;

/// How often a waiting worker checks the stop flag.
const POLL: Duration = Duration::from_millis(50);

/// How long a batch waits beyond its longest expected start, ns: starting many at once is slower.
const SPARE_NS: u64 = 1_000_000_000;

/// The cells that have not begun, and the state of the current batch.
pub struct Queue<'a> {
    state: Mutex<State<'a>>,
    ended: Condvar,
    workers: usize,
    now_ns: Clock,
}

/// A monotonic clock, in ns.
pub type Clock = fn() -> u64;

struct State<'a> {
    batches: VecDeque<VecDeque<Turn<'a>>>,
    /// The cells of the current batch that have not begun.
    begun: VecDeque<Turn<'a>>,
    /// When the current batch began, ns on the monotonic clock.
    begun_ns: u64,
    running: usize,
}

/// A cell that may begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// Number of cells in its batch.
    pub together: u16,
    /// When to start it, ns. In the queue this counts from the start of its batch; [`Queue::next`]
    /// returns it on the monotonic clock.
    pub start_ns: u64,
    /// When to begin measuring, ns, counted like `start_ns`: by then the last cell of its batch is up.
    pub not_before_ns: u64,
}

impl<'a> Queue<'a> {
    /// Queues these cells in this order, `jobs` at a time; without `jobs`, as many as each cell
    /// allows. `now_ns` is the clock by which cells are started.
    #[must_use]
    pub fn new(cells: &[&'a Cell], jobs: Option<u16>, now_ns: Clock) -> Queue<'a> {
        let batches = batches(cells, jobs);
        let workers = batches.iter().map(Vec::len).max().unwrap_or(0);
        let turns = batches.iter().map(|batch| turns(batch)).collect();
        Queue::of(turns, workers, now_ns)
    }

    /// Queues these cells, `jobs` at a time, each as soon as there is room. In virtual time nothing
    /// is measured, so nothing can be disturbed.
    #[must_use]
    pub fn unmeasured(cells: &[&'a Cell], jobs: u16) -> Queue<'a> {
        let turn = |cell: &&'a Cell| Turn {
            cell,
            together: 1,
            start_ns: 0,
            not_before_ns: 0,
        };
        let all = cells.iter().map(turn).collect();
        let workers = usize::from(jobs).min(cells.len());
        // All start times are 0, so any clock will do.
        Queue::of(VecDeque::from([all]), workers, || 0)
    }

    fn of(batches: VecDeque<VecDeque<Turn<'a>>>, workers: usize, now_ns: Clock) -> Queue<'a> {
        Queue {
            now_ns,
            state: Mutex::new(State {
                batches,
                begun: VecDeque::new(),
                begun_ns: 0,
                running: 0,
            }),
            ended: Condvar::new(),
            workers,
        }
    }

    /// Maximum number of busy workers.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.workers
    }

    /// Waits until the next cell may begin; `None` when all have begun or `stop` is set.
    pub fn next(&self, stop: &AtomicBool) -> Option<Turn<'a>> {
        let mut state = self.lock();
        while !stop.load(Ordering::Relaxed) {
            let now_ns = (self.now_ns)();
            if state.begun.is_empty() && state.running == 0 {
                state.begun = state.batches.pop_front()?;
                state.begun_ns = now_ns;
            }
            let begun_ns = state.begun_ns;
            let next = state.begun.front().copied();
            if next.is_none() && state.batches.is_empty() {
                return None;
            }
            if let Some(turn) = next.filter(|turn| begun_ns + turn.start_ns <= now_ns) {
                state.begun.pop_front();
                state.running += 1;
                return Some(Turn {
                    start_ns: begun_ns + turn.start_ns,
                    not_before_ns: begun_ns + turn.not_before_ns,
                    ..turn
                });
            }
            let waited = self.ended.wait_timeout(state, POLL);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        None
    }

    /// Reports that a cell has ended.
    pub fn end(&self) {
        let mut state = self.lock();
        state.running = state.running.saturating_sub(1);
        self.ended.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State<'a>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Groups the cells into batches. A batch has as many cells as its first one allows, or `jobs`; all
/// are of the same repeat and allow as many. A batch lasts as long as its longest cell, so it is
/// filled with cells as long as the first one, then with shorter ones.
pub(crate) fn batches<'a>(cells: &[&'a Cell], jobs: Option<u16>) -> Vec<Vec<&'a Cell>> {
    // A plan written by hand may say 0.
    let own = |cell: &Cell| usize::from(jobs.unwrap_or(cell.together).max(1));
    let mut batches: Vec<Vec<&Cell>> = Vec::new();
    for round in cells.chunk_by(|one, next| one.repeat == next.repeat) {
        let mut waiting: Vec<Option<&Cell>> = round.iter().copied().map(Some).collect();
        for place in 0..waiting.len() {
            let Some(first) = waiting[place].take() else {
                continue;
            };
            let mut batch = vec![first];
            for is_long_enough in [u64::eq, u64::gt] {
                for other in &mut waiting[place + 1..] {
                    if batch.len() >= own(first) {
                        break;
                    }
                    let fits = |cell: &&Cell| {
                        own(cell) == own(first)
                            && is_long_enough(&first.duration_ns, &cell.duration_ns)
                    };
                    batch.extend(other.take_if(|cell| fits(cell)));
                }
            }
            batch.sort_by_key(|cell| Reverse(cell.client.spec().start_time));
            batches.push(batch);
        }
    }
    batches
}

/// Expected duration of a batch.
pub(crate) fn batch_time(batch: &[&Cell]) -> Duration {
    let ready_ns = turns(batch).front().map_or(0, |turn| turn.not_before_ns);
    let longest_ns = batch.iter().map(|cell| cell.duration_ns).max().unwrap_or(0);
    Duration::from_nanos(ready_ns + longest_ns + backend::AFTER_OPENING_NS)
}

/// When to start each cell of a batch, one after another, and when all of them are up.
fn turns<'a>(batch: &[&'a Cell]) -> VecDeque<Turn<'a>> {
    let together = u16::try_from(batch.len()).unwrap_or(u16::MAX);
    let (mut start_ns, mut not_before_ns) = (0, 0);
    let mut turns = VecDeque::new();
    for cell in batch {
        turns.push_back(Turn {
            cell,
            together,
            start_ns,
            not_before_ns: 0,
        });
        not_before_ns = not_before_ns.max(start_ns + backend::lead_ns(cell.client));
        start_ns += backend::stagger_ns(cell.client);
    }
    if together > 1 {
        not_before_ns += SPARE_NS;
    }
    for turn in &mut turns {
        turn.not_before_ns = not_before_ns;
    }
    turns
}

#[cfg(test)]
mod tests;
