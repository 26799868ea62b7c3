//! The controller's end: a deadline every h, and a command at each if permitted.
//!
//! Call [`ControllerEnd::poll`] for the next step until it says to wait; report the end of each
//! message with [`ControllerEnd::answered`] or [`ControllerEnd::lost`]. Each deadline becomes exactly
//! one [`MessageRow`]: at once if nothing was sent, otherwise when its message ends. Nothing is
//! allocated after [`ControllerEnd::try_new`]. There are no sockets, retries or waiting here.

use std::collections::VecDeque;

use control::{AnswerFacts, Law, LawInput, Moment, Signals, seconds};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    message::{Answer, Command},
    reference::Reference,
    row::{MessageOutcome, MessageRow},
    setting::{ControllerSettings, Integrate, Late, Mode, Outstanding, Schedule},
};

/// The next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Send this command now, then poll again.
    Send(Command),
    /// Record this deadline, at which nothing is sent, then poll again.
    Missed(MessageRow),
    /// Poll again at this time, or when a message has ended.
    Sleep {
        /// The next deadline.
        until_ns: u64,
    },
    /// Poll again when the message under way has ended.
    AwaitAnswer,
    /// There are no more deadlines. Messages may still be under way.
    Finished,
}

/// A deadline, with its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadline {
    seq: u64,
    due_ns: u64,
}

/// The next [`Step`], without what is sent or recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// [`ControllerEnd::send`] for this deadline, then ask again.
    Send(Deadline),
    /// Record the [`ControllerEnd::row`] of this deadline, then ask again.
    Missed(Deadline),
    /// As [`Step::Sleep`].
    Sleep {
        /// The next deadline.
        until_ns: u64,
    },
    /// As [`Step::AwaitAnswer`].
    AwaitAnswer,
    /// As [`Step::Finished`].
    Finished,
}

/// How a message without a valid answer ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// No answer came within the timeout.
    Timeout,
    /// The connection broke, or the answer was invalid.
    Failed,
}

/// How many deadlines there were, and what became of them.
///
/// `due = sent + missed`, and `sent = answered + timeout + failed` plus those
/// still under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Deadlines so far.
    pub due: u64,
    /// Number of messages sent.
    pub sent: u64,
    /// Deadlines at which nothing was sent.
    pub missed: u64,
    /// Messages with a valid answer.
    pub answered: u64,
    /// Messages without one in time.
    pub timeout: u64,
    /// Messages whose connection or answer was broken.
    pub failed: u64,
}

/// Settings with which no controller can work.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InvalidSettings {
    /// The reference is not finite.
    #[error("reference r = {r} is not a finite number; the paper's is 1")]
    Reference {
        /// The reference.
        r: f64,
    },
    /// The timeout is 0, so every message would end before it is sent.
    #[error("timeout_ns = 0: every message would be late; the paper's is 5000000000 (5 s)")]
    Timeout,
}

/// A message under way: what its row will have, and no more, since there may be thousands.
#[derive(Clone, Copy, Debug)]
struct UnderWay {
    deadline: Deadline,
    send_ns: u64,
    r: f64,
    /// The output from which the command follows; `None` in open loop.
    y: Option<f64>,
    u: f64,
    /// The message whose answer brought that output.
    y_seq: Option<u64>,
}

/// The newest answer that counts.
#[derive(Clone, Copy, Debug)]
struct NewestAnswer {
    /// The message that it answers.
    seq: u64,
    told: AnswerFacts,
}

/// The controller's end of the loop.
#[derive(Clone, Debug)]
pub struct ControllerEnd {
    settings: ControllerSettings,
    /// r over time, from `start_ns` on; that of the settings, if it rests.
    reference: Option<Reference>,
    start_ns: u64,
    /// h in seconds, computed once, since a division costs as much as a law's arithmetic.
    h_s: f64,
    law: Law,
    /// The newest known outputs, and the answer that brought them.
    y: Signals,
    newest: Option<NewestAnswer>,
    /// When the previous command was sent, for `Integrate::Elapsed`.
    last_send_ns: Option<u64>,
    next_seq: u64,
    /// `None` while a relative schedule waits for an answer.
    next_due_ns: Option<u64>,
    stop_ns: u64,
    /// In order of `seq`, so mostly answered from the front.
    under_way: VecDeque<UnderWay>,
    counts: Counts,
}

