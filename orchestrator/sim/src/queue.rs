//! What is to happen, in order of time; what is due at one instant, in the order it was put in.
//!
//! Times are integers, so the order is the same on every machine.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Events in order of (time, sequence).
///
/// The first is kept apart: mostly one packet is under way, and then nothing is sorted.
#[derive(Debug)]
pub(crate) struct Queue<E> {
    first: Option<Entry<E>>,
    later: BinaryHeap<Entry<E>>,
    sequence: u64,
}

#[derive(Debug)]
struct Entry<E> {
    t_ns: u64,
    sequence: u64,
    event: E,
}

impl<E> Queue<E> {
    pub(crate) fn new() -> Self {
        Self {
            first: None,
            later: BinaryHeap::with_capacity(64),
            sequence: 0,
        }
    }

    /// Puts in what happens at `t_ns`.
    pub(crate) fn push(&mut self, t_ns: u64, event: E) {
        let sequence = self.sequence;
        self.sequence += 1;
        let entry = Entry {
            t_ns,
            sequence,
            event,
        };
        match &mut self.first {
            None => self.first = Some(entry),
            Some(first) if t_ns < first.t_ns => {
                self.later.push(std::mem::replace(first, entry));
            }
            Some(_) => self.later.push(entry),
        }
    }

    /// When the first event is due; never, if there is none.
    pub(crate) fn next_ns(&self) -> u64 {
        self.first.as_ref().map_or(u64::MAX, |entry| entry.t_ns)
    }

    /// Takes the first event out.
    pub(crate) fn pop(&mut self) -> Option<(u64, E)> {
        let first = self.first.take()?;
        // Asked first, since an empty heap's answer costs as much as all the rest.
        if !self.later.is_empty() {
            self.first = self.later.pop();
        }
        Some((first.t_ns, first.event))
    }
}

// The heap gives its greatest: here that is the earliest.
impl<E> Ord for Entry<E> {
    fn cmp(&self, other: &Self) -> Ordering {
        (other.t_ns, other.sequence).cmp(&(self.t_ns, self.sequence))
    }
}

impl<E> PartialOrd for Entry<E> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<E> PartialEq for Entry<E> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<E> Eq for Entry<E> {}

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
