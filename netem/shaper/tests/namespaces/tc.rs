//! The tc player, on a kernel that has netem; elsewhere these tests say that they are skipped.
//! The ends are joined by a bridge, so it is the kernel that forwards.

use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};

use clock::now::now_ns;
use link::certificate::{Baseline, Echo, TcReport, TcRow, Verdict, certify_within};
use link::{Epoch, LinkTime, Profile, Timeline, Way};
use shaper::{
    CONTROLLER_INTERFACE, Error, Namespace, PLANT_INTERFACE, TcConfig, TcPlayer, bridge, join,
    probe, tc_available,
};

use crate::attempt::{held, holds};
use crate::cell::{MS, SECOND, builtin, in_time, print, series};

type Played = shaper::Result<(TcReport, Vec<TcRow>)>;

/// A bridged cell, both of whose ways are played by tc.
pub(crate) struct TcCell {
    pub(crate) controller: Namespace,
    pub(crate) plant: Namespace,
    pub(crate) middle: Arc<Namespace>,
    pub(crate) epoch_ns: u64,
    stop: Arc<AtomicBool>,
    players: [JoinHandle<Played>; 2],
}

/// Two ends and a bridge between them, without any link.
pub(crate) fn bridged() -> [Namespace; 3] {
    let [controller, plant, middle] = [(); 3].map(|()| Namespace::new().unwrap());
    join(&controller, &plant, &middle, false).unwrap();
    middle.run(bridge).unwrap();
    [controller, plant, middle]
}

/// Whether netem is there; says so where it is not.
pub(crate) fn netem(middle: &Namespace) -> bool {
    match middle.run(|| tc_available(PLANT_INTERFACE)) {
        Ok(()) => true,
        Err(error @ Error::Unsupported { .. }) => {
            println!("  SKIPPED: {error}");
            false
        }
        Err(error) => panic!("{error}"),
    }
}

