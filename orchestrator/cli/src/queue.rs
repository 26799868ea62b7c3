//! Whose turn it is: cells that wait, and how many may run at a time.
//!
//! Cells begin in the plan's order. One that has to be alone waits until it is, and so do those
//! behind it. A cell's running is `jobs`' work.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use plan::Cell;

/// How often one who waits looks whether to stop.
const POLL: Duration = Duration::from_millis(50);

/// The cells that have not begun, and what is under way.
pub(crate) struct Queue<'a> {
    jobs: Option<u16>,
    state: Mutex<State<'a>>,
    ended: Condvar,
}

struct State<'a> {
    waiting: VecDeque<&'a Cell>,
    /// For each cell under way, how many it can be one of.
    running: Vec<u16>,
    /// Until when the latest is starting, which is when it needs the processors most.
    starting: Option<Instant>,
}

impl<'a> Queue<'a> {
    /// Of these cells, in this order; `jobs` at a time, or else as many as each says of itself.
    pub(crate) fn new(cells: &[&'a Cell], jobs: Option<u16>) -> Queue<'a> {
        Queue {
            jobs,
            state: Mutex::new(State {
                waiting: cells.iter().copied().collect(),
                running: Vec::new(),
                starting: None,
            }),
            ended: Condvar::new(),
        }
    }

    /// How many workers can ever be busy.
    pub(crate) fn workers(&self) -> u16 {
        let state = self.lock();
        let most = state.waiting.iter().map(|cell| together(cell, self.jobs));
        most.max().unwrap_or(0)
    }

    /// The next cell, once it may begin; none, when all have begun or `stop` is set.
    pub(crate) fn next(&self, stop: &AtomicBool) -> Option<&'a Cell> {
        let mut state = self.lock();
        while !stop.load(Ordering::Relaxed) {
            let cell = *state.waiting.front()?;
            let own = together(cell, self.jobs);
            let limit = state.running.iter().fold(own, |least, of| least.min(*of));
            let is_room = state.running.len() < usize::from(limit);
            let is_quiet = state.running.is_empty()
                || state.starting.is_none_or(|until| until <= Instant::now());
            if is_room && is_quiet {
                state.waiting.pop_front();
                state.running.push(own);
                state.starting = Some(Instant::now() + backend::start_time(cell.client));
                return Some(cell);
            }
            let waited = self.ended.wait_timeout(state, POLL);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        None
    }

    /// A cell has ended.
    pub(crate) fn end(&self, cell: &Cell) {
        let mut state = self.lock();
        let own = together(cell, self.jobs);
        if let Some(at) = state.running.iter().position(|of| *of == own) {
            state.running.swap_remove(at);
        }
        self.ended.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State<'a>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How many cells may run at a time while this one does.
pub(crate) fn together(cell: &Cell, jobs: Option<u16>) -> u16 {
    // A plan by hand may say 0.
    jobs.unwrap_or(cell.together).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use plan::{Instead, Plan, ProfileText};

    fn plan() -> Plan {
        let block = |h: &str, together: u16| {
            format!(
                "[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"open\"\n\
                 h = [{h}]\nduration = \"1s\"\ntogether = {together}\n"
            )
        };
        let source = format!(
            "name = \"mine\"\n{}{}{}",
            block("\"100ms\", \"200ms\", \"300ms\"", 2),
            block("\"10ms\"", 1),
            block("\"20ms\", \"30ms\"", 3)
        );
        let profile = |name: &str| {
            let source = link::Profile::builtin(name).expect("built in").to_owned();
            Ok(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        Plan::resolve(&source, "mine.toml", &Instead::default(), profile).expect("an experiment")
    }

    /// What may begin now.
    fn begun<'a>(queue: &Queue<'a>) -> Vec<&'a Cell> {
        let mut begun = Vec::new();
        loop {
            let state = queue.lock();
            let Some(cell) = state.waiting.front() else {
                return begun;
            };
            let own = together(cell, queue.jobs);
            let limit = state.running.iter().fold(own, |least, of| least.min(*of));
            if state.running.len() >= usize::from(limit) {
                return begun;
            }
            drop(state);
            begun.extend(queue.next(&AtomicBool::new(false)));
        }
    }

    fn rounds(jobs: Option<u16>) -> Vec<Vec<usize>> {
        let plan = plan();
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        let queue = Queue::new(&cells, jobs);
        let mut rounds = Vec::new();
        let mut running: VecDeque<&Cell> = VecDeque::new();
        loop {
            let new = begun(&queue);
            rounds.push(new.iter().map(|cell| cell.index).collect());
            running.extend(new);
            let Some(cell) = running.pop_front() else {
                rounds.pop();
                return rounds;
            };
            queue.end(cell);
        }
    }

    #[test]
    fn as_many_run_at_a_time_as_the_most_particular_of_them_allows_in_order() {
        // 0 to 2 in pairs, 3 alone, 4 and 5 in threes; each round begins as one ends.
        assert_eq!(
            rounds(None),
            [vec![0, 1], vec![2], vec![], vec![3], vec![4, 5], vec![]]
        );
    }

    #[test]
    fn jobs_say_it_for_all() {
        assert_eq!(rounds(Some(1)), [[0], [1], [2], [3], [4], [5]]);
        assert_eq!(rounds(Some(6))[0], [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn whoever_is_told_to_stop_begins_nothing() {
        let plan = plan();
        let queue = Queue::new(&plan.cells.iter().collect::<Vec<_>>(), None);
        assert_eq!(queue.workers(), 3);
        assert!(queue.next(&AtomicBool::new(true)).is_none());
    }
}
