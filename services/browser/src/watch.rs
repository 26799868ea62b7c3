//! Judges a page by the plant's status of its session. Pure: the time since the start of the browser
//! is an argument. [`crate::attempt`] handles processes and asks the plant.

use std::time::Duration;

use endpoint::report::Session;

use crate::{
    config::Limits,
    plant::{State, Status},
};

/// A page that goes on, or has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// No change since the last query.
    Wait,
    /// The page holds the session now.
    Opened,
    /// The page has ended, without an error as far as the plant knows.
    Ended,
}

/// Why a page did not end as expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// No page took the session.
    NeverOpened,
    /// The page is silent.
    Hung { silent_s: u64 },
    /// The page does not end.
    Unfinished,
    /// The page itself reports what went wrong.
    Page { outcome: String, reason: String },
}

/// When a page should take the session, and when it should end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Course {
    /// Time from the browser's start to the first deadline, if known.
    pub(crate) start: Option<Duration>,
    /// Time from the first deadline to the last.
    pub(crate) length: Duration,
    /// How long a message waits for its answer.
    pub(crate) timeout: Duration,
    /// How long to wait for each step.
    pub(crate) limits: Limits,
}

impl Course {
    /// How long a page may be silent: a message's time-out plus the limit of silence.
    pub(crate) fn silence(&self) -> Duration {
        self.timeout.saturating_add(self.limits.silence)
    }
}

/// Watches one page from the start of the browser.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    course: Course,
    /// When it was first seen to hold the session.
    opened: Option<Duration>,
    /// The plant's last status of its session.
    seen: Option<Session>,
}

impl Watch {
    pub(crate) fn new(course: Course) -> Self {
        Self {
            course,
            opened: None,
            seen: None,
        }
    }

    /// When the page was first seen to hold the session.
    pub(crate) fn opened(&self) -> Option<Duration> {
        self.opened
    }

    /// The plant's last status of its session.
    pub(crate) fn session(&self) -> Option<&Session> {
        self.seen.as_ref()
    }

    /// Judges the plant's status at `now`.
    pub(crate) fn saw(&mut self, now: Duration, status: &Status) -> Result<Step, Trouble> {
        let idle = Duration::from_millis(status.idle_ms);
        match status.state {
            State::Free if self.opened.is_none() => self.passed(now).map(|()| Step::Wait),
            // The plant has stopped waiting for the page.
            State::Free => Err(Trouble::Hung {
                silent_s: self.course.silence().as_secs(),
            }),
            // A session that ended before the start of the browser belongs to another page.
            State::Ended if self.opened.is_none() && idle >= now => {
                self.passed(now).map(|()| Step::Wait)
            }
            State::Ended => {
                self.opened.get_or_insert(now);
                self.note(status);
                match &status.outcome {
                    Some(outcome) if outcome != "complete" => Err(Trouble::Page {
                        outcome: outcome.clone(),
                        reason: status.reason.clone().unwrap_or_default(),
                    }),
                    _ => Ok(Step::Ended),
                }
            }
            State::Held => {
                let new = self.opened.is_none();
                self.opened.get_or_insert(now);
                self.note(status);
                if idle > self.course.silence() {
                    return Err(Trouble::Hung {
                        silent_s: idle.as_secs(),
                    });
                }
                self.passed(now)?;
                Ok(if new { Step::Opened } else { Step::Wait })
            }
        }
    }

    /// Judges the page at `now` by the time alone.
    pub(crate) fn passed(&self, now: Duration) -> Result<(), Trouble> {
        let Course {
            start,
            length,
            timeout,
            limits,
        } = self.course;
        let Some(opened) = self.opened else {
            return if now > limits.open {
                Err(Trouble::NeverOpened)
            } else {
                Ok(())
            };
        };
        let end = start
            .unwrap_or(opened)
            .saturating_add(length)
            .saturating_add(timeout)
            .saturating_add(limits.finish);
        if now > end {
            Err(Trouble::Unfinished)
        } else {
            Ok(())
        }
    }

