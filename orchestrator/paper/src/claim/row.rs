//! The claims as a table: a claim consists of rows, and each row says which runs, which number, and
//! what is accepted. One function judges them all.

use analysis::{Campaign, Metrics, ReadError, Run};

use super::evidence::{Evidence, Source};
use crate::subject::Asked;
use crate::subject::PYTHON;
use report::claim::rule::{self, ANY};
use report::claim::{Finding, Limits, Verdict};
use report::group::Estimate;

/// The topologies of the paper's Figures 3 to 5 and 8, and of Table 3.
pub(super) const NEAR: [&str; 3] = ["arima", "buccoo", "couva"];

/// What the paper says, and the numbers with which it is compared. The texts are those of [`Finding`].
#[derive(Default)]
pub(super) struct Claim {
    pub(super) id: &'static str,
    pub(super) place: &'static str,
    pub(super) claim: &'static str,
    /// Formatted from the limits of the rows.
    pub(super) check: String,
    /// Empty for a claim that has code of its own.
    pub(super) rows: Vec<Row>,
    /// The claim of which this is a reading.
    pub(super) reading_of: Option<&'static str>,
    /// Adds remarks on the rows after they are judged.
    pub(super) remark: Option<fn(&mut Evidence, &[Judged<'_>])>,
}

/// The finding before anything is judged.
impl From<Claim> for Finding {
    fn from(claim: Claim) -> Finding {
        Finding {
            id: claim.id,
            place: claim.place,
            claim: claim.claim,
            check: claim.check,
            reading_of: claim.reading_of,
            verdict: Verdict::NotRun,
            reason: String::new(),
            parts: Vec::new(),
            runs: Vec::new(),
        }
    }
}

/// One number of one group of runs.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) asked: Asked<'static>,
    metric: Metric,
    pub(super) paper: Option<f64>,
    accepted: Accepted,
    pub(super) weight: Weight,
}

/// How a row is used.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Weight {
    /// The verdict depends on it.
    Decides,
    /// Its runs are needed, but its number is only shown.
    Shown,
    /// It is shown if there are runs, such as those of a browser that the paper does not name.
    Beside,
}

/// Where a number agrees.
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
pub(super) struct Than {
    pub(super) asked: Asked<'static>,
    pub(super) metric: Metric,
    /// The limits to show if it was not run; the number is not compared with them.
    pub(super) unknown: (f64, f64),
}

/// A number that is measured for a group.
#[derive(Clone, Copy)]
pub(super) struct Metric {
    /// Its name: `settling`.
    pub(super) of: &'static str,
    /// Its unit; empty for a share or a ratio.
    pub(super) unit: &'static str,
    pub(super) figure: Figure,
}

/// How a group's number is computed from its runs.
#[derive(Clone, Copy)]
pub(super) enum Figure {
    /// The median.
    Median(fn(&Metrics) -> Option<f64>),
    /// The median, of a number that runs may never reach.
    OrNever(fn(&Metrics) -> Option<f64>),
    /// The range over single runs: the claim is about what one run did.
    Each(fn(&Run) -> Result<Option<f64>, ReadError>),
    /// Settling divided by that of Python on arima at the same rate with the same plant.
    Settling,
    /// Computed from the whole group.
    Group(fn(&Source<'_>) -> Result<Option<Estimate>, ReadError>),
}

/// A row with its result.
pub(super) struct Judged<'a> {
    pub(super) row: Row,
    pub(super) source: Source<'a>,
    pub(super) ours: Option<Estimate>,
    pub(super) verdict: Verdict,
}

impl Row {
    /// A row that decides.
    pub(super) fn new(asked: Asked<'static>, metric: Metric, accepted: impl Into<Accepted>) -> Row {
        Row {
            asked,
            metric,
            paper: None,
            accepted: accepted.into(),
            weight: Weight::Decides,
        }
    }

    /// A row whose runs are needed, but which is only shown.
    pub(super) fn shown(asked: Asked<'static>, metric: Metric) -> Row {
        Row {
            weight: Weight::Shown,
            ..Row::new(asked, metric, ANY)
        }
    }

    /// The row, only shown beside another that decides.
    pub(super) fn beside(self) -> Row {
        Row {
            weight: Weight::Beside,
            ..self
        }
    }

