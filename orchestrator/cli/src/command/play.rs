//! `webloop serve link`: plays a link, both ways between two interfaces or one way beside an end.
//!
//! A player prints `ready` when packets can cross, and writes its report as JSON beside its rows.

use std::fs::File;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, ToSocketAddrs};
use std::path::Path;
use std::sync::atomic::AtomicBool;

use ::link::{PacketRow, Profile, Way};
use anyhow::{Context, anyhow};
use backend::{LinkRole, Player};
use clock::now::now_ns;
use link::certificate::{Beside, OneWay};
use link::{Epoch, LinkTime};
use serde::Serialize;
use shaper::{
    PacketPort, PlayerConfig, Record, TUNNEL_PORT, TcConfig, TcPlayer, TunPort, UdpPort, WayConfig,
};

use crate::argument::ServeLink;
use crate::command::serve::{leave, read, say_ready};
use crate::exit::{Failure, Outcome};
use crate::{source, stop};

/// What to play, and by which player.
struct Piece {
    profile: Profile,
    seed: u64,
    epoch: Epoch,
    opens: LinkTime,
    player: Player,
    device: Option<String>,
}

/// What a player beside an end prints when it is ready. It tells whoever started it the addresses
/// of the two ends on this link.
#[derive(Debug, Serialize)]
struct Playing {
    player: Player,
    #[serde(skip_serializing_if = "Option::is_none")]
    own: Option<Ipv4Addr>,
    #[serde(skip_serializing_if = "Option::is_none")]
    peer: Option<Ipv4Addr>,
}

impl Playing {
    fn beside<R>(&self, report: R) -> Beside<R> {
        Beside {
            own: self.own,
            peer: self.peer,
            report,
        }
    }
}

/// Plays until SIGTERM or SIGINT.
pub(crate) fn link(argument: &ServeLink) -> Outcome {
    let role = role(argument)?;
    let piece = Piece {
        profile: source::played(&role.profile, "profile")?,
        seed: role.seed,
        epoch: role.epoch.unwrap_or_else(|| Epoch::at_ns(now_ns())),
        opens: LinkTime::from_ns(role.opens_ns),
        player: role.player,
        device: role.device,
    };
    let stop = stop::told_to_end()?;
    std::fs::create_dir_all(&argument.out)
        .with_context(|| format!("cannot make {}", argument.out.display()))?;
    match role.way {
        None => between(argument, piece, &stop),
        Some(way) => beside(argument, way, piece, &stop),
    }
}

/// The player's settings, from a file or from the options.
fn role(argument: &ServeLink) -> Result<LinkRole, Failure> {
    if let Some(file) = &argument.told.file {
        return read(file);
    }
    let asked = argument.profile.as_deref().unwrap_or_default();
    Ok(LinkRole {
        profile: source::named_profile(asked)?,
        seed: argument.seed,
        epoch: argument.epoch_ns.map(Epoch::at_ns),
        opens_ns: 0,
        way: argument.way.map(Way::from),
        player: argument.player.into(),
        device: argument.device.clone(),
    })
}

/// Plays both ways, between two interfaces.
fn between(argument: &ServeLink, piece: Piece, stop: &AtomicBool) -> Outcome {
    let mut record = record(&argument.out, "link")?;
    let packets = packets(&argument.out, "packets", &piece.profile)?;
    let config = PlayerConfig {
        profile: piece.profile,
        seed: piece.seed,
        epoch: piece.epoch,
        opens: piece.opens,
        controller: PacketPort::open(&argument.controller)?,
        plant: PacketPort::open(&argument.plant)?,
        packets,
    };
    say_ready(&format!("{} to {}", argument.controller, argument.plant));
    let report = shaper::play(config, stop, |rows| record.add(rows))?;
    finish(record)?;
    leave(&argument.out, "link", &report)
}

/// Plays the way of one end's packets, in that end's namespace.
fn beside(argument: &ServeLink, way: Way, piece: Piece, stop: &AtomicBool) -> Outcome {
    let neighbours = neighbours(argument)?;
    let device = match (&piece.device, neighbours) {
        (Some(device), _) => Some(device.clone()),
        (None, Some((_, peer))) => Some(shaper::device_towards(peer)?),
        (None, None) => None,
    };
    let player = match (piece.player, &device) {
        (Player::Auto, Some(_)) if piece.profile.beyond_tc().is_some() => Player::User,
        (Player::Auto, Some(device)) => match shaper::tc_available(device) {
            Ok(()) => Player::Tc,
            Err(problem) => {
                tracing::info!(%problem, "the link is played in user space");
                Player::User
            }
        },
        (Player::Auto, None) => Player::User,
        (asked, _) => asked,
    };
    player.check(&piece.profile).map_err(Failure::unsupported)?;
    match (player, device, neighbours) {
        (Player::Tc, Some(device), _) => {
            if let Some((_, peer)) = neighbours {
                shaper::prefill_neighbour(&device, peer)?;
            }
            by_tc(argument, way, piece, device, neighbours, stop)
        }
        (Player::User, _, Some(neighbours)) => by_user(argument, way, piece, neighbours, stop),
        _ => Err(Failure::usage(anyhow!(
            "one direction of a link needs both its ends: give --local and --peer, or --player tc \
             and --device"
        ))),
    }
}

