//! Who keeps a connection when there are more than an agent serves.
//!
//! A newcomer gets the place of one that has asked nothing yet, the oldest first, and else of one that has been idle
//! for long. One whose request is being answered stays. So nobody who only connects keeps the orchestrator out.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use tokio::task::AbortHandle;
use tokio::time::Instant;

/// How long one that has asked something may be idle before its place is taken. Its answer is on its way meanwhile.
const IDLE: Duration = Duration::from_secs(1);

/// The places that are taken, the oldest first.
pub(crate) struct Seats {
    limit: usize,
    begun: Instant,
    taken: VecDeque<(Arc<Use>, AbortHandle)>,
}

/// What a connection is used for.
pub(crate) struct Use {
    begun: Instant,
    under_way: AtomicUsize,
    /// When its last answer was there, in ms since `begun`, and one more; 0 if none was.
    answered_ms: AtomicU64,
}

/// A request that is being answered.
pub(crate) struct UnderWay(Arc<Use>);

impl Seats {
    pub(crate) fn new(limit: usize) -> Seats {
        Seats {
            limit,
            begun: Instant::now(),
            taken: VecDeque::new(),
        }
    }

    /// What a new connection will be used for.
    pub(crate) fn new_use(&self) -> Arc<Use> {
        Arc::new(Use {
            begun: self.begun,
            under_way: AtomicUsize::new(0),
            answered_ms: AtomicU64::new(0),
        })
    }

    /// Makes room for one more; whether there is.
    pub(crate) fn has_room(&mut self) -> bool {
        self.taken.retain(|(_, task)| !task.is_finished());
        if self.taken.len() < self.limit {
            return true;
        }
        let now = Instant::now();
        let taken = self.taken.iter().enumerate();
        let idle = taken.filter_map(|(place, (its, _))| Some((its.idle_since(now)?, place)));
        let Some((_, place)) = idle.min() else {
            return false;
        };
        if let Some((_, task)) = self.taken.remove(place) {
            task.abort();
        }
        true
    }

    /// A connection, served by `task`, takes a place.
    pub(crate) fn take(&mut self, its: Arc<Use>, task: AbortHandle) {
        self.taken.push_back((its, task));
    }
}

impl Use {
    /// A request begins.
    pub(crate) fn begin(self: &Arc<Use>) -> UnderWay {
        self.under_way.fetch_add(1, Ordering::Relaxed);
        UnderWay(Arc::clone(self))
    }

    /// Since when it has been idle, if its place may be taken; 0 if it has asked nothing yet.
    fn idle_since(&self, now: Instant) -> Option<u64> {
        let answered_ms = self.answered_ms.load(Ordering::Relaxed);
        let is_idle = self.under_way.load(Ordering::Relaxed) == 0;
        let idle_ms = ms(now - self.begun).saturating_sub(answered_ms);
        let is_free = answered_ms == 0 || u128::from(idle_ms) >= IDLE.as_millis();
        (is_idle && is_free).then_some(answered_ms)
    }
}

impl Drop for UnderWay {
    fn drop(&mut self) {
        let Use {
            begun,
            under_way,
            answered_ms,
        } = &*self.0;
        under_way.fetch_sub(1, Ordering::Relaxed);
        answered_ms.store(1 + ms(begun.elapsed()), Ordering::Relaxed);
    }
}

fn ms(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn who_only_connects_leaves_first_and_who_waits_for_an_answer_never() {
        let mut seats = Seats::new(3);
        let mut enter = || {
            assert!(seats.has_room());
            let (its, task) = (seats.new_use(), tokio::spawn(std::future::pending::<()>()));
            seats.take(Arc::clone(&its), task.abort_handle());
            (its, task)
        };
        let (asks, asking) = enter();
        let under_way = asks.begin();
        let (asked, answered) = enter();
        drop(asked.begin());
        let (_, fresh) = enter();
        let (_, newer) = enter();
        tokio::time::sleep(Duration::from_millis(1)).await;
        assert!(fresh.is_finished() && !asking.is_finished() && !answered.is_finished());
        let (used, _newest) = enter();
        drop(used.begin());
        tokio::time::sleep(Duration::from_millis(1)).await;
        assert!(newer.is_finished() && !answered.is_finished());
        // All have asked, and none has been idle for long.
        assert!(!seats.has_room());
        tokio::time::sleep(2 * IDLE).await;
        assert!(seats.has_room());
        tokio::time::sleep(Duration::from_millis(1)).await;
        assert!(answered.is_finished() && !asking.is_finished());
        drop(under_way);
    }
}
