//! Decides whether a link was the one asked for, and defines the reports of its players.
//!
//! - [`Echo`]: a packet that crossed the link; [`certify`] compares it with what the same
//!   [`Timeline`](crate::timeline::Timeline) [predicts](predict). The [`Certificate`] has a [`Verdict`].
//! - [`PlayerReport`], [`WayPlayed`], [`TcReport`] and their rows: what a player did, as it writes it
//!   to its files, and as one [`LinkReport`]; a [`Histogram`] of its lateness.
//!
//! All times are nanoseconds of one monotonic clock. There is no clock, socket, file or thread here:
//! the shaper sends echoes and plays links.

#[allow(clippy::module_inception)]
mod certificate;
mod echo;
mod entry;
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
