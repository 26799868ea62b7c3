//! The control mathematics of the loop: plants, controllers, how they are sampled, and how well the
//! loop performs.
//!
//! Read in this order:
//!
//! - [`timebase`]: distinguishes continuous from sampled systems by type;
//! - [`transfer`] and [`state_space`]: the two forms of a linear system, the second with up to two inputs and outputs
//!   ([`signals`]);
//! - [`mod@discretise`]: from continuous to sampled, by backward Euler (the paper's), zero-order hold
//!   or Tustin;
//! - [`stepper`]: a running sampled system, its inputs and outputs tick by tick;
//! - [`plant`]: a model with dead time, and how it is sampled;
//! - [`pid`]: the controller of the paper, one error and one command per update;
//! - [`law`]: the PID and other laws: a transfer function, a Smith predictor, state feedback with a
//!   Kalman filter; [`moment`] has what they are told of time;
//! - [`preset`]: the plant and the controller of the paper;
//! - [`open_loop`]: plant and law as a function of frequency, by their states; `swept` and `hessenberg` have the
//!   parts, `wide` the numbers of 32 digits; [`minimal`] tells the modes that a zero cancels;
//! - [`scan`]: that function along all frequencies, and where its gain passes 1;
//! - [`margin`]: gain, phase and delay margin, with dead time; `winding`: how many closed-loop poles are unstable;
//! - [`closed_loop`]: the loop with a constant delay, and the longest round trip at which it is stable;
//! - [`blocking`]: the same for a client that waits for each answer;
//! - [`mod@step_info`]: rise, settling, overshoot and the other figures, with python-control's names
//!   and definitions.
//!
//! Names and conventions are those of python-control where it has one: polynomials have the highest
//! power first, frequencies are in rad/s, phases in degrees, times in seconds. Its results (0.10.2)
//! and scipy's are committed under `tests/fixtures`, and the tests compare with them.
//!
//! The crate is pure. It has no systems with more than two inputs or outputs, no nonlinear plants, and
//! no design, except what follows from weights by a Riccati equation: it runs and judges loops that are
//! already designed.
#![forbid(unsafe_code)]

pub mod blocking;
pub mod closed_loop;
pub mod discretise;
mod hessenberg;
pub mod law;
pub mod margin;
pub mod minimal;
pub mod moment;
pub mod open_loop;
pub mod pid;
pub mod plant;
mod polynomial;
pub mod preset;
mod riccati;
pub mod scan;
pub mod signals;
pub mod state_space;
pub mod step_info;
pub mod stepper;
mod swept;
pub mod timebase;
pub mod transfer;
mod wide;
mod winding;

pub use blocking::{Untold, largest_stable_blocking_round_trip_s};
pub use closed_loop::{Analysis, largest_stable_round_trip_s, loop_delay_ticks, step_response};
pub use discretise::{InvalidDiscretisation, Method, discretise};
pub use law::{
    AgedFeedback, Estimator, InvalidLaw, Law, Noise, Smith, StateFeedback, Transfer, Weights,
};
pub use margin::{InvalidDeadTime, Margins, margins};
pub use minimal::{Fate, Hidden};
pub use moment::{AnswerFacts, LawInput, Moment};
pub use nalgebra::Complex;
pub use open_loop::OpenLoop;
pub use pid::{AntiWindup, Gains, InvalidPid, Pid, Saturation};
pub use plant::{Plant, SampledPlant};
pub use riccati::NoSolution;
pub use scan::Unsure;
pub use signals::Signals;
pub use state_space::{InvalidStateSpace, StateSpace};
pub use step_info::{InvalidResponse, StepInfo, StepSettings, sampled_step_info, step_info};
pub use stepper::Stepper;
pub use timebase::{Continuous, Discrete, InvalidSampleTime, Timebase, seconds};
pub use transfer::{InvalidTransferFunction, TransferFunction};
