//! The plant over HTTP: the model runs free, every h, and takes the inputs that
//! requests bring.
//!
//! * [`serve`], [`serve_until`]: the entry; [`Config`] in,
//!   [`endpoint::report::Plant`] out.
//! * `ticker`: the thread that steps the model on its deadlines.
//! * `server`: the thread that accepts connections and speaks HTTP/1.
//! * `route`: what each request gets, as an `answer` or a `refusal`; `origin`
//!   keeps foreign pages out; `openapi` describes it all to others.
//! * `socket`: commands over a WebSocket.
//! * `page`: the files of the page that closes the loop in a browser.
//! * `session`: who is in control, proved by a `token`.
//! * `upload`: what a page sends with a body; `filer`: the thread that files it,
//!   `chunk` by chunk of `rows`.
//! * `latest`: how the two threads see each other without waiting.
//!
//! What a command does to the plant is decided in the crate `endpoint`, what
//! the model is in `control`. There is no TLS here, and a token says who is in
//! control, not who may be: a plant listens where only its own controllers can
//! reach it.
#![forbid(unsafe_code)]

mod answer;
mod chunk;
mod config;
mod ending;
mod filer;
mod handler;
mod latest;
mod openapi;
mod origin;
mod page;
mod refusal;
mod route;
mod rows;
mod serve;
mod server;
mod session;
mod socket;
mod ticker;
mod token;
mod upload;

pub use config::{Config, Ready, ServeError};
pub use serve::{serve, serve_until};
