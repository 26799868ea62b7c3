//! The controller over HTTP, a WebSocket, TCP or UDP: a deadline every h, with messages in parallel.
//!
//! * [`drive()`], [`drive_until`]: the entry points; [`Config`] in, [`endpoint::report::Native`] out.
//! * `transport`: sends commands and receives their answers, over HTTP (`transport/http`), a
//!   WebSocket (`transport/websocket`), lines (`transport/line`) or datagrams (`transport/datagram`).
//!
//! One task does it all: an alarm on the run's clock wakes it at each deadline, and so does each answer. The crate `endpoint` decides when a message is sent and with which u.
#![forbid(unsafe_code)]

mod config;
mod drive;
mod transport;

pub use config::{Config, DriveError};
pub use drive::{drive, drive_until};
