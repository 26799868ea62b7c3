//! The controller over HTTP or a WebSocket: a deadline every h, with messages in parallel.
//!
//! * [`drive()`], [`drive_until`]: the entry points; [`Config`] in, [`endpoint::report::Native`] out.
//! * `transport`: sends a command and receives its answer, over HTTP (`transport/http`) or a
//!   WebSocket (`transport/websocket`).
//!
//! One thread does it all: an alarm on the run's clock wakes it at each deadline, and each message is
//! a task of its own. The crate `endpoint` decides when a message is sent and with which u.
#![forbid(unsafe_code)]

mod config;
mod drive;
mod transport;

pub use config::{Config, DriveError};
pub use drive::{drive, drive_until};
