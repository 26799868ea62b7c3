//! Faults that an experiment lays over its runs: `[[fault]]` as written.
//!
//! What it does to the link becomes part of the link's profile, so that players, prediction and virtual time know
//! it as everything else of the link; `link` reads its words and says when it is in force. What it does to the
//! ends is in `end_fault`, and which cells of a plan it hits, in `faults`. Here times count from the loop's start.

use link::Profile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::{WEEK_NS, duration_ns};

use crate::bad_fault::BadFault;
use crate::cell::START_AT;
use crate::end_fault::{End, EndEffect};
use crate::profile_text::ProfileText;

/// The faults that every experiment knows by name.
const BUILT_IN: &str = include_str!("../faults.toml");

/// A fault, as written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Its name, for `fault` in a block, in tables and folders: up to 40 of a-z, 0-9 and -.
    pub name: String,
    /// One sentence on what happens.
    #[serde(default)]
    pub about: String,
    /// What happens, and when.
    pub event: Vec<FaultEvent>,
}

/// One event of a fault, as written: when, and exactly one thing that happens.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FaultEvent {
    /// When it begins, after the loop's start, such as "2s".
    pub at: String,
    /// How long it lasts.
    #[serde(rename = "for", skip_serializing_if = "String::is_empty")]
    pub lasts: String,
    /// It happens again, at a random instant of each further time of this length, by the link's seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<String>,
    /// It happens again, exactly so often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<String>,
    /// At most so many times; until the end, if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<u32>,
    /// Of the link: the direction, up or down; both, if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub way: Option<String>,
    /// The link loses every packet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub down: Option<bool>,
    /// The link takes so much longer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay: Option<String>,
    /// The link loses the packets of so many milliseconds, such as "30%".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loss: Option<String>,
    /// The packets of so many milliseconds come out twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duplicate: Option<String>,
    /// The packets of so many milliseconds are overtaken by others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reorder: Option<String>,
    /// With `reorder`: how long they are held back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// A bit is wrong in the packets of so many milliseconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrupt: Option<String>,
    /// TCP connections are reset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reset: Option<bool>,
    /// The controller's ports change, as behind a NAT that forgot them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rebind: Option<bool>,
    /// This end's process stands still, with all its descendants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub freeze: Option<End>,
    /// This end's process stands still for `share` of each 10 ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starve: Option<End>,
    /// With `starve`: how much is taken away, such as "70%".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<String>,
    /// This end's process is killed at the beginning, and started again at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kill: Option<End>,
    /// So many programs compute without end on the machine of both ends, as ordinary ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub busy: Option<u16>,
}

/// The most programs that a fault lets compute.
const MOST_BUSY: u16 = 256;

impl FaultEvent {
    /// The same event on link time, as a table of a profile.
    fn in_profile(&self) -> Result<String, BadFault> {
        let at_ns = duration_ns(&self.at, 1..=WEEK_NS).map_err(BadFault::At)?;
        let event = FaultEvent {
            // In a unit that a profile knows; exact for any that a person writes.
            at: format!("{}ms", at_ns.saturating_add(START_AT.ns()) as f64 / 1e6),
            ..self.clone()
        };
        let table =
            toml::to_string(&event).map_err(|problem| BadFault::Link(problem.to_string()))?;
        Ok(format!("\n[[fault]]\n{table}"))
    }

    /// Whether it does something to the link.
    fn is_of_link(&self) -> bool {
        let words = [
            &self.delay,
            &self.loss,
            &self.duplicate,
            &self.reorder,
            &self.corrupt,
        ];
        let switches = [self.down, self.reset, self.rebind];
        words.iter().any(|word| word.is_some()) || switches.iter().any(Option::is_some)
    }

    /// The ends that the event hits, with what happens to them; empty if it is one of the link.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub(crate) fn of_ends(&self) -> Result<Vec<(End, EndEffect)>, BadFault> {
        let share = || match &self.share {
            Some(text) => percent(text),
            None => Err(BadFault::NoShare),
        };
        let mut effects = Vec::new();
        effects.extend(self.freeze.map(|end| vec![(end, EndEffect::Freeze)]));
        effects.extend(self.kill.map(|end| vec![(end, EndEffect::Kill)]));
        if let Some(programs) = self.busy {
            if !(1..=MOST_BUSY).contains(&programs) {
                return Err(BadFault::Busy(programs, MOST_BUSY));
            }
            let both = End::BOTH.map(|end| (end, EndEffect::Busy(programs)));
            effects.push(both.into());
        }
        if let Some(end) = self.starve {
            effects.push(vec![(end, EndEffect::Starve(share()?))]);
        } else if self.share.is_some() {
            return Err(BadFault::ShareAlone);
        }
        let Some(effect) = effects.pop() else {
            return Ok(Vec::new());
        };
        if !effects.is_empty() || self.is_of_link() {
            return Err(BadFault::Effects);
        }
        if self.way.is_some() {
            return Err(BadFault::WayOfEnd);
        }
        Ok(effect)
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
fn percent(text: &str) -> Result<f64, BadFault> {
    let number = text.strip_suffix('%').and_then(|text| text.parse().ok());
    match number {
        Some(percent @ 1.0..=99.0) => Ok(percent / 100.0),
        _ => Err(BadFault::Share(text.to_owned())),
    }
}

/// A link without anything but these faults, whose times count from the loop's start.
pub(crate) fn profile_of(events: &[FaultEvent]) -> Result<Profile, BadFault> {
    let mut text = ProfileText {
        source: EMPTY.to_owned(),
        ..ProfileText::default()
    };
    for event in events {
        text.source += &event.in_profile()?;
    }
    text.profile("empty").map_err(|findings| {
        let first = findings.first();
        BadFault::Link(first.map_or_else(String::new, |first| first.problem.clone()))
    })
}

impl Fault {
    /// The built-in faults.
    pub(crate) fn built_in() -> Result<Vec<Fault>, toml::de::Error> {
        #[derive(Deserialize)]
        struct File {
            fault: Vec<Fault>,
        }
        toml::from_str::<File>(BUILT_IN).map(|file| file.fault)
    }

