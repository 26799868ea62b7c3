//! Plays a link on real packets, and sends the echoes that prove it.
//!
//! - Network: [`Namespace`]s without names, [joined](join) by veth pairs through a middle one.
//! - Player: [`play`] forwards between two [`Port`]s according to the [`Timeline`](link::Timeline) of
//!   a profile and a seed; a [`Record`] keeps its rows. If no interface connects the ends, a player
//!   beside each [plays its way](play_way), and a tunnel joins the two.
//! - Player with tc: a [`TcPlayer`] plays one way with a netem that it changes in time.
//! - Proof: a [`Prober`] measures each direction with echoes, in two halves ([`Asker`], [`Witness`])
//!   if the ends are in different processes; the [certificate](link::certificate) compares them with the predictions of
//!   the same timeline.
//!
//! All times are nanoseconds of `CLOCK_MONOTONIC`, which is the same for all namespaces and processes
//! of a machine; [`clock::now::now_ns`] reads it.

mod error;
mod network;
mod player;
mod port;
mod probe;
mod record;
mod scheduling;
mod stamp;
mod sys;
mod tc;

pub use error::{Error, Result};
pub use network::bridge::bridge;
pub use network::namespace::{Authority, Namespace, become_root};
pub use network::neighbour::prefill_neighbour;
pub use network::route::device_towards;
pub use network::veth::{
    CONTROLLER_ADDRESS, CONTROLLER_INTERFACE, END_INTERFACE, PLANT_ADDRESS, PLANT_INTERFACE,
    connect, join,
};
pub use player::tunnel::{WayConfig, play_way};
pub use player::{PlayerConfig, play};
pub use port::frame::FRAME_MAX;
pub use port::inbox::Inbox;
pub use port::tun::TunPort;
pub use port::udp::{TUNNEL_PORT, UdpPort};
pub use port::{Arrival, PacketPort, Port, PortCounters};
pub use probe::asker::Asker;
pub use probe::plan::ProbePlan;
pub use probe::witness::Witness;
pub use probe::{Prober, probe};
pub use record::Record;
pub use tc::command::tc_available;
pub use tc::{TcConfig, TcPlayer};

/// Changes a packet as a fault of a link asks.
#[cfg(fuzzing)]
pub fn fuzz(packet: &mut [u8], way: link::Way, twist: link::Twist) -> (usize, link::Twist) {
    player::twist::apply(packet, way, twist)
}
