//! Judges a run by what it recorded.
//!
//! - [`message`]: every message of the loop, compared with the link each way;
//! - [`end`]: the plant's ticks and the controller's deadlines;
//! - [`machine`]: what stood still or had to wait: the player, a process, a processor;
//! - [`Hits`]: faults of the ends that were asked for, and what they excuse;
//! - [`replay`]: both ends, from each other by the plan's plant and law;
//! - [`limit`]: all limits for these, with their reasons;
//! - [`Judgement`]: the result of all of them, and the verdict that follows.
//!
//! Pure: rows come in, words and numbers go out. The `certificate` crate judges the echoes; the
//! analysis says how the loop itself behaved, stable or not.
#![forbid(unsafe_code)]

mod busy;
mod connecting;
mod crossed;
mod crossing;
pub mod end;
mod fault;
mod flight;
mod glances;
mod hit;
mod judgement;
mod lateness;
pub mod limit;
pub mod machine;
pub mod message;
mod met;
mod milliseconds;
mod quantile;
pub mod replay;
mod still;
mod terms;

pub use busy::Busy;
pub use connecting::Connecting;
pub use fault::LinkFault;
pub use hit::Hits;
pub use judgement::{Judgement, Records, judge};
pub use limit::Allowance;
pub use still::Still;
pub use terms::Terms;
