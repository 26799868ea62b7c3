//! Faults of one direction: when each is in force, and what it does then.
//!
//! All of it is a function of the seed and of time, without a state: the k-th spell of a fault that
//! comes at random lies within the k-th `every`, so any instant can be asked at any time. The spells of a
//! fault of both directions are the same in both, since a cable that is pulled out carries nothing either
//! way. Some faults concern a share of the slots of a millisecond, by the slot as a loss does; those draws
//! are each direction's own. What a [`Twist`] does to bytes is left to others.

#[allow(clippy::module_inception)]
mod faults;
mod seeded;
mod spell;

use serde::Serialize;

pub(crate) use faults::Faults;
pub(crate) use seeded::{Seeded, Span};
pub use spell::FaultSpell;

/// For all packets of such a slot alike it is decided whether a fault concerns them.
pub(crate) const SLOT_NS: u64 = 1_000_000;

/// A fault, as a profile describes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Fault {
    /// Its number in the profile, which its draws follow from.
    pub(crate) number: u32,
    pub(crate) at_ns: u64,
    pub(crate) for_ns: u64,
    pub(crate) again: Again,
    /// How many spells there are at most.
    pub(crate) times: Option<u64>,
    pub(crate) effect: Effect,
}

/// Whether a fault comes again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Again {
    Never,
    /// Once at a random instant of each further span of this length.
    Random {
        every_ns: u64,
    },
    /// Exactly so often.
    Exact {
        period_ns: u64,
    },
}

/// What a fault does while it is in force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Effect {
    Down,
    Delay { delay_ns: u64 },
    Loss { share: f64 },
    Duplicate { share: f64 },
    Reorder { share: f64, by_ns: u64 },
    Corrupt { share: f64 },
    Reset,
    Rebind,
}

impl Effect {
    /// The same effect on another share of the slots, where it has one.
    pub(crate) fn of(mut self, of_slots: f64) -> Self {
        match &mut self {
            Self::Loss { share }
            | Self::Duplicate { share }
            | Self::Reorder { share, .. }
            | Self::Corrupt { share } => *share = of_slots,
            Self::Down | Self::Delay { .. } | Self::Reset | Self::Rebind => {}
        }
        self
    }

    /// Its word in a profile.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Delay { .. } => "delay",
            Self::Loss { .. } => "loss",
            Self::Duplicate { .. } => "duplicate",
            Self::Reorder { .. } => "reorder",
            Self::Corrupt { .. } => "corrupt",
            Self::Reset => "reset",
            Self::Rebind => "rebind",
        }
    }
}

impl Fault {
    /// Time from the beginning of a spell, or of the span that it lies in, to that of the next.
    pub(crate) fn step_ns(&self) -> Option<u64> {
        match self.again {
            Again::Never => None,
            Again::Random { every_ns } => Some(every_ns),
            Again::Exact { period_ns } => Some(period_ns),
        }
    }

    fn last(&self) -> u64 {
        match (self.step_ns(), self.times) {
            (None, _) => 0,
            (Some(_), None) => u64::MAX,
            (Some(_), Some(times)) => times.saturating_sub(1),
        }
    }
}

/// What faults do to a packet that leaves the link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Twist {
    /// It comes out twice, at the same instant.
    pub twice: bool,
    /// One bit of what follows its IP header is flipped: the one of this number, counted round and round.
    pub flip: Option<u32>,
    /// If it is a segment of TCP, it becomes a reset of its connection.
    pub reset: bool,
    /// If it is a segment of TCP, the controller has another port.
    pub rebind: bool,
}

impl Twist {
    /// What nearly all packets have.
    pub const NONE: Self = Self {
        twice: false,
        flip: None,
        reset: false,
        rebind: false,
    };
}
