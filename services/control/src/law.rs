//! Running control laws: from a reference and the newest output to a command, once per message.
//!
//! - [`Pid`]: PI and PID, in `pid`;
//! - [`Transfer`]: any transfer function of the error, in `law::transfer`;
//! - [`Smith`]: a PID that predicts past a known dead time, in `law::smith`;
//! - [`StateFeedback`]: gains on states that a Kalman filter estimates, in `law::feedback`;
//! - [`AgedFeedback`]: the same with a filter that knows how old each output is, in `law::aged`.
//!
//! [`Pid`] gets the time since the last update, and [`AgedFeedback`] the times of [`LawInput`]; the other laws advance
//! by the h with which they were sampled, one step per message. In all of them an input that is not finite changes nothing and
//! repeats the last command. The laws in Python and JavaScript give the same bits, which test vectors
//! verify. The crate chooses no gains, except the two kinds that follow from weights.

mod aged;
mod feedback;
mod filter;
mod smith;
pub(crate) mod swept;
mod transfer;

use thiserror::Error;

pub use aged::AgedFeedback;
pub use feedback::{Estimator, StateFeedback, Weights};
pub use filter::Noise;
pub use smith::Smith;
pub use transfer::Transfer;

use crate::moment::LawInput;
use crate::pid::{InvalidPid, Pid, Saturation};
use crate::riccati::NoSolution;
use crate::signals::Signals;
use crate::state_space::StateSpace;
use crate::timebase::Discrete;
use crate::transfer::{InvalidTransferFunction, TransferFunction};

/// A control law with its state, at rest when new.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// PI or PID of the error.
    Pid(Pid),
    /// A transfer function of the error.
    Transfer(Transfer),
    /// A Smith predictor.
    Smith(Smith),
    /// State feedback with a Kalman filter.
    StateFeedback(StateFeedback),
    /// State feedback with a Kalman filter that knows how old each output is. As a function of frequency, and where
    /// nobody measures time, it is the law for outputs that are as old as it assumes.
    Aged(Box<AgedFeedback>),
}

/// Numbers that do not give a law.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidLaw {
    /// Invalid gains or limits.
    #[error(transparent)]
    Pid(#[from] InvalidPid),
    /// Invalid weights or noise.
    #[error(transparent)]
    Riccati(#[from] NoSolution),
    /// The length of a list does not match the number of the model's states.
    #[error("{list} has {given} numbers; it needs {needed}, {why}")]
    Length {
        /// `gains` or `observer`.
        list: &'static str,
        /// Its length.
        given: usize,
        /// The required length.
        needed: usize,
        /// What its numbers belong to.
        why: &'static str,
    },
    /// A number is not finite.
    #[error("{field} has an entry that is not finite")]
    NotFinite {
        /// The field's name.
        field: &'static str,
    },
    /// No constant input holds the outputs at their references.
    #[error(
        "no constant command holds the plant's outputs at their references: its DC gain is 0, or there are \
         more references than inputs; control another output"
    )]
    NoRest,
}

impl Law {
    /// Returns the command u for the reference `r` and what was `seen` last, `dt_s` seconds after the last update:
    /// the newest output y, or [`LawInput`]. All laws but those of states look at the first output and give one command.
    #[inline]
    pub fn update(&mut self, r: f64, seen: impl Into<LawInput>, dt_s: f64) -> Signals {
        let seen = seen.into();
        // Tested separately: a jump to one of five targets costs more than the paper's law does.
        if let Self::Pid(pid) = self {
            return pid.update(r - seen.y.first, dt_s).into();
        }
        let (first, second) = self.update_other(r, &seen, dt_s);
        Signals {
            first,
            second: (self.signals().1 > 1).then_some(second),
        }
    }

