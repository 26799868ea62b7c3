//! Pairs the runs of two campaigns.

use analysis::layout::{Column, Shown, number, text};
use analysis::{Campaign, Run, grouped};
use endpoint::Mode;
use plan::{Cell, Client, Setup, Verdict};
use serde::Serialize;

/// What the runs of a group have in common.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct GroupKey {
    /// The topology.
    pub topology: String,
    /// The client.
    pub client: Client,
    /// The client's preset, and the settings that the experiment changed.
    pub setup: Setup,
    /// `open` or `closed`.
    pub mode: Mode,
    /// The rate for people, such as `333 Hz`.
    pub rate: String,
    /// The sample time, ns.
    pub h_ns: u64,
}

impl GroupKey {
    /// The columns that name a group.
    pub(crate) const COLUMNS: [Column; 5] = [
        text("topology"),
        text("client").shown(Shown::IfDiffers),
        text("setup").shown(Shown::IfDiffers),
        text("mode").shown(Shown::IfDiffers),
        number("", "rate"),
    ];

    /// Its entries in these columns.
    pub(crate) fn entries(&self) -> [String; 5] {
        [
            self.topology.clone(),
            self.client.to_string(),
            self.setup.to_string(),
            self.mode.to_string(),
            self.rate.clone(),
        ]
    }

    fn of(cell: &Cell) -> GroupKey {
        GroupKey {
            topology: cell.topology.clone(),
            client: cell.client,
            setup: cell.setup(),
            mode: cell.settings.mode,
            rate: cell.rate(),
            h_ns: cell.settings.h.ns(),
        }
    }
}

impl std::fmt::Display for GroupKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let GroupKey {
            topology,
            client,
            setup,
            mode,
            rate,
            ..
        } = self;
        write!(f, "{topology}, {client} ({setup}), {mode} loop at {rate}")
    }
}

/// A group that has no pair.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Lone {
    /// The group.
    #[serde(flatten)]
    pub kind: GroupKey,
    /// The reason, in a sentence.
    pub reason: String,
}

/// A group with its pairs.
pub(crate) struct Paired<'a> {
    pub(crate) kind: GroupKey,
    /// Pairs that are complete in both, in order of repeat: A's run and B's.
    pub(crate) runs: Vec<(&'a Run, &'a Run)>,
    /// Number of pairs if all runs of either plan were complete in both.
    pub(crate) planned: usize,
}

/// The groups of both campaigns, in the order of A's plan and then of B's.
pub(crate) fn pair<'a>(a: &'a Campaign, b: &'a Campaign) -> (Vec<Paired<'a>>, Vec<Lone>) {
    let of_a = a.runs.iter().map(|run| (run, true));
    let runs = of_a.chain(b.runs.iter().map(|run| (run, false)));
    let (mut paired, mut lone) = (Vec::new(), Vec::new());
    for (kind, runs) in grouped(runs, |(run, _)| GroupKey::of(&run.cell)) {
        let own = |of_a| runs.iter().filter(move |(_, is_a)| *is_a == of_a);
        let members = Members {
            a: own(true).map(|(run, _)| *run).collect(),
            b: own(false).map(|(run, _)| *run).collect(),
        };
        match members.reason_against(a, b, &kind) {
            Some(reason) => lone.push(Lone { kind, reason }),
            None => paired.push(Paired {
                runs: members.pairs(is_complete),
                planned: members.a.len().max(members.b.len()),
                kind,
            }),
        }
    }
    (paired, lone)
}

/// Complete runs of A that B's plan does not have: it has no run of their kind and repeat, whatever its link.
#[must_use]
pub fn lost<'a>(a: &'a Campaign, b: &Campaign) -> Vec<&'a Run> {
    let key = |run: &Run| (GroupKey::of(&run.cell), run.cell.repeat);
    let there: Vec<_> = b.runs.iter().map(key).collect();
    let complete = a.runs.iter().filter(|run| is_complete(run));
    complete.filter(|run| !there.contains(&key(run))).collect()
}

/// The runs of one kind in both campaigns.
struct Members<'a> {
    a: Vec<&'a Run>,
    b: Vec<&'a Run>,
}

impl<'a> Members<'a> {
    /// The pairs of runs with the same repeat, link seed and duration, of which both satisfy
    /// `is_asked`.
    fn pairs(&self, is_asked: impl Fn(&Run) -> bool) -> Vec<(&'a Run, &'a Run)> {
        let link = |run: &Run| (run.cell.repeat, run.cell.link_seed, run.cell.duration_ns);
        let mut pairs = Vec::new();
        for a in self.a.iter().filter(|run| is_asked(run)) {
            let mut others = self.b.iter().filter(|run| is_asked(run));
            pairs.extend(others.find(|b| link(a) == link(b)).map(|b| (*a, *b)));
        }
        pairs
    }

    /// Why there is no pair; `None` if there is.
    fn reason_against(&self, a: &Campaign, b: &Campaign, kind: &GroupKey) -> Option<String> {
        let (Some(one), Some(other)) = (self.a.first(), self.b.first()) else {
            let (has, lacks) = if self.b.is_empty() {
                ("A", "B")
            } else {
                ("B", "A")
            };
            return Some(format!("{has}'s plan has it, and {lacks}'s does not"));
        };
        let profile = |campaign: &Campaign| campaign.plan.profiles.get(&kind.topology).cloned();
        if profile(a) != profile(b) {
            return Some(format!("the profile of {} is not the same", kind.topology));
        }
        if self.pairs(|_| true).is_empty() {
            let (one, other) = (&one.cell, &other.cell);
            let s = |ns: u64| ns as f64 / 1e9;
            return Some(if one.duration_ns == other.duration_ns {
                format!(
                    "no run met the same link: A has seed {}, B has {}",
                    a.plan.seed, b.plan.seed
                )
            } else {
                format!(
                    "A's runs last {} s, B's {} s",
                    s(one.duration_ns),
                    s(other.duration_ns)
                )
            });
        }
        if self.pairs(is_complete).is_empty() {
            let complete = |runs: &[&Run]| runs.iter().filter(|run| is_complete(run)).count();
            return Some(format!(
                "no run is complete in both: {} of {} are complete in A, {} of {} in B",
                complete(&self.a),
                self.a.len(),
                complete(&self.b),
                self.b.len()
            ));
        }
        None
    }
}

/// Whether its figures can be used: it ran to its end over a link that held, and its folder is whole.
pub(super) fn is_complete(run: &Run) -> bool {
    run.summary.verdict == Some(Verdict::Complete) && run.damage.is_empty()
}
