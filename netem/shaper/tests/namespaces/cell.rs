//! A whole cell in this process: three namespaces, joined, and a player on a thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use clock::now::now_ns;
use link::certificate::{Baseline, Certificate, Echo, LinkRow, PlayerReport, certify};
use link::{Epoch, LinkTime, Profile};
use shaper::{
    CONTROLLER_INTERFACE, Namespace, PLANT_ADDRESS, PLANT_INTERFACE, PacketPort, PlayerConfig,
    ProbePlan, join, play, probe,
};

pub(crate) const MS: u64 = 1_000_000;
pub(crate) const SECOND: u64 = 1_000_000_000;

/// A link that is constant.
pub(crate) fn constant(delay: &str) -> Profile {
    parse(&format!(
        "name = \"constant\"\nabout = \"a constant link\"\n[both.delay]\nbase = \"{delay}\"\n"
    ))
}

/// One of the paper's.
pub(crate) fn builtin(name: &str) -> Profile {
    parse(Profile::builtin(name).expect("a profile of the paper"))
}

pub(crate) fn parse(source: &str) -> Profile {
    Profile::parse(source, "a test").expect("a valid profile")
}

pub(crate) struct Cell {
    pub(crate) controller: Namespace,
    pub(crate) plant: Namespace,
    profile: Profile,
    seed: u64,
    pub(crate) epoch_ns: u64,
    stop: Arc<AtomicBool>,
    player: JoinHandle<shaper::Result<(PlayerReport, Vec<LinkRow>)>>,
}

/// What was measured over a link, and the judgement.
pub(crate) struct Proof {
    pub(crate) certificate: Certificate,
    pub(crate) echoes: Vec<Echo>,
    pub(crate) baseline: Baseline,
    pub(crate) epoch_ns: u64,
}

/// Echoes to the plant every `interval_ns` from link time `start_ns` on.
pub(crate) fn series(
    epoch_ns: u64,
    start_ns: i64,
    interval_ns: u64,
    count: u32,
    id: u16,
) -> ProbePlan {
    ProbePlan {
        target: PLANT_ADDRESS,
        start_ns: epoch_ns.checked_add_signed(start_ns).expect("after boot"),
        interval_ns,
        seed: None,
        until_ns: vec![u64::from(count) * interval_ns + 5 * SECOND; count as usize],
        id,
    }
}

/// Whether echoes over the empty link were sent while it was still empty.
pub(crate) fn in_time(echoes: &[Echo], epoch_ns: u64) -> Result<(), String> {
    if echoes.iter().all(|echo| echo.t_send_ns < epoch_ns) {
        Ok(())
    } else {
        Err("the machine was too busy to measure the empty link in time".into())
    }
}

impl Cell {
    /// Link time 0 is `empty_ns` from now, during which the empty link plays.
    pub(crate) fn start(profile: &Profile, seed: u64, empty_ns: u64) -> shaper::Result<Self> {
        let (controller, plant, middle) = (Namespace::new()?, Namespace::new()?, Namespace::new()?);
        join(&controller, &plant, &middle, profile.treats_packets_alike())?;
        let (at_controller, at_plant) = middle.run(|| {
            Ok((
                PacketPort::open(CONTROLLER_INTERFACE)?,
                PacketPort::open(PLANT_INTERFACE)?,
            ))
        })?;
        let epoch_ns = now_ns() + empty_ns;
        let config = PlayerConfig {
            packets: None,
            profile: profile.clone(),
            seed,
            epoch: Epoch::at_ns(epoch_ns),
            opens: LinkTime::ZERO,
            controller: at_controller,
            plant: at_plant,
        };
        let stop = Arc::new(AtomicBool::new(false));
        let player = thread::spawn({
            let stop = Arc::clone(&stop);
            move || {
                let mut rows = Vec::with_capacity(1000);
                let report = play(config, &stop, |second| rows.extend(second))?;
                Ok((report, rows))
            }
        });
        Ok(Self {
            controller,
            plant,
            profile: profile.clone(),
            seed,
            epoch_ns,
            stop,
            player,
        })
    }

    /// Probes every `interval_ns` from link time `start_ns` on.
    pub(crate) fn probe(&self, start_ns: i64, interval_ns: u64, count: u32, id: u16) -> Vec<Echo> {
        let plan = series(self.epoch_ns, start_ns, interval_ns, count, id);
        probe(&plan, &self.controller, &self.plant).expect("probing works")
    }

    /// Probes the empty link, then the link, every `interval_ns`, and ends the player.
    pub(crate) fn prove(self, name: &str, interval_ns: u64, count: u32) -> Result<Proof, String> {
        let empty = self.probe(-900 * MS.cast_signed(), 4 * MS, 200, 1);
        if let Err(busy) = in_time(&empty, self.epoch_ns) {
            self.finish();
            return Err(busy);
        }
        let baseline = Baseline::of(&empty).expect("the empty link answers");
        let echoes = self.probe(100 * MS.cast_signed(), interval_ns, count, 2);
        let (profile, seed, epoch_ns) = (self.profile.clone(), self.seed, self.epoch_ns);
        let report = self.finish();
        let certificate = certify(&echoes, &profile, seed, Epoch::at_ns(epoch_ns), baseline);
        print(name, &certificate);
        println!(
            "  {:?}, lateness up {:?}",
            report.scheduling, report.up.lateness
        );
        Ok(Proof {
            certificate,
            echoes,
            baseline,
            epoch_ns,
        })
    }

    /// Sleeps until so long after link time 0.
    pub(crate) fn sleep_until(&self, t_ns: u64) {
        let left = (self.epoch_ns + t_ns).saturating_sub(now_ns());
        thread::sleep(Duration::from_nanos(left));
    }

    /// Ends the player. What it says of itself must add up, and it must have lost nothing.
    pub(crate) fn finish(self) -> PlayerReport {
        self.stop.store(true, Ordering::Relaxed);
        let (report, rows) = self
            .player
            .join()
            .unwrap()
            .expect("the player plays to the end");
        assert_eq!(report.dropped(), 0, "the player lost packets: {report:?}");
        for (way, from_rows) in [(report.up, 0), (report.down, 1)] {
            assert_eq!(
                way.packets + way.duplicated,
                way.delivered + way.lost + way.overflow + way.unplayed,
                "each packet is accounted for"
            );
            let delivered: u64 = rows
                .iter()
                .filter(|row| row.way as usize == from_rows)
                .map(|row| row.delivered)
                .sum();
            assert_eq!(delivered, way.delivered, "the rows add up to the report");
        }
        report
    }
}

/// In one line what there is to see in a certificate.
pub(crate) fn print(name: &str, certificate: &Certificate) {
    let us = |ms: f64| ms * 1e3;
    let residual = certificate.residuals.rtt;
    println!(
        "  {name}: {} of {} answered; RTT residual us: median {:.0}, p99 {:.0}, max {:.0}, bias {:.0}; baseline {:.0}; fates {:?}; {:?}",
        certificate.answered,
        certificate.sent,
        us(residual.median_ms),
        us(residual.p99_ms),
        us(residual.max_ms),
        us(residual.bias_ms),
        us(certificate.baseline.rtt_ms),
        certificate.fates,
        certificate.verdict
    );
}
