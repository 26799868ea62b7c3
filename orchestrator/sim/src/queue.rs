//! Future events in order of time; simultaneous events in order of insertion.
//!
//! Times are integers, so the order is the same on every machine. Packets that leave a link one way mostly
//! leave it in the order in which they entered, so each way has a lane of its own, to whose end nearly all are
//! put. All other events have a third lane.

use std::collections::VecDeque;

use link::{PerWay, Way};

/// Packets `P` and other events `E` in order of (time, sequence): three sorted rings, not a heap.
#[derive(Debug)]
pub(crate) struct Queue<P, E> {
    packets: PerWay<Lane<P>>,
    others: Lane<E>,
    /// How many were put in.
    number: u64,
    /// The first key of all: asked for far more often than it changes.
    first: Key,
}

/// What is first in a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum First {
    Packet(Way),
    Other,
}

impl<P, E> Queue<P, E> {
    pub(crate) fn new() -> Self {
        Self {
            packets: PerWay::of(|_| Lane::new()),
            others: Lane::new(),
            number: 0,
            first: NEVER,
        }
    }

    /// Inserts a packet that comes out of the link this way at `t_ns`.
    #[inline]
    pub(crate) fn push_packet(&mut self, way: Way, t_ns: u64, packet: P) {
        let key = self.key(t_ns);
        self.packets[way].push(key, packet);
    }

    /// Inserts another event at `t_ns`.
    #[inline]
    pub(crate) fn push(&mut self, t_ns: u64, event: E) {
        let key = self.key(t_ns);
        self.others.push(key, event);
    }

    /// When the first is due; `u64::MAX` if there is none.
    #[inline]
    pub(crate) fn next_ns(&self) -> u64 {
        t_ns(self.first)
    }

    /// What the first is; anything if there is none.
    #[inline]
    pub(crate) fn first(&self) -> First {
        let PerWay { up, down } = &self.packets;
        if self.first == up.first {
            First::Packet(Way::Up)
        } else if self.first == down.first {
            First::Packet(Way::Down)
        } else {
            First::Other
        }
    }

    /// Removes the first packet that comes out this way.
    #[inline]
    pub(crate) fn pop_packet(&mut self, way: Way) -> Option<(u64, P)> {
        let popped = self.packets[way].pop();
        self.finds_first();
        popped
    }

    /// Removes the first other event.
    #[inline]
    pub(crate) fn pop(&mut self) -> Option<(u64, E)> {
        let popped = self.others.pop();
        self.finds_first();
        popped
    }

    /// The key of what is put in now.
    #[inline]
    fn key(&mut self, t_ns: u64) -> Key {
        self.number += 1;
        let key = u128::from(t_ns) << 64 | u128::from(self.number);
        self.first = self.first.min(key);
        key
    }

    #[inline]
    fn finds_first(&mut self) {
        let PerWay { up, down } = &self.packets;
        self.first = up.first.min(down.first).min(self.others.first);
    }
}

/// A time, and a number that counts up: in one number, so that two are compared at once.
type Key = u128;

/// That of a lane without entries.
const NEVER: Key = Key::MAX;

#[inline]
fn t_ns(key: Key) -> u64 {
    (key >> 64) as u64
}

/// Entries in order of their keys.
#[derive(Debug)]
struct Lane<T> {
    entries: VecDeque<(Key, T)>,
    /// The first key.
    first: Key,
    /// The last key; of an empty lane, the last that there was.
    last: Key,
}

impl<T> Lane<T> {
    fn new() -> Self {
        Self {
            entries: VecDeque::with_capacity(64),
            first: NEVER,
            last: 0,
        }
    }

    #[inline]
    fn push(&mut self, key: Key, entry: T) {
        self.first = self.first.min(key);
        if key < self.last {
            self.insert(key, entry);
        } else {
            self.last = key;
            self.entries.push_back((key, entry));
        }
    }

    #[cold]
    fn insert(&mut self, key: Key, entry: T) {
        let place = self.entries.partition_point(|(own, _)| *own < key);
        self.entries.insert(place, (key, entry));
    }

    #[inline]
    fn pop(&mut self) -> Option<(u64, T)> {
        let (key, entry) = self.entries.pop_front()?;
        self.first = self.entries.front().map_or(NEVER, |(key, _)| *key);
        Some((t_ns(key), entry))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_in_order_of_time_and_equal_times_as_they_were_put_in() {
        let mut queue = Queue::new();
        let (up, down, other) = (Some(Way::Up), Some(Way::Down), None);
        for (t_ns, way, event) in [
            (5, down, "c"),
            (1, up, "a"),
            (5, up, "d"),
            (3, other, "b"),
            (5, down, "e"),
            (5, other, "f"),
            (4, down, "B"),
        ] {
            match way {
                Some(way) => queue.push_packet(way, t_ns, event),
                None => queue.push(t_ns, event),
            }
        }
        assert_eq!(queue.next_ns(), 1);
        let pop = || match queue.first() {
            First::Packet(way) => queue.pop_packet(way),
            First::Other => queue.pop(),
        };
        let order: Vec<_> = std::iter::from_fn(pop).map(|(_, e)| e).collect();
        assert_eq!(order.concat(), "abBcdef");
        assert_eq!(queue.next_ns(), u64::MAX);
    }
}
