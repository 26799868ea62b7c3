//! Pings through a link with nothing else on it: what `webloop probe` does.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};
use std::thread;

use clock::now::now_ns;
use link::certificate::{Baseline, Certificate, Echo, Edge};
use link::{Epoch, LinkTime, Profile, Way};
use plan::Phase;
use shaper::{PacketPort, PlayerConfig, Prober, TcConfig, TcPlayer, play};

use crate::error::RunError;
use crate::lab::Lab;
use crate::link_check::{LinkCheck, NOTHING_ENTERED};
use crate::player::Player;
use crate::schedule::{self, Series, Spacing};

/// What the echoes have shown.
#[derive(Debug)]
pub struct Probed {
    /// Every echo after the epoch, in order of sending.
    pub echoes: Vec<Echo>,
    /// Cost of crossing the player itself.
    pub baseline: Baseline,
    /// Whether the link was the one asked for; `None` on loopback.
    pub certificate: Option<Certificate>,
}

/// Makes the link, measures it empty, then sends `count` echoes from link time 0 on.
///
/// `on_answer` gets each echo when its answer comes. The probe ends early when `stop` is set.
///
/// # Errors
/// If the link cannot be made, played or probed.
pub fn probe(
    profile: &Profile,
    seed: u64,
    player: Player,
    count: u32,
    interval_ns: u64,
    stop: &AtomicBool,
    on_answer: impl FnMut(&Echo) + Send,
) -> Result<Probed, RunError> {
    player.check(profile)?;
    let lab = Lab::new(profile, player)?;
    let epoch_ns = now_ns() + schedule::PROBE_LEAD_NS;
    let epoch = Epoch::at_ns(epoch_ns);
    let link_check = LinkCheck {
        target: lab.plant_address(),
        profile,
        seed,
        epoch,
        opens: LinkTime::ZERO,
        closes: LinkTime::from_ns(u64::MAX),
        entered: &NOTHING_ENTERED,
    };
    let series = Series {
        phase: Phase::During,
        start_ns: epoch_ns,
        interval_ns,
        count,
    };
    let (echoes, edge) = play_and_send(&lab, player, &link_check, series, stop, on_answer)?;
    let [empty, echoes] = echoes;
    let baseline = link_check
        .baseline(&empty)
        .ok_or_else(|| RunError::Echoes("no echo came through the empty link".into()))?;
    let certificate =
        (!profile.is_loopback()).then(|| link_check.certificate(&echoes, baseline, edge));
    Ok(Probed {
        echoes,
        baseline,
        certificate,
    })
}

/// Sends the echoes while the link is played. Returns them, and how exactly the players kept to the
/// link's times.
fn play_and_send(
    lab: &Lab,
    player: Player,
    link_check: &LinkCheck,
    series: Series,
    stop: &AtomicBool,
    on_answer: impl FnMut(&Echo) + Send,
) -> Result<([Vec<Echo>; 2], Edge), RunError> {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let (ready, in_force) = mpsc::channel();
        let done = &done;
        let ways = ways(lab, player);
        if let (Some(middle), Player::Tc) = (lab.middle(), player) {
            middle.run(shaper::bridge)?;
        }
        let players: Vec<_> = lab
            .middle()
            .into_iter()
            .flat_map(|middle| ways.iter().map(move |way| (middle, *way)))
            .map(|(middle, way)| {
                let ready = ready.clone();
                scope.spawn(move || middle.run(|| play_link(link_check, way, &ready, done)))
            })
            .collect();
        drop(ready);
        // A player that cannot play says so when it is joined.
        for _ in ways {
            let _ = in_force.recv();
        }
        let echoes = echoes(lab, link_check, series, stop, on_answer);
        done.store(true, Ordering::Relaxed);
        let mut edge = Edge::USER;
        for player in players {
            let played = player
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            edge = edge.or(played?);
        }
        Ok((echoes?, edge))
    })
}

/// The ways that each player plays: no player on loopback, one for each way with tc, else one for both.
fn ways(lab: &Lab, player: Player) -> &'static [Option<Way>] {
    match (lab.middle(), player) {
        (None, _) => &[],
        (Some(_), Player::Tc) => &[Some(Way::Up), Some(Way::Down)],
        (Some(_), Player::User | Player::Auto) => &[None],
    }
}

/// Sends the echoes on the empty link, then those of a series.
fn echoes(
    lab: &Lab,
    link_check: &LinkCheck,
    series: Series,
    stop: &AtomicBool,
    on_answer: impl FnMut(&Echo) + Send,
) -> Result<[Vec<Echo>; 2], RunError> {
    let mut prober = Prober::open(lab.controller(), lab.plant())?;
    let plan = link_check.plan(Spacing::Close.empty(now_ns()));
    let empty = prober.run(&plan, stop, |_| {})?;
    let echoes = prober.run(&link_check.plan(series), stop, on_answer)?;
    Ok([empty, echoes])
}

/// Plays on this thread, in the middle namespace, until `done`: one way by tc, or both by webloop.
/// Signals on `ready` when the empty link is in force, and returns how exactly it kept to the
/// link's times.
fn play_link(
    link_check: &LinkCheck,
    way: Option<Way>,
    ready: &Sender<()>,
    done: &AtomicBool,
) -> shaper::Result<Edge> {
    let LinkCheck {
        seed, epoch, opens, ..
    } = *link_check;
    let profile = link_check.profile.clone();
    let (controller, plant) = (shaper::CONTROLLER_INTERFACE, shaper::PLANT_INTERFACE);
    let Some(way) = way else {
        let config = PlayerConfig {
            profile,
            seed,
            epoch,
            opens,
            controller: PacketPort::open(controller)?,
            plant: PacketPort::open(plant)?,
            packets: None,
        };
        let _ = ready.send(());
        return play(config, done, |_| {}).map(|_| Edge::USER);
    };
    let device = match way {
        Way::Up => plant,
        Way::Down => controller,
    };
    let player = TcPlayer::start(TcConfig {
        profile,
        seed,
        epoch,
        opens,
        way,
        device: device.to_owned(),
    })?;
    let _ = ready.send(());
    player.play(done, |_| {}).map(|report| report.edge())
}
