//! Future events in order of time; simultaneous events in order of insertion.
//!
//! Times are integers, so the order is the same on every machine.

use std::collections::VecDeque;

/// Events in order of (time, sequence).
///
/// A sorted ring, not a heap: packets leave a link mostly in the order in which they entered, so
/// nearly all are inserted at the end or close to it.
#[derive(Debug)]
pub(crate) struct Queue<E> {
    entries: VecDeque<(u64, E)>,
}

impl<E> Queue<E> {
    pub(crate) fn new() -> Self {
        Self {
            entries: VecDeque::with_capacity(64),
        }
    }

    /// Inserts an event at `t_ns`.
    pub(crate) fn push(&mut self, t_ns: u64, event: E) {
        if self
            .entries
            .back()
            .is_none_or(|(last_ns, _)| *last_ns <= t_ns)
        {
            self.entries.push_back((t_ns, event));
        } else {
            let place = self.entries.partition_point(|(own_ns, _)| *own_ns <= t_ns);
            self.entries.insert(place, (t_ns, event));
        }
    }

    /// When the first event is due; `u64::MAX` if there is none.
    pub(crate) fn next_ns(&self) -> u64 {
        self.entries.front().map_or(u64::MAX, |(t_ns, _)| *t_ns)
    }

    /// Removes the first event.
    pub(crate) fn pop(&mut self) -> Option<(u64, E)> {
        self.entries.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_in_order_of_time_and_equal_times_as_they_were_put_in() {
        let mut queue = Queue::new();
        for (t_ns, event) in [(5, "c"), (1, "a"), (5, "d"), (3, "b"), (5, "e")] {
            queue.push(t_ns, event);
        }
        assert_eq!(queue.next_ns(), 1);
        let order: Vec<_> = std::iter::from_fn(|| queue.pop()).map(|(_, e)| e).collect();
        assert_eq!(order.concat(), "abcde");
        assert_eq!(queue.next_ns(), u64::MAX);
    }
}
