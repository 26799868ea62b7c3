//! Judges a run by what it recorded.
//!
//! - [`message`]: every message of the loop, compared with the link each way;
//! - [`end`]: the plant's ticks and the controller's deadlines;
//! - [`machine`]: what stood still or had to wait: the player, a process, a processor;
//! - [`Hits`]: faults of the ends that were asked for, and what they excuse;
//! - [`limit`]: all limits for these, with their reasons;
//! - [`Judgement`]: the result of all of them, and the verdict that follows.
//!
//! Pure: rows come in, words and numbers go out. The `certificate` crate judges the echoes; the
//! analysis says how the loop itself behaved, stable or not.
#![forbid(unsafe_code)]

mod crossing;
pub mod end;
mod fault;
mod hit;
mod judgement;
pub mod limit;
pub mod machine;
pub mod message;
mod still;
mod terms;

pub use crossing::Crossed;
pub use fault::Fault;
pub use hit::Hits;
pub use judgement::{Judgement, Records, judge, opens_always, shares_one};
pub use limit::Allowance;
pub use machine::{Pulse, Watched};
pub use message::Messages;
pub use still::Still;
pub use terms::Terms;
