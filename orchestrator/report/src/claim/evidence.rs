//! From parts to a finding: which runs were asked, which parts decide, and the reason in words.

use analysis::{Campaign, Run};
use endpoint::{Mode, Preset};
use plan::Client;

use super::{Finding, Part, Verdict, words};
use crate::group::{Asked, Estimate, Group};

/// What the paper says, before anything is held against it; the fields are [`Finding`]'s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim {
    pub(super) id: &'static str,
    pub(super) place: &'static str,
    pub(super) claim: &'static str,
    pub(super) check: &'static str,
}

/// A client with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Who {
    pub(super) client: Client,
    pub(super) preset: Preset,
}

/// The paper's Python client.
pub(super) const PYTHON: Who = Who {
    client: Client::Python,
    preset: Preset::PaperPython,
};
/// The paper's JavaScript client in the paper's browser: what claims on JavaScript are judged by.
pub(super) const FIREFOX: Who = Who {
    client: Client::Firefox,
    preset: Preset::Paper2011,
};
/// The same program in a browser that the paper does not name: shown beside, and decides nothing.
pub(super) const CHROMIUM: Who = Who {
    client: Client::Chromium,
    preset: Preset::Paper2011,
};

/// A median over fewer runs can be led by one stall.
pub(super) const RUNS_ASKED: usize = 20;

/// The topologies of the paper's Figures 3 to 5 and 8, and of Table 3.
pub(super) const NEAR: [&str; 3] = ["arima", "buccoo", "couva"];

/// Some runs, and what they are called in a part.
#[derive(Debug, Clone)]
pub(super) struct Source<'a> {
    pub(super) group: Group<'a>,
    pub(super) h_ns: u64,
    label: String,
}

impl<'a> Source<'a> {
    pub(super) fn open(campaign: &'a Campaign, who: Who, topology: &str, h_ns: u64) -> Self {
        Self::of(campaign, who, topology, Mode::Open, h_ns)
    }

    pub(super) fn closed(campaign: &'a Campaign, who: Who, topology: &str, h_ns: u64) -> Self {
        Self::of(campaign, who, topology, Mode::Closed, h_ns)
    }

    /// The step responses of Python at 333 Hz with a plant that is as noisy as it is told to be: of a reading,
    /// and of no claim.
    pub(super) fn noisy(campaign: &'a Campaign, topology: &str) -> Self {
        let is = |run: &&Run| {
            let cell = &run.cell;
            cell.topology == topology
                && cell.client == PYTHON.client
                && cell.preset == PYTHON.preset
                && cell.settings.mode == Mode::Closed
                && cell.settings.h.ns() == crate::paper::H_333_HZ_NS
                && cell.tick_noise.is_some()
        };
        let planned: Vec<&Run> = campaign.runs.iter().filter(is).collect();
        let law = planned.first().and_then(|run| run.cell.tick_noise);
        let noise = law.map_or_else(String::new, |law| format!(", tick noise {law}"));
        Source {
            group: Group {
                planned: planned.len(),
                runs: planned
                    .into_iter()
                    .filter(|run| run.is_complete())
                    .collect(),
            },
            h_ns: crate::paper::H_333_HZ_NS,
            label: format!("python, {topology}, 333 Hz{noise}"),
        }
    }

    fn of(campaign: &'a Campaign, who: Who, topology: &str, mode: Mode, h_ns: u64) -> Self {
        let asked = Asked {
            topology,
            client: who.client,
            preset: who.preset,
            mode,
            h_ns,
        };
        let client = match who == PYTHON {
            true => who.client.to_string(),
            false => format!("{} {}", who.client, who.preset),
        };
        Source {
            group: Group::of(campaign, asked),
            h_ns,
            label: format!("{client}, {topology}, {}", rate(h_ns)),
        }
    }

    /// What a part is of: `settling, python, diego-vpn, 333 Hz`.
    pub(super) fn name(&self, quantity: &str) -> String {
        format!("{quantity}, {}", self.label)
    }

    /// Who and where: `python, diego-vpn, 333 Hz`.
    pub(super) fn label(&self) -> &str {
        &self.label
    }

