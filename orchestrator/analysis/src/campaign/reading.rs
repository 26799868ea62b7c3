//! A results folder that is read cell by cell, and what its cells share: links and systems, each read once.

use std::collections::BTreeMap;
use std::path::Path;

use link::Profile;
use plan::system::System;
use plan::{Cell, Plan, ProfileText};
use record::Manifest;
use record::whole::Medium;

use super::Run;
use super::cell::Known;
use crate::metrics::Metrics;
use crate::parallel;
use crate::summary::LinkFacts;

/// A folder whose runs are read one after the other, and what they share.
pub(super) struct Reading<'a> {
    folder: &'a Path,
    plan: &'a Plan,
    links: Links,
    systems: Systems,
    /// The back-end of the first run that has a manifest.
    backend: Option<String>,
    fresh: &'a Fresh,
}

/// Metrics of cells that this process has just run, by the cell's index: it had their rows in memory, and nobody else
/// could write their files.
pub type Fresh = BTreeMap<usize, Metrics>;

impl<'a> Reading<'a> {
    pub(super) fn new(folder: &'a Path, plan: &'a Plan, fresh: &'a Fresh) -> Reading<'a> {
        let read = |cell: &Cell| Manifest::read(&folder.join(cell.folder()));
        let first = plan.cells.iter().find_map(|cell| read(cell).ok().flatten());
        Reading {
            folder,
            plan,
            links: Links::of(plan),
            systems: Systems::of(plan),
            backend: first.map(|first| first.backend),
            fresh,
        }
    }

    pub(super) fn run(&self, cell: &Cell) -> Run {
        let known = Known {
            backend: self.backend.as_deref(),
            medium: self.links.medium(cell),
            link: self.links.facts(cell),
            system: self.systems.0.get(&cell.system),
            fresh: self.fresh.get(&cell.index),
        };
        Run::of(self.folder, self.plan, cell, known)
    }
}

/// The profiles of a plan, each played once over a long time for its link facts.
struct Links(BTreeMap<String, (Profile, LinkFacts)>);

impl Links {
    fn of(plan: &Plan) -> Links {
        let profiles: Vec<(&String, &ProfileText)> = plan.profiles.iter().collect();
        let links = parallel::each(&profiles, |(name, text)| {
            let profile = text.profile(name).ok()?;
            let facts = LinkFacts::of(&profile);
            Some(((*name).clone(), (profile, facts)))
        });
        Links(links.into_iter().flatten().collect())
    }

    fn medium(&self, cell: &Cell) -> Medium {
        match self.0.get(&cell.topology) {
            Some((profile, _)) if profile.is_loopback() => Medium::Loopback,
            _ => Medium::Link,
        }
    }

    fn facts(&self, cell: &Cell) -> LinkFacts {
        let link = self.0.get(&cell.topology);
        link.map_or_else(LinkFacts::default, |(profile, facts)| {
            facts.in_run(profile, cell)
        })
    }
}

/// The systems of a plan by name, each read once.
struct Systems(BTreeMap<String, System>);

impl Systems {
    fn of(plan: &Plan) -> Systems {
        let mut systems = BTreeMap::new();
        for cell in &plan.cells {
            if !systems.contains_key(&cell.system)
                && let Ok(system) = plan.system(cell)
            {
                systems.insert(cell.system.clone(), system);
            }
        }
        Systems(systems)
    }
}