/// What a command in a namespace prints; it must succeed.
pub(crate) fn command(namespace: &Namespace, line: &str) -> String {
    let output = namespace
        .run(|| {
            let mut words = line.split_whitespace();
            let program = words.next().unwrap();
            Ok(Command::new(program).args(words).output().unwrap())
        })
        .unwrap();
    assert!(output.status.success(), "{line}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// Plays one way on a thread of its own in the middle; the empty link is in force when this
/// returns.
pub(crate) fn start(
    middle: &Arc<Namespace>,
    config: TcConfig,
    stop: &Arc<AtomicBool>,
) -> JoinHandle<Played> {
    let (middle, stop) = (Arc::clone(middle), Arc::clone(stop));
    let (started, ready) = channel();
    let player = thread::spawn(move || {
        middle.enter()?;
        let player = TcPlayer::start(config);
        started.send(()).unwrap();
        let mut rows = Vec::with_capacity(1000);
        let report = player?.play(&stop, |row| rows.push(row))?;
        Ok((report, rows))
    });
    ready.recv().unwrap();
    player
}

/// The way that leaves by `device`.
pub(crate) fn config(profile: &Profile, way: Way, epoch_ns: u64) -> TcConfig {
    let device = match way {
        Way::Up => PLANT_INTERFACE,
        Way::Down => CONTROLLER_INTERFACE,
    };
    TcConfig {
        profile: profile.clone(),
        seed: SEED,
        epoch: Epoch::at_ns(epoch_ns),
        opens: LinkTime::ZERO,
        way,
        device: device.to_owned(),
    }
}

pub(crate) const SEED: u64 = 7;

impl TcCell {
    /// Link time 0 is `empty_ns` from now, during which the empty link plays; on a machine where the
    /// players take more than half of that to start, twice as long and so on. `None` where there is
    /// no netem.
    pub(crate) fn start(profile: &Profile, empty_ns: u64) -> Option<Self> {
        let [controller, plant, middle] = bridged();
        if !netem(&middle) {
            return None;
        }
        let middle = Arc::new(middle);
        for lead_ns in [1, 2, 4, 8].map(|times| times * empty_ns) {
            let epoch_ns = now_ns() + lead_ns;
            let stop = Arc::new(AtomicBool::new(false));
            let players = [Way::Up, Way::Down]
                .map(|way| start(&middle, config(profile, way, epoch_ns), &stop));
            if now_ns() + empty_ns / 2 < epoch_ns {
                return Some(Self {
                    controller,
                    plant,
                    middle,
                    epoch_ns,
                    stop,
                    players,
                });
            }
            println!("  too slow to start within {} s", lead_ns / SECOND);
            stop.store(true, Ordering::Relaxed);
            for player in players {
                player.join().unwrap().expect("plays until it is stopped");
            }
        }
        panic!("the players take more than seven times {empty_ns} ns to start");
    }

    pub(crate) fn probe(&self, start_ns: i64, interval_ns: u64, count: u32, id: u16) -> Vec<Echo> {
        let plan = series(self.epoch_ns, start_ns, interval_ns, count, id);
        probe(&plan, &self.controller, &self.plant).expect("probing works")
    }

    /// What the empty link costs.
    fn baseline(&self) -> Result<Baseline, String> {
        let echoes = self.probe(-1400 * MS.cast_signed(), 20 * MS, 60, 1);
        in_time(&echoes, self.epoch_ns)?;
        Ok(Baseline::of(&echoes).expect("the empty link answers"))
    }

    /// Sleeps until so long after link time 0.
    pub(crate) fn sleep_until(&self, t_ns: u64) {
        let left = (self.epoch_ns + t_ns).saturating_sub(now_ns());
        thread::sleep(std::time::Duration::from_nanos(left));
    }

    /// Ends the players. What they say must add up, they must have lost nothing, and the
    /// interfaces must be as they were.
    pub(crate) fn finish(self) -> [TcReport; 2] {
        self.stop.store(true, Ordering::Relaxed);
        let reports = self.players.map(|player| {
            let (report, rows) = player.join().unwrap().expect("plays to the end");
            let traffic = &report.traffic;
            assert_eq!(traffic.dropped, 0, "the player lost packets: {report:?}");
            assert_eq!(
                traffic.packets,
                traffic.delivered + traffic.lost + traffic.overflow + traffic.unplayed
            );
            let sum = |column: fn(&TcRow) -> u64| rows.iter().map(column).sum::<u64>();
            assert_eq!(sum(|row| row.delivered), traffic.delivered);
            assert_eq!(sum(|row| row.lost), traffic.lost);
            assert_eq!(sum(|row| row.changes), report.changes);
            report
        });
        for device in [CONTROLLER_INTERFACE, PLANT_INTERFACE] {
            let listing = command(&self.middle, &format!("tc qdisc show dev {device}"));
            assert!(listing.contains("noqueue 0: root"), "{listing}");
        }
        reports
    }
}

/// The goal: each link holds its certificate, and none that is another's.
pub(crate) fn tc_plays_each_of_the_paper_s_links_as_predicted() {
    for name in ["buccoo", "diego-lan", "diego-vpn", "couva"] {
        // A guest of one core is interrupted by its host for tens of milliseconds now and then,
        // and what it then does late is late for every player.
        holds(name, || match TcCell::start(&builtin(name), 4 * SECOND) {
            Some(cell) => play_and_judge(name, cell),
            None => Ok(()),
        });
    }
}

fn play_and_judge(name: &str, cell: TcCell) -> Result<(), String> {
    let baseline = match cell.baseline() {
        Ok(baseline) => baseline,
        Err(busy) => {
            cell.finish();
            return Err(busy);
        }
    };
    let echoes = cell.probe(100 * MS.cast_signed(), 20 * MS, 400, 2);
    let timeline = |seed| Timeline::new(&builtin(name), seed, Epoch::at_ns(cell.epoch_ns));
    let [right, wrong] = [SEED, SEED + 1].map(timeline);
    let reports = cell.finish();
    let edge = reports[0].edge().or(reports[1].edge());
    let certificate = certify_within(&echoes, right, baseline, edge);
    print(name, &certificate);
    for report in &reports {
        let seconds = (report.ended_ns - report.started_ns) as f64 / 1e9;
        println!(
            "    {:?} {:?}: {} changes, {:.0} a second, {} skipped; lateness {:.0?}; answers {:.0?}; {:?}",
            report.way,
            report.scheduling,
            report.changes,
            report.changes as f64 / seconds,
            report.skipped,
            report.traffic.lateness,
            report.answer,
            report.edge(),
        );
    }
    let another = certify_within(&echoes, wrong, baseline, edge);
    held(&certificate)?;
    // Changes that come late let an echo take the time of the level before or of the one after, and with many of
    // them any seed's levels explain what was measured.
    if another.verdict == Verdict::Holds {
        return Err(format!("another seed's link would hold too: {another:?}"));
    }
    Ok(())
}
