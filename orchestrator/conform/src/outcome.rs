//! What came out of a trial, in words: one line each, and a table of all.

use std::fmt;
use std::time::Duration;

use endpoint::Mode;

use crate::check;
use crate::record::Record;
use crate::trial::Trial;

/// Whether a controller passed a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It kept the contract.
    Passed,
    /// It said that it does not support what the trial asks, which the contract allows.
    Unsupported,
    /// It broke the contract.
    Failed,
}

/// The result of a trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrialResult {
    /// Name of the trial.
    pub trial: &'static str,
    /// What it asks, in a sentence.
    pub asks: &'static str,
    /// Whether the controller passed.
    pub verdict: Verdict,
    /// Each fault, or what there is to say without one.
    pub words: Vec<String>,
    /// How long the trial took.
    pub wall: Duration,
}

impl TrialResult {
    /// Judges a trial by what it saw of its controllers.
    pub(crate) fn of(trial: &Trial, records: &[Record], wall: Duration) -> TrialResult {
        let said = |verdict, words| TrialResult {
            trial: trial.name,
            asks: trial.asks,
            verdict,
            words,
            wall,
        };
        let is_unsupported = |record: &Record| record.ending.is_unsupported;
        if trial.mode == Mode::Open && records.iter().any(is_unsupported) {
            let words = "does not support an open loop, as its exit code 127 says".to_owned();
            return said(Verdict::Unsupported, vec![words]);
        }
        // With more than one controller, whose fault it is.
        let mark = |index: usize, words: String| match records {
            [_] => words,
            _ => format!("controller {}: {words}", index + 1),
        };
        let mut words = Vec::new();
        for (index, record) in records.iter().enumerate() {
            let faults = check::faults(trial, record);
            words.extend(faults.iter().map(|fault| mark(index, fault.to_string())));
        }
        if !words.is_empty() {
            return said(Verdict::Failed, words);
        }
        for (index, record) in records.iter().enumerate() {
            words.push(mark(index, numbers(trial, record)));
            words.extend(check::strays(trial, record).map(|note| mark(index, note)));
        }
        said(Verdict::Passed, words)
    }
}

/// The numbers of a controller that passed.
fn numbers(trial: &Trial, record: &Record) -> String {
    let (heard, ending) = (&record.heard, &record.ending);
    let of_due = match ending.told_ns {
        None => format!(" of {}", trial.due()),
        Some(_) => String::new(),
    };
    let messages = format!(
        "{} messages{of_due}, connections: {}",
        heard.messages(),
        heard.connections
    );
    let Some(ended_ns) = ending.ended_ns else {
        return messages;
    };
    let (since, from_ns) = match ending.told_ns {
        Some(told_ns) => ("SIGTERM", told_ns),
        None => ("its time", trial.stop_ns(record.start_ns)),
    };
    let (which, ns) = match ended_ns.checked_sub(from_ns) {
        Some(after_ns) => ("after", after_ns),
        None => ("before", from_ns - ended_ns),
    };
    let s = control::seconds(ns);
    format!("{messages}; ended {s:.2} s {which} {since}")
}

/// The outcomes as a table in words, with a closing line.
#[must_use]
pub fn table(outcomes: &[TrialResult]) -> String {
    let width = outcomes.iter().map(|one| one.trial.len()).max();
    let width = width.unwrap_or_default();
    let mut text = String::new();
    for one in outcomes {
        let verdict = one.verdict.to_string();
        for (index, words) in one.words.iter().enumerate() {
            let (trial, verdict) = match index {
                0 => (one.trial, verdict.as_str()),
                _ => ("", ""),
            };
            text += &format!("{trial:<width$}  {verdict:<11}  {words}\n");
        }
    }
    let count = |verdict| outcomes.iter().filter(|one| one.verdict == verdict).count();
    let passed = count(Verdict::Passed);
    text += &format!("\n{passed} of {} trials passed", outcomes.len());
    match count(Verdict::Unsupported) {
        0 => text + "\n",
        unsupported => text + &format!(", {unsupported} unsupported\n"),
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Passed => "ok",
            Verdict::Unsupported => "unsupported",
            Verdict::Failed => "failed",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_line_for_each_fault_and_counts_what_passed() {
        let outcome = |trial, verdict, words: &[&str]| TrialResult {
            trial,
            asks: "",
            verdict,
            words: words.iter().map(|&one| one.to_owned()).collect(),
            wall: Duration::ZERO,
        };
        let outcomes = [
            outcome("steady", Verdict::Passed, &["fine"]),
            outcome("stop", Verdict::Failed, &["one", "two"]),
            outcome("open", Verdict::Unsupported, &["no"]),
        ];
        let expected = "\
steady  ok           fine
stop    failed       one
                     two
open    unsupported  no

1 of 3 trials passed, 1 unsupported
";
        assert_eq!(table(&outcomes), expected);
    }
}
