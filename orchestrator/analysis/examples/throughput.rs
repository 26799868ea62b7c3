//! How fast a results folder is analysed, and in how much memory.
//!
//! `cargo run --release -p webloop-analysis --example throughput -- [million rows]`, for instance
//! `-- 10`. It makes a folder of closed loops at 1 kHz with that many rows, in one cell and then in
//! ten, and prints how long [`Campaign::read`] takes over each, and [`Metrics::read`], which holds
//! nothing against the manifest, over the cells one after the other. One cell is read by one core,
//! ten by all. The peak is that of the process, writing included, which keeps no rows.
//!
//! On two busy cores of an AMD EPYC at idle priority, 10 million rows of 103 bytes: one cell 2.1 to
//! 5.3 M rows/s, as busy as they were, ten cells up to 6.5; peak 86 MB. Checksums are a quarter to a
//! third of that where the processor has SHA instructions: 1 million rows in one cell took 0.32 to
//! 0.35 s, and 0.23 to 0.26 s unchecked.
//! Of 30 million rows in one cell the peak is 160 MB: 16 bytes for each row of the longest file.
//! With serde alone one cell was read at 1.6 to 3.1 M rows/s, with a peak of 173 MB.
#![allow(clippy::print_stdout, reason = "its output is what it is for")]

use std::error::Error;
use std::fs::{self, File};
use std::path::Path;
use std::time::{Duration, Instant};

use analysis::{Campaign, CellFacts, Metrics};
use control::preset::{paper_pi, paper_plant};
use endpoint::{
    ArrivalOutcome, ArrivalRow, Counts, MessageOutcome, MessageRow, Mode, PlantSettings, Preset,
    SampleTime, TickRow,
};
use link::Epoch;
use plan::{Cell, Client, Plan, ProbeRow, ProfileText, Verdict};
use record::{FileFact, Machine, Manifest};
use serde_json::{Value, json};

const H_NS: u64 = 1_000_000;
/// When a run of an hour since boot began: stamps have as many digits as real ones.
const START_NS: u64 = 3_600_000_000_000;
/// Loopback: no link that has to prove itself.
const ARIMA: &str = "arima";

fn main() -> Result<(), Box<dyn Error>> {
    let million: u64 = std::env::args().nth(1).as_deref().unwrap_or("10").parse()?;
    for cells in [1, 10] {
        let folder = tempfile::tempdir()?;
        let ticks = million * 1_000_000 / 3 / cells;
        write_campaign(folder.path(), cells as usize, ticks)?;
        measure(folder.path(), 3 * ticks * cells)?;
    }
    Ok(())
}

fn measure(folder: &Path, rows: u64) -> Result<(), Box<dyn Error>> {
    let clock = Instant::now();
    let campaign = Campaign::read(folder)?;
    let read = clock.elapsed();
    if let Some(damage) = campaign.damage().into_iter().next() {
        return Err(damage.into());
    }
    let manifests = campaign.runs.iter().filter_map(|run| run.manifest.as_ref());
    let bytes: u64 = manifests
        .flat_map(|manifest| manifest.files.values())
        .map(|file| file.bytes)
        .sum();
    let per_s = |what: u64, took: Duration| what as f64 / 1e6 / took.as_secs_f64();
    println!("{} cells, {rows} rows, {bytes} bytes", campaign.runs.len());
    println!(
        "  rows      {:.2} s: {:.2} M rows/s, {:.0} MB/s",
        read.as_secs_f64(),
        per_s(rows, read),
        per_s(bytes, read)
    );
    let clock = Instant::now();
    for run in &campaign.runs {
        Metrics::read(&run.folder, &CellFacts::from(&run.cell))?;
    }
    let unchecked = clock.elapsed();
    println!(
        "  unchecked {:.2} s: {:.2} M rows/s, one cell after the other",
        unchecked.as_secs_f64(),
        per_s(rows, unchecked)
    );
    println!("  peak      {}", peak()?);
    Ok(())
}

/// The most memory that the process ever had, in the kernel's words.
fn peak() -> Result<String, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    Ok(peak.ok_or("the kernel does not say")?.trim().to_owned())
}

fn write_campaign(folder: &Path, cells: usize, ticks: u64) -> Result<(), Box<dyn Error>> {
    let h = SampleTime::try_new(H_NS)?;
    let settings = Preset::PaperPython.settings(Mode::Closed, h);
    let cells = (0..cells).map(|index| Cell {
        index,
        id: format!("loop-{index}"),
        topology: ARIMA.to_owned(),
        repeat: 1,
        link_seed: plan::link_seed(1, ARIMA, 1),
        duration_ns: ticks * H_NS,
        ..Cell::new(
            Client::Native,
            Preset::PaperPython,
            settings,
            &PlantSettings::new(h),
        )
    });
    let plan = Plan {
        version: Plan::VERSION,
        experiment: "throughput".to_owned(),
        seed: 1,
        profiles: [(ARIMA.to_owned(), profile()?)].into(),
        cells: cells.collect(),
        ..Plan::default()
    };
    fs::write(folder.join("plan.json"), plan.to_json())?;
    for cell in &plan.cells {
        let folder = folder.join(cell.folder());
        fs::create_dir_all(&folder)?;
        write_rows(&folder, ticks)?;
        fs::write(folder.join("profile.toml"), profile()?.source)?;
        fs::write(
            folder.join("probes.csv"),
            ProbeRow::COLUMNS.join(",") + "\n",
        )?;
        for (name, report) in reports(ticks) {
            fs::write(folder.join(name), serde_json::to_string(&report)?)?;
        }
        let manifest = manifest(&folder, cell)?;
        fs::write(folder.join(Manifest::FILE), manifest.to_json())?;
    }
    Ok(())
}

