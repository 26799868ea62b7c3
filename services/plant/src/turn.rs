//! Whose request is next.
//!
//! A connection that moves the plant is served at once. All other requests are served one at a time, first come
//! first served, and between two of them the thread looks what else has arrived. Both have a limit to how many in a
//! millisecond, so that whoever sends as many as it can leaves the processor to the loop. A loop alone does not meet
//! it below 32 kHz.

use std::cell::RefCell;

use clock::now::now_ns;
use tokio::{
    sync::{Semaphore, SemaphorePermit},
    task::yield_now,
    time::{Duration, sleep},
};

use crate::place::Place;

/// How many requests may pass in a millisecond, over some time.
const REQUESTS_MS: f64 = 32.0;

/// How many may pass at once: what a controller sent while its link stood still.
const REQUESTS: f64 = 1_024.0;

const MS_NS: u64 = 1_000_000;

/// A number of passes that fills with time.
pub(crate) struct Bucket {
    per_ms: f64,
    most: f64,
    left: f64,
    at_ns: u64,
}

impl Bucket {
    /// One that is full.
    pub(crate) fn new(per_ms: f64, most: f64) -> Self {
        Self {
            per_ms,
            most,
            left: most,
            at_ns: 0,
        }
    }

    /// Takes one, if there is one.
    pub(crate) fn takes(&mut self, now_ns: u64) -> bool {
        let passed_ms = now_ns.saturating_sub(self.at_ns) as f64 / MS_NS as f64;
        self.left = (self.left + passed_ms * self.per_ms).min(self.most);
        self.at_ns = now_ns;
        let takes = self.left >= 1.0;
        if takes {
            self.left -= 1.0;
        }
        takes
    }
}

/// All connections' turns.
pub(crate) struct Turns {
    /// Of the requests that are not served at once, the one that is.
    one: Semaphore,
    passes: RefCell<Bucket>,
    /// For those that are.
    at_once: RefCell<Bucket>,
}

/// What is long takes another pass for each of so many bytes.
const PASS_BYTES: f64 = 4_096.0;

/// The turn of a connection, until it [ends](Turn::end): before anything that the other end can delay.
#[derive(Default)]
pub(crate) struct Turn<'a>(Option<(SemaphorePermit<'a>, &'a RefCell<Bucket>)>);

impl Turns {
    pub(crate) fn new() -> Self {
        Self {
            one: Semaphore::new(1),
            passes: RefCell::new(Bucket::new(REQUESTS_MS, REQUESTS)),
            at_once: RefCell::new(Bucket::new(REQUESTS_MS, REQUESTS)),
        }
    }

    /// Waits for a connection's turn.
    pub(crate) async fn wait(&self, place: &Place) -> Turn<'_> {
        let now = now_ns();
        if place.is_in_control(now) && self.at_once.borrow_mut().takes(now) {
            return Turn(None);
        }
        let one = self.one.acquire().await.ok();
        while !self.passes.borrow_mut().takes(now_ns()) {
            sleep(Duration::from_millis(1)).await;
        }
        Turn(one.map(|one| (one, &self.passes)))
    }
}

impl Turn<'_> {
    /// It takes as long as it takes to copy so many bytes.
    pub(crate) fn on_bytes(&self, bytes: usize) {
        if let Some((_, passes)) = &self.0 {
            passes.borrow_mut().left -= bytes as f64 / PASS_BYTES;
        }
    }

    /// Ends it: what arrived meanwhile goes first.
    pub(crate) async fn end(&mut self) {
        if self.0.is_some() {
            yield_now().await;
            self.0 = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bucket_lets_through_what_it_holds_and_then_its_rate() {
        let mut bucket = Bucket::new(20.0, 100.0);
        let start_ns = 5_000_000_000;
        assert_eq!((0..1_000).filter(|_| bucket.takes(start_ns)).count(), 100);
        let second = (0..1_000_000).filter(|us| bucket.takes(start_ns + us * 1_000));
        assert!((19_990..=20_010).contains(&second.count()));
        let ever = (0..1_000).filter(|_| bucket.takes(start_ns + 900_000_000_000));
        assert_eq!(ever.count(), 100);
    }
}
