//! The figures that a claim can be about, and how it names them.
//!
//! Those of the paper are declared in the files that compute them; each of `[expect]` is one too, by its median.

use plan::Figure;

use super::metric::Metric;
use super::{age, drift, interval, pace, plant, settling, way};

/// Every figure that is declared here.
const DECLARED: [&[Metric]; 7] = [
    pace::FIGURES,
    drift::FIGURES,
    settling::FIGURES,
    plant::FIGURES,
    interval::FIGURES,
    way::FIGURES,
    age::FIGURES,
];

/// Words that name no figure.
#[derive(Debug, thiserror::Error)]
#[error("figure `{0}` is unknown; choose one of: {known}", known = words().join("; "))]
pub(super) struct UnknownFigure(String);

impl TryFrom<String> for Metric {
    type Error = UnknownFigure;

    fn try_from(words: String) -> Result<Metric, UnknownFigure> {
        let mut all = all();
        all.find(|metric| metric.of == words)
            .ok_or(UnknownFigure(words))
    }
}

/// All figures: those that are declared, and those of `[expect]` but for verdicts, which are no numbers.
fn all() -> impl Iterator<Item = Metric> {
    let numbers = Figure::ALL.iter().filter(|figure| !figure.is_verdict());
    let expected = numbers.map(|figure| Metric::expected(*figure));
    DECLARED.into_iter().flatten().cloned().chain(expected)
}

fn words() -> Vec<String> {
    all().map(|metric| metric.of.into_owned()).collect()
}
