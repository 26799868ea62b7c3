//! Assigns a socket's answers to the messages that wait for them.

use std::collections::VecDeque;

use endpoint::Answer;
use tokio::sync::oneshot;

use crate::transport::ExchangeError;

/// A message that waits for its answer.
#[derive(Debug)]
pub(super) struct Waiting {
    /// The number of its command.
    pub(super) seq: u64,
    /// Where the answer goes. It is closed if its receiver has given up.
    pub(super) answer: oneshot::Sender<Result<Answer, ExchangeError>>,
}

/// The messages under way in a socket.
#[derive(Debug, Default)]
pub(super) struct UnderWay {
    /// In the order of their commands, so mostly answered from the front.
    waiting: VecDeque<Waiting>,
}

impl UnderWay {
    /// Adds a message. Drops earlier ones whose receivers have given up; since all have the same
    /// timeout, these are in front.
    pub(super) fn add(&mut self, waiting: Waiting) {
        while self
            .waiting
            .front()
            .is_some_and(|oldest| oldest.answer.is_closed())
        {
            self.waiting.pop_front();
        }
        self.waiting.push_back(waiting);
    }

    /// Passes an answer to the message that waits for it, if there is one.
    pub(super) fn answered(&mut self, answer: Answer) {
        let seq = answer.seq();
        let place = self.waiting.iter().position(|waiting| waiting.seq == seq);
        if let Some(waiting) = place.and_then(|place| self.waiting.remove(place)) {
            // The message may have been given up at this moment.
            let _ = waiting.answer.send(Ok(answer));
        }
    }

    /// Lets all messages fail.
    pub(super) fn failed(&mut self, why: &str) {
        for waiting in self.waiting.drain(..) {
            let error = ExchangeError::Failed(why.to_owned());
            let _ = waiting.answer.send(Err(error));
        }
    }
}

#[cfg(test)]
mod tests {
    use endpoint::Acknowledgement;

    use super::*;

    type Answered = oneshot::Receiver<Result<Answer, ExchangeError>>;

    fn answer(seq: u64) -> Answer {
        Answer::Acknowledgement(Acknowledgement {
            seq,
            t_arrive_ns: 1,
        })
    }

    fn with(numbers: std::ops::Range<u64>) -> (UnderWay, Vec<Answered>) {
        let mut under_way = UnderWay::default();
        let answered = numbers
            .map(|seq| {
                let (answer, answered) = oneshot::channel();
                under_way.add(Waiting { seq, answer });
                answered
            })
            .collect();
        (under_way, answered)
    }

    #[test]
    fn answers_find_their_commands_in_any_order_and_once() {
        let (mut under_way, mut answered) = with(0..4);
        for seq in [2, 0, 7, 2, 3] {
            under_way.answered(answer(seq));
        }
        under_way.failed("hung up");
        for seq in [0, 2, 3] {
            let result = answered[seq as usize].try_recv().expect("an end");
            assert_eq!(result.expect("an answer"), answer(seq));
        }
        let error = answered[1].try_recv().expect("an end").expect_err("lost");
        assert_eq!(error.to_string(), "hung up");
    }

    #[test]
    fn what_was_given_up_is_forgotten() {
        let (mut under_way, mut answered) = with(0..1000);
        answered.drain(..999);
        let (last, _is_last) = oneshot::channel();
        under_way.add(Waiting {
            seq: 1000,
            answer: last,
        });
        assert_eq!(under_way.waiting.len(), 2);
    }
}
