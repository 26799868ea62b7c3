//! The same loop in virtual time: both ends, the link, and what lies between them.
//!
//! The ends come from `endpoint` and the link from `link`, the same code that real runs use; this
//! crate has no control law and no delay. It has the time, and a model of what sockets and programs
//! do to a message:
//!
//! - [`run`] with its input and output: `course`, `setup`, `record`; its events in the order of `queue`
//! - connections, opened as the native client opens them: `connection`
//! - how TCP's timers resend a lost packet: `retransmission`, which depends on `acknowledgement`
//! - one connection for all messages, as a WebSocket is: `stream`
//! - what a machine adds, as measured: [`Timing`], a [`Spread`] for each step
//! - the link's two ways: `wire`, which echoes take too: `echo`
//!
//! The model leaves out congestion control and segmentation, since a message is one packet, and
//! acknowledgements that a timer sends. Timers that end although nothing was lost resend packets only where
//! that has an effect: in front of other packets, behind a rate limit. Nothing here has a clock, a file, a
//! socket or a thread: the same setup gives the same rows, bit by bit, on every machine.
#![forbid(unsafe_code)]

mod acknowledgement;
mod connection;
mod course;
mod echo;
mod queue;
mod record;
mod retransmission;
mod setup;
mod spread;
mod stream;
mod timing;
mod wire;

pub use connection::Pool;
pub use course::run;
pub use echo::{Echo, Series, Start};
pub use record::Record;
pub use setup::{EPOCH, Outcome, Setup, Unfit, plant_start_ns};
pub use spread::{InvalidSpread, Spread};
pub use timing::Timing;
