//! Faults that an experiment lays over its runs: `[[fault]]` as written.
//!
//! What it does to the link becomes part of the link's profile, so that players, prediction and virtual time know
//! it as everything else of the link; `link` reads its words and says when it is in force. What it does to the
//! ends is in `end_fault`. Here times count from the loop's start.

use std::borrow::Cow;
use std::collections::BTreeMap;

use endpoint::duration_ns;
use link::Profile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::cell::{Cell, START_AT};
use crate::end_fault::End;
use crate::experiment::Word;
use crate::{InvalidFile, Plan, ProfileText, Reader};

/// The faults that every experiment knows by name.
const BUILT_IN: &str = include_str!("../faults.toml");

/// The word for no fault.
const NONE: &str = "none";

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
}

/// When something of a fault holds, in ns after the loop's start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaultSpell {
    /// When it begins.
    pub from_ns: u64,
    /// When it ends.
    pub to_ns: u64,
    /// What it does: by its word in a profile, such as `down`, or to an end, such as `plant frozen`.
    pub word: &'static str,
}

impl FaultEvent {
    /// The same event on link time, as a table of a profile.
    fn in_profile(&self) -> Result<String, String> {
        let at_ns = duration_ns(&self.at).map_err(|problem| format!("`at`: {problem}"))?;
        let event = FaultEvent {
            // In a unit that a profile knows; exact for any that a person writes.
            at: format!("{}ms", at_ns.saturating_add(START_AT.ns()) as f64 / 1e6),
            ..self.clone()
        };
        let table = toml::to_string(&event).map_err(|problem| problem.to_string())?;
        Ok(format!("\n[[fault]]\n{table}"))
    }

    /// Whether it does something to the link.
    pub(crate) fn is_of_link(&self) -> bool {
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
}

/// A link without anything but these faults, whose times count from the loop's start.
pub(crate) fn profile_of(events: &[FaultEvent]) -> Result<Profile, String> {
    let mut text = ProfileText {
        source: EMPTY.to_owned(),
        ..ProfileText::default()
    };
    for event in events {
        text.source += &event.in_profile()?;
    }
    text.profile("empty").map_err(|findings| {
        let first = findings.first();
        first.map_or_else(String::new, |first| first.message.clone())
    })
}

impl Fault {
    /// The built-in faults.
    fn built_in() -> Result<Vec<Fault>, toml::de::Error> {
        #[derive(Deserialize)]
        struct File {
            fault: Vec<Fault>,
        }
        toml::from_str::<File>(BUILT_IN).map(|file| file.fault)
    }

    /// Checks every event, as the link reads it.
    fn check(&self) -> Result<(), String> {
        if self.event.is_empty() {
            return Err("it has no [[fault.event]]".to_owned());
        }
        for (number, event) in self.event.iter().enumerate() {
            let place = |problem: String| format!("its event {}: {problem}", number + 1);
            let event = match event.of_end().map_err(place)? {
                Some(_) => event.times_only(),
                None => event.clone(),
            };
            profile_of(&[event]).map_err(place)?;
        }
        Ok(())
    }

    /// Its events that do something to the link.
    fn of_link(&self) -> impl Iterator<Item = &FaultEvent> {
        self.event.iter().filter(|event| event.is_of_link())
    }

    /// The profile with the fault.
    fn over(&self, profile: &ProfileText) -> Result<ProfileText, String> {
        let mut text = profile.clone();
        for event in self.of_link() {
            text.source += &event.in_profile()?;
        }
        Ok(text)
    }
}

/// A link without anything, to check the link's part of a fault by.
const EMPTY: &str = "name = \"empty\"\nabout = \"Nothing.\"\n[both.delay]\nbase = \"1ms\"\n";

impl Plan {
    /// The profile of a cell's link, with what its fault does to the link; `None` if the plan has no such
    /// profile.
    #[must_use]
    pub fn profile(&self, cell: &Cell) -> Option<Cow<'_, ProfileText>> {
        let text = self.profiles.get(&cell.topology)?;
        match self.fault(cell) {
            Some(fault) => fault.over(text).ok().map(Cow::Owned),
            None => Some(Cow::Borrowed(text)),
        }
    }

    /// The fault that a cell's run meets.
    #[must_use]
    pub fn fault(&self, cell: &Cell) -> Option<&Fault> {
        self.faults.get(cell.fault.as_ref()?)
    }

