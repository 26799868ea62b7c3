//! The one link model: delay, loss and rate as seeded functions of time.
//!
//! A [`Profile`] is what a TOML file says of a link, a [`Link`] plays it under a
//! seed, and a [`Prediction`] says what `ping` will see through it. Everything
//! is a function of its arguments: link time is integer nanoseconds since the
//! run's epoch, and no clock, file, socket or thread is touched.
//!
//! - what a profile says: `file` (keys), `resolve` (checks), `profile` (values),
//!   `finding` (what is wrong), `unit` (quantities)
//! - what is played: `path` (one direction: `bottleneck`, `loss`, `spells`,
//!   `wire`), `link` (both), `timeline` (a run's: the empty link first), on `law`
//!   (distributions) and `draws` (randomness); `load`: a queue afterwards
//! - what tc is told: `setting` (one state of netem), `staircase` (the changes in
//!   time), `script` (both as text)
//! - what is foretold: `prediction` (figures), `stall` (when), `describe` (words)
#![forbid(unsafe_code)]

mod bottleneck;
mod describe;
mod draws;
mod file;
mod finding;
mod law;
mod link;
mod load;
mod loss;
mod path;
mod prediction;
mod profile;
mod resolve;
mod script;
mod setting;
mod special;
mod spells;
mod staircase;
mod stall;
mod timeline;
mod trace;
mod unit;
mod way;
mod wire;

pub use describe::describe;
pub use draws::within_ns;
pub use file::schema;
pub use finding::{Finding, Severity};
pub use link::Link;
pub use load::{Load, PacketRow};
pub use path::{Cause, Fate, Passage, Path, State};
pub use prediction::{Band, Pings, Prediction, Rtt, Typical, ping, predict, share_within, typical};
pub use profile::{Asked, Profile};
pub use script::script;
pub use setting::{HANDLE, Pace, Setting, Verb};
pub use staircase::{Change, READING_NS, STEP_NS, Staircase};
pub use stall::Stall;
pub use timeline::Timeline;
pub use unit::{InvalidQuantity, duration_ns, rate_bps, share};
pub use way::{PerWay, Way};
