//! The one link model: delay, loss and rate as seeded functions of time.
//!
//! A [`Profile`] is a link as its TOML file describes it, a [`Link`] plays it under a seed, and a
//! [`Prediction`] gives what `ping` will see through it. Everything is a function of its arguments:
//! [`LinkTime`] is integer nanoseconds since the run's [`Epoch`]; there is no clock, file, socket or thread.
//!
//! - reading a profile: `file` (keys), `resolve` (checks), `profile` (values), `finding` (errors and
//!   warnings), `unit` (quantities)
//! - playing it: `path` (one direction: `bottleneck`, `fault`, `loss`, `spells`, `wire`), `link` (both),
//!   `timeline` (a run's link: the empty link first), based on `law` (distributions) and `draws`
//!   (randomness); `load`: a queue in retrospect; `time`: the link's and the machine's
//! - commands for tc: `setting` (one state of netem), `staircase` (the changes in time), `script`
//!   (both as text)
//! - predictions: `prediction` (figures), `stall` (times of stalls), `describe` (words)
#![forbid(unsafe_code)]

mod bottleneck;
mod describe;
mod draws;
mod fault;
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
mod time;
mod timeline;
mod trace;
mod unit;
mod way;
mod wire;

pub use describe::describe;
pub use draws::within_ns;
pub use fault::{FaultSpell, Twist};
pub use file::{schema, sentence};
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
pub use time::{Epoch, LinkTime};
pub use timeline::Timeline;
pub use unit::{InvalidQuantity, duration_ns, rate_bps, share};
pub use way::{PerWay, Way};