    /// When a cell's fault is in force, in order, in ns after the loop's start, with those that the
    /// profile has itself and those of the ends; empty without one.
    #[must_use]
    pub fn fault_spells(&self, cell: &Cell) -> Vec<FaultSpell> {
        let text = cell.fault.as_ref().and_then(|_| self.profile(cell));
        let Some(profile) = text.and_then(|text| text.profile(&cell.topology).ok()) else {
            return Vec::new();
        };
        let end = START_AT.after(cell.duration_ns);
        let mut spells: Vec<FaultSpell> = profile
            .faults(cell.link_seed, START_AT, end)
            .iter()
            .map(|spell| FaultSpell {
                from_ns: spell.start.ns().saturating_sub(START_AT.ns()),
                to_ns: spell.end.ns().saturating_sub(START_AT.ns()),
                word: spell.word,
            })
            .collect();
        spells.extend(self.end_faults(cell).iter().map(|fault| FaultSpell {
            from_ns: fault.from_ns,
            to_ns: fault.to_ns,
            word: fault.words(),
        }));
        spells.sort_by_key(|spell| (spell.from_ns, spell.to_ns));
        // One of both directions is told once.
        spells.dedup();
        spells
    }

    /// Checks the faults of a plan that comes from a file.
    pub(crate) fn check_faults(&self) -> Result<(), String> {
        for (name, fault) in &self.faults {
            if fault.name != *name {
                return Err(format!(
                    "its fault `{}` calls itself `{}`",
                    name.escape_debug(),
                    fault.name.escape_debug()
                ));
            }
            fault
                .check()
                .map_err(|problem| format!("its fault `{}`: {problem}", name.escape_debug()))?;
        }
        for cell in &self.cells {
            if let Some(name) = &cell.fault
                && !self.faults.contains_key(name)
            {
                let name = name.escape_debug();
                return Err(format!("cell {}: there is no fault `{name}`", cell.index));
            }
            self.check_link_of(cell)?;
            self.check_end_faults(cell)
                .map_err(|problem| format!("cell {}: {problem}", cell.index))?;
        }
        Ok(())
    }

    /// A fault of the link needs a link.
    fn check_link_of(&self, cell: &Cell) -> Result<(), String> {
        let Some(fault) = self.fault(cell) else {
            return Ok(());
        };
        if fault.of_link().next().is_some() && self.is_loopback(&cell.topology) {
            return Err(format!(
                "cell {}: the fault `{}` needs a link, and on {} there is none",
                cell.index, fault.name, cell.topology
            ));
        }
        Ok(())
    }
}

impl Reader<'_> {
    /// The faults that an experiment may name: its own and the built-in ones.
    pub(crate) fn faults(
        &self,
        written: &[Spanned<Fault>],
    ) -> Result<BTreeMap<String, Fault>, InvalidFile> {
        // The built-in ones are checked by a test.
        let built_in = Fault::built_in().unwrap_or_default();
        let mut known: BTreeMap<String, Fault> = built_in
            .into_iter()
            .map(|fault| (fault.name.clone(), fault))
            .collect();
        for written in written {
            let fault = written.get_ref();
            let name = &fault.name;
            let refuse = |problem: String| {
                let remedy = "docs/faults.md has examples";
                Err(self.invalid(written, format!("the fault `{name}`: {problem}"), remedy))
            };
            if !system::is_name(name) || name == NONE {
                return refuse("its name is not up to 40 of a-z, 0-9 and -".to_owned());
            }
            if let Err(problem) = fault.check() {
                return refuse(problem);
            }
            if known.insert(name.clone(), fault.clone()).is_some() {
                return refuse("there is another fault of this name".to_owned());
            }
        }
        Ok(known)
    }

    /// The fault that a word names, which is kept in the plan; `None` for none.
    pub(crate) fn fault(
        &self,
        word: &Word,
        known: &BTreeMap<String, Fault>,
        plan: &mut Plan,
    ) -> Result<Option<String>, InvalidFile> {
        let name = word.get_ref();
        if name == NONE {
            return Ok(None);
        }
        let Some(fault) = known.get(name) else {
            let names: Vec<&str> = known.keys().map(String::as_str).collect();
            let remedy = format!(
                "use {NONE} or one of {}, or describe your own in [[fault]]",
                names.join(", ")
            );
            return Err(self.invalid(word, format!("there is no fault `{name}`"), &remedy));
        };
        plan.faults.insert(name.clone(), fault.clone());
        Ok(Some(name.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(text: &str) -> FaultEvent {
        toml::from_str(text).expect("an event")
    }

    #[test]
    fn every_built_in_fault_is_sound_and_has_words() {
        let faults = Fault::built_in().expect("TOML");
        assert!(faults.len() >= 11);
        for fault in faults {
            assert_eq!(fault.check(), Ok(()), "{}", fault.name);
            assert!(
                system::is_name(&fault.name) && !fault.about.is_empty(),
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
            assert!(problem.contains(words), "{text}: {problem}");
        }
    }
}
