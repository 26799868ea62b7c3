//! Compares two campaigns: is the second worse? Yes, no, or it cannot be told.
//!
//! Runs that met the same link are paired: those with equal topology, client, setup, mode, rate,
//! repeat and link seed. A group consists of the pairs that differ only in their repeat. A measure of
//! a group is worse if both hold: the change is large enough to matter, and it is more than chance by
//! the signed-rank test with Holm's correction over the groups. It is alike if the median change is, with 95 %
//! confidence, too small to matter in either direction. In between it is open, and the number of pairs that would
//! tell is said. The tests are in [`analysis::pairs`].
//!
//! Each direction is tested by itself, at 5 %. The question is whether B is worse: for each measure, an alarm is false
//! in at most one of twenty comparisons of campaigns that are alike. A test of both directions at once pays half of
//! that for calling B better, and needs a pair more for each answer. No exact test needs fewer pairs: if all of n are
//! on one side, chance alone does that with 0.5 to the n.
//!
//! - `measure`: what is compared, and which direction is worse; `pairing`: which runs form a pair;
//! - `text`: the comparison as text and as CSV.

mod measure;
mod pairing;
mod text;

use analysis::pairs::{
    Sides, holm, least_probability, median_at_most, sign_test, signed_rank_test, to_tell,
    worth_making,
};
use analysis::statistics::median;
use analysis::{Campaign, LoopVerdict, grouped};
use serde::Serialize;

pub use measure::Measure;
pub use pairing::{GroupKey, Lone, lost};

pub(crate) use pairing::pair;

use pairing::{Paired, is_complete};

/// The probability of a false alarm that is accepted among all groups of a measure, in each direction.
pub const LEVEL: f64 = 0.05;

/// The comparison of two campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// A, with which B is compared.
    pub a: Side,
    /// B, which is compared.
    pub b: Side,
    /// Whether B is worse.
    pub answer: Answer,
    /// The least change that matters, as a share: 0.05.
    pub least_change: f64,
    /// The groups that have pairs, in the order of A's plan, with each measure that they have.
    pub groups: Vec<PairedMeasures>,
    /// Loops whose verdict changed.
    pub changed: Vec<ChangedLoop>,
    /// The groups without a pair, and why.
    pub lone: Vec<Lone>,
}

/// Whether B is worse than A.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// A measure of a group is worse, or a loop has become unstable.
    Worse,
    /// No measure is worse by so much that it would matter.
    NotWorse,
    /// Some measure may be worse by so much, or not: the pairs are too few.
    CannotTell,
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
pub struct PairedMeasures {
    /// What they have in common.
    #[serde(flatten)]
    pub kind: GroupKey,
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
    /// The most that the median change may be for the worse, with 95 % confidence: a share as `change`, positive if it
    /// is worse. Infinite with too few pairs.
    pub at_worst: f64,
    /// The sign test's probability of as many changes in the direction of the less likely side.
    pub p_sign: f64,
    /// The signed-rank test's probability in that direction.
    pub p_rank: f64,
    /// The signed-rank test's probability after Holm's correction over the groups of this measure;
    /// `None` if there are too few pairs to tell.
    pub p_holm: Option<f64>,
    /// The conclusion.
    pub outcome: Conclusion,
    /// The number of pairs that would tell, if they go like these; `None` if none has to, or none would.
    pub would_tell: Option<usize>,
    #[serde(skip)]
    tested: Tested,
}

/// What the conclusion is drawn from.
#[derive(Debug, Clone, PartialEq)]
struct Tested {
    /// The probabilities of the signed-rank test, of a change for the worse and of one for the better.
    worse: f64,
    better: f64,
    /// The most that the median change may be for the better.
    at_best: f64,
    /// Whether no pair has a change at all.
    is_same: bool,
    /// For each pair, its change for the worse.
    changes: Vec<f64>,
}

/// The conclusion about a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Conclusion {
    /// B is worse, by more than chance and by enough to matter.
    Worse,
    /// B is better, by more than chance and by enough to matter.
    Better,
    /// The change is too small to matter.
    Alike,
    /// The change may be large, or due to chance.
    Unclear,
    /// With so few pairs, no change, however large, could be told from chance.
    TooFew,
}

