//! Plays a link on real packets, and proves that it did.
//!
//! - Where: [`Namespace`]s without names, [joined](join) by veth pairs through a middle one.
//! - What plays: [`play`] forwards between two [`Port`]s as the [`Timeline`] of a profile and
//!   a seed says; a [`Record`] keeps its rows.
//! - What proves it: a [`Prober`] measures each direction with echoes, and [`certify`] holds
//!   them against what the same timeline had predicted.
//!
//! All times are nanoseconds of `CLOCK_MONOTONIC`, which is one for all namespaces and
//! processes of a machine.

mod certificate;
mod clock;
mod error;
mod fate;
mod icmp;
mod lateness;
mod namespace;
mod netlink;
mod player;
mod port;
mod prediction;
mod probe;
mod record;
mod relay;
mod report;
mod scheduling;
mod statistics;
mod sys;
mod timeline;
mod verdict;
mod veth;

pub use certificate::{Certificate, Residual, Residuals, certify};
pub use clock::now_ns;
pub use error::{Error, Result};
pub use fate::Fates;
pub use lateness::Lateness;
pub use namespace::{Authority, Namespace, become_root};
pub use player::{PlayerConfig, play};
pub use port::{Arrival, FRAME_MAX, PacketPort, Port, PortCounters};
pub use prediction::{Baseline, Expected, Prediction, predict};
pub use probe::{Echo, ProbePlan, Prober, probe};
pub use record::Record;
pub use report::{LinkRow, PlayerReport, WayReport};
pub use scheduling::Scheduling;
pub use statistics::RttStatistics;
pub use timeline::Timeline;
pub use verdict::{ANSWERS_NEEDED, Verdict};
pub use veth::{
    CONTROLLER_ADDRESS, CONTROLLER_INTERFACE, END_INTERFACE, PLANT_ADDRESS, PLANT_INTERFACE, join,
};