    /// The row with the paper's number.
    pub(super) fn paper(self, paper: f64) -> Row {
        Row {
            paper: Some(paper),
            ..self
        }
    }
}

impl From<(f64, f64)> for Accepted {
    fn from(limits: (f64, f64)) -> Accepted {
        Accepted::Within(limits)
    }
}

impl Metric {
    /// The median over the runs of a measured number.
    pub(super) const fn median(
        of: &'static str,
        unit: &'static str,
        figure: fn(&Metrics) -> Option<f64>,
    ) -> Metric {
        let figure = Figure::Median(figure);
        Metric { of, unit, figure }
    }

    /// A number of each run by itself.
    pub(super) const fn each(
        of: &'static str,
        unit: &'static str,
        figure: fn(&Run) -> Result<Option<f64>, ReadError>,
    ) -> Metric {
        let figure = Figure::Each(figure);
        Metric { of, unit, figure }
    }

    /// A number of all runs together.
    pub(super) const fn group(
        of: &'static str,
        unit: &'static str,
        figure: fn(&Source<'_>) -> Result<Option<Estimate>, ReadError>,
    ) -> Metric {
        let figure = Figure::Group(figure);
        Metric { of, unit, figure }
    }

    fn of(self, campaign: &Campaign, source: &Source<'_>) -> Result<Option<Estimate>, ReadError> {
        let group = &source.group;
        Ok(match self.figure {
            Figure::Median(figure) => group.median(|run| figure(run.metrics.as_ref()?)),
            Figure::OrNever(figure) => group.median_or_never(|run| figure(run.metrics.as_ref()?)),
            Figure::Each(figure) => {
                let values = group.runs.iter().map(|run| figure(run));
                let values = values.collect::<Result<Vec<_>, _>>()?;
                Estimate::of_each(&values.into_iter().flatten().collect::<Vec<_>>())
            }
            Figure::Settling => group
                .settling_ms()
                .and_then(|ms| ms.times(reference(campaign, source).group.settling_ms()?)),
            Figure::Group(figure) => figure(source)?,
        })
    }
}

/// Judges a claim by its rows.
pub(super) fn judge(campaign: &Campaign, claim: Claim) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    let mut judged = Vec::new();
    for row in &claim.rows {
        judged.push(judge_row(campaign, row, &mut evidence)?);
    }
    if let Some(remark) = claim.remark {
        remark(&mut evidence, &judged);
    }
    Ok(evidence.on(claim))
}

fn judge_row<'a>(
    campaign: &'a Campaign,
    row: &Row,
    evidence: &mut Evidence,
) -> Result<Judged<'a>, ReadError> {
    let source = Source::of(campaign, row.asked);
    let mut ours = row.metric.of(campaign, &source)?;
    let mut measured = |than: Than, limits: fn(Estimate) -> Limits| {
        let other = Source::of(campaign, than.asked);
        evidence.ask(&other);
        let other = than.metric.of(campaign, &other)?;
        // Without the other group there is no limit to be above or below.
        ours = other.and(ours);
        Ok(other.map_or(Limits::from(than.unknown), limits))
    };
    let limits = match row.accepted {
        Accepted::Within(limits) | Accepted::WithinOrBeyond(limits, ..) => limits.into(),
        Accepted::Above(than) => measured(than, Limits::above)?,
        Accepted::Below(than) => measured(than, Limits::below)?,
    };
    let Metric { of, unit, figure } = row.metric;
    let mut part = source.part(of, unit, row.paper, ours, limits);
    if let Accepted::WithinOrBeyond(_, other, limits) = row.accepted {
        let other = rule::judge(other.of(campaign, &source)?, &limits.into());
        part.verdict = match (part.verdict, other) {
            (Verdict::Differs, Verdict::Differs) => Verdict::Agrees,
            (Verdict::Differs, Verdict::CannotBeTold) => Verdict::CannotBeTold,
            (verdict, _) => verdict,
        };
    }
    let verdict = part.verdict;
    if row.weight == Weight::Beside {
        evidence.ask_beside(&source);
    } else {
        evidence.ask(&source);
        if let Figure::Settling = figure {
            evidence.ask(&reference(campaign, &source));
        }
    }
    if row.weight == Weight::Decides {
        evidence.decide(part);
    } else {
        evidence.show(part);
    }
    Ok(Judged {
        row: *row,
        source,
        ours,
        verdict,
    })
}

/// The reference of settling: Python on arima at the same rate with the same plant.
fn reference<'a>(campaign: &'a Campaign, source: &Source<'_>) -> Source<'a> {
    let asked = Asked {
        subject: PYTHON,
        topology: "arima",
        ..source.asked
    };
    Source::of(campaign, asked)
}
