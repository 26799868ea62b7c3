//! The plant of a trial without its network: the motor, what was heard, and what the script does to a
//! message.
//!
//! The motor is stepped when a request comes, by all ticks that are due by then: in between nobody sees
//! its output. `route` reads HTTP, `socket` the WebSocket.

use std::ops::Range;
use std::time::Duration;

use clock::now::now_ns;
use control::{InvalidDiscretisation, Stepper, preset};
use endpoint::{Answer, Inbox, Mode, Observation, Output, PlantSettings, Process, Request};
use hyper::StatusCode;

use crate::record::{Arrival, Heard};
use crate::trial::{REFUSAL, STALL, Script, Trial};

/// The plant's state.
#[derive(Debug)]
pub(crate) struct Exchange {
    script: Script,
    start_ns: u64,
    settings: PlantSettings,
    at_rest: Stepper,
    inbox: Inbox,
    process: Process,
    /// Number of messages that were answered.
    answered: u64,
    pub(crate) heard: Heard,
}

/// What becomes of a message.
#[derive(Debug)]
pub(crate) struct Said {
    pub(crate) answer: Result<Answer, Refusal>,
    /// When it is answered, ns.
    pub(crate) at_ns: u64,
    /// Whether its connection is closed then.
    pub(crate) is_last: bool,
}

/// Why a request gets nothing else.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub(crate) status: StatusCode,
    pub(crate) words: String,
}

impl Exchange {
    /// The plant of a trial whose first message is due at `start_ns`; its tick 0 is due at `now_ns`.
    pub(crate) fn new(
        trial: &Trial,
        start_ns: u64,
        now_ns: u64,
    ) -> Result<Self, InvalidDiscretisation> {
        let settings = PlantSettings::new(trial.h);
        let at_rest = preset::paper_plant().sampled(trial.h.ns())?.stepper();
        Ok(Self {
            script: trial.script,
            start_ns,
            settings,
            inbox: Inbox::new(&settings, 1),
            process: Process::new(&settings, at_rest.clone(), now_ns),
            at_rest,
            answered: 0,
            heard: Heard::default(),
        })
    }

    /// Takes a message that arrived at `now_ns`; `query` is its text.
    pub(crate) fn message(
        &mut self,
        mode: Mode,
        query: &str,
        connection: u64,
        now_ns: u64,
    ) -> Said {
        let said = |answer, at_ns, is_last| Said {
            answer,
            at_ns,
            is_last,
        };
        let request = match query.parse::<Request>() {
            Ok(request) => request,
            Err(problem) => {
                let query: String = query
                    .chars()
                    .take(80)
                    .flat_map(char::escape_debug)
                    .collect();
                let words = format!("`{query}`: {problem}");
                self.heard.refuse(&words);
                return said(
                    Err(Refusal::new(StatusCode::BAD_REQUEST, words)),
                    now_ns,
                    false,
                );
            }
        };
        let output = self.output(now_ns);
        let mut arrival = Arrival {
            t_ns: now_ns,
            connection,
            mode,
            request,
            y: None,
        };
        if self.script == Script::Refuse && self.is_within(&REFUSAL, now_ns) {
            let refusal = scripted(self.heard.messages());
            self.heard.arrivals.push(arrival);
            return said(Err(refusal), now_ns, false);
        }
        let (_, answer) = self.inbox.command(mode, &request, output, now_ns);
        arrival.y = (mode == Mode::Closed).then_some(output.y.first);
        self.heard.arrivals.push(arrival);
        self.answered += 1;
        let is_last = match self.script {
            Script::Drop { every } => self.answered.is_multiple_of(every),
            _ => false,
        };
        if is_last {
            self.heard.closed_ns.push(now_ns);
        }
        said(Ok(answer), self.released_ns(now_ns), is_last)
    }

    /// The state of the motor, which it does not change.
    pub(crate) fn observe(&mut self, now_ns: u64) -> Observation {
        self.output(now_ns).observed(self.inbox.input(), now_ns)
    }

