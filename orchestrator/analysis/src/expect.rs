//! Judges runs by what is expected of them: the clauses of their plan, and those of `--require`.
//!
//! A group is the repeats of one cell. A clause holds for a group if every run of it is complete and enough of
//! them meet the clause: the share of the runs that were made or, with a confidence, the lower bound of the
//! share of all ([`share`](crate::share)). Where a run has no such figure at all (settling of an open loop) the
//! clause is not asked, and runs that the machine does not support are left out. Where it has one without a value, as
//! a quantile that falls among messages without an answer, the clause is not met, and the answer says why.
//!
//! Repeats between which nothing varies are one run ([`variety`](crate::variety)): no share of all runs can be told
//! from them.
//!
//! A failure that the plan knows does not count: the clause is asked again of the group's other runs. A run that
//! is not complete is no known failure, since it shows nothing.

mod answer;

use std::collections::BTreeSet;
use std::fmt;

use plan::{Clause, Day, Figure, Known, Plan, Verdict};
use record::Damage;

use crate::campaign::Run;
use crate::layout::grouped;
use crate::outline::Outlined;
use crate::share::{bounds, enough, interval};
use crate::statistics::{Quantiles, median};
use crate::summary::Summary;
use crate::variety::{Variety, is_one_run};
use crate::verdict::LoopVerdict;

pub use answer::{Answer, Bounds, ClauseOutcome, Drawn, Shown};

/// The confidence of the bounds that are printed where a clause asks for none.
const USUAL_CONFIDENCE: f64 = 0.95;

/// What became of all that is expected.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Judgement {
    /// One for each clause and group that it is asked of, in the order of the runs.
    pub answers: Vec<Answer>,
    /// Clauses that no run has.
    pub unasked: Vec<Clause>,
    /// Known failures whose cells were asked and did not fail.
    pub passing: Vec<Known>,
}

impl Judgement {
    /// Whether nothing was expected.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.answers.is_empty() && self.unasked.is_empty()
    }

    /// Whether every clause holds, or its failure is known.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.answer() == Answered::Yes
    }

    /// Whether the runs show what is expected.
    #[must_use]
    pub fn answer(&self) -> Answered {
        let is_no = |answer: &Answer| answer.outcome == ClauseOutcome::NotMet;
        if !self.unasked.is_empty() || self.answers.iter().any(is_no) {
            Answered::No
        } else if self.answers.iter().all(|answer| answer.outcome.holds()) {
            Answered::Yes
        } else {
            Answered::CannotTell
        }
    }

    /// Of how many clauses it cannot be told, and the number of runs that would tell of each of them.
    fn open(&self) -> (usize, Option<usize>) {
        let enough = |answer: &Answer| match answer.outcome {
            ClauseOutcome::NotTold { enough } => Some(enough),
            _ => None,
        };
        let open: Vec<Option<usize>> = self.answers.iter().filter_map(enough).collect();
        (open.len(), open.into_iter().flatten().max())
    }
}

/// Whether runs show what is expected of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answered {
    /// They do, but for failures that are known.
    Yes,
    /// They do not.
    No,
    /// The runs are too few to tell.
    CannotTell,
}

/// A line for each answer, and for what else is to be said.
impl fmt::Display for Judgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for answer in &self.answers {
            writeln!(f, "{answer}")?;
        }
        for clause in &self.unasked {
            writeln!(f, "NOT MET: {clause}: no run here has it")?;
        }
        for known in &self.passing {
            let of = known.expect.map_or(String::new(), |of| format!(", {of}"));
            writeln!(
                f,
                "known failure {}{of}: passes, remove it from [[known]]",
                known.cells
            )?;
        }
        if self.answer() == Answered::CannotTell {
            let (open, enough) = self.open();
            let of = match self.answers.len() {
                1 => String::new(),
                all => format!(" of {open} of these {all} clauses"),
            };
            match enough {
                Some(runs) => writeln!(
                    f,
                    "The runs are too few to tell{of}; {runs} in a group would do."
                )?,
                None => writeln!(f, "The runs cannot tell{of}.")?,
            }
        }
        Ok(())
    }
}

/// A run, as far as it is asked.
#[derive(Clone, Copy)]
struct AskedRun<'a> {
    index: usize,
    row: &'a Summary,
    damage: &'a [Damage],
}

