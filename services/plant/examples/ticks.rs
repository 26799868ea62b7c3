//! How well the plant keeps its deadlines on this machine.
//!
//! `cargo run --release -p webloop-plant --example ticks -- [h] [seconds] [busy loops]`,
//! for instance `-- 1ms 20 2`. It prints the interval between ticks and the
//! lateness against the deadlines, and what scheduling was granted.
#![allow(clippy::print_stdout, reason = "its output is what it is for")]

use std::{
    error::Error,
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::Duration,
};

use control::preset;
use endpoint::{PlantSettings, TickRow, report};
use plant::{Config, serve_until};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = |default: &str| arguments.next().unwrap_or_else(|| default.to_owned());
    let settings = PlantSettings::new(next("1ms").parse()?);
    let seconds: u64 = next("10").parse()?;
    let busy: usize = next("0").parse()?;

    let folder = tempfile::tempdir()?;
    let config = Config {
        listen: "127.0.0.1:0".parse()?,
        hosts: Vec::new(),
        settings,
        law: None,
        reference: None,
        out: folder.path().to_owned(),
        again: false,
    };
    let motor = preset::paper_plant()
        .sampled(config.settings.h.ns())?
        .stepper();
    let done = AtomicBool::new(false);
    let report = thread::scope(|scope| {
        for _ in 0..busy {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let stop = async {
            tokio::time::sleep(Duration::from_secs(seconds)).await;
            Ok(())
        };
        let report = serve_until(&config, motor, stop, |_| {});
        done.store(true, Ordering::Relaxed);
        report
    })?;

    let mut reader = csv::Reader::from_path(folder.path().join("ticks.csv"))?;
    let ticks = reader.deserialize().collect::<Result<Vec<TickRow>, _>>()?;
    print(&report, &ticks);
    Ok(())
}

fn print(report: &report::Plant, ticks: &[TickRow]) {
    let ms = |ns: u64| ns as f64 / 1e6;
    let intervals: Vec<f64> = ticks
        .windows(2)
        .map(|pair| ms(pair[1].t_tick_ns - pair[0].t_tick_ns))
        .collect();
    let mean = intervals.iter().sum::<f64>() / intervals.len() as f64;
    let variance = intervals
        .iter()
        .map(|interval| (interval - mean).powi(2))
        .sum::<f64>();
    let sd = (variance / intervals.len() as f64).sqrt();
    let mut late: Vec<f64> = ticks
        .iter()
        .map(|row| ms(row.t_tick_ns - row.t_due_ns))
        .collect();
    late.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| late[((late.len() - 1) as f64 * share) as usize];
    let within = late.partition_point(|late| *late <= 0.1) as f64 / late.len() as f64;
    println!("ticks {}, missed {}", report.ticks, report.missed);
    println!("interval   mean {mean:.6} ms, sd {sd:.4} ms");
    println!(
        "lateness   p50 {:.4}, p99 {:.4}, p99.9 {:.4}, max {:.4} ms; within 0.1 ms {:.2} %",
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0),
        100.0 * within
    );
    println!("scheduling {:?}", report.granted.ticker);
}
