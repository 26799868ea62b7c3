//! How fast virtual time goes: `cargo run --release -p webloop-sim --example speed`.
//!
//! The paper's closed loop at 1 kHz for 600 s, with its metrics, on one core; over loopback, where
//! nothing but the loop takes time, and over each link; or over those that are named.

// What is measured here is measured by a clock, and printed.
#![allow(clippy::disallowed_methods, clippy::print_stdout)]

use std::time::Instant;

use analysis::response::ResponseTrace;
use control::preset;
use endpoint::{Hold, Mode, Preset, TickRow};
use link::{Epoch, Profile};
use sim::{Pool, Record, Setup, Timing, run};

const RUNS: usize = 9;
const DURATION_S: u64 = 600;

struct Metrics(ResponseTrace);

impl Record for Metrics {
    fn tick(&mut self, row: &TickRow) {
        self.0.push(row);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let h: endpoint::SampleTime = "1ms".parse()?;
    let plant = preset::paper_plant().sampled(h.ns())?;
    let asked: Vec<String> = std::env::args().skip(1).collect();
    for name in Profile::BUILTIN {
        if !asked.is_empty() && !asked.iter().any(|word| word == name) {
            continue;
        }
        let none = |_: &str| Err(String::new());
        let source = Profile::builtin(name).ok_or("a built-in profile")?;
        let profile = Profile::read(source, name, &none).0.ok_or("a profile")?;
        let setup = Setup {
            profile: &profile,
            seed: 1,
            settings: Preset::PaperPython.settings(Mode::Closed, h),
            timer_floor_ns: 0,
            plant: plant.stepper(),
            hold: Hold::Last,
            max_age_ns: None,
            tick_noise: None,
            reference: None,
            law: preset::paper_pi().into(),
            pool: Pool::Shared,
            message_bytes: [166, 288],
            frozen: [&[], &[]],
            echoes: &[],
            timing: &Timing::IDEAL,
            epoch: Epoch::at_ns(0),
            plant_start_ns: 0,
            start_ns: 0,
            duration_ns: DURATION_S * 1_000_000_000,
            after_ns: 0,
        };
        let mut times_s = Vec::new();
        let mut settling_ms = None;
        for _ in 0..RUNS {
            let clock = Instant::now();
            let mut metrics = Metrics(ResponseTrace::new(h.ns(), 1.0, None));
            run(&setup, &mut metrics)?;
            settling_ms = metrics.0.finish().and_then(|response| response.settling_ms);
            times_s.push(clock.elapsed().as_secs_f64());
        }
        times_s.sort_by(f64::total_cmp);
        let median_s = times_s[RUNS / 2];
        println!(
            "{name:<10} {DURATION_S} s in {:.1} ms (best {:.1}), {:.0} x real time; settling {:?} ms",
            median_s * 1e3,
            times_s[0] * 1e3,
            DURATION_S as f64 / median_s,
            settling_ms
        );
    }
    Ok(())
}
