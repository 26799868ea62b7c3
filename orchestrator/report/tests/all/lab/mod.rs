//! A results folder made by hand.
//!
//! ```ignore
//! let lab = Lab::new(EXPERIMENT);                  // a folder with plan.json, nothing run
//! for cell in lab.cells("arima-python-closed") {   // by how their ids begin
//!     lab.run(cell, &Rows::step(cell, 318.0));     // a manifest and the four files of rows
//! }
//! let campaign = lab.campaign();                   // as `webloop report` reads it
//! ```
//!
//! Rows are plain vectors: change one and write the cell again.
#![allow(dead_code)] // Each test file uses a part of it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use analysis::Campaign;
use endpoint::report::{
    ControllerGranted, Plant, PlantGranted, Policy, Python, Scheduling, Written,
};
use endpoint::{
    ArrivalOutcome, ArrivalRow, Counts, MessageOutcome, MessageRow, Mode, TickRow, Transport,
};
use link::certificate::{Baseline, Certificate, certify};
use link::{Epoch, Profile};
use plan::{Cell, Instead, Phase, Plan, ProbeRow, ProfileText, Verdict};
use record::{FileFact, Machine, Manifest};
use serde::Serialize;
use tempfile::TempDir;

/// A results folder that is removed with the value.
pub(crate) struct Lab {
    folder: TempDir,
    pub(crate) plan: Plan,
}

