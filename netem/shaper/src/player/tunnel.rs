//! Plays one way of a link beside an end, for two ends that no interface of this machine connects,
//! such as two containers.
//!
//! ```text
//!  controller's namespace                  plant's namespace
//!   link0 10.77.0.1/30                      link0 10.77.0.2/30
//!         │                                       │
//!      player ── UDP ──── a network ──── UDP ── player
//!     shapes up                             shapes down
//! ```
//!
//! Each end has a player beside it, which takes the packets of its end from a [TUN device](TunPort),
//! shapes them, and sends them to the other player in [datagrams](UdpPort). Packets from the other
//! player are already shaped and go to the end at once. The cost of the network between the two is
//! part of the [baseline](link::certificate::Baseline), like a player's own cost.

use std::sync::atomic::AtomicBool;

use link::certificate::{LinkRow, WayPlayed};
use link::{Epoch, LinkTime, PacketRow, PerWay, Profile, Timeline, Way};

use crate::error::Result;
use crate::player::Player;
use crate::player::relay::Relay;
use crate::port::Port;
use crate::port::inbox::Inbox;
use crate::port::tun::TunPort;
use crate::port::udp::UdpPort;
use crate::record::Record;

/// What to play beside an end.
#[derive(Debug)]
pub struct WayConfig {
    /// The link; the way of the end's packets is played.
    pub profile: Profile,
    /// Its seed, the same beside both ends.
    pub seed: u64,
    /// The monotonic instant of link time 0, the same beside both ends.
    pub epoch: Epoch,
    /// The link time from which on the link is played, the same beside both ends. Before it, the empty link is.
    pub opens: LinkTime,
    /// The end's interface.
    pub end: TunPort,
    /// The socket to the other end's player.
    pub tunnel: UdpPort,
    /// Where each packet that enters the way is recorded, if at all.
    pub packets: Option<Record<PacketRow>>,
}

/// Plays like [`play`](crate::play), on the calling thread and until `stop` is set, but only the way
/// of this end. `on_second` gets the row of that way.
///
/// # Errors
/// [`Error::Failed`](crate::Error::Failed) if a port fails.
pub fn play_way(
    config: WayConfig,
    stop: &AtomicBool,
    mut on_second: impl FnMut([LinkRow; 1]),
) -> Result<WayPlayed> {
    let (mut end, mut tunnel) = (config.end, config.tunnel);
    let shaped = end.way();
    let carried = shaped.back();
    let timeline = Timeline::new(&config.profile, config.seed, config.epoch).opening(config.opens);
    let relay = Relay::new(timeline).carrying(carried);
    let ports: PerWay<&mut dyn Port> = match shaped {
        Way::Up => PerWay {
            up: &mut end,
            down: &mut tunnel,
        },
        Way::Down => PerWay {
            up: &mut tunnel,
            down: &mut end,
        },
    };
    let mut player = Player::new(relay, ports, Inbox::of_packets(), config.packets);
    let played = player.run(stop, &mut |rows| on_second([rows[shaped]]))?;
    let reports = player.into_reports();
    Ok(WayPlayed {
        way: shaped,
        scheduling: played.scheduling,
        epoch: config.epoch,
        started_ns: played.started_ns,
        ended_ns: played.ended_ns,
        pauses: played.pauses,
        shaped: reports[shaped],
        carried: reports[carried].into(),
    })
}
