//! A state feedback: as a system's text has it, and the resulting law for a sampled plant.
//!
//! Which law a text asks for, and the round trip that it assumes, is in `law`.

use control::{
    AgedFeedback, Discrete, Estimator, InvalidLaw, Law, Saturation, StateFeedback, StateSpace,
    Weights,
};
use nalgebra::DMatrix;
use text::Diagnostic;
use toml::Spanned;

use crate::system::design::{Design, Limits, Matrices, NoiseNumbers, to_rows};
use crate::system::fault::Source;
use crate::system::file::{ControllerFile, Rows};
use crate::system::obstacle::{Obstacle, within};

/// Each update corrects as many estimates, and a margin sums as many terms at each frequency.
const FILTER_TICKS: usize = 300;

/// A state feedback before the sample time is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Feedback {
    by: Choice,
    estimator: Estimator,
    age: AgeSource,
    /// The references of the outputs after the first.
    pub(crate) others: Vec<f64>,
    limits: Option<Saturation>,
}

/// Where the gains of a state feedback come from.
#[derive(Debug, Clone, PartialEq)]
enum Choice {
    /// A row for each input.
    Gains(Vec<Vec<f64>>),
    Weights(Weights),
}

/// How a filter knows how old an output is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AgeSource {
    /// It is the round trip that the law is designed for.
    Assumed,
    /// The law measures it, by ticks and stamps.
    Measured,
}

impl Feedback {
    /// Reads one; `others` are the references of the outputs after the first.
    pub(crate) fn read(
        source: Source,
        asked: &Spanned<ControllerFile>,
        others: &[f64],
        limits: Option<Saturation>,
    ) -> Result<Self, Diagnostic> {
        let file = asked.get_ref();
        let by = match (&file.gains, &file.weights) {
            (Some(gains), None) => Choice::Gains(match gains.get_ref() {
                Rows::List(list) => vec![list.clone()],
                Rows::Rows(rows) => rows.clone(),
            }),
            (None, Some(weights)) => Choice::Weights(Weights {
                output: source.positives("weights.output", &weights.get_ref().output)?,
                input: source.positives("weights.input", &weights.get_ref().input)?,
            }),
            _ => {
                let remedy =
                    "give gains, one for each state, or weights = { output = .., input = .. }";
                return Err(source.fault(asked, "the law needs either gains or weights", remedy));
            }
        };
        let Some(noise) = &file.noise else {
            let remedy =
                "give noise = { disturbance = .., measurement = .. }, as standard deviations";
            let problem = "`noise` is missing: the law's Kalman filter needs it";
            return Err(source.fault(asked, problem, remedy));
        };
        Ok(Self {
            by,
            estimator: Estimator {
                disturbance: source.positives("noise.disturbance", &noise.get_ref().disturbance)?,
                noise: source.positives("noise.measurement", &noise.get_ref().measurement)?,
            },
            age: match &file.age {
                Some(word) => age(source, word)?,
                None => AgeSource::Assumed,
            },
            others: others.to_vec(),
            limits,
        })
    }

    /// Whether it measures how old an output is.
    pub(crate) fn measures(&self) -> bool {
        self.age == AgeSource::Measured
    }

    /// The law for a plant as it is sampled every `h_ns`, without its dead time, and the law's numbers; `delay` is
    /// that time and the round trip, in ticks.
    pub(crate) fn at(
        &self,
        model: &StateSpace<Discrete>,
        delay: usize,
        h_ns: u64,
    ) -> Result<(Law, Design), Obstacle> {
        let gains = match &self.by {
            Choice::Gains(gains) => from_rows(gains)?,
            Choice::Weights(weights) => weights.gains(model)?,
        };
        let delay = within("state-feedback", delay, FILTER_TICKS)?;
        let observer = self.estimator.observer(model, delay)?;
        let law = StateFeedback::try_new(
            model.clone(),
            gains.clone(),
            observer.clone(),
            self.others.clone(),
            self.limits,
        )?;
        let (model_rows, gains) = (Matrices::from(model), to_rows(&gains));
        let (reference, others) = (to_rows(law.reference()), self.others.clone());
        let limits = self.limits.as_ref().map(Limits::from);
        if self.age == AgeSource::Assumed {
            let design = Design::StateFeedback {
                model: model_rows,
                gains,
                observer: to_rows(&observer),
                reference,
                others,
                limits,
            };
            return Ok((Law::StateFeedback(law), design));
        }
        let noise = self.estimator.noise(model)?;
        let aged = AgedFeedback::try_new(law, &noise, h_ns)?;
        let design = Design::AgedFeedback {
            model: model_rows,
            gains,
            reference,
            others,
            limits,
            h_ns,
            noise: NoiseNumbers::from(&noise),
        };
        Ok((Law::Aged(Box::new(aged)), design))
    }
}

fn age(source: Source, word: &Spanned<String>) -> Result<AgeSource, Diagnostic> {
    match word.get_ref().as_str() {
        "assumed" => Ok(AgeSource::Assumed),
        "measured" => Ok(AgeSource::Measured),
        other => {
            let problem = format!("age `{other}` is unknown");
            Err(source.fault(word, problem, "choose assumed or measured"))
        }
    }
}

/// Gains as a matrix, if the rows are equally long.
fn from_rows(rows: &[Vec<f64>]) -> Result<DMatrix<f64>, InvalidLaw> {
    let width = rows.first().map_or(0, Vec::len);
    match rows.iter().find(|row| row.len() != width) {
        None => Ok(DMatrix::from_row_iterator(
            rows.len(),
            width,
            rows.iter().flatten().copied(),
        )),
        Some(row) => Err(InvalidLaw::Length {
            list: "gains",
            given: row.len(),
            needed: width,
            why: "as many as in its first row",
        }),
    }
}