    /// Checks every event, as the link reads it.
    pub(crate) fn check(&self) -> Result<(), BadFault> {
        if self.event.is_empty() {
            return Err(BadFault::NoEvent);
        }
        for (number, event) in self.event.iter().enumerate() {
            let place = |problem| BadFault::Event {
                number: number + 1,
                problem: Box::new(problem),
            };
            let is_of_ends = !event.of_ends().map_err(place)?.is_empty();
            let event = if is_of_ends {
                event.times_only()
            } else {
                event.clone()
            };
            profile_of(&[event]).map_err(place)?;
        }
        Ok(())
    }

    /// Its events that do something to the link.
    pub(crate) fn of_link(&self) -> impl Iterator<Item = &FaultEvent> {
        self.event.iter().filter(|event| event.is_of_link())
    }

    /// The profile with the fault.
    pub(crate) fn over(&self, profile: &ProfileText) -> Result<ProfileText, BadFault> {
        let mut text = profile.clone();
        for event in self.of_link() {
            text.source += &event.in_profile()?;
        }
        Ok(text)
    }
}

/// A link without anything, to check the link's part of a fault by.
const EMPTY: &str = "name = \"empty\"\nabout = \"Nothing.\"\n[both.delay]\nbase = \"1ms\"\n";

#[cfg(test)]
mod tests {
    use super::*;

    fn event(text: &str) -> FaultEvent {
        toml::from_str(text).expect("an event")
    }

    fn of_ends(text: &str) -> Result<Vec<(End, EndEffect)>, BadFault> {
        event(text).of_ends()
    }

    #[test]
    fn an_event_hits_the_link_or_one_end_once() {
        let at = "at = \"1s\"\nfor = \"1s\"\n";
        let event = |line: &str| of_ends(&format!("{at}{line}"));
        assert_eq!(event("down = true"), Ok(Vec::new()));
        assert_eq!(
            event("freeze = \"plant\""),
            Ok(vec![(End::Plant, EndEffect::Freeze)])
        );
        assert_eq!(
            event("starve = \"controller\"\nshare = \"70%\""),
            Ok(vec![(End::Controller, EndEffect::Starve(0.7))])
        );
        // Both ends are on the machine that is busy.
        assert_eq!(
            event("busy = 4"),
            Ok(End::BOTH.map(|end| (end, EndEffect::Busy(4))).into())
        );
        for (line, words) in [
            ("starve = \"plant\"", "needs a `share`"),
            ("starve = \"plant\"\nshare = \"100%\"", "`freeze`"),
            ("freeze = \"plant\"\nshare = \"10%\"", "without `starve`"),
            ("freeze = \"plant\"\ndown = true", "one effect"),
            ("freeze = \"plant\"\nkill = \"plant\"", "one effect"),
            ("freeze = \"plant\"\nway = \"up\"", "`way`"),
            ("busy = 0", "`busy` is 0"),
            ("busy = 1\nkill = \"plant\"", "one effect"),
        ] {
            let problem = event(line).expect_err(line);
            assert!(problem.to_string().contains(words), "{line}: {problem}");
        }
    }

    #[test]
    fn every_built_in_fault_is_sound_and_has_words() {
        let faults = Fault::built_in().expect("TOML");
        assert!(faults.len() >= 11);
        for fault in faults {
            assert_eq!(fault.check(), Ok(()), "{}", fault.name);
            assert!(
                text::is_name(&fault.name) && !fault.about.is_empty(),
                "{}",
                fault.name
            );
        }
    }

    #[test]
    fn an_event_that_does_not_make_sense_is_refused_with_what_is_wrong() {
        for (text, words) in [
            ("at = \"1s\"\ndown = true", "for"),
            ("at = \"x\"\nfor = \"1s\"\ndown = true", "`at`"),
            ("at = \"1s\"\nfor = \"1s\"", "needs an effect"),
            ("at = \"1s\"\nfor = \"1s\"\nloss = \"130%\"", "130%"),
        ] {
            let fault = Fault {
                name: "mine".to_owned(),
                about: String::new(),
                event: vec![event(text)],
            };
            let problem = fault.check().expect_err(text);
            assert!(problem.to_string().contains(words), "{text}: {problem}");
        }
    }
}
