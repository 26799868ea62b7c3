//! The law in a system's text, and the resulting law at a sample time.

use control::{
    Gains, InvalidLaw, Law, Method, Pid, SampledPlant, Saturation, Smith, StateSpace, Transfer,
    discretise, loop_delay_ticks, seconds,
};
use text::Diagnostic;
use toml::Spanned;

use crate::system::design::{Design, Limits, Model, PidNumbers};
use crate::system::fault::Source;
use crate::system::feedback::Feedback;
use crate::system::file::ControllerFile;
use crate::system::limits;
use crate::system::obstacle::{Obstacle, within};
use crate::system::plant::{PlantModel, counted, method, ratio};

/// A predictor keeps one number per tick; this limit also holds in Python and on the page.
const SMITH_TICKS: usize = 1_000_000;

/// A law before the sample time is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Recipe {
    Pid {
        gains: Gains,
        limits: Option<Saturation>,
    },
    Transfer {
        model: StateSpace,
        method: Method,
        limits: Option<Saturation>,
    },
    Smith {
        gains: Gains,
        limits: Option<Saturation>,
        rtt_ns: u64,
    },
    StateFeedback {
        feedback: Feedback,
        rtt_ns: u64,
    },
}

/// The keys of each law besides `law` and `limits`.
const WORDS: [(&str, &[&str]); 4] = [
    ("pid", &["kp", "ki", "kd", "filter"]),
    ("transfer", &["num", "den", "sampling"]),
    ("smith", &["kp", "ki", "kd", "filter", "round_trip"]),
    (
        STATE_FEEDBACK,
        &["gains", "weights", "noise", "round_trip", "age"],
    ),
];

/// The one law for several inputs and outputs.
const STATE_FEEDBACK: &str = "state-feedback";

impl Recipe {
    /// Reads a law for a plant; `others` are the references of the outputs after the first.
    pub(crate) fn read(
        source: Source,
        asked: &Spanned<ControllerFile>,
        plant: &PlantModel,
        others: &[f64],
    ) -> Result<Self, Diagnostic> {
        let file = asked.get_ref();
        let law = file.law.get_ref().as_str();
        let Some((_, words)) = WORDS.iter().find(|(name, _)| *name == law) else {
            let names = WORDS.map(|(name, _)| name);
            let remedy = text::or_nearest(law, names, &format!("choose {}", names.join(", ")));
            return Err(source.fault(&file.law, format!("law `{law}` is unknown"), remedy));
        };
        if let Some(stray) = given(file).into_iter().find(|word| !words.contains(word)) {
            return Err(source.fault(
                &file.law,
                format!("`{stray}` is not a key of law `{law}`"),
                format!("leave it out; {law} takes {} and limits", words.join(", ")),
            ));
        }
        let model = plant.linear().map(|plant| &plant.model);
        if let Some(model) = model.filter(|model| !model.is_single())
            && law != STATE_FEEDBACK
        {
            let (inputs, outputs) = (model.inputs(), model.outputs());
            let problem = format!(
                "law `{law}` has one input and one output, and the plant has {}",
                counted(inputs, outputs)
            );
            return Err(source.fault(&file.law, problem, "choose state-feedback"));
        }
        let limits = file
            .limits
            .as_ref()
            .map(|limits| limits::read(source, limits, law));
        let limits = limits.transpose()?;
        let rtt_ns = match &file.round_trip {
            Some(text) => source.span_ns(text)?,
            None => 0,
        };
        match law {
            "pid" => Ok(Self::Pid {
                gains: read_gains(source, asked, limits)?,
                limits,
            }),
            "smith" => Ok(Self::Smith {
                gains: read_gains(source, asked, limits)?,
                limits,
                rtt_ns,
            }),
            "transfer" => {
                let (Some(num), Some(den)) = (&file.num, &file.den) else {
                    let remedy = "give the coefficients of both, highest power first";
                    return Err(source.fault(asked, "the law needs both num and den", remedy));
                };
                Ok(Self::Transfer {
                    model: StateSpace::from(&ratio(source, num, den)?),
                    method: match &file.sampling {
                        Some(word) => method(source, word)?,
                        None => Method::Tustin,
                    },
                    limits,
                })
            }
            _ => Self::state_feedback(source, asked, plant, (others, limits, rtt_ns)),
        }
    }

    fn state_feedback(
        source: Source,
        asked: &Spanned<ControllerFile>,
        plant: &PlantModel,
        (others, limits, rtt_ns): (&[f64], Option<Saturation>, u64),
    ) -> Result<Self, Diagnostic> {
        let feedback = Feedback::read(source, asked, others, limits)?;
        let dead_time_ns = plant.linear().map_or(0, |plant| plant.dead_time_ns);
        match &asked.get_ref().age {
            Some(age) if feedback.measures() && dead_time_ns > 0 => {
                let problem =
                    "the plant has a dead time, which a filter with measured ages does not model";
                let remedy = "use age = \"assumed\", which counts the dead time as a delay";
                Err(source.fault(age, problem, remedy))
            }
            _ => Ok(Self::StateFeedback { feedback, rtt_ns }),
        }
    }