/// Plays by netem, on the interface through which this way's packets leave.
fn by_tc(
    argument: &ServeLink,
    way: Way,
    piece: Piece,
    device: String,
    neighbours: Option<(Ipv4Addr, Ipv4Addr)>,
    stop: &AtomicBool,
) -> Outcome {
    let name = format!("link-{way}");
    let mut record = record(&argument.out, &name)?;
    let config = TcConfig {
        profile: piece.profile,
        seed: piece.seed,
        epoch: piece.epoch,
        opens: piece.opens,
        way,
        device,
    };
    let playing = Playing {
        player: Player::Tc,
        own: neighbours.map(|(own, _)| own),
        peer: neighbours.map(|(_, peer)| peer),
    };
    let player = TcPlayer::start(config)?;
    say_ready(&line(&playing));
    let report = player.play(stop, |row| record.add([row]))?;
    finish(record)?;
    leave(&argument.out, &name, &OneWay::Tc(playing.beside(report)))
}

/// Plays in user space, through a tunnel to the player beside the other end.
fn by_user(
    argument: &ServeLink,
    way: Way,
    piece: Piece,
    (local, peer): (Ipv4Addr, Ipv4Addr),
    stop: &AtomicBool,
) -> Outcome {
    let name = format!("link-{way}");
    let mut record = record(&argument.out, &name)?;
    let packets = packets(&argument.out, &format!("packets-{way}"), &piece.profile)?;
    let socket = |address| SocketAddrV4::new(address, TUNNEL_PORT);
    let config = WayConfig {
        profile: piece.profile,
        seed: piece.seed,
        epoch: piece.epoch,
        opens: piece.opens,
        end: TunPort::open(way)?,
        tunnel: UdpPort::open(socket(local), socket(peer))?,
        packets,
    };
    let ends = (shaper::CONTROLLER_ADDRESS, shaper::PLANT_ADDRESS);
    let (own, peer) = match way {
        Way::Up => ends,
        Way::Down => (ends.1, ends.0),
    };
    let playing = Playing {
        player: Player::User,
        own: Some(own),
        peer: Some(peer),
    };
    say_ready(&line(&playing));
    let report = shaper::play_way(config, stop, |rows| record.add(rows))?;
    finish(record)?;
    leave(&argument.out, &name, &OneWay::User(playing.beside(report)))
}

/// The addresses of this end and of the other, if given.
fn neighbours(argument: &ServeLink) -> Result<Option<(Ipv4Addr, Ipv4Addr)>, Failure> {
    match (&argument.local, &argument.peer) {
        (Some(local), Some(peer)) => Ok(Some((address(local)?, address(peer)?))),
        (None, None) => Ok(None),
        _ => Err(Failure::usage(anyhow!("--local and --peer go together"))),
    }
}

/// The IPv4 address of a host.
fn address(host: &str) -> anyhow::Result<Ipv4Addr> {
    (host, 0)
        .to_socket_addrs()
        .with_context(|| format!("the host `{host}` is not known here"))?
        .find_map(|address| match address {
            SocketAddr::V4(address) => Some(*address.ip()),
            SocketAddr::V6(_) => None,
        })
        .ok_or_else(|| anyhow!("the host `{host}` has no IPv4 address"))
}

/// The file that records packets, if the link has a rate limit: its queue follows from them.
fn packets(
    folder: &Path,
    name: &str,
    profile: &Profile,
) -> anyhow::Result<Option<Record<PacketRow>>> {
    if profile.has_rate() {
        record(folder, name).map(Some)
    } else {
        Ok(None)
    }
}

fn record<R: Serialize + Send + 'static>(folder: &Path, name: &str) -> anyhow::Result<Record<R>> {
    let path = folder.join(format!("{name}.csv"));
    let file = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Record::start(file)?)
}

fn finish<R: Serialize + Send + 'static>(record: Record<R>) -> anyhow::Result<()> {
    record
        .finish()
        .context("cannot write the link's rows; free space")
}

fn line(playing: &Playing) -> String {
    // Two addresses and a word: serialising them cannot fail.
    serde_json::to_string(playing).unwrap_or_default()
}
