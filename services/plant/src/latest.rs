//! The latest value of one thread, as read by another: a sequence lock.
//!
//! One thread publishes a few words, others read all of them or none. The publisher never waits. A
//! reader that meets an incomplete publication gets nothing and decides what to do. The tick thread
//! must not wait for a thread that it may just have preempted, so it keeps its previous value.
//!
//! The words are atomics, so a torn read cannot be observed. The ordering follows H.-J. Boehm, "Can
//! seqlocks get along with programming language memory models?" (2012): the version is odd while
//! words change, and the fences keep the words between its two changes and its two reads.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering, fence},
};

#[derive(Debug)]
struct Shared<const N: usize> {
    version: AtomicU64,
    words: [AtomicU64; N],
}

/// The only writer; not `Clone`, since two writers would mix words.
#[derive(Debug)]
pub(crate) struct Publisher<const N: usize>(Arc<Shared<N>>);

/// A reader.
#[derive(Clone, Debug)]
pub(crate) struct Reader<const N: usize>(Arc<Shared<N>>);

/// A value of `N` words and its two sides.
pub(crate) fn latest<const N: usize>(words: [u64; N]) -> (Publisher<N>, Reader<N>) {
    let shared = Arc::new(Shared {
        version: AtomicU64::new(0),
        words: words.map(AtomicU64::new),
    });
    (Publisher(Arc::clone(&shared)), Reader(shared))
}

impl<const N: usize> Publisher<N> {
    pub(crate) fn publish(&mut self, words: [u64; N]) {
        let version = self.0.version.load(Ordering::Relaxed);
        self.0
            .version
            .store(version.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        for (shared, word) in self.0.words.iter().zip(words) {
            shared.store(word, Ordering::Relaxed);
        }
        self.0
            .version
            .store(version.wrapping_add(2), Ordering::Release);
    }
}

impl<const N: usize> Reader<N> {
    /// The latest words, or `None` during the nanoseconds in which they change.
    pub(crate) fn try_read(&self) -> Option<[u64; N]> {
        let before = self.0.version.load(Ordering::Acquire);
        let mut words = [0; N];
        for (word, shared) in words.iter_mut().zip(&self.0.words) {
            *word = shared.load(Ordering::Relaxed);
        }
        fence(Ordering::Acquire);
        let after = self.0.version.load(Ordering::Relaxed);
        (before == after && before.is_multiple_of(2)).then_some(words)
    }

    /// The latest words; yields to the publisher for as long as necessary.
    pub(crate) fn read(&self) -> [u64; N] {
        loop {
            if let Some(words) = self.try_read() {
                return words;
            }
            std::thread::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_never_sees_words_of_two_publications() {
        let (mut publisher, reader) = latest([0; 3]);
        let writer = std::thread::spawn(move || {
            for n in 1..=300_000_u64 {
                publisher.publish([n, n.wrapping_mul(3), !n]);
            }
        });
        // Only in the first value is the last word not !n.
        let mut newest = 0;
        while newest < 300_000 {
            let [n, triple, complement] = reader.read();
            assert_eq!(triple, n * 3);
            assert_eq!(complement, if n == 0 { 0 } else { !n });
            assert!(n >= newest, "time goes on: {n} after {newest}");
            newest = n;
        }
        writer.join().expect("the writer only stores");
    }
}
