//! Pings through a link with nothing else on it: what `webloop probe` does.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use link::Profile;
use shaper::{Baseline, Certificate, Echo, PacketPort, PlayerConfig, now_ns, play};

use crate::proof::Proof;
use crate::schedule::{self, Series};
use crate::{Lab, RunError};
use plan::Phase;

/// What the echoes have shown.
#[derive(Debug)]
pub struct Probed {
    /// Every echo after the epoch, in order of sending.
    pub echoes: Vec<Echo>,
    /// What the crossing of the player itself costs.
    pub baseline: Baseline,
    /// Whether the link was the one asked for; `None` on loopback.
    pub certificate: Option<Certificate>,
}

/// Makes the link, measures it empty, then sends `count` echoes from link time 0 on.
///
/// `on_answer` gets each echo as its answer comes. It ends early when `stop` is set.
///
/// # Errors
/// When the link cannot be made, played or probed.
pub fn probe(
    profile: &Profile,
    seed: u64,
    count: u32,
    interval_ns: u64,
    stop: &AtomicBool,
    on_answer: impl FnMut(&Echo) + Send,
) -> Result<Probed, RunError> {
    let lab = Lab::new(profile)?;
    let epoch_ns = now_ns() + schedule::EPOCH_AFTER_NS;
    let proof = Proof {
        lab: &lab,
        profile,
        seed,
        epoch_ns,
    };
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let player = scope.spawn(|| match lab.middle() {
            None => Ok(None),
            Some(middle) => middle.run(|| {
                let config = PlayerConfig {
                    profile: profile.clone(),
                    seed,
                    epoch_ns,
                    controller: PacketPort::open(shaper::CONTROLLER_INTERFACE)?,
                    plant: PacketPort::open(shaper::PLANT_INTERFACE)?,
                };
                play(config, &done, |_| {}).map(Some)
            }),
        });
        let probed = (|| {
            let empty = proof.series(schedule::empty(now_ns()), stop)?;
            let series = Series {
                phase: Phase::During,
                start_ns: epoch_ns,
                interval_ns,
                count,
            };
            let echoes = proof.watched(series, stop, on_answer)?;
            Ok::<_, RunError>((empty, echoes))
        })();
        done.store(true, Ordering::Relaxed);
        let played = player
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        played?;
        let (empty, echoes) = probed?;
        let baseline = proof
            .baseline(&empty)
            .ok_or_else(|| RunError::Link("no echo came through the empty link".into()))?;
        let certificate = proof.certificate(&echoes, baseline);
        Ok(Probed {
            echoes,
            baseline,
            certificate,
        })
    })
}
