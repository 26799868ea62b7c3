//! What of a link its seed draws: what differs from one repeat of a run to the next.
//!
//! Two runs over a link of which nothing is drawn meet the same link, so that nothing is known from the second
//! that the first did not show. Judging runs is left to others.

use std::fmt;

use crate::fault::{Again, Effect, Fault};
use crate::profile::{Delay, Loss, PathLaw, Profile};
use crate::time::LinkTime;
use crate::trace::{Step, Trace};
use crate::way::Way;

/// A part of a link that the seed draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Drawn {
    /// The levels of the delay, and how long each is held.
    Delay,
    /// When packets wait, and how long.
    Stalls,
    /// Which packets are lost.
    Losses,
    /// Which packets faults concern.
    FaultPackets,
    /// Where the traces begin, in both directions alike.
    Start,
    /// When faults come again, in both directions alike.
    FaultTimes,
}

impl Drawn {
    /// Whether each direction has draws of its own.
    #[must_use]
    pub fn is_of_each_way(self) -> bool {
        !matches!(self, Self::Start | Self::FaultTimes)
    }
}

impl fmt::Display for Drawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Delay => "the delay",
            Self::Stalls => "stalls",
            Self::Losses => "losses",
            Self::FaultPackets => "which packets faults concern",
            Self::Start => "where the trace begins",
            Self::FaultTimes => "when faults come again",
        })
    }
}

impl Profile {
    /// What the seed draws of the link before `until`, in order and each once. Without any, all seeds give one
    /// and the same link up to then, packet by packet, and repeats over it are a single draw; with any, each
    /// seed has a draw of its own, of so many that no two are equal.
    #[must_use]
    pub fn drawn(&self, until: LinkTime) -> Vec<Drawn> {
        if self.loopback {
            return Vec::new();
        }
        let mut drawn: Vec<Drawn> = Way::BOTH
            .iter()
            .flat_map(|way| of_way(self.law(*way), until.ns()))
            .collect();
        drawn.sort_unstable();
        drawn.dedup();
        drawn
    }

    /// Whether two seeds can give different links before `until`: whether repeats are more than one draw.
    #[must_use]
    pub fn varies_by_seed(&self, until: LinkTime) -> bool {
        !self.drawn(until).is_empty()
    }
}

/// What is drawn of one direction. Where it loses every packet, its delay is nobody's.
fn of_way(law: &PathLaw, until_ns: u64) -> Vec<Drawn> {
    let faults: Vec<&Fault> = law.faults.iter().filter(|f| f.at_ns < until_ns).collect();
    let is_cut =
        |fault: &&Fault| fault.at_ns == 0 && fault.for_ns >= until_ns && loses_all(fault.effect);
    if is_all_lost(law, until_ns) || faults.iter().any(is_cut) {
        return Vec::new();
    }
    let delay = match &law.delay {
        Delay::Constant { .. } => None,
        Delay::Held(_) => (law.delay.floor_ns() != law.delay.reach_ns()).then_some(Drawn::Delay),
        Delay::Trace(trace) => trace.is_drawn().then_some(Drawn::Start),
    };
    let stalls = law
        .stall
        .as_ref()
        .filter(|stall| stall.length.reach_ns() >= 1.0);
    let losses = match &law.loss {
        Loss::Never => false,
        Loss::Random { share, .. } => is_some(*share),
        Loss::GilbertElliott {
            in_good, in_bad, ..
        } => in_good != in_bad || is_some(*in_good),
        Loss::Trace { .. } => {
            let trace = law.trace();
            trace.is_some_and(|trace| has_step(trace, until_ns, |step| is_some(step.loss)))
        }
    };
    let times = faults.iter().any(|fault| comes_at_random(fault, until_ns));
    let packets = faults
        .iter()
        .any(|fault| share(fault.effect).is_some_and(is_some));
    let all = [
        delay,
        stalls.map(|_| Drawn::Stalls),
        losses.then_some(Drawn::Losses),
        packets.then_some(Drawn::FaultPackets),
        times.then_some(Drawn::FaultTimes),
    ];
    all.into_iter().flatten().collect()
}

/// Whether a share is neither none nor all.
fn is_some(share: f64) -> bool {
    share > 0.0 && share < 1.0
}

fn is_all_lost(law: &PathLaw, until_ns: u64) -> bool {
    match &law.loss {
        Loss::Never => false,
        Loss::Random { share, .. } => *share >= 1.0,
        Loss::GilbertElliott {
            in_good, in_bad, ..
        } => *in_good >= 1.0 && *in_bad >= 1.0,
        Loss::Trace { .. } => law
            .trace()
            .is_some_and(|trace| !has_step(trace, until_ns, |step| step.loss < 1.0)),
    }
}

/// Whether the link may meet such a step of the trace before `until_ns`.
fn has_step(trace: &Trace, until_ns: u64, is_it: impl Fn(&Step) -> bool) -> bool {
    if trace.is_drawn() {
        return trace.steps().iter().any(is_it);
    }
    let mut t_ns = 0;
    // One more than there are, since the first may be met in its middle and again at its end.
    for _ in 0..=trace.steps().len() {
        if t_ns >= until_ns {
            return false;
        }
        let (span_ns, step) = trace.step_at(t_ns);
        if is_it(&step) {
            return true;
        }
        t_ns = span_ns.end;
    }
    false
}

fn comes_at_random(fault: &Fault, until_ns: u64) -> bool {
    let Again::Random { every_ns } = fault.again else {
        return false;
    };
    // The first comes at a fixed time, and the others within what the spell leaves of their span.
    every_ns > fault.for_ns
        && fault.times != Some(1)
        && fault.at_ns.saturating_add(every_ns) < until_ns
        && share(fault.effect) != Some(0.0)
}

fn loses_all(effect: Effect) -> bool {
    match effect {
        Effect::Down => true,
        Effect::Loss { share } | Effect::Corrupt { share } => share >= 1.0,
        _ => false,
    }
}

/// The share of slots that an effect concerns, where it has one.
fn share(effect: Effect) -> Option<f64> {
    match effect {
        Effect::Loss { share }
        | Effect::Duplicate { share }
        | Effect::Corrupt { share }
        | Effect::Reorder { share, .. } => Some(share),
        Effect::Down | Effect::Delay { .. } | Effect::Reset | Effect::Rebind => None,
    }
}
