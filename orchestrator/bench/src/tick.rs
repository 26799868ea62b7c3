//! Ticks every millisecond: how late each is against its deadline, and how far the time between two varies.
//!
//! All keep an absolute grid but tokio's interval, whose deadlines are its own. Those that can ask for real-time
//! scheduling do.

use std::process::Command;
use std::thread;
use std::time::Duration;

use analysis::statistics::Moments;
use endpoint::TickRow;
use tokio::time::{Instant, MissedTickBehavior, interval_at};

use crate::Context;
use crate::contender::{Contender, Kind, Lack, Measured, quantiles};
use crate::python;
use crate::role::{Role, is_installed, output};

const H_NS: u64 = 1_000_000;

const LATENESS: [(&str, f64); 3] = [("p50_us", 0.5), ("p99_us", 0.99), ("p99.9_us", 0.999)];

/// The base of the table.
pub(crate) const BASE: &str = "cyclictest, FIFO";

pub(crate) const CONTENDERS: [Contender; 4] = [
    Contender {
        name: BASE,
        kind: Kind::Peer,
        measure: cyclictest,
    },
    Contender {
        name: "webloop, plant",
        kind: Kind::Webloop,
        measure: webloop,
    },
    Contender {
        name: "tokio interval",
        kind: Kind::Peer,
        measure: tokio_interval,
    },
    Contender {
        name: "Python sleep",
        kind: Kind::Peer,
        measure: python::sleep,
    },
];

/// Figures of deadlines and of when they were met.
fn figures(ticks: &[(u64, u64)]) -> Result<Measured, Lack> {
    let mut gaps_ms = Moments::default();
    for pair in ticks.windows(2) {
        gaps_ms.push((pair[1].1 - pair[0].1) as f64 * 1e-6);
    }
    let late_ns = ticks.iter().map(|(due, at)| at.saturating_sub(*due));
    let mut figures = quantiles(late_ns.collect(), &LATENESS)?;
    let sd_ms = gaps_ms.spread().map(|spread| spread.sd_ms);
    figures.extend(sd_ms.map(|sd_ms| ("sd_us", sd_ms * 1e3)));
    Ok(figures)
}

fn webloop(context: &Context<'_>) -> Result<Measured, Lack> {
    let folder = context.folder.join("plant");
    let plant = Role::plant(context.webloop, "1ms", &folder)?;
    thread::sleep(Duration::from_millis(context.measure_ms));
    plant.end()?;
    let mut rows = csv::Reader::from_path(folder.join(TickRow::FILE))?;
    let rows = rows.deserialize().collect::<Result<Vec<TickRow>, _>>();
    let ticks = rows?;
    let ticks: Vec<_> = ticks
        .iter()
        .map(|row| (row.t_due_ns, row.t_tick_ns))
        .collect();
    figures(&ticks)
}

fn tokio_interval(context: &Context<'_>) -> Result<Measured, Lack> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()?;
    let ticks = runtime.block_on(async {
        let begin = Instant::now() + Duration::from_millis(10);
        let begin_ns = pace::now_ns() + 10_000_000;
        let mut interval = interval_at(begin, Duration::from_nanos(H_NS));
        interval.set_missed_tick_behavior(MissedTickBehavior::Burst);
        let mut ticks = Vec::with_capacity(1 << 16);
        for k in 0..context.measure_ms {
            interval.tick().await;
            ticks.push((begin_ns + k * H_NS, pace::now_ns()));
        }
        ticks
    });
    figures(&ticks)
}

/// `cyclictest` with real-time scheduling, and a histogram of µs.
fn cyclictest(context: &Context<'_>) -> Result<Measured, Lack> {
    const NAME: &str = "cyclictest";
    if !is_installed(NAME) {
        return Err(Lack::program(NAME, "the package rt-tests"));
    }
    let mut command = Command::new(NAME);
    command
        .args(["--quiet", "--threads=1", "--policy=fifo", "--priority=50"])
        .args(["--interval=1000", "--histogram=100000"])
        .arg(format!("--loops={}", context.measure_ms));
    let said = output(&mut command)?;
    let mut counts = Vec::new();
    for line in said.lines().filter(|line| !line.starts_with('#')) {
        let mut words = line.split_whitespace();
        let us = words.next().and_then(|word| word.parse::<u64>().ok());
        let count = words.next().and_then(|word| word.parse::<usize>().ok());
        counts.extend(us.zip(count).filter(|(_, count)| *count > 0));
    }
    // It only has whole µs, cut off: the middle is nearer.
    let late_ns = counts
        .iter()
        .flat_map(|(us, count)| std::iter::repeat_n(us * 1000 + 500, *count));
    quantiles(late_ns.collect(), &LATENESS)
}
