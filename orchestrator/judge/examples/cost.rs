//! What judging a run's messages costs, once, when it has ended.
//!
//! `cargo run --release -p webloop-judge --example cost -- [SECONDS]` judges a loop at 1 kHz over each
//! link, of 60 s if nothing is said. Nothing of it is on a measured path, and whoever reads a folder
//! finds the result in its manifest.
#![allow(clippy::print_stdout, reason = "its output is what it is for")]
#![allow(
    clippy::disallowed_methods,
    reason = "it measures, which the crate does not"
)]

use std::error::Error;
use std::time::Instant;

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow};
use judge::{Still, Terms};
use link::{Epoch, Profile, Timeline, Way};
use plan::Client;

const H_NS: u64 = 1_000_000;
const EPOCH_NS: u64 = 3_600_000_000_000;
/// What a client and the kernels take of a way.
const COST_NS: u64 = 80_000;

fn main() -> Result<(), Box<dyn Error>> {
    let seconds: u64 = std::env::args().nth(1).as_deref().unwrap_or("60").parse()?;
    for name in Profile::BUILTIN {
        let source = Profile::builtin(name).ok_or("not built in")?;
        let (profile, _) = Profile::read(source, name, &|_| Err("no trace".to_owned()));
        let profile = profile.ok_or("not valid")?;
        let (messages, arrivals) = rows(&profile, seconds * 1_000_000_000 / H_NS);
        let terms = Terms {
            timeline: Timeline::new(&profile, 1, Epoch::at_ns(EPOCH_NS)),
            run_ns: EPOCH_NS..EPOCH_NS + (seconds + 10) * 1_000_000_000,
            before_ns: 0,
            fall_ns: 0,
            baseline_ms: [0.02; 2],
            allowance: Client::Native.spec().allowance,
            connecting: judge::Connecting::Pool { accepted: None },
            has_rate: profile.has_rate(),
            timeout_ms: 5_000.0,
            busy: judge::Busy::default(),
            h_ms: H_NS as f64 * 1e-6,
            still: Still::default(),
            hits: judge::Hits::default(),
        };
        let clock = Instant::now();
        let held = judge::message::hold(&messages, &arrivals, &terms);
        let took = clock.elapsed();
        println!(
            "{name:>10}: {:.0} ms for {} messages, {:.2} us each; {} faults",
            took.as_secs_f64() * 1e3,
            messages.len(),
            took.as_secs_f64() * 1e6 / messages.len() as f64,
            judge::message::faults(&held, &terms).len()
        );
    }
    Ok(())
}

/// A loop whose every message is answered, save those that the link loses.
fn rows(profile: &Profile, count: u64) -> (Vec<MessageRow>, Vec<ArrivalRow>) {
    let mut link = Timeline::new(profile, 1, Epoch::at_ns(EPOCH_NS));
    let mut cross = |way, t_ns: u64| {
        let passage = link.passage(way, t_ns + COST_NS / 2, 90);
        (!passage.lost).then(|| t_ns + COST_NS + passage.delay_ns)
    };
    let (mut messages, mut arrivals) = (Vec::new(), Vec::new());
    for seq in 0..count {
        let t_send_ns = EPOCH_NS + 1_300_000_000 + seq * H_NS;
        let t_arrive_ns = cross(Way::Up, t_send_ns);
        let t_receive_ns = t_arrive_ns.and_then(|t_ns| cross(Way::Down, t_ns));
        messages.push(MessageRow {
            seq,
            t_due_ns: t_send_ns,
            t_send_ns: Some(t_send_ns),
            t_receive_ns,
            t_arrive_ns: t_receive_ns.and(t_arrive_ns),
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome: match t_receive_ns {
                Some(_) => MessageOutcome::Answered,
                None => MessageOutcome::Timeout,
            },
            y_seq: None,
        });
        if let Some(t_arrive_ns) = t_arrive_ns {
            arrivals.push(ArrivalRow {
                n: arrivals.len() as u64,
                seq,
                t_send_ns: Some(t_send_ns),
                t_arrive_ns,
                tick: 0,
                u: 0.0,
                outcome: ArrivalOutcome::Applied,
            });
        }
    }
    (messages, arrivals)
}