impl<'a> AskedRun<'a> {
    fn of(run: &'a Run) -> AskedRun<'a> {
        AskedRun {
            index: run.cell.index,
            row: &run.summary,
            damage: &run.damage,
        }
    }

    fn of_row(row: &'a Outlined) -> AskedRun<'a> {
        AskedRun {
            index: row.index,
            row: &row.summary,
            damage: &row.damage,
        }
    }

    fn is_unsupported(&self) -> bool {
        self.damage.is_empty() && self.row.verdict == Some(Verdict::Unsupported)
    }

    /// Why it shows nothing, in a word; `None` if it is complete.
    fn fault(&self) -> Option<String> {
        match self.row.verdict {
            _ if !self.damage.is_empty() => Some("damaged".to_owned()),
            None => Some("not run".to_owned()),
            Some(Verdict::Complete) => None,
            Some(verdict) => Some(verdict.to_string()),
        }
    }
}

/// Asks runs what their plan expects of them, and what is `required` of all of them. `today` decides which known
/// failures are still accepted.
#[must_use]
pub fn judge(plan: &Plan, runs: &[&Run], required: &[Clause], today: Day) -> Judgement {
    let runs: Vec<AskedRun<'_>> = runs.iter().map(|run| AskedRun::of(run)).collect();
    judge_asked(plan, &runs, required, today)
}

/// As [`judge`], of runs in their rows.
#[must_use]
pub fn judge_rows(plan: &Plan, rows: &[&Outlined], required: &[Clause], today: Day) -> Judgement {
    let runs: Vec<AskedRun<'_>> = rows.iter().map(|row| AskedRun::of_row(row)).collect();
    judge_asked(plan, &runs, required, today)
}

fn judge_asked(plan: &Plan, runs: &[AskedRun<'_>], required: &[Clause], today: Day) -> Judgement {
    let indices: BTreeSet<usize> = runs.iter().map(|run| run.index).collect();
    // A clause that is both expected and required is asked once.
    let mut clauses: Vec<(&Clause, BTreeSet<usize>)> = Vec::new();
    let expected = plan.expect.iter();
    let expected = expected.flat_map(|of| of.clauses.iter().map(move |clause| (clause, &of.cells)));
    for (clause, cells) in expected.chain(required.iter().map(|clause| (clause, &indices))) {
        match clauses.iter_mut().find(|(known, _)| *known == clause) {
            Some((_, known)) => known.extend(cells),
            None => clauses.push((clause, cells.clone())),
        }
    }
    let mut answers = Vec::new();
    for (clause, cells) in &clauses {
        let has_it = |run: &&AskedRun<'_>| clause.figure().is_of(run.row.mode);
        let of_it = runs.iter().filter(|run| cells.contains(&run.index));
        let groups = grouped(of_it.filter(has_it), |run| {
            (&run.row.topology, run.row.condition())
        });
        for (_, group) in groups {
            let runs: Vec<AskedRun<'_>> = group.into_iter().copied().collect();
            let group = Question {
                clause,
                known: &plan.known,
                today,
                drawn: drawn(plan, &runs),
                runs,
            };
            answers.push((group.runs[0].index, group.answer()));
        }
    }
    answers.sort_by_key(|(first, _)| *first);
    let answers: Vec<Answer> = answers.into_iter().map(|(_, answer)| answer).collect();
    let is_unasked = |clause: &&Clause| {
        let text = clause.to_string();
        !answers.iter().any(|answer| answer.clause == text)
    };
    Judgement {
        unasked: required.iter().filter(is_unasked).cloned().collect(),
        passing: plan
            .known
            .iter()
            .filter(|known| is_passing(known, &answers))
            .cloned()
            .collect(),
        answers,
    }
}

/// Whether a known failure does not happen any more where it was asked for.
fn is_passing(known: &Known, answers: &[Answer]) -> bool {
    let about = |answer: &&Answer| {
        let mut cells = answer.cells.iter();
        cells.any(|cell| known.is_about(answer.figure, cell))
    };
    let mut about = answers.iter().filter(about).peekable();
    about.peek().is_some() && about.all(|answer| answer.outcome == ClauseOutcome::Met)
}

/// What the complete runs of a group are of all that there could be.
fn drawn(plan: &Plan, runs: &[AskedRun<'_>]) -> Drawn {
    let complete = || runs.iter().filter(|run| run.fault().is_none());
    let Some(first) = complete().next() else {
        return Drawn::Nothing;
    };
    // Most plans have each cell in the place of its index.
    let cell = plan.cells.get(first.index);
    let cell = cell.filter(|cell| cell.index == first.index);
    let Some(cell) = cell.or_else(|| plan.cell(first.index)) else {
        return Drawn::Nothing;
    };
    let variety = if first.row.is_simulated() {
        Variety::simulated(plan, cell)
    } else {
        Variety::real(plan, cell)
    };
    match complete().count() {
        1 => Drawn::Once,
        _ if variety.is_none() || is_one_run(complete().map(|run| run.row)) => Drawn::Again,
        _ => Drawn::Of(variety),
    }
}

/// A clause and the runs of a group.
struct Question<'a> {
    clause: &'a Clause,
    known: &'a [Known],
    today: Day,
    drawn: Drawn,
    /// At least one.
    runs: Vec<AskedRun<'a>>,
}

impl<'a> Question<'a> {
    /// The runs that the machine supports.
    fn asked(&self) -> impl Iterator<Item = &AskedRun<'a>> {
        self.runs.iter().filter(|run| !run.is_unsupported())
    }

    fn answer(&self) -> Answer {
        let first = self.runs[0].row;
        let asked = || self.asked();
        let complete: Vec<&Summary> = asked()
            .filter(|run| run.fault().is_none())
            .map(|run| run.row)
            .collect();
        let incomplete: Vec<(String, String)> = asked()
            .filter_map(|run| Some((run.fault()?, run.row.cell.clone())))
            .collect();
        let (met, n) = (count(self.clause, &complete), complete.len());
        let confidence = self.clause.confidence().unwrap_or(USUAL_CONFIDENCE);
        let (outcome, note) = self.outcome(&complete);
        Answer {
            clause: self.clause.to_string(),
            figure: self.clause.figure(),
            client: first.client,
            group: format!(
                "{} {} {} {} {}",
                first.topology, first.client, first.setup, first.mode, first.rate
            ),
            cells: asked().map(|run| run.row.cell.clone()).collect(),
            met,
            runs: n,
            // What is asked with a confidence is asked of one side; else the bounds are an interval.
            bounds: match self.clause.confidence() {
                Some(confidence) => Bounds::OneSide(bounds(met, n, confidence)),
                None => Bounds::Interval(interval(met, n, confidence)),
            },
            confidence,
            drawn: self.drawn,
            shown: shown(self.clause, &complete),
            incomplete,
            unsupported: self.runs.len() - asked().count(),
            outcome,
            note,
        }
    }

    /// The outcome, and the reason of a failure that is known, or was.
    fn outcome(&self, complete: &[&Summary]) -> (ClauseOutcome, Option<String>) {
        if self.runs.iter().all(AskedRun::is_unsupported) {
            return (ClauseOutcome::Unsupported, None);
        }
        let is_whole = self.asked().all(|run| run.fault().is_none());
        let first = self.ask(complete);
        let first = if is_whole || first == ClauseOutcome::NotMet {
            first
        } else {
            // Whatever the others show.
            ClauseOutcome::NotMet
        };
        if first == ClauseOutcome::Met {
            return (first, None);
        }
        let is_about =
            |known: &Known, row: &Summary| known.is_about(self.clause.figure(), &row.cell);
        let about = |row: &Summary, is_accepted: bool| {
            let mut known = self.known.iter();
            known.find(|one| is_about(one, row) && one.is_accepted(self.today) == is_accepted)
        };
        let others: Vec<&Summary> = complete
            .iter()
            .filter(|row| about(row, true).is_none())
            .copied()
            .collect();
        let of = |is_accepted| complete.iter().find_map(|row| about(row, is_accepted));
        if let Some(known) = of(true) {
            let is_enough = others.is_empty() || self.ask(&others) == ClauseOutcome::Met;
            if is_whole && is_enough {
                return (ClauseOutcome::Known, Some(known.reason.clone()));
            }
        }
        let expired = of(false).and_then(|known| {
            let until = known.until?;
            Some(format!("known until {until} only: {}", known.reason))
        });
        (first, expired)
    }

    /// Asks complete runs alone; not met without one.
    fn ask(&self, complete: &[&Summary]) -> ClauseOutcome {
        let clause = self.clause;
        let (met, n) = (count(clause, complete), complete.len());
        let Some(confidence) = clause.confidence() else {
            // In whole runs, so that 90 % of ten are nine.
            return if n > 0 && met as f64 >= clause.share() * n as f64 - 1e-9 {
                ClauseOutcome::Met
            } else {
                ClauseOutcome::NotMet
            };
        };
        if n > 0 && self.drawn == Drawn::Again {
            return ClauseOutcome::NotTold { enough: None };
        }
        let (lower, upper) = bounds(met, n, confidence);
        if n == 0 || upper < clause.share() {
            ClauseOutcome::NotMet
        } else if lower >= clause.share() {
            ClauseOutcome::Met
        } else {
            ClauseOutcome::NotTold {
                enough: enough(n - met, clause.share(), confidence),
            }
        }
    }
}

/// How many complete runs meet a clause. A run without the figure, as one that never settled, does not.
fn count(clause: &Clause, complete: &[&Summary]) -> usize {
    let is_met = |row: &&&Summary| match clause.limit() {
        None => is_met_by(clause.figure(), row.loop_verdict),
        Some(limit) => value(clause.figure(), row).is_some_and(|value| limit.is_kept_by(value)),
    };
    complete.iter().filter(is_met).count()
}

/// Whether a loop that ended so meets a clause on its verdict.
fn is_met_by(figure: Figure, verdict: Option<LoopVerdict>) -> bool {
    verdict.is_some_and(|verdict| match figure {
        Figure::Survives => verdict.is_held(),
        _ => verdict == LoopVerdict::Holds,
    })
}

/// A run's figure, in the unit of its limits; `None` of verdicts, and where the run has none.
#[must_use]
pub fn value(figure: Figure, row: &Summary) -> Option<f64> {
    match figure {
        Figure::Holds | Figure::Survives => None,
        Figure::Settling => row.settling_ms,
        Figure::Rise => row.rise_ms,
        Figure::Overshoot => row.overshoot_pct,
        Figure::Iae => row.iae_s,
        Figure::Sent => row.sent_share.map(|share| share * 100.0),
        Figure::RttP50 => row.message_rtt_p50_ms,
        Figure::RttP90 => row.message_rtt_p90_ms,
        Figure::RttP99 => row.message_rtt_p99_ms,
        Figure::RttMax => row.message_rtt_max_ms,
    }
}

/// Why a run has no value of a figure.
fn lack(figure: Figure, row: &Summary) -> String {
    let quantile = match figure {
        Figure::RttP50 => 0.5,
        Figure::RttP90 => 0.9,
        Figure::RttP99 => 0.99,
        Figure::RttMax => 1.0,
        _ => return format!("no {figure}"),
    };
    let (answered, missing) = (row.messages_answered.unwrap_or(0), row.unanswered());
    let is_among_them = match figure {
        Figure::RttMax => missing > 0,
        _ => Quantiles::falls_among_missing(quantile, answered, missing),
    };
    if is_among_them {
        let sent = answered + missing;
        format!("{figure} has no value: {missing} of {sent} messages had no answer")
    } else {
        format!("{figure} has no value: {answered} answers are too few for it")
    }
}

/// What complete runs show: the median, and the run that is worst. Of loops that all hold none is.
fn shown(clause: &Clause, complete: &[&Summary]) -> Option<Shown> {
    let figure = clause.figure();
    let Some(limit) = clause.limit() else {
        let verdict = |row: &Summary| row.loop_verdict.map(|verdict| verdict as u8);
        let rank = |row: &Summary| verdict(row).unwrap_or(u8::MAX);
        let worst = complete.iter().max_by_key(|row| rank(row))?;
        let words = worst.loop_verdict.map(|verdict| verdict.to_string());
        return (!is_met_by(figure, worst.loop_verdict)).then(|| Shown {
            median: None,
            worst: words.unwrap_or_else(|| "no verdict on the loop".to_owned()),
            cell: worst.cell.clone(),
            repeat: worst.repeat,
        });
    };
    // How far each is from meeting it; without the figure, infinitely.
    let sign = if limit.is_at_most { 1.0 } else { -1.0 };
    let distance = |row: &Summary| value(figure, row).map_or(f64::INFINITY, |value| sign * value);
    let all: Vec<f64> = complete.iter().map(|row| distance(row)).collect();
    let worst = complete
        .iter()
        .max_by(|one, other| distance(one).total_cmp(&distance(other)))?;
    let words = |distance: f64| match distance {
        there if there.is_finite() => answer::figure_words(figure, sign * there),
        _ => "none".to_owned(),
    };
    let worst_words = match value(figure, worst) {
        Some(value) => answer::figure_words(figure, value),
        None => lack(figure, worst),
    };
    Some(Shown {
        median: median(&all).map(words),
        worst: worst_words,
        cell: worst.cell.clone(),
        repeat: worst.repeat,
    })
}

#[cfg(test)]
mod tests;
