//! A plant over real sockets on loopback.

mod errors;
mod foreign;
mod framing;
mod http;
mod mutation;
mod page;
mod safe;
mod session;
mod socket;
mod support;
