//! A figure: its words, its unit, and how a group of runs has it. Which there are is in `figure`.

use std::borrow::Cow;

use analysis::{Metrics, Run, expect};
use plan::Figure;
use serde::Deserialize;

use super::source::Source;
use record::ReadError;
use report::group::Estimate;

/// A number that is measured for a group.
#[derive(Debug, Clone, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct Metric {
    /// Its words, by which a claim names it: `final value`.
    pub(super) of: Cow<'static, str>,
    /// Its unit; empty for a share or a ratio.
    // Not a part of the text that is read, as serde takes it to be.
    #[serde(skip)]
    pub(super) unit: &'static str,
    computed: Computed,
}

/// How a group's number is computed from its runs.
#[derive(Debug, Clone, Copy)]
enum Computed {
    /// The median.
    Median(fn(&Metrics) -> Option<f64>),
    /// The range over single runs: the claim is about what one run did.
    Each(fn(&Run) -> Result<Option<f64>, ReadError>),
    /// Computed from the whole group.
    Group(fn(&Source<'_>) -> Result<Option<Estimate>, ReadError>),
    /// The median, which is infinite if half of the runs never reached it.
    Expected(Figure),
}

impl Metric {
    /// The median over the runs of a measured number.
    pub(super) const fn median(
        of: &'static str,
        unit: &'static str,
        figure: fn(&Metrics) -> Option<f64>,
    ) -> Metric {
        Metric::new(of, unit, Computed::Median(figure))
    }

    /// A number of each run by itself.
    pub(super) const fn each(
        of: &'static str,
        unit: &'static str,
        figure: fn(&Run) -> Result<Option<f64>, ReadError>,
    ) -> Metric {
        Metric::new(of, unit, Computed::Each(figure))
    }

    /// A number of all runs together.
    pub(super) const fn group(
        of: &'static str,
        unit: &'static str,
        figure: fn(&Source<'_>) -> Result<Option<Estimate>, ReadError>,
    ) -> Metric {
        Metric::new(of, unit, Computed::Group(figure))
    }

    /// One of `[expect]`.
    pub(super) fn expected(figure: Figure) -> Metric {
        Metric {
            of: figure.to_string().into(),
            unit: figure.unit().suffix().trim(),
            computed: Computed::Expected(figure),
        }
    }

    const fn new(of: &'static str, unit: &'static str, computed: Computed) -> Metric {
        Metric {
            of: Cow::Borrowed(of),
            unit,
            computed,
        }
    }

    /// The number of a group; `None` if it has none.
    pub(super) fn of(&self, source: &Source<'_>) -> Result<Option<Estimate>, ReadError> {
        let group = &source.group;
        Ok(match self.computed {
            Computed::Median(figure) => group.median(|run| figure(run.metrics.as_ref()?)),
            Computed::Each(figure) => {
                let values = group.runs.iter().map(|run| figure(run));
                let values = values.collect::<Result<Vec<_>, _>>()?;
                Estimate::of_each(&values.into_iter().flatten().collect::<Vec<_>>())
            }
            Computed::Group(figure) => figure(source)?,
            Computed::Expected(figure) => {
                group.median_or_never(|run| expect::value(figure, &run.summary))
            }
        })
    }
}
