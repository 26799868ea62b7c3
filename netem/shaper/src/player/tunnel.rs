//! Plays one way of a link beside an end, for two ends that no interface of this machine
//! lies between, as two containers are.
//!
//! ```text
//!  controller's namespace                  plant's namespace
//!   link0 10.77.0.1/30                      link0 10.77.0.2/30
//!         │                                       │
//!      player ── UDP ──── a network ──── UDP ── player
//!     shapes up                             shapes down
//! ```
//!
//! Each end has a player beside it, which takes what its end sends into a
//! [TUN device](TunPort), shapes it, and sends it to the other one in
//! [datagrams](UdpPort); what comes from there is shaped already and handed to the end at
//! once. What the network between the two costs is in the
//! [baseline](certificate::Baseline), as a player's own cost is.

use std::sync::atomic::AtomicBool;

use certificate::{LinkRow, WayPlayed};
use link::{PacketRow, PerWay, Profile, Timeline, Way};

use crate::error::Result;
use crate::player::Player;
use crate::player::relay::Relay;
use crate::port::Port;
use crate::port::tun::TunPort;
use crate::port::udp::UdpPort;
use crate::record::Record;

/// What to play beside an end.
#[derive(Debug)]
pub struct WayConfig {
    /// The link, of which the way of the end's packets is played.
    pub profile: Profile,
    /// Its seed: the same beside both ends.
    pub seed: u64,
    /// The monotonic instant of link time 0: the same beside both ends. Before it, the empty
    /// link is played.
    pub epoch_ns: u64,
    /// The end's interface.
    pub end: TunPort,
    /// The way to the other end's player.
    pub tunnel: UdpPort,
    /// Where each packet that enters the way is written down, if it is.
    pub packets: Option<Record<PacketRow>>,
}

/// Plays as [`play`](crate::play) does, on the calling thread and until `stop` is set, but
/// the way of this end alone. `on_second` gets the row of that way.
///
/// # Errors
/// [`Error::Failed`](crate::Error::Failed) when a port fails.
pub fn play_way(
    config: WayConfig,
    stop: &AtomicBool,
    mut on_second: impl FnMut([LinkRow; 1]),
) -> Result<WayPlayed> {
    let (mut end, mut tunnel) = (config.end, config.tunnel);
    let shaped = end.way();
    let carried = shaped.back();
    let timeline = Timeline::new(&config.profile, config.seed, config.epoch_ns);
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
    let mut player = Player::new(relay, ports, config.packets);
    let played = player.run(stop, &mut |rows| on_second([rows[shaped]]))?;
    let reports = player.into_reports();
    Ok(WayPlayed {
        way: shaped,
        scheduling: played.scheduling,
        epoch_ns: config.epoch_ns,
        started_ns: played.started_ns,
        ended_ns: played.ended_ns,
        pauses: played.pauses,
        shaped: reports[shaped],
        carried: reports[carried].into(),
    })
}
