//! The messages of one connection, or of none: those that wait to be sent, and those that wait for their answers.

use std::{
    collections::VecDeque,
    pin::Pin,
    task::{Context, Poll, ready},
    time::Duration,
};

use endpoint::Command;
use tokio::time::{Instant, Sleep, sleep_until};

/// A message that has not ended.
#[derive(Debug)]
struct Waiting {
    command: Command,
    until: Instant,
}

/// All messages that have not ended.
#[derive(Debug)]
pub(crate) struct UnderWay {
    timeout: Duration,
    /// In the order of their commands, so mostly answered from the front, and by the same timeout.
    waiting: VecDeque<Waiting>,
    /// How many at the end are not sent.
    unsent: usize,
    /// For the first of them, or for one before it.
    alarm: Option<Pin<Box<Sleep>>>,
}

impl UnderWay {
    pub(crate) fn new(timeout: Duration) -> Self {
        Self {
            timeout,
            waiting: VecDeque::new(),
            unsent: 0,
            alarm: None,
        }
    }

    /// Adds a message, from now on for its timeout.
    pub(crate) fn add(&mut self, command: Command) {
        self.waiting.push_back(Waiting {
            command,
            until: Instant::now() + self.timeout,
        });
        self.unsent += 1;
    }

    pub(crate) fn has_unsent(&self) -> bool {
        self.unsent > 0
    }

    /// The next command to send, which then is sent. After a stall, commands that nobody waits for any more are not
    /// among them, as a request over HTTP ends with its timeout.
    pub(crate) fn take_unsent(&mut self) -> Option<Command> {
        let place = self.waiting.len() - self.unsent;
        let waiting = self.waiting.get(place)?;
        self.unsent -= 1;
        Some(waiting.command)
    }

    /// Takes notice of an answer; whether a message waited for it.
    pub(crate) fn answered(&mut self, seq: u64) -> bool {
        let sent = self.waiting.len() - self.unsent;
        let mut places = self.waiting.iter().take(sent);
        let place = places.position(|waiting| waiting.command.seq == seq);
        place.is_some_and(|place| self.waiting.remove(place).is_some())
    }

    /// Ends all messages; their numbers.
    pub(crate) fn give_up(&mut self) -> impl Iterator<Item = u64> {
        self.unsent = 0;
        self.waiting.drain(..).map(|waiting| waiting.command.seq)
    }

    /// The number of the next message that ends by its timeout; that message has ended then.
    pub(crate) fn poll_timeout(&mut self, context: &mut Context<'_>) -> Poll<u64> {
        loop {
            let Some(first) = self.waiting.front() else {
                return Poll::Pending;
            };
            let until = first.until;
            let alarm = self
                .alarm
                .get_or_insert_with(|| Box::pin(sleep_until(until)));
            ready!(alarm.as_mut().poll(context));
            // It may have been set for a message that has ended otherwise.
            if Instant::now() < until {
                alarm.as_mut().reset(until);
                continue;
            }
            let ended = self.waiting.pop_front();
            self.unsent = self.unsent.min(self.waiting.len());
            match ended {
                Some(ended) => return Poll::Ready(ended.command.seq),
                None => return Poll::Pending,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(numbers: std::ops::Range<u64>) -> UnderWay {
        let mut under_way = UnderWay::new(Duration::from_secs(5));
        for seq in numbers {
            under_way.add(Command {
                seq,
                t_send_ns: 0,
                u: 0.0.into(),
            });
        }
        under_way
    }

    #[test]
    fn answers_find_their_commands_in_any_order_and_once() {
        let mut under_way = with(0..5);
        for seq in 0..4 {
            assert_eq!(
                under_way.take_unsent().map(|command| command.seq),
                Some(seq)
            );
        }
        let found = [2, 0, 7, 2, 3, 4].map(|seq| under_way.answered(seq));
        // The last is not sent yet.
        assert_eq!(found, [true, true, false, false, true, false]);
        assert_eq!(under_way.give_up().collect::<Vec<_>>(), [1, 4]);
        assert!(!under_way.has_unsent());
        assert_eq!(under_way.take_unsent(), None);
    }

    #[test]
    fn messages_end_by_their_own_timeouts_and_are_not_sent_afterwards() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .expect("a runtime");
        runtime.block_on(async {
            let mut under_way = UnderWay::new(Duration::from_millis(20));
            for seq in 0..3 {
                under_way.add(Command {
                    seq,
                    t_send_ns: 0,
                    u: 0.0.into(),
                });
            }
            assert_eq!(under_way.take_unsent().map(|command| command.seq), Some(0));
            assert!(under_way.answered(0));
            let start = Instant::now();
            let timeout = std::future::poll_fn(|context| under_way.poll_timeout(context)).await;
            assert_eq!(timeout, 1);
            assert!(start.elapsed() >= Duration::from_millis(19));
            assert_eq!(under_way.take_unsent().map(|command| command.seq), Some(2));
        });
    }
}
