//! Whether what a run recorded vouches for it.
//!
//! - [`message`]: every message of the loop held against the link, each way;
//! - [`end`]: the plant's ticks and the controller's deadlines;
//! - [`machine`]: what stood still or waited: the player, a process, a processor;
//! - [`limit`]: every limit of these, with its reason;
//! - [`Judgement`]: all of it together, and what it makes of the verdict.
//!
//! Pure: rows come in, words and numbers go out. The echoes' certificate is the shaper's; how the loop
//! itself fared, stable or not, is the analysis'.
#![forbid(unsafe_code)]

mod crossing;
pub mod end;
mod fault;
mod judgement;
pub mod limit;
pub mod machine;
pub mod message;
mod terms;

pub use crossing::Crossed;
pub use fault::Fault;
pub use judgement::{Judgement, Records, judge, opens_always, shares_one};
pub use limit::Allowance;
pub use machine::{Pulse, Watched};
pub use message::Messages;
pub use terms::{Still, Terms};
