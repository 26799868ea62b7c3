//! Named settings: the paper's two clients, and what is possible today.
//!
//! A preset says how a client sends and, if that client is a page, how the page runs its loop. Native
//! and Python clients do not use the latter.

use crate::page::{PageSettings, Sender, Thread, Timer};
use crate::sample_time::SampleTime;
use crate::setting::{ControllerSettings, Mode, Outstanding, Schedule, Transport};

text::choice!(
    /// A client's settings with a name.
    Preset, "preset", {
        /// The paper's Python client, as its closed loop over the VPN shows it:
        /// it sends every h whatever is outstanding, each message a blocking
        /// request on its own worker, connections kept.
        PaperPython = "paper-python",
        /// The same with one request at a time: it waits for each answer.
        Blocking = "blocking",
        /// The paper's JavaScript client in a browser of 2011: on the page's only
        /// thread a timer that sets itself anew, no timer below 10 ms, and then
        /// a request that the thread waits for. (Were the timer set after the
        /// request, the 10.9 ms of the paper's messages would leave 0.9 ms for a
        /// request to a Python server of that time, and for all lateness.)
        Paper2011 = "paper-2011",
        /// The same program in a browser of today.
        Today = "today",
        /// What a browser of today can do with one request at a time: a thread
        /// of its own that sleeps until its deadlines.
        Worker = "worker",
        /// Every h whatever is outstanding, on one WebSocket: a browser has at
        /// most six HTTP connections to a server, and no such limit here.
        Socket = "socket",
    }
);

impl Preset {
    /// Whether it is one of the paper's clients, whose plant takes whatever comes.
    #[must_use]
    pub fn is_of_the_paper(self) -> bool {
        matches!(self, Self::PaperPython | Self::Paper2011)
    }

    /// How the client sends.
    #[must_use]
    pub fn settings(self, mode: Mode, h: SampleTime) -> ControllerSettings {
        let blocking = ControllerSettings {
            outstanding: Outstanding::ONE,
            ..ControllerSettings::new(mode, h)
        };
        match self {
            Self::PaperPython => ControllerSettings::new(mode, h),
            Self::Socket => ControllerSettings {
                transport: Transport::WebSocket,
                ..ControllerSettings::new(mode, h)
            },
            Self::Blocking | Self::Worker => blocking,
            Self::Paper2011 | Self::Today => ControllerSettings {
                schedule: Schedule::SinceSend,
                ..blocking
            },
        }
    }

    /// How a page runs its loop.
    #[must_use]
    pub fn page(self) -> PageSettings {
        /// The least delay of a timer in browsers of 2011.
        const FLOOR_OF_2011_NS: u64 = 10_000_000;
        match self {
            Self::Paper2011 | Self::Today => PageSettings {
                thread: Thread::Main,
                sender: Sender::Xhr,
                timer: Timer::Timeout,
                floor_ns: match self {
                    Self::Paper2011 => FLOOR_OF_2011_NS,
                    _ => 0,
                },
                chores_ns: 0,
            },
            Self::Blocking | Self::Worker => PageSettings {
                thread: Thread::Worker,
                sender: Sender::Xhr,
                timer: Timer::Wait,
                floor_ns: 0,
                chores_ns: 0,
            },
            Self::PaperPython | Self::Socket => PageSettings {
                thread: Thread::Worker,
                sender: Sender::Fetch,
                timer: Timer::Wait,
                floor_ns: 0,
                chores_ns: 0,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_one_that_a_page_can_follow() {
        let h: SampleTime = "3ms".parse().expect("a sample time");
        for preset in Preset::ALL {
            let settings = preset.settings(Mode::Closed, h);
            assert_eq!(preset.page().check(&settings), Ok(()), "{preset}");
        }
    }
}