impl ControllerEnd {
    /// An end whose first deadline is `start_ns` and whose last is before `stop_ns`. `y` has the
    /// plant's outputs before the first answer: 0 for a plant at rest.
    ///
    /// # Errors
    /// [`InvalidSettings`] if the reference is not finite or the timeout is 0.
    pub fn try_new(
        settings: ControllerSettings,
        law: impl Into<Law>,
        y: impl Into<Signals>,
        start_ns: u64,
        stop_ns: u64,
    ) -> Result<Self, InvalidSettings> {
        if !settings.r.is_finite() {
            return Err(InvalidSettings::Reference { r: settings.r });
        }
        if settings.timeout_ns == 0 {
            return Err(InvalidSettings::Timeout);
        }
        Ok(Self {
            settings,
            reference: None,
            start_ns,
            h_s: settings.h.seconds(),
            law: law.into(),
            y: y.into(),
            newest: None,
            last_send_ns: None,
            next_seq: 0,
            next_due_ns: Some(start_ns),
            stop_ns,
            under_way: VecDeque::with_capacity(settings.outstanding.limit()),
            counts: Counts::default(),
        })
    }

    /// Follows a reference that moves, instead of r in the settings.
    #[must_use]
    pub fn following(self, reference: Option<Reference>) -> Self {
        Self { reference, ..self }
    }

    /// Goes on at `now_ns` with the run of an earlier end, which was lost: with the first deadline after
    /// `now_ns` on the grid start + k h, and its number k. On the other schedules too, whose deadlines are
    /// never less than h apart: so no number comes twice, however often a run is gone on with.
    #[must_use]
    pub fn resumed(self, now_ns: u64) -> Self {
        let k = self.settings.h.next_k(self.start_ns, now_ns);
        let since_start_ns = k.saturating_mul(self.settings.h.ns());
        Self {
            next_seq: k,
            next_due_ns: Some(self.start_ns.saturating_add(since_start_ns)),
            ..self
        }
    }

    /// The next step at `now_ns`. One call handles at most one deadline, so poll until the step is to wait.
    ///
    /// On an absolute schedule a deadline is over when the next one is due: a controller that wakes late
    /// sends for the present deadline and records the earlier ones as missed, since it cannot send in the
    /// past. The other schedules have no such grid, and a late message only delays the next.
    #[inline]
    pub fn poll(&mut self, now_ns: u64) -> Step {
        match self.next(now_ns) {
            Next::Send(deadline) => Step::Send(self.send(deadline, now_ns)),
            Next::Missed(deadline) => Step::Missed(self.row(deadline)),
            Next::Sleep { until_ns } => Step::Sleep { until_ns },
            Next::AwaitAnswer => Step::AwaitAnswer,
            Next::Finished => Step::Finished,
        }
    }

    /// The next step as [`ControllerEnd::poll`] gives it, but for what is sent or recorded:
    /// [`ControllerEnd::send`] and [`ControllerEnd::row`] give that, of the same deadline. In virtual time it
    /// pays not to move a command in and out of a [`Step`].
    #[inline]
    pub fn next(&mut self, now_ns: u64) -> Next {
        let Some(due_ns) = self.next_due_ns else {
            return Next::AwaitAnswer;
        };
        if due_ns >= self.stop_ns {
            return Next::Finished;
        }
        if now_ns < due_ns {
            return Next::Sleep { until_ns: due_ns };
        }
        let full = self.under_way.len() >= self.settings.outstanding.limit();
        if full && self.settings.schedule == Schedule::SinceSend {
            return Next::AwaitAnswer;
        }
        let seq = self.next_seq;
        self.next_seq += 1;
        self.counts.due += 1;

        let h_ns = self.settings.h.ns();
        let blocking = self.settings.outstanding == Outstanding::ONE;
        let over = match self.settings.schedule {
            Schedule::Absolute => {
                let next_ns = due_ns.saturating_add(h_ns);
                self.next_due_ns = Some(next_ns);
                now_ns >= next_ns
            }
            Schedule::Relative => {
                self.next_due_ns = (!blocking).then(|| now_ns.saturating_add(h_ns));
                false
            }
            Schedule::SinceSend => {
                self.next_due_ns = Some(now_ns.saturating_add(h_ns));
                false
            }
        };
        if over || full {
            self.counts.missed += 1;
            return Next::Missed(Deadline { seq, due_ns });
        }
        self.counts.sent += 1;
        Next::Send(Deadline { seq, due_ns })
    }

    /// Reports the answer to a message. Returns `None` if that message is not under way (any more).
    #[inline]
    pub fn answered(&mut self, answer: &Answer, now_ns: u64) -> Option<MessageRow> {
        let message = self.end(answer.seq(), now_ns)?;
        self.counts.answered += 1;
        let mut tick = None;
        if let Answer::State(state) = answer {
            tick = Some(state.tick);
            // The plant's tick, not seq, gives the age of a measurement: a command that was overtaken
            // on its way up brings back the newer output.
            let overtaken = self
                .newest
                .is_some_and(|newest| state.tick < newest.told.tick);
            if !(overtaken && self.settings.late == Late::Drop) {
                self.y = state.y;
                self.newest = Some(NewestAnswer {
                    seq: state.seq,
                    told: AnswerFacts {
                        tick: state.tick,
                        u: state.u,
                        send_ns: message.send_ns,
                    },
                });
            }
        }
        Some(MessageRow {
            t_receive_ns: Some(now_ns),
            t_arrive_ns: Some(answer.t_arrive_ns()),
            tick,
            ..message.row(MessageOutcome::Answered)
        })
    }