    fn note(&mut self, status: &Status) {
        self.seen = Some(Session {
            client: status.client.clone(),
            commands: status.commands,
            rows: status.rows,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn s(s: u64) -> Duration {
        Duration::from_secs(s)
    }

    /// A page with deadlines from `start` for 6 s, and a time-out of 5 s.
    fn watch(start: Option<Duration>) -> Watch {
        Watch::new(Course {
            start,
            length: s(6),
            timeout: s(5),
            limits: Limits::default(),
        })
    }

    fn status(state: State, idle_ms: u64) -> Status {
        Status {
            state,
            client: "page".to_owned(),
            commands: 7,
            rows: 6,
            idle_ms,
            outcome: None,
            reason: None,
        }
    }

    #[test]
    fn a_page_comes_runs_and_ends() {
        let mut watch = watch(Some(s(5)));
        assert_eq!(watch.saw(s(1), &status(State::Free, 0)), Ok(Step::Wait));
        assert_eq!(watch.saw(s(2), &status(State::Held, 0)), Ok(Step::Opened));
        assert_eq!(watch.saw(s(3), &status(State::Held, 900)), Ok(Step::Wait));
        assert_eq!(watch.saw(s(12), &status(State::Ended, 0)), Ok(Step::Ended));
        assert_eq!(watch.opened(), Some(s(2)));
        assert_eq!(watch.session().map(|session| session.rows), Some(6));
    }

    #[test]
    fn a_page_that_came_and_went_between_two_looks_has_ended_and_an_older_one_has_not() {
        let mut quick = watch(None);
        let old = status(State::Ended, 60_000);
        assert_eq!(quick.saw(s(1), &old), Ok(Step::Wait));
        let own = status(State::Ended, 200);
        assert_eq!(quick.saw(s(2), &own), Ok(Step::Ended));
        let mut never = watch(None);
        let still = status(State::Ended, 91_000);
        assert_eq!(never.saw(s(31), &still), Err(Trouble::NeverOpened));
    }

    #[test]
    fn every_ending_has_its_name_and_its_time() {
        let opened = |start| {
            let mut watch = watch(start);
            assert_eq!(watch.saw(s(2), &status(State::Held, 0)), Ok(Step::Opened));
            watch
        };
        assert_eq!(watch(None).passed(s(30)), Ok(()));
        assert_eq!(watch(None).passed(s(31)), Err(Trouble::NeverOpened));
        // 5 s of time-out and 10 s of permitted silence.
        let silent = |idle_ms| opened(None).saw(s(20), &status(State::Held, idle_ms));
        assert_eq!(silent(15_000), Ok(Step::Wait));
        assert_eq!(silent(15_001), Err(Trouble::Hung { silent_s: 15 }));
        let expired = opened(None).saw(s(20), &status(State::Free, 0));
        assert_eq!(expired, Err(Trouble::Hung { silent_s: 15 }));
        // 6 s, 5 s of time-out and 60 s, from the start or, if none was given, from when the page opened.
        for (start, last) in [(Some(s(5)), s(76)), (None, s(73))] {
            assert_eq!(opened(start).passed(last), Ok(()));
            let over = last + Duration::from_millis(1);
            assert_eq!(opened(start).passed(over), Err(Trouble::Unfinished));
            let held = opened(start).saw(over, &status(State::Held, 0));
            assert_eq!(held, Err(Trouble::Unfinished));
        }
    }

    #[test]
    fn a_page_that_says_what_went_wrong_is_believed() {
        for (outcome, ok) in [("complete", true), ("late", false), ("failed", false)] {
            let said = Status {
                outcome: Some(outcome.to_owned()),
                reason: Some("so".to_owned()),
                ..status(State::Ended, 0)
            };
            assert_eq!(watch(None).saw(s(3), &said).is_ok(), ok, "{outcome}");
        }
    }
}
