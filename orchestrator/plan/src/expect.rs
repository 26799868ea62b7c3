//! What an experiment expects of its runs: `[expect]` as written, and as a plan has it.
//!
//! A plan says for each clause which cells it is asked of, by their indices: an index is unique in its plan, and
//! the plan stays whole whatever is selected from it.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::Diagnostic;

use crate::cell::Cell;
use crate::clause::{Clause, Figure};
use crate::invalid::{Reader, Word};

/// Clauses, and the cells that they are asked of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// Indices of the cells, ascending.
    pub cells: BTreeSet<usize>,
    /// The clauses, each as `--require` takes it.
    pub clauses: Vec<Clause>,
}

/// `[expect]` or `expect = {...}` as written: what is asked of each run, and of how many.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Expect {
    /// Whether loops hold, and hold well: all, or "in 90%". `stable` is an older word for it.
    #[serde(alias = "stable")]
    #[schemars(with = "Option<String>")]
    holds: Option<Word>,
    /// Whether loops hold, well or badly: all, or "in 95%".
    #[schemars(with = "Option<String>")]
    survives: Option<Word>,
    /// Limit of the settling time into the band: "<= 400ms in 95%".
    #[schemars(with = "Option<String>")]
    settling: Option<Word>,
    /// Limit of the rise time from 10 to 90 %: "<= 200ms".
    #[schemars(with = "Option<String>")]
    rise: Option<Word>,
    /// Limit of the overshoot, of the step: "<= 20%".
    #[schemars(with = "Option<String>")]
    overshoot: Option<Word>,
    /// Limit of the integral of the absolute error, s: "<= 0.3".
    #[schemars(with = "Option<String>")]
    iae: Option<Word>,
    /// Limit of the messages sent, of those due: ">= 99%".
    #[schemars(with = "Option<String>")]
    sent: Option<Word>,
    /// Limits of the round trips of messages.
    #[serde(default)]
    rtt: ExpectRtt,
    /// How sure a share of runs has to be, such as 95%; without it the runs that were made are asked.
    #[schemars(with = "Option<String>")]
    confidence: Option<Word>,
}

/// Limits of the round trips of messages.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ExpectRtt {
    /// Limit of the median: "<= 60ms".
    #[schemars(with = "Option<String>")]
    p50: Option<Word>,
    /// Limit of the 90th percentile.
    #[schemars(with = "Option<String>")]
    p90: Option<Word>,
    /// Limit of the 99th percentile.
    #[schemars(with = "Option<String>")]
    p99: Option<Word>,
    /// Limit of the longest.
    #[schemars(with = "Option<String>")]
    max: Option<Word>,
}

impl Expect {
    /// What is written, by figure.
    fn words(&self) -> impl Iterator<Item = (Figure, &Word)> {
        let all = [
            (Figure::Holds, &self.holds),
            (Figure::Survives, &self.survives),
            (Figure::Settling, &self.settling),
            (Figure::Rise, &self.rise),
            (Figure::Overshoot, &self.overshoot),
            (Figure::Iae, &self.iae),
            (Figure::Sent, &self.sent),
            (Figure::RttP50, &self.rtt.p50),
            (Figure::RttP90, &self.rtt.p90),
            (Figure::RttP99, &self.rtt.p99),
            (Figure::RttMax, &self.rtt.max),
        ];
        all.into_iter()
            .filter_map(|(figure, word)| Some((figure, word.as_ref()?)))
    }
}

/// A clause with its place in the file.
pub(crate) type Placed<'a> = (Clause, &'a Word);

impl Reader<'_> {
    /// The clauses of a block: its own, and those of the whole experiment on other figures.
    pub(crate) fn clauses<'a>(
        &self,
        whole: &'a Expect,
        own: &'a Expect,
    ) -> Result<Vec<Placed<'a>>, Diagnostic> {
        let own = self.read_clauses(own)?;
        let whole = self.read_clauses(whole)?;
        let is_replaced = |figure| own.iter().any(|(clause, _)| clause.figure() == figure);
        let kept: Vec<Placed<'_>> = whole
            .into_iter()
            .filter(|(clause, _)| !is_replaced(clause.figure()))
            .collect();
        Ok(kept.into_iter().chain(own).collect())
    }

    fn read_clauses<'a>(&self, expect: &'a Expect) -> Result<Vec<Placed<'a>>, Diagnostic> {
        let wrong = |word: &Word, problem: String| self.invalid(word, problem, "");
        if let Some(confidence) = &expect.confidence {
            // Also if no clause asks for a share yet.
            let some: Result<Clause, _> = "holds in 50%".parse();
            some.and_then(|some| some.at(confidence.get_ref()))
                .map_err(|problem| wrong(confidence, problem.to_string()))?;
        }
        let read = |(figure, word): (Figure, &'a Word)| {
            let text = match (figure, word.get_ref().trim()) {
                (figure, "all") if figure.is_verdict() => figure.to_string(),
                (figure, text) if figure.is_verdict() && !text.starts_with("in ") => {
                    let problem = format!("`{text}` does not say how many loops are to hold");
                    return Err(self.invalid(word, problem, "give all, or a share like in 90%"));
                }
                (figure, text) => format!("{figure} {text}"),
            };
            let clause = text
                .parse::<Clause>()
                .and_then(|clause| match &expect.confidence {
                    Some(confidence) => clause.at(confidence.get_ref()),
                    None => Ok(clause),
                });
            let clause = clause.map_err(|problem| wrong(word, problem.to_string()))?;
            Ok((clause, word))
        };
        expect.words().map(read).collect()
    }
}

/// Collects the clauses of blocks while their cells are made.
#[derive(Default)]
pub(crate) struct Expectations {
    /// Each clause with its place in the file, and the ids of the cells that it is asked of.
    clauses: Vec<(Clause, Word, BTreeSet<String>)>,
}

impl Expectations {
    /// Asks clauses of cells, those of a block. Where two blocks have the same cell, both their clauses are
    /// asked of it.
    pub(crate) fn ask(&mut self, clauses: Vec<Placed<'_>>, cells: &[Cell]) {
        for (clause, place) in clauses {
            let has_it = |cell: &&Cell| clause.figure().is_of(cell.settings.mode);
            let ids: BTreeSet<String> = cells
                .iter()
                .filter(has_it)
                .map(|cell| cell.id.clone())
                .collect();
            match self.clauses.iter_mut().find(|(known, ..)| *known == clause) {
                Some((.., known)) => known.extend(ids),
                None => self.clauses.push((clause, place.clone(), ids)),
            }
        }
    }

    /// As a plan has them, once its cells have their indices: clauses that are asked of the same cells together.
    pub(crate) fn of(
        self,
        cells: &[Cell],
        reader: Reader<'_>,
    ) -> Result<Vec<Expectation>, Diagnostic> {
        let mut all: Vec<Expectation> = Vec::new();
        for (clause, place, ids) in self.clauses {
            if ids.is_empty() {
                let figure = clause.figure();
                return Err(reader.invalid(
                    &place,
                    format!("no cell has {figure}, which is of closed loops"),
                    "leave it out, or expect it of a block whose `mode` is closed",
                ));
            }
            let asked = cells.iter().filter(|cell| ids.contains(&cell.id));
            let asked: BTreeSet<usize> = asked.map(|cell| cell.index).collect();
            match all.iter_mut().find(|known| known.cells == asked) {
                Some(known) => known.clauses.push(clause),
                None => all.push(Expectation {
                    cells: asked,
                    clauses: vec![clause],
                }),
            }
        }
        Ok(all)
    }
}
