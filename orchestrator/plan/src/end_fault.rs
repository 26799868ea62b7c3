//! Faults of the loop's two ends: a process stands still, gets less of its processor, is killed and started again, or
//! shares its machine with programs that compute without end.
//!
//! An end's fault is no part of the link's profile. But its instants follow the words and the seed of the link's
//! faults, so `link` draws them too: `fault` reads the words, and `faults` draws the instants. Who stops and kills
//! processes is in `backend` and `agent`; virtual time lets an end wait.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::client::Client;

text::choice!(
    /// An end of the loop.
    End, "end", {
        /// The process of the controller, with all that it has started: a browser's processes, or a program of one's
        /// own.
        Controller = "controller",
        /// The process of the plant.
        Plant = "plant",
    }
);

impl End {
    /// Both.
    pub const BOTH: [End; 2] = [End::Controller, End::Plant];
}

/// What a fault does to an end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EndEffect {
    /// It stands still.
    Freeze,
    /// It stands still for this share of each [`STARVED_NS`], 0 to 1.
    Starve(f64),
    /// It is killed at the beginning, and started again at the end.
    Kill,
    /// So many other programs compute on its machine without end. Both ends are on one, so it hits both.
    Busy(u16),
}

/// A starved end stands still for a share of each such time, ns, as under `cpulimit`.
pub const STARVED_NS: u64 = 10_000_000;

/// One spell of a fault of an end, in ns after the loop's start.
#[derive(Debug, Clone, PartialEq)]
pub struct EndFault {
    /// The end.
    pub end: End,
    /// What happens to it.
    pub effect: EndEffect,
    /// When it begins.
    pub from_ns: u64,
    /// When it is over; a killed end is started then.
    pub to_ns: u64,
}

impl EndFault {
    /// The times at which the end stands still, in order, ns, in a loop that starts at `start_ns`; none if it is
    /// killed, or only has to share.
    #[must_use]
    pub fn stops(&self, start_ns: u64) -> Vec<Range<u64>> {
        let (every_ns, share) = match self.effect {
            EndEffect::Freeze => (u64::MAX, 1.0),
            EndEffect::Starve(share) => (STARVED_NS, share),
            EndEffect::Kill | EndEffect::Busy(_) => return Vec::new(),
        };
        let stop_ns = (share * every_ns as f64) as u64;
        let [from_ns, to_ns] = [self.from_ns, self.to_ns].map(|ns| start_ns + ns);
        let begins = (from_ns..to_ns).step_by(usize::try_from(every_ns).unwrap_or(usize::MAX));
        begins
            .map(|from_ns| from_ns..from_ns.saturating_add(stop_ns).min(to_ns))
            .collect()
    }

    /// Why these faults of the ends cannot be done to a client and its plant; `None` if they can.
    #[must_use]
    pub fn undoable(faults: &[EndFault], client: &Client) -> Option<String> {
        let is_killed = |end| {
            faults
                .iter()
                .any(|fault| fault.end == end && fault.effect == EndEffect::Kill)
        };
        let knows_again = matches!(client, Client::Native | Client::Python);
        let is_page = client.spec().engine.is_some();
        if is_killed(End::Controller) && !knows_again {
            return Some(format!(
                "the fault kills the controller, and only native and python go on where they were killed, not {client}"
            ));
        }
        if is_killed(End::Plant) && is_page {
            return Some(format!(
                "the fault kills the plant, and with it the session of the page in {client}, which begins no other"
            ));
        }
        None
    }

    /// What happens, in two words.
    #[must_use]
    pub fn words(&self) -> &'static str {
        match (self.end, self.effect) {
            (End::Controller, EndEffect::Freeze) => "controller frozen",
            (End::Controller, EndEffect::Starve(_)) => "controller starved",
            (End::Controller, EndEffect::Kill) => "controller killed",
            (End::Plant, EndEffect::Freeze) => "plant frozen",
            (End::Plant, EndEffect::Starve(_)) => "plant starved",
            (End::Plant, EndEffect::Kill) => "plant killed",
            (_, EndEffect::Busy(_)) => "machine busy",
        }
    }
}

/// A fault of an end as it was done, for a run's manifest. Times are ns on the monotonic clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EndFaultDone {
    /// The end.
    pub end: End,
    /// What happened to it.
    pub effect: EndEffect,
    /// When it was to begin.
    pub asked_from_ns: u64,
    /// When it was to be over.
    pub asked_to_ns: u64,
    /// When it began: the first stop, or the kill.
    pub from_ns: u64,
    /// When it was over: the end goes on, or is ready again.
    pub to_ns: u64,
    /// How long the end stood still in all, ns; all of that time for one that is killed, or shares its machine.
    pub stood_ns: u64,
}

impl EndFaultDone {
    /// Whether whoever looks at the end at this instant may see it stopped. A look takes some time.
    #[must_use]
    pub fn shows_at(&self, t_ns: u64) -> bool {
        const LOOK_NS: u64 = 5_000_000;
        // An end that only has to share is not stopped by that.
        let is_stopped = !matches!(self.effect, EndEffect::Busy(_));
        is_stopped && (self.from_ns..self.to_ns.saturating_add(LOOK_NS)).contains(&t_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_starved_end_stands_still_for_its_share_of_each_ten_milliseconds() {
        let fault = EndFault {
            end: End::Plant,
            effect: EndEffect::Starve(0.7),
            from_ns: 900_000_000,
            to_ns: 925_000_000,
        };
        let ms = |range: &Range<u64>| [range.start / 1_000_000, range.end / 1_000_000];
        let stops: Vec<[u64; 2]> = fault.stops(100_000_000).iter().map(ms).collect();
        assert_eq!(stops, [[1000, 1007], [1010, 1017], [1020, 1025]]);
    }
}
