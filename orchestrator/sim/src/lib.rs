//! The same loop in virtual time: both ends, the link, and what lies between them.
//!
//! The ends are `endpoint`'s and the link is `link`'s, the same code that real runs drive; there
//! is no control law here and no delay. What is here is time, and the model of what sockets and
//! programs do to a message:
//!
//! - [`run`] and what it is given and gives: `course`, `setup`, `record`, in the order of `queue`
//! - connections, opened as the native client opens them: `connection`
//! - a lost packet's second way, by TCP's timers: `retransmission`, and what they go by:
//!   `acknowledgement`
//! - one connection for all messages, as a WebSocket is: `stream`
//! - what a machine adds, as measured: [`Timing`], a [`Spread`] for each step
//! - the link's two ways: `wire`, which echoes take too: `echo`
//!
//! What the model leaves out: congestion control and segmentation, since a message is one packet;
//! and acknowledgements that a timer sends. Timers that end although nothing was lost send packets
//! again where these have an effect: in front of others, behind a rate limit. Nothing here has a clock, a file, a socket or a thread: the same setup
//! gives the same rows, bit by bit, on every machine.
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
pub use setup::{EPOCH_NS, Outcome, Setup, Unfit, plant_start_ns};
pub use spread::{InvalidSpread, Spread};
pub use timing::Timing;
