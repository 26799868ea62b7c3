//! What this machine can do for runs in namespaces, tried out rather than guessed. What clients and containers need
//! is not here: who offers them all tries it.
//!
//! Each ability is tried the way a run would use it. For a missing one, the result says what that means
//! for the user and what to do about it.

use link::Profile;

use crate::awake;
use crate::lab::Lab;
use crate::player::Player;
pub use crate::unable::Unable;

/// How much a run needs an ability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Without it there are no runs.
    Must,
    /// Without it runs are less exact, or fewer.
    Better,
}

/// One thing that the machine can or cannot do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ability {
    /// Its name.
    pub what: &'static str,
    /// How much it is needed.
    pub need: Need,
    /// What was found, or why it is missing.
    pub found: Result<String, Unable>,
    /// What to do if it is missing.
    pub remedy: &'static str,
}

/// Tries all that a run in namespaces uses. Call [`shaper::become_root`] first and pass its result.
#[must_use]
pub fn abilities(authority: &shaper::Result<shaper::Authority>) -> Vec<Ability> {
    let mut abilities = vec![Ability {
        what: "make namespaces",
        need: Need::Must,
        found: match authority {
            Ok(shaper::Authority::Privileged) => Ok("as root".into()),
            Ok(shaper::Authority::UserNamespace) => Ok("in a user namespace, without root".into()),
            Err(problem) => Err(Unable::by(problem)),
        },
        remedy: "run as root, or allow user namespaces",
    }];
    abilities.push(Ability {
        what: "join them by veth pairs",
        need: Need::Must,
        found: match authority {
            Ok(_) => Lab::new(&Profile::empty(), Player::User)
                .map(|_| "made and removed".to_owned())
                .map_err(|problem| Unable::by(&problem)),
            Err(_) => Err(Unable::new("needs namespaces")),
        },
        remedy: "load the kernel module veth",
    });
    abilities.extend([
        Ability {
            what: "real-time scheduling",
            need: Need::Better,
            found: try_fifo(),
            remedy: "run as root on the host, or grant rtprio; without it ticks and the link are late when the machine is busy",
        },
        Ability {
            what: "processors kept awake",
            need: Need::Better,
            found: awake::trial(),
            remedy: "needed by --awake only: run as root on the host; in a container, --device /dev/cpu_dma_latency",
        },
        Ability {
            what: "two processors or more",
            need: Need::Better,
            found: match std::thread::available_parallelism().map_or(1, usize::from) {
                1 => Err(Unable::new("one")),
                n => Ok(n.to_string()),
            },
            remedy: "expect late ticks; keep --jobs at 1",
        },
        Ability {
            what: "open files",
            need: Need::Better,
            found: open_files(),
            remedy: "raise the hard limit (ulimit -Hn): with unlimited outstanding, a stall of 3 s at 1 kHz holds 3000 connections",
        },
        Ability {
            what: "netem, for --player tc",
            need: Need::Better,
            found: netem(),
            remedy: "not needed, since webloop plays links itself; load the kernel module sch_netem and install iproute2",
        },
    ]);
    abilities
}

/// Asks for `SCHED_FIFO` on a thread of its own.
fn try_fifo() -> Result<String, Unable> {
    std::thread::spawn(|| {
        let granted = clock::scheduling::ask(Some(1));
        match granted.fifo_priority {
            Some(_) => Ok("SCHED_FIFO granted".to_owned()),
            None => Err(Unable::new(granted.refused.unwrap_or_default())),
        }
    })
    .join()
    .unwrap_or_else(|_| Err(Unable::new("the trial failed")))
}

/// Has tc put a netem on an interface that nothing else uses.
fn netem() -> Result<String, Unable> {
    shaper::Namespace::new()
        .and_then(|nowhere| nowhere.run(|| shaper::tc_available("lo")))
        .map(|()| "tried out".to_owned())
        .map_err(|problem| match problem {
            shaper::Error::Unsupported { source, .. } => Unable::by(&source),
            failed @ shaper::Error::Failed { .. } => Unable::by(&failed),
        })
}

fn open_files() -> Result<String, Unable> {
    const ENOUGH: u64 = 8_192;
    let limit = rustix::process::getrlimit(rustix::process::Resource::Nofile);
    match limit.maximum {
        Some(most) if most < ENOUGH => Err(Unable::new(format!("at most {most}"))),
        Some(most) => Ok(format!("up to {most}")),
        None => Ok("without limit".into()),
    }
}
