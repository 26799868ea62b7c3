//! Compares two campaigns: in which groups of runs is the second worse, or better?
//!
//! Runs that met the same link are paired: those with equal topology, client, setup, mode, rate,
//! repeat and link seed. A group consists of the pairs that differ only in their repeat. A measure of
//! a group is worse if both hold: the change is large enough to matter, and it is more than chance by
//! the signed-rank test with Holm's correction over the groups. The tests are in [`analysis::pairs`].
//!
//! - `measure`: what is compared, and which direction is worse; `pairing`: which runs form a pair;
//! - `text`: the comparison as text and as CSV.

mod measure;
mod pairing;
mod text;

use analysis::pairs::{holm, least_probability, sign_test, signed_rank_test, worth_making};
use analysis::statistics::median;
use analysis::{Campaign, LoopVerdict, grouped};
use serde::Serialize;

pub use measure::Measure;
pub use pairing::{Kind, Lone, lost};

pub(crate) use pairing::pair;

use pairing::{Paired, is_complete};

/// The probability of a false alarm that is accepted among all groups of a measure.
pub const LEVEL: f64 = 0.05;

/// The comparison of two campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// A, with which B is compared.
    pub a: Side,
    /// B, which is compared.
    pub b: Side,
    /// The least change that matters, as a share: 0.05.
    pub least_change: f64,
    /// The groups that have pairs, in the order of A's plan, with each measure that they have.
    pub groups: Vec<Group>,
    /// Loops whose verdict changed.
    pub changed: Vec<ChangedLoop>,
    /// The groups without a pair, and why.
    pub lone: Vec<Lone>,
}

/// One of the two campaigns.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Side {
    /// The experiment's name.
    pub experiment: String,
    /// The campaign's seed.
    pub seed: u64,
    /// Number of cells in its plan.
    pub cells: usize,
    /// Number of its cells that are complete.
    pub complete: usize,
    /// Whether its runs are in virtual time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub simulated: bool,
}

/// Pairs of runs that differ only in their repeat.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// What they have in common.
    #[serde(flatten)]
    pub kind: Kind,
    /// Number of pairs.
    pub pairs: usize,
    /// Number of pairs if all runs of either plan were complete in both.
    pub planned: usize,
    /// The measures of the group.
    pub measures: Vec<Compared>,
}

/// A measure of a group in both campaigns. An infinite number, from loops that never settled, is null
/// in JSON and empty in CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// The measure.
    pub measure: Measure,
    /// Number of pairs in which both runs have it.
    pub pairs: usize,
    /// A's median over these pairs, in the measure's unit.
    pub a: f64,
    /// B's median.
    pub b: f64,
    /// The median change over the pairs, as [`Measure::change`] defines it; `None` if half of them
    /// never settled in A and the other half never in B.
    pub change: Option<f64>,
    /// The sign test's probability.
    pub p_sign: f64,
    /// The signed-rank test's probability.
    pub p_rank: f64,
    /// The signed-rank test's probability after Holm's correction over the groups of this measure;
    /// `None` if there are too few pairs to tell.
    pub p_holm: Option<f64>,
    /// The conclusion.
    pub outcome: Outcome,
}

/// The conclusion about a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// B is worse, by more than chance and by enough to matter.
    Worse,
    /// B is better, by more than chance and by enough to matter.
    Better,
    /// The change is too small to matter.
    Alike,
    /// The change is large, but may be due to chance.
    Unclear,
    /// With so few pairs, no change, however large, could be told from chance.
    TooFew,
}

/// Loops of a group whose verdict changed in the same way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChangedLoop {
    /// The group.
    #[serde(flatten)]
    pub kind: Kind,
    /// A's verdict.
    pub from: LoopVerdict,
    /// B's verdict.
    pub to: LoopVerdict,
    /// The repeats.
    pub repeats: Vec<u32>,
}

impl Comparison {
    /// Compares `b` with `a`; changes below `least_change`, a share, do not matter.
    #[must_use]
    pub fn of(a: &Campaign, b: &Campaign, least_change: f64) -> Comparison {
        let (paired, lone) = pair(a, b);
        let changed = paired.iter().flat_map(changed_loops).collect();
        let mut groups: Vec<Group> = paired.iter().map(Group::of).collect();
        for measure in Measure::ALL {
            let mut of_all: Vec<&mut Compared> = groups
                .iter_mut()
                .flat_map(|group| &mut group.measures)
                .filter(|compared| compared.measure == measure)
                .collect();
            judge(&mut of_all, least_change);
        }
        Comparison {
            a: Side::of(a),
            b: Side::of(b),
            least_change,
            groups,
            changed,
            lone,
        }
    }