/// Loops of a group whose verdict changed in the same way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChangedLoop {
    /// The group.
    #[serde(flatten)]
    pub kind: GroupKey,
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
        let mut groups: Vec<PairedMeasures> = paired.iter().map(PairedMeasures::of).collect();
        for measure in Measure::ALL {
            let mut of_all: Vec<&mut Compared> = groups
                .iter_mut()
                .flat_map(|group| &mut group.measures)
                .filter(|compared| compared.measure == measure)
                .collect();
            judge(&mut of_all, least_change);
        }
        let mut comparison = Comparison {
            answer: Answer::NotWorse,
            a: Side::of(a),
            b: Side::of(b),
            least_change,
            groups,
            changed,
            lone,
        };
        comparison.answer = comparison.answered();
        comparison
    }

    /// Worse is a measure of a group, or a loop that has become unstable, which needs no statistics.
    fn answered(&self) -> Answer {
        let unstable = |changed: &ChangedLoop| changed.to == LoopVerdict::Lost;
        if self.count(Conclusion::Worse) > 0 || self.changed.iter().any(unstable) {
            Answer::Worse
        } else if self.open().next().is_some() {
            Answer::CannotTell
        } else {
            Answer::NotWorse
        }
    }

    /// Whether anything is worse in B.
    #[must_use]
    pub fn is_worse(&self) -> bool {
        self.answer == Answer::Worse
    }

    /// The measures that may be worse by so much that it matters, and may not.
    pub fn open(&self) -> impl Iterator<Item = &Compared> {
        let measures = self.groups.iter().flat_map(|group| &group.measures);
        measures.filter(|of| of.is_open(self.least_change))
    }

    /// The number of measures, over all groups, with this outcome.
    #[must_use]
    pub fn count(&self, outcome: Conclusion) -> usize {
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

impl PairedMeasures {
    fn of(paired: &Paired<'_>) -> PairedMeasures {
        let compared = |measure: &Measure| Compared::of(*measure, paired);
        PairedMeasures {
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
        let differences: Vec<f64> = both.iter().map(|(_, _, d)| measure.badness(*d)).collect();
        let middle = median(&differences);
        // Adding nothing makes a negative zero a plain one.
        let change = |badness: f64| measure.badness(measure.change(measure.badness(badness))) + 0.0;
        let turned: Vec<f64> = differences.iter().map(|d| -d).collect();
        let Sides { above, below } = signed_rank_test(&differences);
        let sign = sign_test(&differences);
        Some(Compared {
            measure,
            pairs: both.len(),
            a: median(&both.iter().map(|(a, _, _)| *a).collect::<Vec<_>>())?,
            b: median(&both.iter().map(|(_, b, _)| *b).collect::<Vec<_>>())?,
            change: middle.map(|middle| measure.change(measure.badness(middle))),
            at_worst: change(median_at_most(&differences, LEVEL)),
            p_sign: sign.above.min(sign.below),
            p_rank: above.min(below),
            p_holm: None,
            outcome: Conclusion::TooFew,
            would_tell: None,
            tested: Tested {
                worse: above,
                better: below,
                at_best: -change(-median_at_most(&turned, LEVEL)),
                is_same: differences.iter().all(|d| *d == 0.0),
                changes: differences.iter().map(|d| change(*d)).collect(),
            },
        })
    }

    /// The conclusion, by the corrected probabilities of a change for the worse and for the better; `None` if no
    /// test could tell.
    fn outcome(&self, least_change: f64, worse_better: Option<(f64, f64)>) -> Conclusion {
        let is_seen = self.a == self.b || (self.b - self.a).abs() >= self.measure.least();
        if self.tested.is_same || !is_seen {
            return Conclusion::Alike;
        }
        if let Some(((worse, better), change)) = worse_better.zip(self.change) {
            let badness = self.measure.badness(change);
            if badness > least_change && worse < LEVEL {
                return Conclusion::Worse;
            }
            if -badness > least_change && better < LEVEL {
                return Conclusion::Better;
            }
        }
        if self.at_worst <= least_change && self.tested.at_best <= least_change {
            Conclusion::Alike
        } else if worse_better.is_some() {
            Conclusion::Unclear
        } else {
            Conclusion::TooFew
        }
    }

    /// Whether it may be worse by so much that it matters, and may not.
    fn is_open(&self, least_change: f64) -> bool {
        let is_undecided = matches!(self.outcome, Conclusion::Unclear | Conclusion::TooFew);
        is_undecided && self.at_worst > least_change
    }
}

/// Corrects the probabilities of a measure over all its groups, and sets the outcomes.
fn judge(of_all: &mut [&mut Compared], least_change: f64) {
    let tests = of_all.len();
    let least: Vec<f64> = of_all
        .iter()
        .map(|one| least_probability(one.pairs))
        .collect();
    let is_worth = worth_making(&least, LEVEL);
    let raised = |side: fn(&Tested) -> f64| {
        let made = of_all
            .iter()
            .zip(&is_worth)
            .filter(|(_, is_worth)| **is_worth);
        holm(&made.map(|(one, _)| side(&one.tested)).collect::<Vec<f64>>())
    };
    let mut raised = raised(|of| of.worse)
        .into_iter()
        .zip(raised(|of| of.better));
    for (one, is_worth) in of_all.iter_mut().zip(is_worth) {
        let sides = if is_worth { raised.next() } else { None };
        one.p_holm = sides.map(|(worse, better)| worse.min(better));
        one.outcome = one.outcome(least_change, sides);
        if one.is_open(least_change) {
            let beyond = one.tested.changes.iter().filter(|of| **of > least_change);
            one.would_tell = to_tell(one.pairs, beyond.count(), tests, LEVEL);
        }
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
