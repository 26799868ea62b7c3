//! A claim's rows: which runs, which number, and what is accepted. One function judges each.

use analysis::Campaign;
use serde::Deserialize;

use super::evidence::Evidence;
use super::metric::Metric;
use super::source::Source;
use crate::subject::{AskedRuns, Except};
use record::ReadError;
use report::claim::rule;
use report::claim::{Limits, Verdict};
use report::group::Estimate;

/// One number of one group of runs.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) asked: AskedRuns<'static>,
    pub(super) metric: Metric,
    /// By whose number it is divided.
    pub(super) over: Option<Except>,
    pub(super) paper: Option<f64>,
    pub(super) accepted: Accepted,
    pub(super) weight: Weight,
}

/// How a row is used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Weight {
    /// The verdict depends on it.
    #[default]
    Decides,
    /// Its runs are needed, but its number is only shown.
    Shown,
    /// It is shown if there are runs, such as those of a browser that the paper does not name.
    Beside,
}

/// Where a number agrees.
#[derive(Debug)]
pub(super) enum Accepted {
    /// From one number to another.
    Within((f64, f64)),
    /// Above the number of another group.
    Above(Than),
    /// Below the number of another group.
    Below(Than),
    /// From one number to another, or anywhere if another number of the same runs is beyond limits of
    /// its own.
    WithinOrBeyond((f64, f64), Metric, (f64, f64)),
}

/// A limit that is itself measured.
#[derive(Debug)]
pub(super) struct Than {
    pub(super) asked: AskedRuns<'static>,
    /// Another figure than the row's.
    pub(super) metric: Option<Metric>,
    /// Divided by another number than the row's is.
    pub(super) over: Option<Except>,
    /// The limit is so many times the size of the number.
    pub(super) times: Option<f64>,
    /// And with `times` it is this at least.
    pub(super) least: f64,
    /// The limits to show if it was not run; the number is not compared with them.
    pub(super) unknown: (f64, f64),
}

/// A row with its result.
pub(super) struct Judged<'a> {
    pub(super) row: &'a Row,
    pub(super) source: Source<'a>,
    pub(super) ours: Option<Estimate>,
    pub(super) verdict: Verdict,
}

impl Row {
    /// Judges its number, and adds it to the evidence.
    pub(super) fn judge<'a>(
        &'a self,
        campaign: &'a Campaign,
        evidence: &mut Evidence,
    ) -> Result<Judged<'a>, ReadError> {
        let source = Source::of(campaign, self.asked);
        let mut ours = number(campaign, &source, &self.metric, self.over)?;
        let mut measured = |than: &Than, limits: fn(Estimate) -> Limits| {
            let other = Source::of(campaign, than.asked);
            evidence.ask(&other);
            let metric = than.metric.as_ref().unwrap_or(&self.metric);
            if let Some(over) = than.over {
                evidence.ask(&Source::of(campaign, than.asked.but(over)));
            }
            let other = number(campaign, &other, metric, than.over.or(self.over))?;
            // Without the other group there is no limit to be above or below.
            ours = other.and(ours);
            Ok(other.map_or(than.unknown.into(), |other| limits(than.scaled(other))))
        };
        let limits = match &self.accepted {
            Accepted::Within(limits) | Accepted::WithinOrBeyond(limits, ..) => (*limits).into(),
            Accepted::Above(than) => measured(than, Limits::above)?,
            Accepted::Below(than) => measured(than, Limits::below)?,
        };
        let unit = self.over.map_or(self.metric.unit, |_| "");
        let mut part = source.part(&self.words(), unit, self.paper, ours, limits);
        if let Accepted::WithinOrBeyond(_, other, limits) = &self.accepted {
            let other = rule::judge(other.of(&source)?, &(*limits).into());
            part.verdict = match (part.verdict, other) {
                (Verdict::Differs, Verdict::Differs) => Verdict::Agrees,
                (Verdict::Differs, Verdict::CannotBeTold) => Verdict::CannotBeTold,
                (verdict, _) => verdict,
            };
        }
        let verdict = part.verdict;
        if self.weight == Weight::Beside {
            evidence.ask_beside(&source);
        } else {
            evidence.ask(&source);
            if let Some(over) = self.over {
                evidence.ask(&Source::of(campaign, self.asked.but(over)));
            }
        }
        if self.weight == Weight::Decides {
            evidence.decide(part);
        } else {
            evidence.show(part);
        }
        Ok(Judged {
            row: self,
            source,
            ours,
            verdict,
        })
    }

    /// What is measured: `settling over that of Python on arima`.
    fn words(&self) -> String {
        let mut words = self.metric.of.clone().into_owned();
        if let Some(over) = self.over {
            words += " over that";
            if let Some(who) = over.who {
                words += &format!(" of {}", who.prose());
            }
            let that = self.asked.but(over);
            words += &format!(" on {}", that.topology);
            let (with, own) = (that.with, self.asked.with);
            words += &match (with == own, with.is_nothing()) {
                (true, true) => String::new(),
                (true, false) => " with the same settings".to_owned(),
                (false, true) => " as its preset has it".to_owned(),
                (false, false) => format!(" with {with}"),
            };
        }
        words
    }
}

/// A figure of a group, divided by that of the runs that it is held against.
fn number(
    campaign: &Campaign,
    source: &Source<'_>,
    metric: &Metric,
    over: Option<Except>,
) -> Result<Option<Estimate>, ReadError> {
    let ours = metric.of(source)?;
    let Some(over) = over else {
        return Ok(ours);
    };
    let that = metric.of(&Source::of(campaign, source.asked.but(over)))?;
    Ok(ours.zip(that).and_then(|(ours, that)| ours.times(that)))
}

impl Than {
    /// The limit from the other group's number. Of its size, with `times`: that of zero, if zero is within its
    /// interval.
    fn scaled(&self, that: Estimate) -> Estimate {
        let Some(times) = self.times else {
            return that;
        };
        let size = |value: f64| self.least.max(times * value.abs());
        let (a, b) = (size(that.low), size(that.high));
        let has_zero = that.low <= 0.0 && that.high >= 0.0;
        Estimate {
            value: size(that.value),
            low: if has_zero { size(0.0) } else { a.min(b) },
            high: a.max(b),
            n: that.n,
        }
    }
}
