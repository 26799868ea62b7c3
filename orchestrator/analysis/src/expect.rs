//! Judges runs by what is expected of them: the clauses of their plan, and those of `--require`.
//!
//! A group is the repeats of one cell. A clause holds for a group if every run of it is complete and enough of
//! them meet the clause: the share of the runs that were made or, with a confidence, the lower bound of the
//! share of all ([`share`](crate::share)). Where a run has no such figure at all (settling of an open loop) the
//! clause is not asked, and runs that the machine does not support are left out.
//!
//! A failure that the plan knows does not count: the clause is asked again of the group's other runs. A run that
//! is not complete is no known failure, since it shows nothing.

mod answer;

use std::collections::BTreeSet;
use std::fmt;

use plan::{Clause, Day, Figure, Known, Plan, Verdict};

use crate::layout::grouped;
use crate::response::LoopVerdict;
use crate::share::{bounds, enough};
use crate::statistics::median;
use crate::summary::Summary;
use crate::{Damage, Run};

pub use answer::{Answer, Outcome, Shown};

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
        self.unasked.is_empty() && self.answers.iter().all(|answer| answer.outcome.holds())
    }
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
        Ok(())
    }
}

/// A run, as far as it is asked.
#[derive(Clone, Copy)]
struct Asked<'a> {
    index: usize,
    row: &'a Summary,
    damage: &'a [Damage],
}

impl<'a> Asked<'a> {
    fn of(run: &'a Run) -> Asked<'a> {
        Asked {
            index: run.cell.index,
            row: &run.summary,
            damage: &run.damage,
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
    let runs: Vec<Asked<'_>> = runs.iter().map(|run| Asked::of(run)).collect();
    judge_asked(plan, &runs, required, today)
}

fn judge_asked(plan: &Plan, runs: &[Asked<'_>], required: &[Clause], today: Day) -> Judgement {
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
        let has_it = |run: &&Asked<'_>| clause.figure().is_of(run.row.mode);
        let of_it = runs.iter().filter(|run| cells.contains(&run.index));
        let groups = grouped(of_it.filter(has_it), |run| {
            let row = run.row;
            (&row.topology, row.client, &row.setup, row.mode, row.h_ns)
        });
        for (_, group) in groups {
            let group = Group {
                clause,
                known: &plan.known,
                today,
                runs: group.into_iter().copied().collect(),
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
    about.peek().is_some() && about.all(|answer| answer.outcome == Outcome::Met)
}

/// A clause and the runs of a group.
struct Group<'a> {
    clause: &'a Clause,
    known: &'a [Known],
    today: Day,
    /// At least one.
    runs: Vec<Asked<'a>>,
}

impl Group<'_> {
    fn answer(&self) -> Answer {
        let first = self.runs[0].row;
        let asked = || self.runs.iter().filter(|run| !run.is_unsupported());
        let complete: Vec<&Summary> = asked()
            .filter(|run| run.fault().is_none())
            .map(|run| run.row)
            .collect();
        let incomplete: Vec<(String, String)> = asked()
            .filter_map(|run| Some((run.fault()?, run.row.cell.clone())))
            .collect();
        let (met, n) = (count(self.clause, &complete), complete.len());
        let confidence = self.clause.confidence().unwrap_or(USUAL_CONFIDENCE);
        let (outcome, note) = self.outcome(&complete, incomplete.is_empty());
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
            bounds: bounds(met, n, confidence),
            confidence,
            shown: shown(self.clause, &complete),
            incomplete,
            unsupported: self.runs.len() - asked().count(),
            outcome,
            note,
        }
    }

    /// The outcome, and the reason of a failure that is known, or was.
    fn outcome(&self, complete: &[&Summary], is_whole: bool) -> (Outcome, Option<String>) {
        if self.runs.iter().all(Asked::is_unsupported) {
            return (Outcome::Unsupported, None);
        }
        let first = ask(self.clause, complete);
        let first = if is_whole || first == Outcome::NotMet {
            first
        } else {
            // Whatever the others show.
            Outcome::NotMet
        };
        if first == Outcome::Met {
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
            let is_enough = others.is_empty() || ask(self.clause, &others) == Outcome::Met;
            if is_whole && is_enough {
                return (Outcome::Known, Some(known.reason.clone()));
            }
        }
        let expired = of(false).and_then(|known| {
            let until = known.until?;
            Some(format!("known until {until} only: {}", known.reason))
        });
        (first, expired)
    }
}

/// Asks complete runs alone; not met without one.
fn ask(clause: &Clause, complete: &[&Summary]) -> Outcome {
    let (met, n) = (count(clause, complete), complete.len());
    let Some(confidence) = clause.confidence() else {
        // In whole runs, so that 90 % of ten are nine.
        return if n > 0 && met as f64 >= clause.share() * n as f64 - 1e-9 {
            Outcome::Met
        } else {
            Outcome::NotMet
        };
    };
    let (lower, upper) = bounds(met, n, confidence);
    if n == 0 || upper < clause.share() {
        Outcome::NotMet
    } else if lower >= clause.share() {
        Outcome::Met
    } else {
        Outcome::NotTold {
            enough: enough(n - met, clause.share(), confidence),
        }
    }
}

/// How many complete runs meet a clause. A run without the figure, as one that never settled, does not.
fn count(clause: &Clause, complete: &[&Summary]) -> usize {
    let is_met = |row: &&&Summary| match clause.limit() {
        None => row.loop_verdict == Some(LoopVerdict::Stable),
        Some(limit) => value(clause.figure(), row).is_some_and(|value| limit.is_kept_by(value)),
    };
    complete.iter().filter(is_met).count()
}

/// A run's figure, in the unit of the clause.
fn value(figure: Figure, row: &Summary) -> Option<f64> {
    match figure {
        Figure::Stable => None,
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

/// What complete runs show: the median, and the run that is worst. Of loops that are all stable none is.
fn shown(clause: &Clause, complete: &[&Summary]) -> Option<Shown> {
    let figure = clause.figure();
    let Some(limit) = clause.limit() else {
        let verdict = |row: &Summary| row.loop_verdict.map(|verdict| verdict as u8);
        let rank = |row: &Summary| verdict(row).unwrap_or(u8::MAX);
        let worst = complete.iter().max_by_key(|row| rank(row))?;
        let words = worst.loop_verdict.map(|verdict| verdict.to_string());
        return (worst.loop_verdict != Some(LoopVerdict::Stable)).then(|| Shown {
            median: None,
            worst: words.unwrap_or_else(|| "no verdict on the loop".to_owned()),
            cell: worst.cell.clone(),
        });
    };
    // How far each is from meeting it; without the figure, infinitely.
    let sign = if limit.is_at_most { 1.0 } else { -1.0 };
    let distance = |row: &Summary| value(figure, row).map_or(f64::INFINITY, |value| sign * value);
    let all: Vec<f64> = complete.iter().map(|row| distance(row)).collect();
    let worst = complete
        .iter()
        .max_by(|one, other| distance(one).total_cmp(&distance(other)))?;
    let words = |distance: f64| answer::figure_words(figure, sign * distance);
    Some(Shown {
        median: median(&all).map(words),
        worst: words(distance(worst)),
        cell: worst.cell.clone(),
    })
}

#[cfg(test)]
mod tests;
