//! The trials: what each asks of a controller, and what its plant does meanwhile.
//!
//! `check` decides whether the controller did it.

use std::ops::{Range, RangeInclusive};

use endpoint::{Mode, SampleTime};

const MS: u64 = 1_000_000;

/// A second in ns.
pub(crate) const S: u64 = 1_000 * MS;

/// Time from the start of a controller until its first message is due, ns: an interpreter is loaded
/// within it, also beside four others on two processors.
pub(crate) const LEAD_NS: u64 = 2 * S;

/// A plant that listens late does so this long before the start, ns.
pub(crate) const LISTENS_BEFORE_NS: u64 = S;

/// When answers are held back, ns after the start.
pub(crate) const STALL: Range<u64> = S..2_500 * MS;

/// When messages are refused, ns after the start.
pub(crate) const REFUSAL: Range<u64> = 800 * MS..1_100 * MS;

/// When a controller gets SIGTERM, ns after the start.
pub(crate) const TERMINATE_NS: u64 = S;

/// What happens to a controller in a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Script {
    /// Nothing out of the ordinary.
    Plain,
    /// The plant listens only from [`LISTENS_BEFORE_NS`] on.
    ListenLate,
    /// The plant gives no answer during [`STALL`], and then all of them.
    Stall,
    /// The plant closes a connection, without notice, after each so many answers.
    Drop {
        /// Number of answers from one closing to the next.
        every: u64,
    },
    /// The plant refuses messages during [`REFUSAL`].
    Refuse,
    /// The controller gets SIGTERM.
    Terminate,
}

/// One test of a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Its name.
    pub name: &'static str,
    /// What it asks, in a sentence.
    pub asks: &'static str,
    /// The mode that the controller is told.
    pub mode: Mode,
    /// Sample time.
    pub h: SampleTime,
    /// Reference.
    pub r: f64,
    /// Messages are due for this long, ns.
    pub duration_ns: u64,
    /// How many controllers run at once, each with a plant of its own.
    pub(crate) controllers: usize,
    pub(crate) script: Script,
    /// Least and greatest number of messages, as shares of those that are due.
    pub(crate) shares: RangeInclusive<f64>,
    /// Whether it is said if y does not settle at r.
    pub(crate) notes_r: bool,
}

impl Trial {
    /// Every trial, at sample time `h` where it does not need another one.
    #[must_use]
    pub fn all(h: SampleTime) -> Vec<Trial> {
        let steady = Trial::steady(h);
        let mut all = vec![steady.clone()];
        all.extend(steady.troubled());
        all.extend(steady.varied());
        all
    }

    /// The trial in which nothing happens.
    fn steady(h: SampleTime) -> Trial {
        Trial {
            name: "steady",
            asks: "A message each h from the start on, over a few kept connections, and an end by itself.",
            mode: Mode::Closed,
            h,
            r: 1.0,
            duration_ns: 2 * S,
            controllers: 1,
            script: Script::Plain,
            shares: 0.8..=1.2,
            notes_r: false,
        }
    }

    /// The trials in which something happens to the controller of this one.
    fn troubled(&self) -> [Trial; 5] {
        // With a long h there are no 50 answers.
        let every = (self.due() / 4).clamp(1, 50);
        [
            Trial {
                name: "late-start",
                asks: "The plant listens only 1 s after the controller was started: it tries again.",
                script: Script::ListenLate,
                ..self.clone()
            },
            Trial {
                name: "stall",
                asks: "All answers are held back for 1.5 s: it goes on within 1 s, without a flood.",
                duration_ns: 4 * S,
                script: Script::Stall,
                shares: 0.0..=2.0,
                ..self.clone()
            },
            Trial {
                name: "dropped",
                asks: "The plant closes connections without notice: it connects again and goes on.",
                script: Script::Drop { every },
                shares: 0.5..=2.0,
                ..self.clone()
            },
            Trial {
                name: "refusal",
                asks: "The plant refuses messages with 409 and 500 for 300 ms: it goes on after that.",
                duration_ns: 5 * S / 2,
                script: Script::Refuse,
                shares: 0.0..=2.0,
                ..self.clone()
            },
            Trial {
                name: "stop",
                asks: "It gets SIGTERM in the middle and ends within 1 s.",
                // Far from its end, so that it does not end by itself meanwhile.
                duration_ns: 4 * S,
                script: Script::Terminate,
                shares: 0.0..=2.0,
                ..self.clone()
            },
        ]
    }

    /// The trials whose controllers are told something else than that of this one, or are two.
    fn varied(&self) -> [Trial; 3] {
        let h = self.h;
        let other_ns = if h.ns() == 20 * MS { 10 * MS } else { 20 * MS };
        [
            Trial {
                name: "open",
                asks: "Open loop, answers without y: it keeps the rate, or says so with exit code 127.",
                mode: Mode::Open,
                ..self.clone()
            },
            Trial {
                name: "two",
                asks: "Two controllers at once, each with its plant: both keep the rate.",
                controllers: 2,
                ..self.clone()
            },
            Trial {
                name: "reference",
                asks: "Another r and another h: it takes both from its environment.",
                h: SampleTime::try_new(other_ns).unwrap_or(h),
                r: 0.5,
                duration_ns: 3 * S,
                notes_r: true,
                ..self.clone()
            },
        ]
    }

    /// Number of messages that are due.
    pub(crate) fn due(&self) -> u64 {
        self.duration_ns.div_ceil(self.h.ns())
    }

    /// When the last message's h is over, for a controller that starts at `start_ns`.
    pub(crate) fn stop_ns(&self, start_ns: u64) -> u64 {
        start_ns + self.duration_ns
    }
}