    /// When an answer to a request that arrived at `now_ns` is given: at once, unless the plant stalls.
    pub(crate) fn released_ns(&self, now_ns: u64) -> u64 {
        if self.script == Script::Stall && self.is_within(&STALL, now_ns) {
            self.start_ns + STALL.end
        } else {
            now_ns
        }
    }

    fn is_within(&self, span: &Range<u64>, now_ns: u64) -> bool {
        let since_ns = now_ns.checked_sub(self.start_ns);
        since_ns.is_some_and(|ns| span.contains(&ns))
    }

    /// The motor's output after all ticks that are due.
    fn output(&mut self, now_ns: u64) -> Output {
        while self.process.next_due_ns() <= now_ns {
            self.process.tick(self.inbox.input(), now_ns);
        }
        // A law for another plant may be unstable here, and the trials are not about that.
        if !self.process.output().y.is_finite() {
            self.process = Process::new(&self.settings, self.at_rest.clone(), now_ns);
        }
        self.process.output()
    }
}

impl Refusal {
    pub(crate) fn new(status: StatusCode, words: impl Into<String>) -> Self {
        Self {
            status,
            words: words.into(),
        }
    }
}

/// A refusal that the script asks for: one that a plant gives, and one of a server in trouble.
fn scripted(count: u64) -> Refusal {
    if count.is_multiple_of(2) {
        Refusal::new(
            StatusCode::CONFLICT,
            "the plant has another controller; try again",
        )
    } else {
        Refusal::new(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the plant cannot answer now; try again",
        )
    }
}

/// Returns at `t_ns`; at once if that has passed.
pub(crate) async fn wait_until(t_ns: u64) {
    let left_ns = t_ns.saturating_sub(now_ns());
    if left_ns > 0 {
        tokio::time::sleep(Duration::from_nanos(left_ns)).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START_NS: u64 = 100_000_000_000;

    fn exchange(name: &str) -> Exchange {
        let trials = Trial::all("10ms".parse().expect("a sample time"));
        let mut named = trials.iter().filter(|trial| trial.name == name);
        let trial = named.next().expect(name);
        Exchange::new(trial, START_NS, START_NS).expect("a motor")
    }

    #[test]
    fn refusals_by_the_script_are_messages_and_no_fault_of_the_controller() {
        let mut exchange = exchange("refusal");
        let mut status = |since_ns: u64| {
            let said = exchange.message(Mode::Closed, "u=1", 1, START_NS + since_ns);
            said.answer.err().map(|refusal| refusal.status.as_u16())
        };
        assert_eq!(status(REFUSAL.start), Some(409));
        assert_eq!(status(REFUSAL.end - 1), Some(500));
        assert_eq!(status(REFUSAL.end), None);
        assert_eq!((exchange.heard.messages(), exchange.heard.refused), (3, 0));
    }

    #[test]
    fn a_stall_holds_answers_back_until_its_end_and_hears_meanwhile() {
        let mut exchange = exchange("stall");
        let mut answered = |since_ns: u64| {
            let said = exchange.message(Mode::Closed, "u=1", 1, START_NS + since_ns);
            said.at_ns - START_NS
        };
        let before_ns = STALL.start - 1;
        assert_eq!(answered(before_ns), before_ns);
        assert_eq!(answered(STALL.start), STALL.end);
        assert_eq!(answered(STALL.end), STALL.end);
        assert_eq!(exchange.heard.messages(), 3);
    }

    #[test]
    fn y_stays_finite_whatever_u_is() {
        let mut exchange = exchange("steady");
        for k in 0..100 {
            let t_ns = START_NS + k * 10_000_000;
            let said = exchange.message(Mode::Closed, "u=1e308", 1, t_ns);
            assert!(matches!(said.answer, Ok(Answer::State(state)) if state.y.is_finite()));
        }
    }
}
