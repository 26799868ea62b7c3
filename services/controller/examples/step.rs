//! The paper's step over loopback, plant and controller in one process.
//!
//! `cargo run --release -p webloop-controller --example step -- [h] [seconds]
//! [transport]`, for instance `-- 1ms 4 websocket`; without a transport, all of
//! them one after another. It prints the round trip, how late messages were
//! sent, and the step beside the one of the loop without a network.
#![allow(clippy::print_stdout, reason = "its output is what it is for")]

use std::{error::Error, path::Path, sync::mpsc, thread, time::Duration};

use control::{StepSettings, preset, step_info};
use controller::drive_until;
use endpoint::{
    ControllerSettings, MessageRow, Mode, PlantSettings, Policy, Preset, SampleTime, TickRow,
    Transport,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = |default: &str| arguments.next().unwrap_or_else(|| default.to_owned());
    let h: SampleTime = next("3ms").parse()?;
    let seconds: u64 = next("4").parse()?;
    let transports = match arguments.next() {
        Some(word) => vec![word.parse()?],
        None => Transport::ALL.to_vec(),
    };
    for transport in transports {
        step(h, seconds, transport)?;
    }
    Ok(())
}

fn step(h: SampleTime, seconds: u64, transport: Transport) -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let plant = plant::Config {
        listen: "127.0.0.1:0".parse()?,
        hosts: Vec::new(),
        settings: PlantSettings {
            udp: transport == Transport::Udp,
            ..PlantSettings::new(h)
        },
        law: None,
        reference: None,
        out: folder.path().to_owned(),
        again: false,
    };
    let motor = preset::paper_plant().sampled(h.ns())?.stepper();
    let (ready, is_ready) = mpsc::channel();
    let stop = async move {
        tokio::time::sleep(Duration::from_secs(seconds + 1)).await;
        Ok(())
    };
    let plant = thread::spawn(move || {
        plant::serve_until(&plant, motor, stop, |facts| {
            ready.send(facts).expect("main waits");
        })
    });
    let config = controller::Config {
        plant: format!("http://{}", is_ready.recv()?.address),
        settings: ControllerSettings {
            transport,
            ..Preset::PaperPython.settings(Mode::Closed, h)
        },
        claim: false,
        check: false,
        reference: None,
        law: preset::paper_pi().into(),
        start_ns: None,
        duration_ns: seconds * 1_000_000_000,
        connections: 1,
        out: folder.path().to_owned(),
        again: false,
        scheduling: Policy::Fifo,
    };
    // In a thread of its own, since real-time scheduling stays with a thread.
    let run = thread::spawn(move || drive_until(&config, std::future::pending()));
    let report = run.join().expect("no panic")?;
    let plant = plant.join().expect("no panic")?;
    println!(
        "{transport}: {:?}; {} connections",
        report.counts, plant.connections
    );
    if let Some(why) = report.first_failure {
        return Err(format!("{transport}: {why}").into());
    }

    let messages: Vec<MessageRow> = read(&folder.path().join("messages.csv"))?;
    let us = |from_ns: u64, to_ns: u64| to_ns.saturating_sub(from_ns) as f64 / 1e3;
    let round_trips = messages
        .iter()
        .filter_map(|row| Some(us(row.t_send_ns?, row.t_receive_ns?)))
        .collect();
    quantiles("round trip", round_trips);
    let lateness = messages
        .iter()
        .filter_map(|row| Some(us(row.t_due_ns, row.t_send_ns?)))
        .collect();
    quantiles("sent late by", lateness);

    let ticks: Vec<TickRow> = read(&folder.path().join("ticks.csv"))?;
    let measured: Vec<f64> = ticks
        .iter()
        .skip_while(|row| row.seq.is_none())
        .map(|row| row.y)
        .collect();
    show("measured", h, &measured)?;
    show("without a network", h, &bare(h, measured.len())?)
}

/// The loop in which each command acts within the tick of its measurement.
fn bare(h: SampleTime, ticks: usize) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut motor = preset::paper_plant().sampled(h.ns())?.stepper();
    let mut law = preset::paper_pi();
    let mut y = 0.0;
    let step = |_| {
        y = motor.step(law.update(1.0 - y, h.seconds()));
        y
    };
    Ok((0..ticks).map(step).collect())
}

fn show(what: &str, h: SampleTime, y: &[f64]) -> Result<(), Box<dyn Error>> {
    let t: Vec<f64> = (0..y.len()).map(|k| k as f64 * h.seconds()).collect();
    let settings = StepSettings {
        final_value: Some(1.0),
        ..StepSettings::default()
    };
    let info = step_info(&t, y, &settings)?;
    let last = y.last().copied().unwrap_or_default();
    println!(
        "{what}: rise {:.4} s, settling {:.4} s, overshoot {:.2} %, last {last:.5}",
        info.rise_time, info.settling_time, info.overshoot
    );
    Ok(())
}

fn quantiles(what: &str, mut us: Vec<f64>) {
    us.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| us[((us.len() - 1) as f64 * share) as usize];
    let [p50, p99, p999, max] = [0.5, 0.99, 0.999, 1.0].map(at);
    println!("{what}: p50 {p50:.0}, p99 {p99:.0}, p99.9 {p999:.0}, max {max:.0} us");
}

fn read<R: serde::de::DeserializeOwned>(path: &Path) -> Result<Vec<R>, Box<dyn Error>> {
    Ok(csv::Reader::from_path(path)?
        .deserialize()
        .collect::<Result<_, _>>()?)
}