    /// Both commands, or one and 0. As plain numbers they come back in registers; were they written to memory,
    /// the paper's law would have to write its command there too, and whoever copies it would wait for that.
    #[inline(never)]
    fn update_other(&mut self, r: f64, seen: &LawInput, dt_s: f64) -> (f64, f64) {
        let y = seen.y;
        let u: Signals = match self {
            Self::Pid(pid) => pid.update(r - y.first, dt_s).into(),
            Self::Transfer(law) => law.update(r, y.first).into(),
            Self::Smith(law) => law.update(r, y.first, dt_s).into(),
            Self::StateFeedback(law) => law.update(r, y),
            Self::Aged(law) => match &seen.times {
                Some(times) => law.update(r, y, times),
                None => law.assumed_mut().update(r, y),
            },
        };
        (u.first, u.second.unwrap_or_default())
    }

    /// The same law at rest with all gains times `factor`, within the same limits: what a gain margin is about.
    /// `None` for a law with a model of its plant, and where a gain would not be finite.
    #[must_use]
    pub fn times(&self, factor: f64) -> Option<Self> {
        match self {
            Self::Pid(pid) => pid.times(factor).map(Self::Pid),
            Self::Transfer(law) => law.times(factor).map(Self::Transfer),
            Self::Smith(_) | Self::StateFeedback(_) | Self::Aged(_) => None,
        }
    }

    /// Whether its gains follow from how old each output is: then it is no linear law of constant numbers, and what
    /// analysis says is of the one that assumes an age.
    #[must_use]
    pub fn measures_age(&self) -> bool {
        matches!(self, Self::Aged(_))
    }

    /// Number of outputs that it expects, and of inputs that it gives.
    #[must_use]
    pub fn signals(&self) -> (usize, usize) {
        match self {
            Self::StateFeedback(law) => law.signals(),
            Self::Aged(law) => law.assumed().signals(),
            _ => (1, 1),
        }
    }

    /// Number of state variables.
    #[must_use]
    pub fn order(&self) -> usize {
        match self {
            Self::Pid(pid) => pid.gains().order(),
            Self::Transfer(law) => law.state_space().order(),
            Self::Smith(law) => law.order(),
            Self::StateFeedback(law) => law.order(),
            Self::Aged(law) => law.assumed().order(),
        }
    }

    /// The law from y to u with r = 0, within its limits, one step every `h_s`.
    ///
    /// # Errors
    /// [`InvalidTransferFunction`] if a number overflows.
    pub fn state_space(&self, h_s: f64) -> Result<StateSpace<Discrete>, InvalidTransferFunction> {
        Ok(match self {
            Self::Pid(pid) => StateSpace::from(&negated(&pid.gains().sampled(h_s)?)?),
            Self::Transfer(law) => law.state_space(),
            Self::Smith(law) => law.state_space(h_s)?,
            Self::StateFeedback(law) => law.state_space(),
            Self::Aged(law) => law.assumed().state_space(),
        })
    }

    /// The law from -y to u, as used in the loop with negative feedback.
    ///
    /// # Errors
    /// [`InvalidTransferFunction`] if a coefficient overflows.
    pub fn transfer_function(
        &self,
        h_s: f64,
    ) -> Result<TransferFunction<Discrete>, InvalidTransferFunction> {
        match self {
            Self::Pid(pid) => pid.gains().sampled(h_s),
            Self::Transfer(law) => negated(&law.state_space().transfer_function()?),
            Self::Smith(law) => law.transfer_function(h_s),
            Self::StateFeedback(law) => negated(&law.state_space().transfer_function()?),
            Self::Aged(law) => negated(&law.assumed().state_space().transfer_function()?),
        }
    }
}

impl From<Pid> for Law {
    fn from(pid: Pid) -> Self {
        Self::Pid(pid)
    }
}

fn negated(
    g: &TransferFunction<Discrete>,
) -> Result<TransferFunction<Discrete>, InvalidTransferFunction> {
    let num: Vec<f64> = g.num().iter().map(|x| -x).collect();
    TransferFunction::try_new(num, g.den(), g.timebase())
}

/// A command limited to its range, if it has one.
#[inline]
fn limited(u: f64, limits: Option<&Saturation>) -> f64 {
    limits.map_or(u, |limits| u.clamp(limits.min, limits.max))
}
