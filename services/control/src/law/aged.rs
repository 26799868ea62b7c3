//! State feedback whose Kalman filter knows how old each output is, and steps its model by the plant's ticks rather
//! than by its own updates.
//!
//! An answer names the tick of its outputs and the inputs that the plant holds from the next one on. An update steps
//! the filter tick by tick from the last output to the newest, corrects by that one, and predicts ahead to the tick at
//! which the new command will act (L. Schenato, 2008, on estimation with outputs that are late or lost; J. Nilsson,
//! 1998, on feedback by the delays that stamps tell). The model is stepped with what the plant is known to hold, and
//! with the commands that were sent since.
//!
//! When a command acts follows from the controller's clock alone: between the arrivals of two messages passes as much
//! time as between their sendings, if the way up is as long for both. Within its tick an arrival may lie anywhere, so
//! the number of ticks between is rounded. A way up that changes, and a command that is lost, are told of by the next
//! answer only. There is no dead time and no integral.

use std::collections::VecDeque;

use super::InvalidLaw;
use super::feedback::StateFeedback;
use super::filter::{Filter, Noise};
use crate::moment::{AnswerFacts, Moment};
use crate::signals::Signals;

/// Most ticks that are stepped at once; of more, the first are left out.
const MOST_TICKS: i64 = 1_000;
/// Most commands whose effect is not known yet; of more, the oldest are forgotten.
const MOST_SENT: usize = 1_000;

/// u = reference r - gains x, with x estimated for the tick at which u acts.
#[derive(Debug, Clone, PartialEq)]
pub struct AgedFeedback {
    /// The gains; and the law as it is for outputs that are always equally old.
    assumed: StateFeedback,
    h_ns: u64,
    filter: Filter,
    /// The state when the next command acts.
    ahead: Vec<f64>,
    newest: Option<LastTaken>,
    /// When each command was sent that is not known to be held, the oldest first.
    sent: VecDeque<(u64, Signals)>,
    output: Signals,
}

/// The newest answer that the filter has taken.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LastTaken {
    /// Its tick; the filter's state is that before the next.
    tick: i64,
    u: Signals,
    send_ns: u64,
    /// Whether there was none yet, and ticks are counted from the first command.
    is_none: bool,
}

/// The inputs that the plant holds from the newest answer on, as far as is known.
struct HeldInputs<'a> {
    newest: LastTaken,
    h_ns: u64,
    sent: &'a VecDeque<(u64, Signals)>,
    /// Commands from then on are not of interest.
    until_ns: u64,
    u: Signals,
    next: usize,
}

impl AgedFeedback {
    /// A law at rest for a plant that ticks every `h_ns`. Gains, limits and model are those of `assumed`.
    ///
    /// # Errors
    /// [`InvalidLaw`] if a matrix of the noise does not fit the model, or a number is not finite.
    pub fn try_new(assumed: StateFeedback, noise: &Noise, h_ns: u64) -> Result<Self, InvalidLaw> {
        noise.check(assumed.model())?;
        Ok(Self {
            h_ns: h_ns.max(1),
            filter: Filter::new(assumed.model(), noise),
            ahead: vec![0.0; assumed.model().order()],
            newest: None,
            sent: VecDeque::with_capacity(MOST_SENT),
            output: Signals::zeros(assumed.model().inputs()),
            assumed,
        })
    }

    /// The law as it is for outputs that are always as old as it assumes.
    #[must_use]
    pub fn assumed(&self) -> &StateFeedback {
        &self.assumed
    }

    pub(super) fn assumed_mut(&mut self) -> &mut StateFeedback {
        &mut self.assumed
    }

