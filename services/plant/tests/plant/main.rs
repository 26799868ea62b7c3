//! A plant over real sockets on loopback.

mod errors;
mod http;
mod page;
mod safe;
mod session;
mod socket;
mod support;
