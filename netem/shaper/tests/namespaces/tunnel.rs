//! Two ends that share no interface, a player beside each, a tunnel between the two, and a
//! probe in two halves: what containers have. Threads in the ends' namespaces stand for the
//! containers beside them.

use std::net::SocketAddrV4;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use clock::now::now_ns;
use link::certificate::{
    Baseline, Certificate, Echo, LinkRow, PlayerReport, Sighting, WayPlayed, WayReport, certify,
    merge,
};
use link::{Epoch, LinkTime, Profile, Way};
use shaper::{
    Asker, Error, Namespace, TUNNEL_PORT, TunPort, UdpPort, WayConfig, Witness, connect, play_way,
};

use crate::cell::{MS, in_time, print, series};

pub(crate) const SEED: u64 = 7;

type Player = JoinHandle<shaper::Result<(WayPlayed, Vec<LinkRow>)>>;

/// Two ends, their players, and a witness beside the plant.
pub(crate) struct Tunnel {
    pub(crate) controller: Namespace,
    pub(crate) plant: Namespace,
    /// Where the players listen.
    pub(crate) at_controller: SocketAddrV4,
    pub(crate) at_plant: SocketAddrV4,
    profile: Profile,
    epoch_ns: u64,
    stop: Arc<AtomicBool>,
    players: [Player; 2],
    witness: JoinHandle<shaper::Result<Vec<Sighting>>>,
}

impl Tunnel {
    /// Link time 0 is `empty_ns` from now, during which the empty link plays.
    pub(crate) fn start(profile: &Profile, empty_ns: u64) -> shaper::Result<Self> {
        let (controller, plant) = (Namespace::new()?, Namespace::new()?);
        let [at_controller, at_plant] =
            connect(&controller, &plant)?.map(|address| SocketAddrV4::new(address, TUNNEL_PORT));
        let epoch_ns = now_ns() + empty_ns;
        let stop = Arc::new(AtomicBool::new(false));
        let play = |end: &Namespace, way, local, peer| -> shaper::Result<Player> {
            let config = end.run(|| {
                Ok(WayConfig {
                    profile: profile.clone(),
                    seed: SEED,
                    epoch: Epoch::at_ns(epoch_ns),
                    opens: LinkTime::ZERO,
                    end: TunPort::open(way)?,
                    tunnel: UdpPort::open(local, peer)?,

                    packets: None,
                })
            })?;
            let stop = Arc::clone(&stop);
            Ok(thread::spawn(move || {
                let mut rows = Vec::with_capacity(1000);
                let played = play_way(config, &stop, |second| rows.extend(second))?;
                Ok((played, rows))
            }))
        };
        let mut witness = plant.run(Witness::open)?;
        let players = [
            play(&controller, Way::Up, at_controller, at_plant)?,
            play(&plant, Way::Down, at_plant, at_controller)?,
        ];
        let witness = thread::spawn({
            let stop = Arc::clone(&stop);
            move || {
                let mut sightings = Vec::with_capacity(10_000);
                witness.run(&stop, |sighting| sightings.push(sighting))?;
                Ok(sightings)
            }
        });
        Ok(Self {
            controller,
            plant,
            at_controller,
            at_plant,
            profile: profile.clone(),
            epoch_ns,
            stop,
            players,
            witness,
        })
    }

    /// Asks every `interval_ns` from link time `start_ns` on.
    fn ask(&self, start_ns: i64, interval_ns: u64, count: u32, id: u16) -> Vec<Echo> {
        let plan = series(self.epoch_ns, start_ns, interval_ns, count, id);
        let mut asker = self.controller.run(Asker::open).unwrap();
        let echoes = asker
            .run(&plan, &AtomicBool::new(false), |echo| {
                assert_eq!(echo.t_reach_ns, None, "the asker cannot know");
            })
            .unwrap();
        assert!(echoes.iter().all(|echo| echo.t_reach_ns.is_none()));
        echoes
    }

    /// Ends it all. What the players say must add up, and they must have lost nothing.
    pub(crate) fn finish(self) -> (WayPlayed, WayPlayed, Vec<Sighting>) {
        self.finish_without(0)
    }

    /// The same, where so many packets were too long for the plant's player.
    pub(crate) fn finish_without(self, too_long: u64) -> (WayPlayed, WayPlayed, Vec<Sighting>) {
        self.stop.store(true, Ordering::Relaxed);
        let [up, down] = self.players.map(|player| {
            let (played, rows) = player.join().unwrap().expect("it plays to the end");
            let report = played.shaped;
            let carried_not = if played.way == Way::Down { too_long } else { 0 };
            assert_eq!(report.dropped, 0, "{played:?}");
            assert_eq!(played.carried.dropped, carried_not, "{played:?}");
            assert_eq!(
                report.packets,
                report.delivered + report.lost + report.overflow + report.unplayed,
                "each packet is accounted for"
            );
            assert!(rows.iter().all(|row| row.way == played.way));
            let delivered: u64 = rows.iter().map(|row| row.delivered).sum();
            assert_eq!(delivered, report.delivered, "the rows add up to the report");
            played
        });
        // Nothing is lost between the two, but one may be ended before the other.
        assert!(up.astray(&down) <= 2 && down.astray(&up) <= 2);
        let link = PlayerReport::of_ways(&up, &down).expect("the two ways of a link");
        let shaped = WayReport {
            dropped: too_long,
            ..up.shaped
        };
        assert_eq!((link.up, link.down), (shaped, down.shaped));
        (up, down, self.witness.join().unwrap().unwrap())
    }

    /// Probes the empty link, then the link, each in two halves.
    pub(crate) fn prove(
        self,
        name: &str,
        interval_ns: u64,
        count: u32,
    ) -> Result<Certificate, String> {
        let empty = self.ask(-900 * MS.cast_signed(), 4 * MS, 200, 1);
        if let Err(busy) = in_time(&empty, self.epoch_ns) {
            self.finish();
            return Err(busy);
        }
        let echoes = self.ask(100 * MS.cast_signed(), interval_ns, count, 2);
        let (profile, epoch_ns) = (self.profile.clone(), self.epoch_ns);
        let (up, down, sightings) = self.finish();
        let baseline = Baseline::of(&merge(&empty, 1, &sightings)).expect("it answers");
        let echoes = merge(&echoes, 2, &sightings);
        let certificate = certify(&echoes, &profile, SEED, Epoch::at_ns(epoch_ns), baseline);
        print(name, &certificate);
        println!(
            "  {:?}; late us: shaped up {:.0} (99 %: {:.0}), down {:.0} ({:.0}), carried up {:.0} ({:.0}), down {:.0} ({:.0})",
            up.scheduling,
            up.shaped.lateness.mean_us,
            up.shaped.lateness.p99_us,
            down.shaped.lateness.mean_us,
            down.shaped.lateness.p99_us,
            down.carried.lateness.mean_us,
            down.carried.lateness.p99_us,
            up.carried.lateness.mean_us,
            up.carried.lateness.p99_us,
        );
        Ok(certificate)
    }
}

/// Whether this machine lets a tunnel be made. If not, the test has said so.
pub(crate) fn possible() -> bool {
    let end = Namespace::new().unwrap();
    match end.run(|| TunPort::open(Way::Up)) {
        Ok(_) => true,
        Err(error @ Error::Unsupported { .. }) => {
            println!("  SKIPPED: {error}");
            false
        }
        Err(error) => panic!("{error}"),
    }
}
