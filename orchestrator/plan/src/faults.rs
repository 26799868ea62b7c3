//! What the faults of a plan do to its cells: to a cell's link, to its ends, and when.
//!
//! `fault` and `end_fault` have the faults themselves. Times count from the loop's start.

use std::borrow::Cow;
use std::collections::BTreeMap;

use text::Diagnostic;
use toml::Spanned;

use crate::cell::{Cell, START_AT};
use crate::end_fault::{End, EndEffect, EndFault};
use crate::fault::{Fault, profile_of};
use crate::invalid::{Reader, Word};
use crate::plan::Plan;
use crate::profile_text::ProfileText;
use crate::unsound::{Unsound, UnsoundName};

/// The word for no fault.
const NONE: &str = "none";

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
    pub(crate) fn check_faults(&self) -> Result<(), Unsound> {
        for (name, fault) in &self.faults {
            if fault.name != *name {
                return Err(Unsound::Called {
                    what: "fault",
                    name: name.escape_debug().to_string(),
                    own: fault.name.escape_debug().to_string(),
                });
            }
            fault.check().map_err(|problem| Unsound::Fault {
                name: name.escape_debug().to_string(),
                problem,
            })?;
        }
        for cell in &self.cells {
            self.check_fault_of(cell)
                .map_err(|problem| Unsound::Named {
                    index: cell.index,
                    problem,
                })?;
        }
        Ok(())
    }

    /// The fault that a cell names is there, and one of the link has a link.
    fn check_fault_of(&self, cell: &Cell) -> Result<(), UnsoundName> {
        if let Some(name) = &cell.fault
            && !self.faults.contains_key(name)
        {
            return Err(UnsoundName::Fault(name.escape_debug().to_string()));
        }
        if let Some(fault) = self.fault(cell)
            && fault.of_link().next().is_some()
            && self.is_loopback(&cell.topology)
        {
            return Err(UnsoundName::Linkless {
                fault: fault.name.clone(),
                topology: cell.topology.clone(),
            });
        }
        self.check_end_faults(cell)
    }

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
            let hits = event.of_ends().unwrap_or_default();
            if hits.is_empty() {
                continue;
            }
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
            for spell in spells.iter().filter(own) {
                found.extend(hits.iter().map(|(end, effect)| EndFault {
                    end: *end,
                    effect: *effect,
                    from_ns: spell.start.ns().saturating_sub(START_AT.ns()),
                    to_ns: spell.end.ns().saturating_sub(START_AT.ns()),
                }));
            }
        }
        found.sort_by_key(|fault| (fault.from_ns, fault.to_ns));
        found
    }

    /// Checks what a cell's fault does to the ends: an end has one fault at a time, and one that is killed is
    /// started again before the loop ends.
    fn check_end_faults(&self, cell: &Cell) -> Result<(), UnsoundName> {
        let all = self.end_faults(cell);
        for end in End::BOTH {
            let mut free_ns = 0;
            for fault in all.iter().filter(|fault| fault.end == end) {
                let at_s = fault.from_ns as f64 / 1e9;
                if fault.from_ns < free_ns {
                    return Err(UnsoundName::Overlap { end, at_s });
                }
                free_ns = fault.to_ns;
                // A load ends with its loop.
                let may_outlast = matches!(fault.effect, EndEffect::Busy(_));
                if fault.to_ns >= cell.duration_ns && !may_outlast {
                    return Err(UnsoundName::Outlasts {
                        end,
                        at_s,
                        until_s: fault.to_ns as f64 / 1e9,
                        ends_s: cell.duration_ns as f64 / 1e9,
                    });
                }
            }
        }
        Ok(())
    }
}

impl Reader<'_> {
    /// The faults that an experiment may name: its own and the built-in ones.
    pub(crate) fn faults(
        &self,
        written: &[Spanned<Fault>],
    ) -> Result<BTreeMap<String, Fault>, Diagnostic> {
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
                let remedy = "the book's page Faults has examples";
                Err(self.invalid(written, format!("the fault `{name}`: {problem}"), remedy))
            };
            if !text::is_name(name) || name == NONE {
                return refuse("its name is not up to 40 of a-z, 0-9 and -".to_owned());
            }
            if let Err(problem) = fault.check() {
                return refuse(problem.to_string());
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
    ) -> Result<Option<String>, Diagnostic> {
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
