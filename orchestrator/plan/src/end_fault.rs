//! Faults of the loop's two ends: a process stands still, gets less of its processor, or is killed and started
//! again.
//!
//! An end's fault is no part of the link's profile. But its instants follow the words and the seed of the link's
//! faults, so `link` draws them too. Who stops and kills processes is in `backend` and `agent`; virtual time lets
//! an end wait.

use std::fmt;
use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cell::{Cell, START_AT};
use crate::fault::{FaultEvent, profile_of};
use crate::{Client, Plan};

/// An end of the loop.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The process of the controller, with all that it has started: a browser's processes, or a program of one's
    /// own.
    Controller,
    /// The process of the plant.
    Plant,
}

impl End {
    /// Both.
    pub const BOTH: [End; 2] = [End::Controller, End::Plant];
}

impl fmt::Display for End {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            End::Controller => "controller",
            End::Plant => "plant",
        })
    }
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
    /// killed.
    #[must_use]
    pub fn stops(&self, start_ns: u64) -> Vec<Range<u64>> {
        let (every_ns, share) = match self.effect {
            EndEffect::Freeze => (u64::MAX, 1.0),
            EndEffect::Starve(share) => (STARVED_NS, share),
            EndEffect::Kill => return Vec::new(),
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
    /// How long the end stood still in all, ns; for a killed one, all of that time.
    pub stood_ns: u64,
}

impl EndFaultDone {
    /// Whether whoever looks at the end at this instant may see it stopped. A look takes some time.
    #[must_use]
    pub fn shows_at(&self, t_ns: u64) -> bool {
        const LOOK_NS: u64 = 5_000_000;
        (self.from_ns..self.to_ns.saturating_add(LOOK_NS)).contains(&t_ns)
    }
}

impl FaultEvent {
    /// The end that the event hits, with what happens to it; `None` if it is one of the link.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub(crate) fn of_end(&self) -> Result<Option<(End, EndEffect)>, String> {
        let share = || match &self.share {
            Some(text) => percent(text),
            None => {
                Err("`starve` needs a `share` such as \"70%\": how much is taken away".to_owned())
            }
        };
        let mut effects = Vec::new();
        effects.extend(self.freeze.map(|end| (end, EndEffect::Freeze)));
        effects.extend(self.kill.map(|end| (end, EndEffect::Kill)));
        if let Some(end) = self.starve {
            effects.push((end, EndEffect::Starve(share()?)));
        } else if self.share.is_some() {
            return Err("`share` without `starve`: drop it".to_owned());
        }
        let Some(effect) = effects.pop() else {
            return Ok(None);
        };
        if !effects.is_empty() || self.is_of_link() {
            return Err(
                "an event has one effect, and this one has more: write two events".to_owned(),
            );
        }
        if self.way.is_some() {
            return Err("`way` is of the link, and this event hits an end: drop it".to_owned());
        }
        Ok(Some(effect))
    }

    /// The same times as a fault of a link, to draw them by.
    pub(crate) fn times_only(&self) -> FaultEvent {
        FaultEvent {
            at: self.at.clone(),
            lasts: self.lasts.clone(),
            every: self.every.clone(),
            period: self.period.clone(),
            times: self.times,
            down: Some(true),
            ..FaultEvent::default()
        }
    }
}

/// A share of 1 to 99 % from its text.
fn percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').and_then(|text| text.parse().ok());
    match number {
        Some(percent @ 1.0..=99.0) => Ok(percent / 100.0),
        _ => Err(format!(
            "`share` is `{}`; write 1% to 99%: all of it is `freeze`",
            text.escape_debug()
        )),
    }
}

impl Plan {
    /// What a cell's fault does to the ends, in order of its beginning, within the loop's duration; empty
    /// without one.
    #[must_use]
    pub fn end_faults(&self, cell: &Cell) -> Vec<EndFault> {
        let events = self.fault(cell).map_or(&[][..], |fault| &fault.event);
        let end = START_AT.after(cell.duration_ns);
        let mut found = Vec::new();
        // A fault's draws follow from its number in its profile. So that no two events come at the same random
        // instants, as many faults of another word are before each.
        let mut before = Vec::new();
        for event in events {
            let Ok(Some((of, effect))) = event.of_end() else {
                continue;
            };
            let times = event.times_only();
            before.push(times);
            let Ok(profile) = profile_of(&before) else {
                continue;
            };
            for event in &mut before {
                (event.down, event.reset) = (None, Some(true));
            }
            let spells = profile.faults(cell.link_seed, START_AT, end);
            // One of both directions is told twice.
            let own =
                |spell: &&link::FaultSpell| spell.word == "down" && spell.way == link::Way::Up;
            let spells = spells.iter().filter(own);
            found.extend(spells.map(|spell| EndFault {
                end: of,
                effect,
                from_ns: spell.start.ns().saturating_sub(START_AT.ns()),
                to_ns: spell.end.ns().saturating_sub(START_AT.ns()),
            }));
        }
        found.sort_by_key(|fault| (fault.from_ns, fault.to_ns));
        found
    }

    /// Checks what a cell's fault does to the ends: an end has one fault at a time, and one that is killed is
    /// started again before the loop ends.
    pub(crate) fn check_end_faults(&self, cell: &Cell) -> Result<(), String> {
        let all = self.end_faults(cell);
        for end in End::BOTH {
            let mut free_ns = 0;
            for fault in all.iter().filter(|fault| fault.end == end) {
                let s = fault.from_ns as f64 / 1e9;
                if fault.from_ns < free_ns {
                    return Err(format!(
                        "its fault hits the {end} at {s} s, while an earlier event still does: write them apart"
                    ));
                }
                free_ns = fault.to_ns;
                if fault.to_ns >= cell.duration_ns {
                    return Err(format!(
                        "its fault hits the {end} at {s} s until {} s, and the loop ends at {} s: let it be over \
                         before",
                        fault.to_ns as f64 / 1e9,
                        cell.duration_ns as f64 / 1e9
                    ));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_end(text: &str) -> Result<Option<(End, EndEffect)>, String> {
        toml::from_str::<FaultEvent>(text)
            .expect("an event")
            .of_end()
    }

    #[test]
    fn an_event_hits_the_link_or_one_end_once() {
        let at = "at = \"1s\"\nfor = \"1s\"\n";
        let event = |line: &str| of_end(&format!("{at}{line}"));
        assert_eq!(event("down = true"), Ok(None));
        assert_eq!(
            event("freeze = \"plant\""),
            Ok(Some((End::Plant, EndEffect::Freeze)))
        );
        assert_eq!(
            event("starve = \"controller\"\nshare = \"70%\""),
            Ok(Some((End::Controller, EndEffect::Starve(0.7))))
        );
        for (line, words) in [
            ("starve = \"plant\"", "needs a `share`"),
            ("starve = \"plant\"\nshare = \"100%\"", "`freeze`"),
            ("freeze = \"plant\"\nshare = \"10%\"", "without `starve`"),
            ("freeze = \"plant\"\ndown = true", "one effect"),
            ("freeze = \"plant\"\nkill = \"plant\"", "one effect"),
            ("freeze = \"plant\"\nway = \"up\"", "`way`"),
        ] {
            let problem = event(line).expect_err(line);
            assert!(problem.contains(words), "{line}: {problem}");
        }
    }

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
