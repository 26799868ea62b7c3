//! Where a table or a figure came from, in one line: how many runs of how many planned, how long,
//! with which seed, by which back-end and player.

use std::collections::BTreeSet;

use analysis::{Campaign, Run};
use endpoint::Mode;

use crate::group::Group;

/// The runs from which a table or a figure was made.
#[derive(Debug, Default)]
pub struct Origin<'a> {
    runs: Vec<&'a Run>,
    /// Number of runs that were planned and wanted, but are not complete.
    lacking: usize,
    /// How long the paper's open loops ran, s, if they stand beside these.
    beside_s: Option<f64>,
}

impl<'a> Origin<'a> {
    /// No runs yet. The line will hold their duration against the paper's, if they are open loops.
    #[must_use]
    pub fn beside(paper_s: f64) -> Origin<'a> {
        Origin {
            beside_s: Some(paper_s),
            ..Origin::default()
        }
    }

    /// Adds all runs of a group. A group with complete runs is counted only once.
    pub fn all(&mut self, group: &Group<'a>) {
        if group.runs.is_empty() || !group.runs.iter().all(|run| self.has(run)) {
            self.lacking += group.planned - group.runs.len();
        }
        self.take(&group.runs);
    }

    /// Adds the first run of a group, where one is enough; `None` if none is complete.
    pub fn first(&mut self, group: &Group<'a>) -> Option<&'a Run> {
        let first = group.runs.first().copied();
        match first {
            Some(run) => self.take(&[run]),
            None => self.lacking += group.planned.min(1),
        }
        first
    }

    /// Adds runs, each once.
    pub fn take(&mut self, runs: &[&'a Run]) {
        for run in runs {
            if !self.has(run) {
                self.runs.push(run);
            }
        }
    }

    fn has(&self, run: &Run) -> bool {
        self.runs.iter().any(|one| one.cell.id == run.cell.id)
    }

    /// The ids of its runs, in the plan's order.
    pub fn ids(&self) -> Vec<String> {
        let mut runs: Vec<&Run> = self.runs.clone();
        runs.sort_by_key(|run| run.cell.index);
        runs.iter().map(|run| run.cell.id.clone()).collect()
    }

    /// The origin in one line.
    pub fn line(&self, campaign: &Campaign) -> String {
        let (taken, wanted) = (self.runs.len(), self.runs.len() + self.lacking);
        let mut words = vec![match (taken, wanted) {
            (1, 1) => "1 run".to_owned(),
            (n, m) if n == m => format!("{n} runs"),
            (n, m) => format!("{n} of {m} planned runs"),
        }];
        if !self.runs.is_empty() {
            words.push(self.durations());
        }
        words.push(format!("campaign seed {}", campaign.plan.seed));
        let manifests = || self.runs.iter().filter_map(|run| run.manifest.as_ref());
        let backends: BTreeSet<&str> = manifests().map(|m| m.backend.as_str()).collect();
        if !backends.is_empty() {
            words.push(format!("back-end {}", list(&backends)));
        }
        let played: BTreeSet<&str> = manifests()
            .map(|m| m.player.as_str())
            .filter(|player| *player != "none")
            .collect();
        if !played.is_empty() {
            words.push(format!("link played by {}", list(&played)));
        }
        if manifests().any(|m| m.player == "none") {
            words.push("no link on loopback".to_owned());
        }
        words.join("; ")
    }

    /// The duration of the runs; for open loops, beside the paper's.
    fn durations(&self) -> String {
        let durations: BTreeSet<u64> = self.runs.iter().map(|run| run.cell.duration_ns).collect();
        let seconds: Vec<String> = durations
            .iter()
            .map(|ns| (*ns as f64 / 1e9).to_string())
            .collect();
        let open = self
            .runs
            .iter()
            .all(|run| run.cell.settings.mode == Mode::Open);
        let s = seconds.join(", ");
        match self.beside_s.filter(|_| open) {
            Some(beside_s) => format!("{s} s of the paper's {beside_s} s"),
            None => format!("{s} s each"),
        }
    }
}

fn list(words: &BTreeSet<&str>) -> String {
    words.iter().copied().collect::<Vec<_>>().join(", ")
}
