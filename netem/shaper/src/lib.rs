//! Plays a link on real packets, and sends the echoes that prove it.
//!
//! - Where: [`Namespace`]s without names, [joined](join) by veth pairs through a middle one.
//! - What plays: [`play`] forwards between two [`Port`]s as the [`Timeline`](link::Timeline) of a profile and
//!   a seed says; a [`Record`] keeps its rows. Where the ends share no interface, a player
//!   beside each [plays its way](play_way), and the two are joined by a tunnel.
//! - Or by tc: a [`TcPlayer`] plays one way by a netem that it changes in time.
//! - What proves it: a [`Prober`] measures each direction with echoes, in two halves
//!   ([`Asker`], [`Witness`]) where the ends share no process; they are held against what the
//!   same timeline had predicted in the [certificate].
//!
//! All times are nanoseconds of `CLOCK_MONOTONIC`, which is one for all namespaces and
//! processes of a machine.

mod clock;
mod error;
mod network;
mod player;
mod port;
mod probe;
mod record;
mod scheduling;
mod sys;
mod tc;

pub use clock::now_ns;
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
pub use port::tun::TunPort;
pub use port::udp::{TUNNEL_PORT, UdpPort};
pub use port::{Arrival, FRAME_MAX, PacketPort, Port, PortCounters};
pub use probe::asker::Asker;
pub use probe::plan::ProbePlan;
pub use probe::witness::Witness;
pub use probe::{Prober, probe};
pub use record::Record;
pub use tc::command::tc_available;
pub use tc::{TcConfig, TcPlayer};
