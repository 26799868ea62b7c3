//! The plant over HTTP: the model runs freely, every h, and takes its input from requests.
//!
//! * [`serve()`], [`serve_until`]: the entry points; [`Config`] and a model in, [`endpoint::report::Plant`] out.
//! * `ticker`: the thread that steps the model at its deadlines.
//! * `server`: the thread that accepts connections, each with its `place`; `connection` serves HTTP/1 on one,
//!   request by request when it is its `turn`, which the crate `http` reads; `shared` is what all have in common.
//! * `route`: what each request gets, as an [`answer`] or a `refusal`; `origin` keeps foreign pages
//!   out; `openapi` describes the API.
//! * `conversation`: commands over a connection that carries a whole loop: a WebSocket (`socket`), after its
//!   [`handshake`], or lines (`line`); `datagram`: commands by UDP.
//! * `page`: the files of the page that closes the loop in a browser.
//! * `session`: who is in control, proved by a `token`.
//! * `upload`: requests of a page that have a body; `filer`: the thread that stores their data,
//!   `chunk` by chunk of `rows`.
//! * `latest`: how the two threads exchange values without waiting.
//!
//! The crate `endpoint` decides what a command does to the plant; the caller brings the model. There is
//! no TLS, and a token shows who is in control, not who is permitted to be: a plant should listen
//! only where its own controllers can reach it.
#![forbid(unsafe_code)]

pub mod answer;
mod chunk;
mod config;
mod connection;
mod conversation;
mod datagram;
mod ending;
mod filer;
mod handler;
pub mod handshake;
mod latest;
mod line;
mod openapi;
mod origin;
mod page;
mod place;
mod refusal;
mod route;
mod rows;
mod serve;
mod server;
mod session;
mod shared;
mod socket;
mod ticker;
mod token;
mod turn;
mod upload;

pub use config::{Config, Ready, ServeError};
pub use serve::{serve, serve_until};