    /// Reports that a message ended without a valid answer. Returns `None` if it is not under way.
    pub fn lost(&mut self, seq: u64, loss: Loss, now_ns: u64) -> Option<MessageRow> {
        let message = self.end(seq, now_ns)?;
        let outcome = match loss {
            Loss::Timeout => {
                self.counts.timeout += 1;
                MessageOutcome::Timeout
            }
            Loss::Failed => {
                self.counts.failed += 1;
                MessageOutcome::Failed
            }
        };
        Some(message.row(outcome))
    }

    /// Number of the oldest message under way, if any.
    #[must_use]
    pub fn oldest_under_way(&self) -> Option<u64> {
        self.under_way.front().map(UnderWay::seq)
    }

    /// Counts of the deadlines so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The command for a deadline, from the newest known output.
    #[inline]
    pub fn send(&mut self, deadline: Deadline, now_ns: u64) -> Command {
        let ControllerSettings {
            mode, integrate, ..
        } = self.settings;
        let r = self.r(deadline.due_ns);
        let newest = self.newest;
        let (u, y) = match mode {
            // The plant does not apply it, so the reference will do.
            Mode::Open => (r.into(), None),
            Mode::Closed => {
                let dt_s = match (integrate, self.last_send_ns) {
                    (Integrate::Elapsed, Some(last_ns)) => seconds(now_ns.saturating_sub(last_ns)),
                    _ => self.h_s,
                };
                let seen = LawInput {
                    y: self.y,
                    times: Some(Moment {
                        send_ns: now_ns,
                        told: newest.map(|newest| newest.told),
                    }),
                };
                (self.law.update(r, seen, dt_s), Some(self.y.first))
            }
        };
        self.last_send_ns = Some(now_ns);
        self.under_way.push_back(UnderWay {
            deadline,
            send_ns: now_ns,
            r,
            y,
            u: u.first,
            y_seq: newest.map(|newest| newest.seq),
        });
        Command {
            seq: deadline.seq,
            t_send_ns: now_ns,
            u,
        }
    }

    /// Removes a message from those under way.
    #[inline]
    fn end(&mut self, seq: u64, now_ns: u64) -> Option<UnderWay> {
        // Usually it is the oldest.
        let message = if self.under_way.front()?.seq() == seq {
            self.under_way.pop_front()
        } else {
            let found = self.under_way.binary_search_by_key(&seq, UnderWay::seq);
            self.under_way.remove(found.ok()?)
        }?;
        // Only a relative schedule with one outstanding message waits for this.
        let h_ns = self.settings.h.ns();
        self.next_due_ns.get_or_insert(now_ns.saturating_add(h_ns));
        Some(message)
    }

    /// The reference at a deadline.
    #[inline]
    fn r(&self, due_ns: u64) -> f64 {
        let since_start_ns = due_ns.saturating_sub(self.start_ns);
        let moving = self.reference.as_ref();
        moving.map_or(self.settings.r, |moving| moving.at(since_start_ns))
    }

    /// The row of a deadline at which nothing was sent.
    #[inline]
    #[must_use]
    pub fn row(&self, Deadline { seq, due_ns }: Deadline) -> MessageRow {
        MessageRow {
            seq,
            t_due_ns: due_ns,
            t_send_ns: None,
            t_receive_ns: None,
            t_arrive_ns: None,
            r: self.r(due_ns),
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome: MessageOutcome::Missed,
            y_seq: None,
        }
    }
}

impl UnderWay {
    #[inline]
    fn seq(&self) -> u64 {
        self.deadline.seq
    }

    /// Its row, as if it had not been answered.
    #[inline]
    fn row(self, outcome: MessageOutcome) -> MessageRow {
        MessageRow {
            seq: self.deadline.seq,
            t_due_ns: self.deadline.due_ns,
            t_send_ns: Some(self.send_ns),
            t_receive_ns: None,
            t_arrive_ns: None,
            r: self.r,
            y: self.y,
            // The same difference as the law's, to the last bit.
            e: self.y.map(|y| self.r - y),
            u: Some(self.u),
            tick: None,
            outcome,
            y_seq: self.y_seq,
        }
    }
}