    pub(super) fn update(&mut self, r: f64, y: Signals, times: &Moment) -> Signals {
        let (outputs, inputs) = self.assumed.signals();
        let is_valid = |signals: Signals, count| signals.is_finite() && signals.count() == count;
        let held_is_valid = times.told.is_none_or(|told| is_valid(told.u, inputs));
        if !(r.is_finite() && is_valid(y, outputs) && held_is_valid) {
            return self.output;
        }
        let before = LastTaken {
            tick: -1,
            u: Signals::zeros(inputs),
            send_ns: times.send_ns.saturating_sub(self.h_ns),
            is_none: true,
        };
        let mut newest = *self.newest.get_or_insert(before);
        if let Some(told) = &times.told {
            let Some(taken) = self.take(newest, y, told) else {
                return self.output;
            };
            newest = taken;
        }
        self.newest = Some(newest);
        self.predict(newest, times.send_ns);
        let u = self.assumed.command(r, &self.ahead);
        if !u.is_finite() {
            return self.output;
        }
        if self.sent.len() == MOST_SENT {
            self.sent.pop_front();
        }
        self.sent.push_back((times.send_ns, u));
        self.output = u;
        u
    }

    /// Steps the filter to an answer; returns the newest then. `None`, and nothing is changed, if a number overflows.
    fn take(&mut self, mut newest: LastTaken, y: Signals, told: &AnswerFacts) -> Option<LastTaken> {
        let tick = i64::try_from(told.tick).unwrap_or(i64::MAX);
        if newest.is_none {
            // The first command came to the plant so long before the one that is answered.
            let since_ns = told.send_ns.saturating_sub(newest.send_ns);
            newest.tick = tick.saturating_sub(ticks(since_ns, self.h_ns));
        }
        if tick < newest.tick || told.send_ns < newest.send_ns {
            return Some(newest);
        }
        let mut held = HeldInputs::new(newest, self.h_ns, &self.sent, told.send_ns);
        self.filter.keep();
        let first = tick
            .saturating_sub(MOST_TICKS - 1)
            .max(newest.tick.saturating_add(1));
        for k in first..=tick {
            self.filter.tick(held.at(k), (k == tick).then_some(y));
        }
        if !self.filter.is_finite() {
            self.filter.forget();
            return None;
        }
        while self
            .sent
            .front()
            .is_some_and(|(send_ns, _)| *send_ns <= told.send_ns)
        {
            self.sent.pop_front();
        }
        Some(LastTaken {
            tick,
            u: told.u,
            send_ns: told.send_ns,
            is_none: false,
        })
    }

    /// Predicts the state before the tick at which a command of now acts.
    fn predict(&mut self, newest: LastTaken, send_ns: u64) {
        self.ahead.copy_from_slice(&self.filter.state);
        let mut held = HeldInputs::new(newest, self.h_ns, &self.sent, send_ns);
        let acts = held.acts(send_ns);
        let first = newest
            .tick
            .saturating_add(1)
            .max(acts.saturating_sub(MOST_TICKS));
        std::mem::swap(&mut self.ahead, &mut self.filter.state);
        for k in first..acts {
            self.filter.step(held.at(k));
        }
        std::mem::swap(&mut self.ahead, &mut self.filter.state);
    }
}

impl<'a> HeldInputs<'a> {
    fn new(
        newest: LastTaken,
        h_ns: u64,
        sent: &'a VecDeque<(u64, Signals)>,
        until_ns: u64,
    ) -> Self {
        Self {
            newest,
            h_ns,
            sent,
            until_ns,
            u: newest.u,
            next: 0,
        }
    }

    /// The first tick with a command that was sent then.
    fn acts(&self, send_ns: u64) -> i64 {
        let since_ns = send_ns.saturating_sub(self.newest.send_ns);
        let after = ticks(since_ns, self.h_ns).saturating_add(1);
        self.newest.tick.saturating_add(after)
    }

    /// The inputs of a tick, which is no earlier than that of the last call.
    fn at(&mut self, tick: i64) -> Signals {
        while let Some((send_ns, u)) = self.sent.get(self.next)
            && *send_ns < self.until_ns
            && self.acts(*send_ns) <= tick
        {
            self.u = *u;
            self.next += 1;
        }
        self.u
    }
}

/// The whole ticks nearest to a time.
fn ticks(ns: u64, h_ns: u64) -> i64 {
    let ticks = ns.saturating_add(h_ns / 2) / h_ns;
    i64::try_from(ticks).unwrap_or(i64::MAX)
}