fn profile() -> Result<ProfileText, Box<dyn Error>> {
    Ok(ProfileText {
        source: link::Profile::builtin(ARIMA)
            .ok_or("not built in")?
            .to_owned(),
        ..ProfileText::default()
    })
}

/// What the two ends say that they wrote.
fn reports(ticks: u64) -> [(&'static str, Value); 2] {
    let rows = json!({ "rows": ticks, "overflow": 0 });
    let plant = json!({ "tick_rows": rows, "arrival_rows": rows });
    let controller = json!({
        "start_ns": START_NS,
        "stop_ns": START_NS + ticks * H_NS,
        "counts": Counts::default(),
        "first_failure": null,
        "interrupted": false,
        "rows": rows,
        "granted": {
            "controller": {
                "asked_priority": null,
                "policy": "other",
                "priority": 0,
                "slack_ns": 50_000,
                "refused": null,
            },
            "open_files": 1024,
        },
    });
    [("plant.json", plant), ("controller.json", controller)]
}

fn manifest(folder: &Path, cell: &Cell) -> Result<Manifest, Box<dyn Error>> {
    let fact = |name: &str| -> std::io::Result<(String, FileFact)> {
        let fact = FileFact::of(File::open(folder.join(name))?)?;
        Ok((name.to_owned(), fact))
    };
    let files = [
        "ticks.csv",
        "arrivals.csv",
        "messages.csv",
        "probes.csv",
        "profile.toml",
        "plant.json",
        "controller.json",
    ]
    .map(fact);
    Ok(Manifest {
        version: Manifest::VERSION,
        verdict: Verdict::Complete,
        reasons: Vec::new(),
        disturbances: Vec::new(),
        earlier: Vec::new(),
        experiment: "throughput".to_owned(),
        campaign_seed: 1,
        cell: cell.clone(),
        profile: cell.topology.clone(),
        backend: "netns".to_owned(),
        engine: None,
        player: "none".to_owned(),
        webloop: String::new(),
        machine: Machine {
            kernel: String::new(),
            architecture: String::new(),
            processor: String::new(),
            cores: 1,
            memory_mib: 0,
            clock_source: String::new(),
            awake: false,
        },
        authority: String::new(),
        started: String::new(),
        wall_s: 0.0,
        epoch: Epoch::at_ns(START_NS),
        start_ns: START_NS,
        certificate: None,
        messages: None,
        pulse: None,
        watched: None,
        end_faults: Vec::new(),
        ends: None,
        plant: None,
        controller: None,
        page: None,
        link: None,
        files: files.into_iter().collect::<Result<_, _>>()?,
    })
}

/// A loop whose message k is sent at tick k, arrives within a few milliseconds, acts at tick k + 1,
/// and is answered within a few more.
fn write_rows(folder: &Path, ticks: u64) -> Result<(), Box<dyn Error>> {
    let writer = |name: &str| csv::Writer::from_path(folder.join(name));
    let mut tick_rows = writer("ticks.csv")?;
    let mut arrival_rows = writer("arrivals.csv")?;
    let mut message_rows = writer("messages.csv")?;
    let (mut plant, mut pid) = (paper_plant().sampled(H_NS)?.stepper(), paper_pi());
    for k in 0..ticks {
        let noise = Noise(k);
        let t_due_ns = START_NS + k * H_NS;
        let u = pid.output();
        let y = plant.step(u) + 1e-3 * noise.of(0) as f64 / 1e6;
        tick_rows.serialize(TickRow {
            k,
            t_due_ns,
            t_tick_ns: t_due_ns + noise.of(1) / 10,
            u,
            y,
            seq: k.checked_sub(1),
            u_applied: None,
        })?;
        let e = 1.0 - y;
        let u = pid.update(e, 0.001);
        let t_send_ns = t_due_ns + noise.of(2) / 10;
        let t_arrive_ns = t_send_ns + 2_000_000 + noise.of(3);
        arrival_rows.serialize(ArrivalRow {
            n: k,
            seq: k,
            t_send_ns: Some(t_send_ns),
            t_arrive_ns,
            tick: (t_arrive_ns - START_NS) / H_NS,
            u,
            outcome: ArrivalOutcome::Applied,
        })?;
        message_rows.serialize(MessageRow {
            seq: k,
            t_due_ns,
            t_send_ns: Some(t_send_ns),
            t_receive_ns: Some(t_arrive_ns + 2_000_000 + noise.of(4)),
            t_arrive_ns: Some(t_arrive_ns),
            r: 1.0,
            y: Some(y),
            e: Some(e),
            u: Some(u),
            tick: Some((t_arrive_ns - START_NS) / H_NS),
            outcome: MessageOutcome::Answered,
            y_seq: None,
        })?;
    }
    for mut writer in [tick_rows, arrival_rows, message_rows] {
        writer.flush()?;
    }
    Ok(())
}

/// What differs from row to row: below a million, and the same each time.
struct Noise(u64);

impl Noise {
    fn of(&self, which: u64) -> u64 {
        let mixed = (8 * self.0 + which + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32 & 0xf_ffff
    }
}
