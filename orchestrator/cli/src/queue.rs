//! Whose turn it is: cells in batches, each of which runs together.
//!
//! To start a cell takes more of a machine than to run it, a browser's above all. So all cells of a
//! batch are up before the first of them is measured, and the next batch begins when all of this one
//! have ended. Batches begin in the plan's order; of a batch those that take longest to start begin first, so
//! that the others wait the less with an open connection. A cell's running is `jobs`' work.

use std::cmp::Reverse;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use plan::Cell;

/// How often one who waits looks whether to stop.
const POLL: Duration = Duration::from_millis(50);

/// What a batch waits beyond the longest start that is expected: a machine that starts many is slower.
const SPARE_NS: u64 = 300_000_000;

/// The cells that have not begun, and what is under way.
pub(crate) struct Queue<'a> {
    state: Mutex<State<'a>>,
    ended: Condvar,
    workers: usize,
}

struct State<'a> {
    batches: VecDeque<VecDeque<Turn<'a>>>,
    /// What is left of the batch that has begun.
    begun: VecDeque<Turn<'a>>,
    /// When it began, ns on the monotonic clock.
    begun_ns: u64,
    running: usize,
}

/// A cell that may begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn<'a> {
    pub(crate) cell: &'a Cell,
    /// How many there are in its batch.
    pub(crate) together: u16,
    /// When it is started; in the queue from its batch's begin, given out as an instant of the
    /// monotonic clock.
    pub(crate) start_ns: u64,
    /// Before then it is not measured: the last of its batch is not up. Likewise.
    pub(crate) not_before_ns: u64,
}

