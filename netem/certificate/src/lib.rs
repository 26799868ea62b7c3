//! Whether a link was the one that was asked for, and the reports of its players.
//!
//! - [`Echo`]: what crossed the link, held by [`certify`] against what the same
//!   [`Timeline`](link::Timeline) had [predicted](predict); the [`Certificate`] has a [`Verdict`].
//! - [`PlayerReport`], [`WayPlayed`], [`TcReport`] and their rows: what a player did, as it leaves it
//!   in its files, and as one [`LinkReport`]; a [`Histogram`] of how late it was.
//!
//! All times are nanoseconds of one monotonic clock. There is no clock, socket, file or thread in
//! this crate: sending echoes and playing a link are the shaper's.
#![forbid(unsafe_code)]

#[allow(clippy::module_inception)]
mod certificate;
mod echo;
mod fate;
mod lateness;
mod link_report;
mod played;
mod prediction;
mod report;
mod scheduling;
mod statistics;
mod tc_report;
mod verdict;

pub use certificate::{Certificate, Residual, Residuals, certify, certify_within};
pub use echo::{Echo, PACKET_BYTES, Sighting, merge};
pub use fate::Fates;
pub use lateness::{Histogram, Lateness};
pub use link_report::{Beside, EachWay, LinkReport, Model, OneWay, PlayedBy};
pub use played::{Carried, WayPlayed};
pub use prediction::{Baseline, Edge, Expected, Prediction, predict, predict_within};
pub use report::{LinkRow, Pause, PlayerReport, WayReport};
pub use scheduling::Scheduling;
pub use statistics::RttStatistics;
pub use tc_report::{TcReport, TcRow};
pub use verdict::{ANSWERS_NEEDED, Verdict};
