//! How a page in a browser runs its loop: thread, sender, timer.
//!
//! A page cannot follow every combination of its settings; [`PageSettings::check`] rejects the
//! others. The page itself, which rejects them too, is elsewhere.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::field::{Field, InvalidSetting, span_field, word_field};
use crate::setting::{Connection, ControllerSettings, Outstanding, Schedule, Transport};

text::choice!(
    /// Where in a page the loop runs.
    Thread, "thread", {
        /// Where the page is drawn and clicked on, as in 2011.
        Main = "main",
        /// On a thread of its own, a Web Worker.
        Worker = "worker",
    }
);

text::choice!(
    /// What sends a page's requests. A WebSocket needs neither.
    Sender, "sender", {
        /// A synchronous `XMLHttpRequest`: its thread waits for the answer.
        Xhr = "xhr",
        /// fetch: its thread goes on.
        Fetch = "fetch",
    }
);

text::choice!(
    /// What a page waits for a deadline with.
    Timer, "timer", {
        /// setTimeout, once a deadline.
        Timeout = "timeout",
        /// setInterval: the browser repeats it, and decides when.
        Interval = "interval",
        /// A `MessageChannel` that it writes to itself until the deadline is
        /// there: exact, and it takes a processor.
        Channel = "channel",
        /// Atomics.wait: its thread sleeps, and hears nothing. A second worker
        /// has the `fetch` or the WebSocket, and wakes it by shared memory.
        Wait = "wait",
    }
);

/// How a page goes about its loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PageSettings {
    /// Where the loop runs.
    pub thread: Thread,
    /// What sends its requests.
    pub sender: Sender,
    /// What it waits for a deadline with.
    pub timer: Timer,
    /// The least delay that a timer is given, 0 for none: browsers of 2011
    /// had 10 ms.
    pub floor_ns: u64,
    /// How long the page draws on its own thread in each 100 ms, beside the loop; 0 for not at all.
    #[serde(default, skip_serializing_if = "is_none")]
    pub chores_ns: u64,
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_none(chores_ns: &u64) -> bool {
    *chores_ns == 0
}

/// All of the time in which chores come once.
const CHORES_EVERY_NS: u64 = 100_000_000;

impl PageSettings {
    /// Checks whether a page can follow these settings.
    ///
    /// # Errors
    /// [`InvalidSetting`], which names the setting to change.
    pub fn check(&self, settings: &ControllerSettings) -> Result<(), InvalidSetting> {
        settings.check_for("a page")?;
        let blocking = settings.outstanding == Outstanding::ONE;
        let http = settings.transport == Transport::Http;
        let relative = settings.schedule == Schedule::Relative;
        let Self {
            thread,
            sender,
            timer,
            ..
        } = *self;
        let (name, problem, remedy) = if http && sender == Sender::Xhr && !blocking {
            (
                "sender",
                "sender `xhr` waits for each answer",
                "use outstanding 1, or sender fetch",
            )
        } else if timer == Timer::Wait && thread == Thread::Main {
            (
                "timer",
                "timer `wait` is not allowed on a page's main thread",
                "use thread worker",
            )
        } else if timer == Timer::Interval && !relative {
            (
                "timer",
                "timer `interval` sets its own schedule",
                "use schedule relative",
            )
        } else if self.chores_ns > CHORES_EVERY_NS {
            (
                "chores",
                "a page cannot draw for more than 100 ms of each 100 ms",
                "use 0ms to 100ms",
            )
        } else if settings.connection == Connection::New {
            (
                "connection",
                "a page cannot choose connection `new`",
                "use keep",
            )
        } else {
            return Ok(());
        };
        Err(InvalidSetting {
            name,
            problem: problem.to_owned(),
            remedy,
        })
    }
}

#[rustfmt::skip]
impl PageSettings {
    /// The settings of a page that an experiment may choose.
    pub const FIELDS: &[Field<Self>] = &[
        word_field!(thread, "Where in the page the loop runs: main or worker", "THREAD", false),
        word_field!(sender, "What sends its requests: xhr or fetch", "SENDER", true),
        word_field!(timer, "How it waits for a deadline: timeout, interval, channel or wait", "TIMER", true),
        span_field!("timer_floor", floor_ns, "The least delay of a timer, like 10ms for a browser of 2011", 0),
        span_field!("chores", chores_ns, "How long of each 100 ms the page draws beside the loop, on its own thread", 0),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Preset;
    use crate::setting::Mode;

    #[test]
    fn what_a_page_cannot_do_is_said() {
        let h = "3ms".parse().expect("a sample time");
        let blocking = Preset::Blocking.settings(Mode::Closed, h);
        let many = Preset::PaperPython.settings(Mode::Closed, h);
        let page = |thread, sender, timer| PageSettings {
            thread,
            sender,
            timer,
            floor_ns: 0,
            chores_ns: 0,
        };
        for (page, settings, word) in [
            (page(Thread::Main, Sender::Xhr, Timer::Timeout), many, "xhr"),
            (
                page(Thread::Main, Sender::Xhr, Timer::Wait),
                blocking,
                "wait",
            ),
            (
                page(Thread::Main, Sender::Fetch, Timer::Interval),
                many,
                "interval",
            ),
            (
                page(Thread::Worker, Sender::Fetch, Timer::Wait),
                ControllerSettings {
                    transport: Transport::Udp,
                    ..many
                },
                "udp",
            ),
        ] {
            let conflict = page.check(&settings).expect_err(word).to_string();
            assert!(conflict.contains(word), "{conflict}");
        }
    }
}
