//! Plays a link on real packets, and proves that it did.
//!
//! - Where: [`Namespace`]s without names, [joined](join) by veth pairs through a middle one.
//! - What plays: [`play`] forwards between two [`Port`]s as the [`Timeline`](link::Timeline) of a profile and
//!   a seed says; a [`Record`] keeps its rows. Where the ends share no interface, a player
//!   beside each [plays its way](play_way), and the two are joined by a tunnel.
//! - Or by tc: a [`TcPlayer`] plays one way by a netem that it changes in time.
//! - What proves it: a [`Prober`] measures each direction with echoes, in two halves
//!   ([`Asker`], [`Witness`]) where the ends share no process, and [`certify`] holds them
//!   against what the same timeline had predicted.
//!
//! All times are nanoseconds of `CLOCK_MONOTONIC`, which is one for all namespaces and
//! processes of a machine.

mod asker;
mod bridge;
mod certificate;
mod clock;
mod error;
mod fate;
mod hearer;
mod icmp;
mod lateness;
mod namespace;
mod neighbour;
mod netlink;
mod played;
mod player;
mod port;
mod prediction;
mod probe;
mod qdisc;
mod record;
mod relay;
mod report;
mod route;
mod scheduling;
mod statistics;
mod sys;
mod tc;
mod tc_batch;
mod tc_command;
mod tc_report;
mod tun;
mod tunnel;
mod udp;
mod verdict;
mod veth;
mod watch;
mod witness;

pub use asker::Asker;
pub use bridge::bridge;
pub use certificate::{Certificate, Residual, Residuals, certify, certify_within};
pub use clock::now_ns;
pub use error::{Error, Result};
pub use fate::Fates;
pub use lateness::Lateness;
pub use namespace::{Authority, Namespace, become_root};
pub use neighbour::prefill_neighbour;
pub use played::{Carried, WayPlayed};
pub use player::{PlayerConfig, play};
pub use port::{Arrival, FRAME_MAX, PacketPort, Port, PortCounters};
pub use prediction::{Baseline, Edge, Expected, Prediction, predict, predict_within};
pub use probe::{Echo, ProbePlan, Prober, probe};
pub use record::Record;
pub use report::{LinkRow, Pause, PlayerReport, WayReport};
pub use route::device_towards;
pub use scheduling::Scheduling;
pub use statistics::RttStatistics;
pub use tc::{TcConfig, TcPlayer};
pub use tc_command::tc_available;
pub use tc_report::{TcReport, TcRow};
pub use tun::TunPort;
pub use tunnel::{WayConfig, play_way};
pub use udp::{TUNNEL_PORT, UdpPort};
pub use verdict::{ANSWERS_NEEDED, Verdict};
pub use veth::{
    CONTROLLER_ADDRESS, CONTROLLER_INTERFACE, END_INTERFACE, PLANT_ADDRESS, PLANT_INTERFACE,
    connect, join,
};
pub use witness::{Sighting, Witness, merge};
