//! The one link model: delay, loss and rate as seeded functions of time.
//!
//! A [`Profile`] is a link as its TOML file describes it, a [`Link`] plays it under a seed, and a
//! [`Prediction`] gives what `ping` will see through it. Everything is a function of its arguments:
//! [`LinkTime`] is integer nanoseconds since the run's [`Epoch`]; there is no clock, file, socket or thread.
//!
//! - reading a profile: `file` (keys), `resolve` (checks), `profile` (values), `finding` (errors and
//!   warnings)
//! - playing it: `path` (one direction: `bottleneck`, `fault`, `loss`, `spells`, `trace`, `wire`), `link` (both),
//!   `timeline` (a run's link: the empty link first), based on `law` (distributions) and `draws`
//!   (randomness); `load`: a queue in retrospect; `time`: the link's and the machine's
//! - commands for tc: `setting` (one state of netem), `staircase` (the changes in time), `script`
//!   (both as text)
//! - predictions: `prediction` (figures), `stall` (times of stalls), `drawn` (what depends on the seed),
//!   `describe` (words)
//! - [`certificate`]: whether a link was the one asked for, and the reports of its players
#![forbid(unsafe_code)]

mod bottleneck;
pub mod certificate;
mod describe;
mod drawn;
mod draws;
mod fault;
mod file;
mod finding;
mod law;
mod link;
mod load;
mod loss;
mod path;
mod piece;
mod prediction;
mod profile;
mod resolve;
mod script;
mod setting;
mod special;
mod spells;
mod staircase;
mod stall;
mod time;
mod timeline;
mod trace;
mod way;
mod wire;

pub use describe::{describe, traces};
pub use drawn::Drawn;
pub use draws::within_ns;
pub use fault::{FaultSpell, Twist};
pub use file::schema;
pub use link::Link;
pub use load::{Load, PacketRow};
pub use path::{Cause, Fate, Passage, Path, State};
pub use piece::{Stay, Stretch};
pub use prediction::{
    Band, Pings, Prediction, Rtt, Typical, ping, predict, shares_within, typical,
};
pub use profile::{Asked, Profile};
pub use resolve::Files;
pub use script::script;
pub use setting::{HANDLE, Pace, Setting, Verb};
pub use staircase::{Change, READING_NS, STEP_NS, Staircase};
pub use stall::Stall;
pub use text::{Diagnostic, Severity};
pub use time::{Epoch, LinkTime};
pub use timeline::Timeline;
pub use trace::Edition;
pub use way::{PerWay, Way};
