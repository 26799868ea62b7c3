//! A plant over real sockets on loopback.

// `--nocapture` prints what docs/reliability.md quotes.
#![allow(clippy::print_stdout)]

mod again;
mod age;
mod datagram;
mod errors;
mod foreign;
mod framing;
mod http;
mod json;
mod line;
mod mutation;
mod page;
mod safe;
mod session;
mod socket;
mod standstill;
mod support;
