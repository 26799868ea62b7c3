//! The answer to a clause, of one group of runs, in a line.

use std::fmt;

use plan::{Client, Figure};

use crate::layout::digits;

/// A clause and a group of runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The clause, as it was asked.
    pub clause: String,
    /// What it is about.
    pub figure: Figure,
    /// Topology, client, setup, mode and rate of the group.
    pub group: String,
    /// The group's client.
    pub client: Client,
    /// The ids of the cells that were asked.
    pub cells: Vec<String>,
    /// Complete runs that meet the clause.
    pub met: usize,
    /// Complete runs.
    pub runs: usize,
    /// Lower and upper bound of the share of all runs that meet it.
    pub bounds: (f64, f64),
    /// The confidence of each bound.
    pub confidence: f64,
    /// What the runs show; `None` without a complete run, and of loops that are all stable.
    pub shown: Option<Shown>,
    /// Runs that are not complete: why, and the cell's id.
    pub incomplete: Vec<(String, String)>,
    /// Number of runs that the machine does not support.
    pub unsupported: usize,
    /// What became of it.
    pub outcome: Outcome,
    /// Why a failure is known, or is not any more.
    pub note: Option<String>,
}

/// What became of a clause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It holds.
    Met,
    /// It does not.
    NotMet,
    /// It cannot be told with the confidence asked for.
    NotTold {
        /// The number of runs that would do if no more of them miss it; `None` if a plan cannot have as many.
        enough: Option<usize>,
    },
    /// It does not hold, but only because of known failures.
    Known,
    /// The machine supports none of the runs.
    Unsupported,
}

impl Outcome {
    /// Whether a gate lets it through.
    #[must_use]
    pub fn holds(self) -> bool {
        !matches!(self, Outcome::NotMet | Outcome::NotTold { .. })
    }

    /// Its word, before an answer.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Outcome::Met => "met",
            Outcome::NotMet => "NOT MET",
            Outcome::NotTold { .. } => "NOT TOLD",
            Outcome::Known => "known",
            Outcome::Unsupported => "not asked",
        }
    }
}

/// What the runs of a group show.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// The median of the figure, in words.
    pub median: Option<String>,
    /// What the worst run shows.
    pub worst: String,
    /// The worst run's cell.
    pub cell: String,
}

/// A figure with its unit; an infinite one is not there.
pub(super) fn figure_words(figure: Figure, value: f64) -> String {
    if value.is_finite() {
        format!("{}{}", digits(Some(value)), figure.unit().suffix())
    } else if figure.to_string().starts_with("rtt") {
        format!("too few answers for {figure}")
    } else {
        format!("no {figure}")
    }
}

impl Answer {
    /// All but its first word.
    #[must_use]
    pub fn words(&self) -> String {
        format!("{}: {} ({})", self.group, self.clause, self.details())
    }

    /// How many runs meet it, what they show, and what is wrong with the others.
    #[must_use]
    pub fn details(&self) -> String {
        let mut parts = Vec::new();
        parts.extend(self.note.clone());
        if let Outcome::NotTold { enough } = self.outcome {
            let runs = self.runs;
            parts.push(match enough {
                Some(enough) => format!(
                    "it cannot be told from {runs} runs; {enough} would do if no more of them miss it"
                ),
                None => format!("it cannot be told from {runs} runs, nor from any number that can be made"),
            });
        }
        let asked = self.cells.len();
        if self.runs == 0 && asked > 0 {
            parts.push("no complete run".to_owned());
        } else if self.runs > 0 {
            let (lower, upper) = self.bounds;
            parts.push(format!(
                "by {} of {} runs, so by {} to {} % of all at {} %",
                self.met,
                self.runs,
                digits(Some(lower * 100.0)),
                digits(Some(upper * 100.0)),
                // Without the noise of a division by 100.
                (self.confidence * 1e8).round() / 1e6
            ));
        }
        if let Some(shown) = &self.shown {
            let median = shown.median.as_ref();
            let median = median.map_or(String::new(), |median| format!("median {median}, "));
            parts.push(format!("{median}worst {} in {}", shown.worst, shown.cell));
        }
        if !self.incomplete.is_empty() {
            parts.push(format!(
                "{} of {asked} runs {} not complete: {}",
                self.incomplete.len(),
                if self.incomplete.len() == 1 {
                    "is"
                } else {
                    "are"
                },
                self.faults()
            ));
        }
        if self.unsupported > 0 {
            let all = asked + self.unsupported;
            let count = self.unsupported;
            parts.push(format!("{count} of {all} runs are not supported here"));
        }
        parts.join("; ")
    }

    /// The first few runs that are not complete, each with its reason.
    fn faults(&self) -> String {
        const FEW: usize = 5;
        let few = self.incomplete.iter().take(FEW);
        let few: Vec<String> = few.map(|(fault, id)| format!("{id} {fault}")).collect();
        match self.incomplete.len().saturating_sub(FEW) {
            0 => few.join(", "),
            more => format!("{} and {more} more", few.join(", ")),
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.outcome.word(), self.words())
    }
}
