//! A group of runs that a claim asks for, with its label.

use analysis::Campaign;
use endpoint::SampleTime;

use crate::subject::AskedRuns;
use report::claim::{Limits, Part};
use report::group::{Estimate, Group};

/// A group of runs, and its label in a part.
#[derive(Debug, Clone)]
pub(super) struct Source<'a> {
    pub(super) group: Group<'a>,
    pub(super) asked: AskedRuns<'static>,
    label: String,
}

impl<'a> Source<'a> {
    pub(super) fn of(campaign: &'a Campaign, asked: AskedRuns<'static>) -> Self {
        let rate =
            SampleTime::try_new(asked.h_ns).map_or_else(|wrong| wrong.to_string(), plan::rate);
        let with = match asked.with.is_nothing() {
            true => String::new(),
            false => format!(", {}", asked.with),
        };
        let who = asked.subject.label();
        Source {
            group: asked.group(campaign),
            asked,
            label: format!("{who}, {}, {rate}{with}", asked.topology),
        }
    }

    /// A number of these runs, judged by the rule in `rule`.
    pub(super) fn part(
        &self,
        quantity: &str,
        unit: &'static str,
        paper: Option<f64>,
        ours: Option<Estimate>,
        limits: impl Into<Limits>,
    ) -> Part {
        Part::judged(quantity, unit, paper, ours, limits).at(&self.label)
    }

    /// Client, topology and rate: `python, diego-vpn, 333 Hz`.
    pub(super) fn label(&self) -> &str {
        &self.label
    }

    pub(super) fn is_empty(&self) -> bool {
        self.group.runs.is_empty()
    }

    /// The sample time, s.
    pub(super) fn h_s(&self) -> f64 {
        self.asked.h_ns as f64 / 1e9
    }
}