impl Lab {
    /// A folder with the plan of an experiment in TOML over built-in profiles.
    pub(crate) fn new(experiment: &str) -> Lab {
        let profile = |name: &str| {
            let source = Profile::builtin(name).ok_or("not built in")?.to_owned();
            Ok(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        let plan = Plan::resolve(experiment, "made.toml", &Instead::default(), profile)
            .expect("an experiment that can run");
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("plan.json"), plan.to_json()).expect("a writable folder");
        Lab { folder, plan }
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The cells whose ids begin so.
    pub(crate) fn cells(&self, start: &str) -> Vec<&Cell> {
        let cells: Vec<&Cell> = self
            .plan
            .cells
            .iter()
            .filter(|cell| cell.id.starts_with(start))
            .collect();
        assert!(!cells.is_empty(), "no cell begins with {start}");
        cells
    }

    /// Writes a complete run.
    pub(crate) fn run(&self, cell: &Cell, rows: &Rows) {
        self.end(cell, rows, Verdict::Complete);
    }

    /// Writes a run that ended so.
    pub(crate) fn end(&self, cell: &Cell, rows: &Rows, verdict: Verdict) {
        self.end_as(cell, rows, verdict, |_| {});
    }

    /// Writes a run that ended so, and whose manifest says something else besides.
    pub(crate) fn end_as(
        &self,
        cell: &Cell,
        rows: &Rows,
        verdict: Verdict,
        say: impl FnOnce(&mut Manifest),
    ) {
        let folder = self.path().join(cell.folder());
        fs::create_dir_all(&folder).expect("a writable folder");
        write(&folder.join("ticks.csv"), TickRow::COLUMNS, &rows.ticks);
        write(
            &folder.join("arrivals.csv"),
            ArrivalRow::COLUMNS,
            &rows.arrivals,
        );
        write(
            &folder.join("messages.csv"),
            MessageRow::COLUMNS,
            &rows.messages,
        );
        write(&folder.join("probes.csv"), ProbeRow::COLUMNS, &rows.probes);
        let profile = &self.plan.profiles[&cell.topology];
        fs::write(folder.join("profile.toml"), &profile.source).expect("a writable folder");
        let mut names = vec!["ticks.csv", "arrivals.csv", "messages.csv", "probes.csv"];
        names.push("profile.toml");
        if let Some(text) = self.plan.system(cell).expect("planned").own_text() {
            fs::write(folder.join("system.toml"), text).expect("a writable folder");
            names.push("system.toml");
        }
        let mut reports = vec!["plant.json", "controller.json"];
        if cell.client.is_browser() {
            reports.push("page.json");
        }
        if !is_loopback(&self.plan, cell) {
            reports.extend(["link.json", "link.csv"]);
        }
        for name in reports {
            let report = match name {
                "plant.json" => serde_json::to_string(&plant(rows)),
                "controller.json" => serde_json::to_string(&python(rows)),
                _ => Ok("{}".to_owned()),
            };
            let report = report.expect("numbers and words");
            fs::write(folder.join(name), report).expect("a writable folder");
            names.push(name);
        }
        let fact = |name: &str| {
            let content = fs::File::open(folder.join(name)).expect("just written");
            (name.to_owned(), FileFact::of(content).expect("readable"))
        };
        let mut manifest = manifest(
            cell,
            &self.plan,
            verdict,
            names.into_iter().map(fact).collect(),
        );
        let through = rows.probes.iter().filter(|row| row.phase != Phase::Empty);
        manifest.certificate = (!is_loopback(&self.plan, cell)).then(|| Certificate {
            sent: through.count(),
            ..held()
        });
        say(&mut manifest);
        fs::write(folder.join(Manifest::FILE), manifest.to_json()).expect("a writable folder");
    }

    /// The folder, read.
    pub(crate) fn campaign(&self) -> Campaign {
        Campaign::read(self.path()).expect("a results folder")
    }
}

fn write<R: Serialize>(path: &Path, columns: &[&str], rows: &[R]) {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_path(path)
        .expect("a writable folder");
    writer.write_record(columns).expect("a writable folder");
    for row in rows {
        writer.serialize(row).expect("a flat row");
    }
    writer.flush().expect("a writable folder");
}

fn manifest(
    cell: &Cell,
    plan: &Plan,
    verdict: Verdict,
    files: BTreeMap<String, FileFact>,
) -> Manifest {
    Manifest {
        version: Manifest::VERSION,
        verdict,
        reasons: Vec::new(),
        disturbances: Vec::new(),
        earlier: Vec::new(),
        experiment: plan.experiment.clone(),
        campaign_seed: plan.seed,
        cell: cell.clone(),
        profile: cell.topology.clone(),
        backend: "netns".to_owned(),
        engine: None,
        player: if is_loopback(plan, cell) {
            "none".to_owned()
        } else {
            "user".to_owned()
        },
        webloop: "0.1.0".to_owned(),
        machine: Machine {
            kernel: "Linux 6.1.0".to_owned(),
            architecture: "x86_64".to_owned(),
            processor: "made by hand".to_owned(),
            cores: 2,
            memory_mib: 4096,
            clock_source: "tsc".to_owned(),
            awake: false,
        },
        authority: "privileged".to_owned(),
        started: "2026-01-01T00:00:00Z".to_owned(),
        wall_s: cell.duration_ns as f64 / 1e9,
        epoch: Epoch::at_ns(START_NS),
        start_ns: START_NS,
        messages: None,
        pulse: None,
        watched: None,
        end_faults: Vec::new(),
        ends: None,
        certificate: None,
        plant: None,
        controller: None,
        page: None,
        link: None,
        files,
    }
}

/// What a plant with these rows says of itself.
pub(crate) fn plant(rows: &Rows) -> Plant {
    Plant {
        address: ([127, 0, 0, 1], 8080).into(),
        start_ns: 0,
        ticks: 0,
        missed: 0,
        arrivals: 0,
        refused: 0,
        refusals: BTreeMap::new(),
        trips: 0,
        connections: 1,
        tick_rows: written(rows.ticks.len()),
        second_rows: None,
        arrival_rows: written(rows.arrivals.len()),
        sessions: 0,
        page_rows: Written::default(),
        granted: PlantGranted {
            ticker: fifo(50),
            server: fifo(45),
            open_files: 1024,
        },
        program: None,
    }
}

/// What a controller in Python with these rows says of itself.
pub(crate) fn python(rows: &Rows) -> Python {
    Python {
        start_ns: 0,
        stop_ns: 0,
        counts: Counts::default(),
        first_failure: None,
        interrupted: false,
        rows: written(rows.messages.len()),
        granted: ControllerGranted {
            controller: fifo(45),
            open_files: 1024,
        },
        client: "python".to_owned(),
        python: "3.11.7".to_owned(),
        implementation: "CPython".to_owned(),
        transport: Transport::Http,
        connections: 1,
    }
}

fn written(rows: usize) -> Written {
    Written {
        rows: rows as u64,
        overflow: 0,
    }
}

fn fifo(priority: u8) -> Scheduling {
    Scheduling {
        asked_priority: Some(priority),
        policy: Policy::Fifo,
        priority: i32::from(priority),
        slack_ns: 1,
        refused: None,
    }
}

/// The certificate of a link that held, over no echoes.
fn held() -> Certificate {
    Certificate {
        verdict: link::certificate::Verdict::Holds,
        ..certify(
            &[],
            &Profile::empty(),
            1,
            Epoch::default(),
            Baseline::default(),
        )
    }
}

fn is_loopback(plan: &Plan, cell: &Cell) -> bool {
    let text = &plan.profiles[&cell.topology];
    let profile = text.profile(&cell.topology).expect("it was resolved");
    profile.is_loopback()
}

/// When everything starts.
pub(crate) const START_NS: u64 = 1_000_000_000;

/// The rows of a cell, each file's as a vector.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    pub(crate) ticks: Vec<TickRow>,
    pub(crate) arrivals: Vec<ArrivalRow>,
    pub(crate) messages: Vec<MessageRow>,
    pub(crate) probes: Vec<ProbeRow>,
}

impl Rows {
    /// A message each `every_ns` for as long as the cell runs, each 1 ms on its way either way, and
    /// ticks each h, without any output.
    pub(crate) fn paced(cell: &Cell, every_ns: u64) -> Rows {
        let h_ns = cell.settings.h.ns();
        let mut rows = Rows::default();
        for seq in 0..cell.duration_ns.div_ceil(every_ns) {
            rows.push(cell, seq, START_NS + seq * every_ns);
        }
        rows.ticks = (0..cell.duration_ns.div_ceil(h_ns))
            .map(|k| TickRow {
                k,
                t_due_ns: START_NS + k * h_ns,
                t_tick_ns: START_NS + k * h_ns,
                u: 0.0,
                y: 0.0,
                seq: None,
                u_applied: None,
            })
            .collect();
        rows
    }

