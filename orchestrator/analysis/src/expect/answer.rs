//! The answer to a clause, of one group of runs, in a line.

use std::fmt;

use plan::{Client, Figure};

use crate::layout::digits;
use crate::variety::Variety;

/// Bounds of a share, the lower and the upper one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bounds {
    /// Each by itself with the confidence of the clause, which asks one of them.
    OneSide((f64, f64)),
    /// Both together with the confidence.
    Interval((f64, f64)),
}

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
    /// Bounds of the share of all runs that meet it.
    pub bounds: Bounds,
    /// The confidence of each bound.
    pub confidence: f64,
    /// What these runs are of all that there could be.
    pub drawn: Drawn,
    /// What the runs show; `None` without a complete run, and of loops that all hold.
    pub shown: Option<Shown>,
    /// Runs that are not complete: why, and the cell's id.
    pub incomplete: Vec<(String, String)>,
    /// Number of runs that the machine does not support.
    pub unsupported: usize,
    /// What became of it.
    pub outcome: ClauseOutcome,
    /// Why a failure is known, or is not any more.
    pub note: Option<String>,
}

/// What the complete runs of a group are of all that there could be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawn {
    /// There is none.
    Nothing,
    /// A single one.
    Once,
    /// One run that was made several times: nothing varies between them.
    Again,
    /// Several, which this distinguishes.
    Of(Variety),
}

/// What became of a clause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClauseOutcome {
    /// It holds.
    Met,
    /// It does not.
    NotMet,
    /// It cannot be told with the confidence asked for.
    NotTold {
        /// The number of runs that would do if no more of them miss it; `None` if a plan cannot have as many, or if
        /// nothing varies between them.
        enough: Option<usize>,
    },
    /// It does not hold, but only because of known failures.
    Known,
    /// The machine supports none of the runs.
    Unsupported,
}

impl ClauseOutcome {
    /// Whether a gate lets it through.
    #[must_use]
    pub fn holds(self) -> bool {
        !matches!(self, ClauseOutcome::NotMet | ClauseOutcome::NotTold { .. })
    }

    /// Its word, before an answer.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            ClauseOutcome::Met => "met",
            ClauseOutcome::NotMet => "NOT MET",
            ClauseOutcome::NotTold { .. } => "NOT TOLD",
            ClauseOutcome::Known => "known",
            ClauseOutcome::Unsupported => "not asked",
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
    /// Which repeat that is.
    pub repeat: u32,
}

/// A figure with its unit.
pub(super) fn figure_words(figure: Figure, value: f64) -> String {
    format!("{}{}", digits(Some(value)), figure.unit().suffix())
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
        if let ClauseOutcome::NotTold { enough } = self.outcome {
            let runs = self.runs;
            parts.push(match enough {
                Some(enough) if self.met == runs => {
                    format!("{runs} runs cannot tell, {enough} would if all of them meet it")
                }
                Some(enough) => {
                    format!("{runs} runs cannot tell, {enough} would if no more of them miss it")
                }
                None if self.drawn == Drawn::Again => "no number of equal runs can tell".to_owned(),
                None => format!("{runs} runs cannot tell, nor any number that can be made"),
            });
        }
        let asked = self.cells.len();
        if self.runs == 0 && asked > 0 {
            parts.push("no complete run".to_owned());
        } else if self.runs > 0 {
            parts.push(self.share());
        }
        if let Some(shown) = &self.shown {
            let (worst, repeat) = (&shown.worst, shown.repeat);
            parts.push(match &shown.median {
                _ if self.runs == 1 => worst.clone(),
                None => format!("worst in run {repeat}: {worst}"),
                Some(median) => format!("median {median}, worst in run {repeat}: {worst}"),
            });
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

    /// How many runs meet it, and what that says of all that there could be.
    fn share(&self) -> String {
        let (met, n) = (self.met, self.runs);
        match self.drawn {
            Drawn::Once if met == n => "1 of 1 met it, with one run nothing is sure".to_owned(),
            Drawn::Once => "1 of 1 missed it, with one run nothing is sure".to_owned(),
            Drawn::Nothing => format!("{met} of {n}"),
            Drawn::Again => {
                format!("{met} of {n}, but 1 distinct run: nothing varies between them")
            }
            Drawn::Of(variety) => {
                let percent = |of: f64| digits(Some(of * 100.0));
                let range = match self.bounds {
                    Bounds::Interval((lower, upper)) => {
                        format!("{} to {}", percent(lower), percent(upper))
                    }
                    Bounds::OneSide((_, upper)) if self.outcome == ClauseOutcome::NotMet => {
                        format!("at most {}", percent(upper))
                    }
                    Bounds::OneSide((lower, _)) => format!("at least {}", percent(lower)),
                };
                // Without the noise of a division by 100.
                let confidence = (self.confidence * 1e8).round() / 1e6;
                format!("{met} of {n}, so {range} % of all {variety} at {confidence} %")
            }
        }
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