    pub(super) fn is_empty(&self) -> bool {
        self.group.runs.is_empty()
    }

    /// The median over the runs of a figure that each of them has.
    pub(super) fn median(&self, figure: impl Fn(&Run) -> Option<f64>) -> Option<Estimate> {
        Estimate::median(&self.group.values(figure))
    }

    /// The sample time, s.
    pub(super) fn h_s(&self) -> f64 {
        self.h_ns as f64 / 1e9
    }
}

/// The paper's rates in its words.
fn rate(h_ns: u64) -> &'static str {
    match h_ns {
        crate::paper::H_3_HZ_NS => "3.3 Hz",
        crate::paper::H_10_HZ_NS => "10 Hz",
        crate::paper::H_100_HZ_NS => "100 Hz",
        crate::paper::H_333_HZ_NS => "333 Hz",
        crate::paper::H_1_KHZ_NS => "1 kHz",
        _ => "another rate",
    }
}

/// All that was found on a claim.
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
    /// Says that these runs were asked. Where there are none the reason will say so.
    pub(super) fn ask(&mut self, source: &Source<'_>) {
        self.ask_beside(source);
        if source.is_empty() {
            self.lack(match source.group.planned {
                0 => format!("{} (not in the plan)", source.label),
                n => format!("{} (none of {n} planned complete)", source.label),
            });
        }
    }

    /// Says that something needed is not there.
    pub(super) fn lack(&mut self, what: String) {
        if !self.missing.contains(&what) {
            self.missing.push(what);
        }
    }

    /// Says that these runs were looked at; the verdict does not hang on them.
    pub(super) fn ask_beside(&mut self, source: &Source<'_>) {
        for id in source.group.ids() {
            self.ask_cell(&id);
        }
    }

    /// Says that this cell was asked.
    pub(super) fn ask_cell(&mut self, id: &str) {
        if !self.runs.iter().any(|run| run == id) {
            self.runs.push(id.to_owned());
        }
    }

    /// A part that the verdict hangs on.
    pub(super) fn decide(&mut self, part: Part) {
        self.deciding.push(part);
    }

    /// A part that is only shown.
    pub(super) fn show(&mut self, part: Part) {
        self.beside.push(part);
    }

    /// Says that there are fewer runs than a median asks for.
    pub(super) fn few(&mut self, source: &Source<'_>) {
        let words = format!("{} of {}", source.group.runs.len(), source.label);
        if !self.few.contains(&words) {
            self.few.push(words);
        }
    }

    /// A sentence that is said whatever the verdict.
    pub(super) fn note(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if !self.notes.contains(&sentence) {
            self.notes.push(sentence);
        }
    }

    /// A sentence that is said where the verdict is that the claim differs.
    pub(super) fn explain(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if !self.explanations.contains(&sentence) {
            self.explanations.push(sentence);
        }
    }

    /// The finding. Its verdict is the worst of the deciding parts'; without any it was not run.
    pub(super) fn on(self, claim: Claim) -> Finding {
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
            id: claim.id,
            place: claim.place,
            claim: claim.claim,
            check: claim.check,
            reading_of: None,
            verdict,
            reason: sentences.join(" "),
            parts: self.deciding.into_iter().chain(self.beside).collect(),
            runs: self.runs,
        }
    }

    /// The finding on a reading of a claim.
    pub(super) fn on_reading(self, claim: Claim, of: &'static str) -> Finding {
        Finding {
            reading_of: Some(of),
            ..self.on(claim)
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
                    Verdict::CannotBeTold => "It cannot be told: ",
                    _ => "",
                };
                format!("{cannot_tell}{}.{agree}", list(&mut with(verdict)))
            }
            Verdict::NotRun => {
                let missing = match self.missing.is_empty() {
                    true => "nothing that it needs".to_owned(),
                    false => self.missing.join("; "),
                };
                let run = list(
                    &mut self
                        .deciding
                        .iter()
                        .chain(&self.beside)
                        .filter(|part| part.ours.is_some()),
                );
                match run.is_empty() {
                    true => format!("Not run: {missing}."),
                    false => format!("Not run: {missing}. What was run: {run}."),
                }
            }
        }
    }
}