    /// The same law with other gains; `None` if it has no such gains, or they are not finite.
    pub(crate) fn with_gains(&self, kp: Option<f64>, ki: Option<f64>) -> Option<Self> {
        let mut recipe = self.clone();
        let (Self::Pid { gains, .. } | Self::Smith { gains, .. }) = &mut recipe else {
            return (kp.is_none() && ki.is_none()).then_some(recipe);
        };
        gains.kp = kp.unwrap_or(gains.kp);
        gains.ki = ki.unwrap_or(gains.ki);
        (gains.kp.is_finite() && gains.ki.is_finite()).then_some(recipe)
    }

    /// Whether it can integrate over the time that has passed; other laws advance by h.
    pub(crate) fn takes_elapsed(&self) -> bool {
        matches!(self, Self::Pid { .. })
    }

    /// The references of the outputs after the first.
    pub(crate) fn other_r(&self) -> &[f64] {
        match self {
            Self::StateFeedback { feedback, .. } => &feedback.others,
            _ => &[],
        }
    }

    /// Whether it estimates states that are not measured.
    pub(crate) fn has_estimator(&self) -> bool {
        matches!(self, Self::StateFeedback { .. })
    }

    /// Whether it measures how old an output is.
    pub(crate) fn measures_age(&self) -> bool {
        matches!(self, Self::StateFeedback { feedback, .. } if feedback.measures())
    }

    /// The law at a sample time, with its numbers. A law that contains a model of the plant needs one.
    pub(crate) fn at(
        &self,
        plant: Option<&SampledPlant>,
        h_ns: u64,
    ) -> Result<(Law, Design), Obstacle> {
        let modelled = |what: &'static str| plant.ok_or(Obstacle::NoModel { what });
        Ok(match self {
            Self::Pid { gains, limits } => (
                Pid::try_new(*gains, *limits)
                    .map_err(InvalidLaw::from)?
                    .into(),
                Design::Pid(PidNumbers::new(gains, limits.as_ref())),
            ),
            Self::Transfer {
                model,
                method,
                limits,
            } => {
                let sampled = discretise(model, *method, seconds(h_ns))?;
                let design = Design::Transfer {
                    model: Model::from(&sampled),
                    limits: limits.as_ref().map(Limits::from),
                };
                (Law::Transfer(Transfer::try_new(sampled, *limits)?), design)
            }
            Self::Smith {
                gains,
                limits,
                rtt_ns,
            } => {
                let plant = modelled("law `smith`")?;
                let model = &plant.system;
                let ticks = within("smith", Smith::ticks(plant, *rtt_ns, h_ns), SMITH_TICKS)?;
                let pid = Pid::try_new(*gains, *limits).map_err(InvalidLaw::from)?;
                let design = Design::Smith {
                    pid: PidNumbers::new(gains, limits.as_ref()),
                    model: Model::from(model),
                    ticks,
                };
                (Law::Smith(Smith::new(pid, model.clone(), ticks)), design)
            }
            Self::StateFeedback { feedback, rtt_ns } => {
                let plant = modelled("law `state-feedback`")?;
                let delay = loop_delay_ticks(*rtt_ns, h_ns).get() + plant.delay_ticks;
                feedback.at(&plant.system, delay, h_ns)?
            }
        })
    }
}

/// The keys besides `law` and `limits` that the file has.
fn given(file: &ControllerFile) -> Vec<&'static str> {
    let all = [
        ("kp", file.kp.is_some()),
        ("ki", file.ki.is_some()),
        ("kd", file.kd.is_some()),
        ("filter", file.filter.is_some()),
        ("num", file.num.is_some()),
        ("den", file.den.is_some()),
        ("sampling", file.sampling.is_some()),
        ("round_trip", file.round_trip.is_some()),
        ("gains", file.gains.is_some()),
        ("weights", file.weights.is_some()),
        ("noise", file.noise.is_some()),
        ("age", file.age.is_some()),
    ];
    let there = all.into_iter().filter(|(_, is_there)| *is_there);
    there.map(|(word, _)| word).collect()
}

fn read_gains(
    source: Source,
    asked: &Spanned<ControllerFile>,
    limits: Option<Saturation>,
) -> Result<Gains, Diagnostic> {
    let file = asked.get_ref();
    let Some(kp) = &file.kp else {
        let remedy = "give kp, and ki and kd if wanted";
        return Err(source.fault(asked, "the law has no kp", remedy));
    };
    let number = |field, value: &Option<Spanned<f64>>, none| match value {
        Some(value) => source.finite(field, value),
        None => Ok(none),
    };
    let gains = Gains {
        kp: source.finite("kp", kp)?,
        ki: number("ki", &file.ki, 0.0)?,
        kd: number("kd", &file.kd, 0.0)?,
        filter_rad_s: match &file.filter {
            Some(filter) => source.positive("filter", filter)?,
            None => f64::INFINITY,
        },
    };
    match Pid::try_new(gains, limits) {
        Ok(_) => Ok(gains),
        Err(problem) => Err(source.fault(asked, problem.to_string(), "choose others")),
    }
}
