//! The plant over HTTP: the model runs free, every h, and takes the inputs that
//! requests bring.
//!
//! * [`serve`], [`serve_until`]: the entry; [`Config`] in, [`Report`] out.
//! * `ticker`: the thread that steps the model on its deadlines.
//! * `server`: the thread that accepts connections and speaks HTTP/1.
//! * `route`: what each request gets; `openapi` describes it to others.
//! * `latest`: how the two threads see each other without waiting.
//!
//! What a command does to the plant is decided in the crate `endpoint`, what
//! the model is in `control`. There is no TLS and no authorisation here: a plant
//! listens where only its own controllers can reach it.
#![forbid(unsafe_code)]

mod config;
mod latest;
mod openapi;
mod route;
mod serve;
mod server;
mod ticker;

pub use config::{Config, Granted, Ready, Report, ServeError};
pub use serve::{serve, serve_until};