    /// Whether anything is worse in B: a measure of a group, or a loop that has become unstable,
    /// which needs no statistics.
    #[must_use]
    pub fn is_worse(&self) -> bool {
        let unstable = |changed: &ChangedLoop| changed.to == LoopVerdict::Unstable;
        self.count(Outcome::Worse) > 0 || self.changed.iter().any(unstable)
    }

    /// The number of measures, over all groups, with this outcome.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> usize {
        let measures = self.groups.iter().flat_map(|group| &group.measures);
        measures.filter(|of| of.outcome == outcome).count()
    }

    /// The comparison as JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Plain data of strings and numbers: serialising it cannot fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

impl Side {
    fn of(campaign: &Campaign) -> Side {
        Side {
            experiment: campaign.plan.experiment.clone(),
            seed: campaign.plan.seed,
            cells: campaign.runs.len(),
            complete: campaign.runs.iter().filter(|run| is_complete(run)).count(),
            simulated: campaign.is_simulated(),
        }
    }
}

impl Group {
    fn of(paired: &Paired<'_>) -> Group {
        let compared = |measure: &Measure| Compared::of(*measure, paired);
        Group {
            kind: paired.kind.clone(),
            pairs: paired.runs.len(),
            planned: paired.planned,
            measures: Measure::ALL.iter().filter_map(compared).collect(),
        }
    }
}

impl Compared {
    /// Compares the pairs in which both runs have the measure, without a conclusion yet; `None` if
    /// there are none.
    fn of(measure: Measure, paired: &Paired<'_>) -> Option<Compared> {
        let both = paired.runs.iter().filter_map(|(a, b)| {
            let (a, b) = (measure.of(&a.summary)?, measure.of(&b.summary)?);
            Some((a, b, measure.difference(a, b)?))
        });
        let both: Vec<(f64, f64, f64)> = both.collect();
        let differences: Vec<f64> = both.iter().map(|(_, _, d)| *d).collect();
        let middle = median(&differences);
        Some(Compared {
            measure,
            pairs: both.len(),
            a: median(&both.iter().map(|(a, _, _)| *a).collect::<Vec<_>>())?,
            b: median(&both.iter().map(|(_, b, _)| *b).collect::<Vec<_>>())?,
            change: middle.map(|middle| measure.change(middle)),
            p_sign: sign_test(&differences),
            p_rank: signed_rank_test(&differences),
            p_holm: None,
            outcome: Outcome::TooFew,
        })
    }

    fn outcome(&self, least_change: f64) -> Outcome {
        let Some(p) = self.p_holm else {
            return Outcome::TooFew;
        };
        // Half of the pairs change infinitely in one direction and half in the other: a large change
        // of unknown direction.
        let Some(change) = self.change else {
            return Outcome::Unclear;
        };
        let is_seen = self.a == self.b || (self.b - self.a).abs() >= self.measure.least();
        match (change.abs() > least_change && is_seen, p < LEVEL) {
            (false, _) => Outcome::Alike,
            (true, false) => Outcome::Unclear,
            (true, true) if self.measure.is_worse(change) => Outcome::Worse,
            (true, true) => Outcome::Better,
        }
    }
}

/// Corrects the probabilities of a measure over all its groups, and sets the outcomes.
fn judge(of_all: &mut [&mut Compared], least_change: f64) {
    let least: Vec<f64> = of_all
        .iter()
        .map(|one| least_probability(one.pairs))
        .collect();
    let mut tested: Vec<&mut &mut Compared> = of_all
        .iter_mut()
        .zip(worth_making(&least, LEVEL))
        .filter_map(|(one, is_worth)| is_worth.then_some(one))
        .collect();
    let own: Vec<f64> = tested.iter().map(|one| one.p_rank).collect();
    for (one, p) in tested.iter_mut().zip(holm(&own)) {
        one.p_holm = Some(p);
        one.outcome = one.outcome(least_change);
    }
}

fn changed_loops(paired: &Paired<'_>) -> Vec<ChangedLoop> {
    let changed = paired.runs.iter().filter_map(|(a, b)| {
        let (from, to) = a.summary.loop_verdict.zip(b.summary.loop_verdict)?;
        (from != to).then_some((from, to, a.cell.repeat))
    });
    let of_kind = |((from, to), runs): (_, Vec<(_, _, u32)>)| ChangedLoop {
        kind: paired.kind.clone(),
        from,
        to,
        repeats: runs.iter().map(|(.., repeat)| *repeat).collect(),
    };
    let changed = grouped(changed, |(from, to, _)| (*from, *to));
    changed.into_iter().map(of_kind).collect()
}

#[cfg(test)]
pub(crate) mod tests;