impl<'a> Queue<'a> {
    /// Of these cells, in this order; `jobs` at a time, or else as many as each says of itself.
    pub(crate) fn new(cells: &[&'a Cell], jobs: Option<u16>) -> Queue<'a> {
        let batches = batches(cells, jobs);
        let workers = batches.iter().map(Vec::len).max().unwrap_or(0);
        let turns = batches.iter().map(|batch| turns(batch)).collect();
        Queue::of(turns, workers)
    }

    /// Of these cells, `jobs` at a time, each as soon as there is room: in virtual time nothing is
    /// measured, so nothing is disturbed.
    pub(crate) fn unmeasured(cells: &[&'a Cell], jobs: u16) -> Queue<'a> {
        let turn = |cell: &&'a Cell| Turn {
            cell,
            together: 1,
            start_ns: 0,
            not_before_ns: 0,
        };
        let all = cells.iter().map(turn).collect();
        Queue::of(VecDeque::from([all]), usize::from(jobs).min(cells.len()))
    }

    fn of(batches: VecDeque<VecDeque<Turn<'a>>>, workers: usize) -> Queue<'a> {
        Queue {
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

    /// How many workers can ever be busy.
    pub(crate) fn workers(&self) -> usize {
        self.workers
    }

    /// The next cell, once it may begin; none, when all have begun or `stop` is set.
    pub(crate) fn next(&self, stop: &AtomicBool) -> Option<Turn<'a>> {
        let mut state = self.lock();
        while !stop.load(Ordering::Relaxed) {
            let now_ns = shaper::now_ns();
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

    /// A cell has ended.
    pub(crate) fn end(&self) {
        let mut state = self.lock();
        state.running = state.running.saturating_sub(1);
        self.ended.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State<'a>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The cells in batches: as many in each as its first allows, or `jobs`, of those of its repeat that allow as
/// many. A batch lasts as long as its longest cell, so its others are as long as the first where there are
/// any, else shorter.
pub(crate) fn batches<'a>(cells: &[&'a Cell], jobs: Option<u16>) -> Vec<Vec<&'a Cell>> {
    // A plan by hand may say 0.
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
            batch.sort_by_key(|cell| Reverse(backend::start_time(cell.client)));
            batches.push(batch);
        }
    }
    batches
}

/// How long a batch takes.
pub(crate) fn batch_time(batch: &[&Cell]) -> Duration {
    let ready_ns = turns(batch).front().map_or(0, |turn| turn.not_before_ns);
    let longest_ns = batch.iter().map(|cell| cell.duration_ns).max().unwrap_or(0);
    Duration::from_nanos(ready_ns + longest_ns + backend::AFTER_EPOCH_NS)
}

/// When each of a batch is started, one after another, and when all of them are up.
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
mod tests {
    use super::*;
    use plan::{Instead, Plan, ProfileText};

    fn plan(blocks: &[(&str, &str, u16)]) -> Plan {
        let block = |(client, h, together): &(&str, &str, u16)| {
            format!(
                "[[cells]]\ntopology = [\"arima\"]\nclient = [{client}]\nmode = \"open\"\n\
                 h = [{h}]\nduration = \"1s\"\ntogether = {together}\n"
            )
        };
        let blocks: String = blocks.iter().map(block).collect();
        resolve(&blocks)
    }

    fn resolve(blocks: &str) -> Plan {
        let profile = |name: &str| {
            let source = link::Profile::builtin(name).expect("built in").to_owned();
            Ok(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        let source = format!("name = \"mine\"\n{blocks}");
        Plan::resolve(&source, "mine.toml", &Instead::default(), profile).expect("an experiment")
    }

    fn natives() -> Plan {
        plan(&[
            ("\"native\"", "\"100ms\", \"200ms\", \"300ms\"", 2),
            ("\"native\"", "\"10ms\"", 1),
            ("\"native\"", "\"20ms\", \"30ms\"", 3),
        ])
    }

    fn indices(jobs: Option<u16>) -> Vec<Vec<usize>> {
        let plan = natives();
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        let batches = batches(&cells, jobs);
        let of = |batch: &Vec<&Cell>| batch.iter().map(|cell| cell.index).collect();
        batches.iter().map(of).collect()
    }

    #[test]
    fn as_many_run_together_as_the_most_particular_of_them_allows_in_order() {
        // 0 to 2 in pairs, 3 alone, 4 and 5 in threes.
        assert_eq!(indices(None), [vec![0, 1], vec![2], vec![3], vec![4, 5]]);
    }

    #[test]
    fn a_batch_is_of_equal_length_where_it_can_be_and_shorter_ones_fill_it_up() {
        let block = |h: &str, duration: &str| {
            format!(
                "[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"open\"\n\
                 h = [{h}]\nduration = \"{duration}\"\ntogether = 3\n"
            )
        };
        let source = ["\"10ms\", \"20ms\"", "\"30ms\"", "\"40ms\", \"50ms\""];
        let lengths = ["1s", "9s", "1s"];
        let source: String = source
            .iter()
            .zip(lengths)
            .map(|(h, length)| block(h, length))
            .collect();
        let plan = resolve(&source);
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        let batches = batches(&cells, None);
        let indices = batches
            .iter()
            .map(|batch| batch.iter().map(|cell| cell.index));
        let indices: Vec<Vec<usize>> = indices.map(Iterator::collect).collect();
        assert_eq!(indices, [vec![0, 1, 3], vec![2, 4]]);
    }

    #[test]
    fn jobs_say_it_for_all() {
        assert_eq!(indices(Some(1)), [[0], [1], [2], [3], [4], [5]]);
        assert_eq!(indices(Some(6)), [[0, 1, 2, 3, 4, 5]]);
    }

    #[test]
    fn nobody_is_measured_before_the_last_of_its_batch_is_up_and_none_starts_beside_one_that_is() {
        let plan = plan(&[
            ("\"native\", \"python\"", "\"100ms\"", 8),
            ("\"chromium\", \"firefox\"", "\"100ms\", \"300ms\"", 8),
        ]);
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        for jobs in [None, Some(1), Some(2), Some(5)] {
            for batch in batches(&cells, jobs) {
                let turns = turns(&batch);
                let starts = turns.iter().map(|turn| turn.start_ns);
                assert!(starts.is_sorted(), "one after another");
                for turn in &turns {
                    assert_eq!(usize::from(turn.together), batch.len());
                    // Its own start fits before anybody's measurement.
                    let up_ns = turn.start_ns + backend::lead_ns(turn.cell.client);
                    assert!(turns.iter().all(|any| up_ns <= any.not_before_ns));
                }
                let clients = batch.iter().map(|cell| backend::start_time(cell.client));
                assert!(clients.is_sorted_by(|a, b| a >= b), "the slowest first");
            }
        }
    }

    #[test]
    fn the_next_batch_begins_when_all_of_this_one_have_ended() {
        let plan = natives();
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        let queue = Queue::new(&cells, None);
        let go_on = AtomicBool::new(false);
        let next = || {
            queue
                .next(&go_on)
                .map(|turn| (turn.cell.index, turn.together))
        };
        assert_eq!((next(), next()), (Some((0, 2)), Some((1, 2))));
        let third = std::thread::scope(|scope| {
            let third = scope.spawn(next);
            queue.end();
            std::thread::sleep(3 * POLL);
            assert!(
                !third.is_finished(),
                "one of the first two is still measured"
            );
            queue.end();
            third.join().expect("no panic")
        });
        assert_eq!(third, Some((2, 1)));
        for (index, together) in [(3, 1), (4, 2)] {
            queue.end();
            assert_eq!(next(), Some((index, together)));
        }
        assert_eq!((next(), next()), (Some((5, 2)), None));
    }

    #[test]
    fn without_a_measurement_each_begins_as_soon_as_there_is_room() {
        let plan = natives();
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        let queue = Queue::unmeasured(&cells, 2);
        assert_eq!(queue.workers(), 2);
        let stop = AtomicBool::new(false);
        let order = std::iter::from_fn(|| queue.next(&stop).map(|turn| turn.cell.index));
        assert!(order.eq(0..6));
    }

    #[test]
    fn whoever_is_told_to_stop_begins_nothing() {
        let plan = natives();
        let queue = Queue::new(&plan.cells.iter().collect::<Vec<_>>(), None);
        assert_eq!(queue.workers(), 2);
        assert!(queue.next(&AtomicBool::new(true)).is_none());
    }
}
