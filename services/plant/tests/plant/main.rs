//! A plant over real sockets on loopback.

mod http;
mod page;
mod session;
mod socket;
mod support;
