//! From parts to a finding: which runs were used, which parts decide, and the reason in words.

use super::source::Source;
use super::words;
use report::claim::{Finding, Part, Verdict};

/// One stall can shift a median over fewer runs than this.
const RUNS_ASKED: usize = 20;

/// All that was found about a claim.
#[derive(Debug, Default)]
pub(super) struct Evidence {
    deciding: Vec<Part>,
    beside: Vec<Part>,
    runs: Vec<String>,
    missing: Vec<String>,
    few: Vec<String>,
    notes: Vec<String>,
    explanations: Vec<String>,
}

impl Evidence {
    /// Records that these runs were used. If there are none, the reason says so.
    pub(super) fn ask(&mut self, source: &Source<'_>) {
        self.ask_beside(source);
        if source.is_empty() {
            self.lack(match source.group.planned {
                0 => format!("{} (not in the plan)", source.label()),
                n => format!("{} (none of {n} planned complete)", source.label()),
            });
        }
    }

    /// Records that something needed is missing.
    pub(super) fn lack(&mut self, what: String) {
        if !self.missing.contains(&what) {
            self.missing.push(what);
        }
    }

    /// Records that these runs were used, although the verdict does not depend on them.
    pub(super) fn ask_beside(&mut self, source: &Source<'_>) {
        for id in source.group.ids() {
            self.ask_cell(&id);
        }
    }

    /// Records that this cell was used.
    pub(super) fn ask_cell(&mut self, id: &str) {
        if !self.runs.iter().any(|run| run == id) {
            self.runs.push(id.to_owned());
        }
    }

    /// Adds a part on which the verdict depends.
    pub(super) fn decide(&mut self, part: Part) {
        self.deciding.push(part);
    }

    /// Adds a part that is only shown.
    pub(super) fn show(&mut self, part: Part) {
        self.beside.push(part);
    }

    /// Records whether there are fewer runs than a median needs.
    pub(super) fn few(&mut self, source: &Source<'_>) {
        let n = source.group.runs.len();
        let words = format!("{n} of {}", source.label());
        if (1..RUNS_ASKED).contains(&n) && !self.few.contains(&words) {
            self.few.push(words);
        }
    }

    /// Adds a sentence for any verdict.
    pub(super) fn note(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if !self.notes.contains(&sentence) {
            self.notes.push(sentence);
        }
    }

    /// Adds a sentence for the case that the claim differs.
    pub(super) fn explain(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if !self.explanations.contains(&sentence) {
            self.explanations.push(sentence);
        }
    }

    /// The finding. Its verdict is the worst of the deciding parts; without any, the claim was not run.
    pub(super) fn on(self, claim: Finding) -> Finding {
        let worst = self.deciding.iter().map(|part| part.verdict).max();
        let verdict = worst.unwrap_or(Verdict::NotRun);
        let mut sentences = vec![self.numbers(verdict)];
        if verdict == Verdict::Differs {
            sentences.extend(self.explanations);
        }
        if !self.runs.is_empty() {
            sentences.extend(self.notes);
        }
        if !self.few.is_empty() {
            sentences.push(format!(
                "The medians are over fewer than the {RUNS_ASKED} runs that one stall cannot lead: {}.",
                self.few.join("; ")
            ));
        }
        Finding {
            verdict,
            reason: sentences.join(" "),
            parts: self.deciding.into_iter().chain(self.beside).collect(),
            runs: self.runs,
            ..claim
        }
    }

    fn numbers(&self, verdict: Verdict) -> String {
        let with = |verdict| {
            self.deciding
                .iter()
                .filter(move |part| part.verdict == verdict)
        };
        let list = |parts: &mut dyn Iterator<Item = &Part>| {
            parts.map(words::part).collect::<Vec<_>>().join("; ")
        };
        match verdict {
            Verdict::Agrees => words::all_agree(&self.deciding),
            Verdict::Differs | Verdict::CannotBeTold => {
                let agree = match with(Verdict::Agrees).count() {
                    0 => String::new(),
                    n => format!(" Of the {} parts {n} agree.", self.deciding.len()),
                };
                let cannot_tell = match verdict {
                    Verdict::CannotBeTold => "Undecided: ",
                    _ => "",
                };
                format!("{cannot_tell}{}.{agree}", list(&mut with(verdict)))
            }
            Verdict::NotRun => {
                let missing = if self.missing.is_empty() {
                    "nothing that it needs".to_owned()
                } else {
                    self.missing.join("; ")
                };
                let run = list(
                    &mut self
                        .deciding
                        .iter()
                        .chain(&self.beside)
                        .filter(|part| part.ours.is_some()),
                );
                if run.is_empty() {
                    format!("Not run: {missing}.")
                } else {
                    format!("Not run: {missing}. What was run: {run}.")
                }
            }
        }
    }
}
