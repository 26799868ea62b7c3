//! Ticks every millisecond: how late each is against its deadline, and how far the time between two varies.
//!
//! All keep an absolute grid but tokio's interval, whose deadlines are its own. Those that can ask for real-time
//! scheduling do.

use std::process::Command;
use std::thread;
use std::time::Duration;

use analysis::statistics::Moments;
use endpoint::TickRow;
use record::rows;
use tokio::time::{Instant, MissedTickBehavior, interval_at};

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured, quantiles};
use crate::context::Context;
use crate::python;
use crate::role::{Role, needs, output};

const H_NS: u64 = 1_000_000;

pub(crate) const TABLE: Table = Table {
    about: "ticks every ms: lateness, and the sd of the time between two",
    base: Some("cyclictest, FIFO"),
    processors: None,
    contenders: &[
        Contender::peer("cyclictest, FIFO", cyclictest),
        Contender::webloop("webloop, plant", webloop),
        Contender::peer("tokio interval", tokio_interval),
        Contender::peer("Python sleep", python::sleep),
    ],
    goals: &[
        goal(
            "webloop, plant",
            "p99_us",
            Some("cyclictest, FIFO"),
            Bound::AtMost(1.0),
        ),
        goal(
            "webloop, plant",
            "p99.9_us",
            Some("cyclictest, FIFO"),
            Bound::AtMost(1.0),
        ),
    ],
};

/// Figures of deadlines and of when they were met.
fn figures(ticks: &[(u64, u64)]) -> Result<Measured, Lack> {
    let mut gaps_ms = Moments::default();
    for pair in ticks.windows(2) {
        gaps_ms.push((pair[1].1 - pair[0].1) as f64 * 1e-6);
    }
    let late_ns = ticks.iter().map(|(due, at)| at.saturating_sub(*due));
    let mut figures = quantiles(late_ns.collect())?;
    let sd_ms = gaps_ms.spread().map(|spread| spread.sd_ms);
    figures.extend(sd_ms.map(|sd_ms| ("sd_us", sd_ms * 1e3)));
    Ok(figures)
}

fn webloop(context: &Context<'_>) -> Result<Measured, Lack> {
    let folder = context.folder.join("plant");
    let plant = Role::plant(context, "1ms", &folder)?;
    thread::sleep(Duration::from_millis(context.measure_ms));
    plant.end()?;
    let mut ticks = Vec::new();
    rows::read(&folder.join(TickRow::FILE), |row: &TickRow| {
        ticks.push((row.t_due_ns, row.t_tick_ns));
    })?;
    figures(&ticks)
}

fn tokio_interval(context: &Context<'_>) -> Result<Measured, Lack> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()?;
    let ticks = runtime.block_on(async {
        let begin = Instant::now() + Duration::from_millis(10);
        let begin_ns = clock::now::now_ns() + 10_000_000;
        let mut interval = interval_at(begin, Duration::from_nanos(H_NS));
        interval.set_missed_tick_behavior(MissedTickBehavior::Burst);
        let mut ticks = Vec::with_capacity(1 << 16);
        for k in 0..context.measure_ms {
            interval.tick().await;
            ticks.push((begin_ns + k * H_NS, clock::now::now_ns()));
        }
        ticks
    });
    figures(&ticks)
}

/// `cyclictest` with real-time scheduling, and a histogram of µs.
fn cyclictest(context: &Context<'_>) -> Result<Measured, Lack> {
    const NAME: &str = "cyclictest";
    needs(NAME, "the package rt-tests")?;
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
    quantiles(late_ns.collect())
}