    /// A closed loop on its schedule that comes to 1 without overshoot and is within 2 % for good
    /// after `settling_ms`.
    pub(crate) fn step(cell: &Cell, settling_ms: f64) -> Rows {
        let h_ns = cell.settings.h.ns();
        let mut rows = Rows::paced(cell, h_ns);
        let rate = 50f64.ln() / settling_ms;
        for tick in &mut rows.ticks {
            tick.y = 1.0 - (-rate * (tick.k * h_ns) as f64 / 1e6).exp();
            tick.seq = Some(tick.k);
        }
        for message in &mut rows.messages {
            message.y = Some(0.0);
        }
        rows
    }

    /// Echoes each `interval_ns` for as long as the cell runs, each as long under way as the profile's
    /// link under the cell's seed has it, after some through the empty link.
    pub(crate) fn with_echoes(
        mut self,
        cell: &Cell,
        profile: &link::Profile,
        interval_ns: u64,
    ) -> Rows {
        const EMPTY_NS: u64 = 2_000_000;
        let row = |phase, seq, t_send_ns, up: u64, down: u64, lost: bool| ProbeRow {
            phase,
            seq,
            t_send_ns,
            t_reach_ns: (!lost).then_some(t_send_ns + up),
            t_back_ns: (!lost).then_some(t_send_ns + up + down),
            due_up_ns: up,
            due_down_ns: down,
            due_lost: lost,
        };
        let empty = (0..20).map(|k| row(Phase::Empty, k, u64::from(k), EMPTY_NS, EMPTY_NS, false));
        self.probes.extend(empty);
        let mut link = link::Link::new(profile, cell.link_seed);
        for k in 0..u32::try_from(cell.duration_ns / interval_ns).expect("few") {
            let t_ns = u64::from(k) * interval_ns;
            let at = link::LinkTime::from_ns(t_ns);
            let up = link.up.state_at(at);
            let down = link.down.state_at(at.after(up.delay_ns));
            let lost = up.lost || down.lost;
            let echo = row(
                Phase::During,
                k,
                START_NS + t_ns,
                up.delay_ns,
                down.delay_ns,
                lost,
            );
            self.probes.push(echo);
        }
        self
    }

    fn push(&mut self, cell: &Cell, seq: u64, t_send_ns: u64) {
        const WAY_NS: u64 = 1_000_000;
        let h_ns = cell.settings.h.ns();
        let closed = cell.settings.mode == Mode::Closed;
        let (t_arrive_ns, tick) = (t_send_ns + WAY_NS, (t_send_ns + WAY_NS - START_NS) / h_ns);
        self.arrivals.push(ArrivalRow {
            n: seq,
            seq,
            t_send_ns: Some(t_send_ns),
            t_arrive_ns,
            tick,
            u: 0.0,
            outcome: if closed {
                ArrivalOutcome::Applied
            } else {
                ArrivalOutcome::Acknowledged
            },
        });
        self.messages.push(MessageRow {
            seq,
            t_due_ns: START_NS + seq * h_ns,
            t_send_ns: Some(t_send_ns),
            t_receive_ns: Some(t_arrive_ns + WAY_NS),
            t_arrive_ns: Some(t_arrive_ns),
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: Some(tick),
            outcome: MessageOutcome::Answered,
            y_seq: None,
        });
    }
}
