//! The controller over HTTP or a WebSocket: one deadline every h, messages beside it.
//!
//! * [`drive`], [`drive_until`]: the entry; [`Config`] in,
//!   [`endpoint::report::Native`] out.
//! * `transport`: how a command goes out and its answer comes back, over HTTP
//!   (`transport/http`) or a WebSocket (`transport/websocket`).
//!
//! One thread does it all: an alarm on the run's clock wakes it at each
//! deadline, and each message is a task of its own beside it. When a message is
//! sent and with which u is decided in the crate `endpoint`.
#![forbid(unsafe_code)]

mod config;
mod drive;
mod transport;

pub use config::{Config, DriveError};
pub use drive::{drive, drive_until};
