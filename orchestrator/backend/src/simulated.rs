//! A cell in virtual time: `sim` runs it, and its rows and echoes go into the same files.
//!
//! Nothing here is measured, so a machine that is busy makes no difference; what a machine's
//! programs take is told by a [`Timing`].

use std::fs::File;
use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, Thread, TickRow, Timer};
use link::{Profile, Way};
use plan::{Cell, Phase};
use serde_json::{Value, json};
use shaper::{Echo, Timeline};
use sim::{EPOCH_NS, Record, Setup, Timing};
use system::System;

use crate::course::Seen;
use crate::schedule::{self, Series};
use crate::{RunError, folder};

/// How long the plant goes on after the last message, as in a real run.
const AFTER_NS: u64 = 1_200_000_000;

/// Simulates a cell, and leaves its rows and reports in `folder`.
pub(crate) fn run(
    cell: &Cell,
    system: &System,
    profile: &Profile,
    timing: &Timing,
    folder: &Path,
) -> Result<Seen, RunError> {
    let h = cell.settings.h;
    let own = system
        .at(h)
        .map_err(|unfit| RunError::Link(unfit.to_string()))?;
    let start_ns = EPOCH_NS + plan::START_AT_NS;
    let setup = Setup {
        profile,
        seed: cell.link_seed,
        settings: cell.settings,
        timer_floor_ns: timer_floor_ns(cell, timing),
        plant: own.plant.stepper(),
        hold: cell.hold,
        law: own.law,
        timing,
        epoch_ns: EPOCH_NS,
        plant_start_ns: sim::plant_start_ns(cell.link_seed, h.ns()),
        start_ns,
        duration_ns: cell.duration_ns,
        after_ns: AFTER_NS,
    };
    let mut files = Files::create(folder)?;
    let outcome = sim::run(&setup, &mut files)
        .map_err(|problem| RunError::Unsupported(problem.to_string()))?;
    files.finish(folder)?;
    write_report(folder, "link.json", &json!({ "player": "model" }))?;
    let controller = json!({
        "counts": outcome.counts,
        "connections": outcome.connections,
        "resent": outcome.resent,
        "timing": timing,
    });
    write_report(folder, "controller.json", &controller)?;
    let mut echoes = Echoes {
        link: (!profile.is_loopback()).then(|| Timeline::new(profile, cell.link_seed, EPOCH_NS)),
        player_ns: u64::from(timing.player_ns),
    };
    Ok(Seen {
        epoch_ns: EPOCH_NS,
        start_ns,
        echoes: [
            (Phase::Empty, echoes.series(schedule::empty(0))),
            (Phase::Before, echoes.series(schedule::before(EPOCH_NS))),
            (
                Phase::During,
                echoes.series(schedule::during(start_ns, cell.duration_ns)),
            ),
            (Phase::After, echoes.series(schedule::after(outcome.end_ns))),
        ],
    })
}

/// The least that the client's timer waits: what its page is told, and what its browser does to
/// timers within timers by itself.
fn timer_floor_ns(cell: &Cell, timing: &Timing) -> u64 {
    cell.page.map_or(0, |page| match (page.thread, page.timer) {
        (Thread::Main, Timer::Timeout) => page.floor_ns.max(u64::from(timing.clamp_ns)),
        _ => page.floor_ns,
    })
}

fn write_report(folder: &Path, name: &str, report: &Value) -> Result<(), RunError> {
    // Plain data of words and numbers: serialising it cannot fail.
    let text = serde_json::to_string_pretty(report).unwrap_or_default() + "\n";
    folder::write_whole(&folder.join(name), text.as_bytes())
}

/// The three files of rows.
struct Files {
    ticks: csv::Writer<File>,
    arrivals: csv::Writer<File>,
    messages: csv::Writer<File>,
    problem: Option<csv::Error>,
}

impl Files {
    fn create(folder: &Path) -> Result<Files, RunError> {
        Ok(Files {
            ticks: create(&folder.join("ticks.csv"), TickRow::COLUMNS)?,
            arrivals: create(&folder.join("arrivals.csv"), ArrivalRow::COLUMNS)?,
            messages: create(&folder.join("messages.csv"), MessageRow::COLUMNS)?,
            problem: None,
        })
    }

    /// Keeps the first problem: the simulation itself cannot fail.
    fn note(&mut self, written: Result<(), csv::Error>) {
        if let Err(problem) = written {
            self.problem.get_or_insert(problem);
        }
    }

    fn finish(mut self, folder: &Path) -> Result<(), RunError> {
        if let Some(problem) = self.problem {
            return Err(RunError::write(folder, std::io::Error::other(problem)));
        }
        [&mut self.ticks, &mut self.arrivals, &mut self.messages]
            .into_iter()
            .try_for_each(csv::Writer::flush)
            .map_err(|problem| RunError::write(folder, problem))
    }
}

impl Record for Files {
    fn tick(&mut self, row: &TickRow) {
        let written = self.ticks.serialize(row);
        self.note(written);
    }

    fn arrival(&mut self, row: &ArrivalRow) {
        let written = self.arrivals.serialize(row);
        self.note(written);
    }

    fn message(&mut self, row: &MessageRow) {
        let written = self.messages.serialize(row);
        self.note(written);
    }
}

/// A new file with its header, as it stays where there are no rows.
fn create(path: &Path, columns: &[&str]) -> Result<csv::Writer<File>, RunError> {
    let fail = |problem: std::io::Error| RunError::write(path, problem);
    let file = File::create_new(path).map_err(fail)?;
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .buffer_capacity(1 << 16)
        .from_writer(file);
    csv.write_record(columns)
        .map_err(|problem| fail(std::io::Error::other(problem)))?;
    Ok(csv)
}

/// Echoes through the link, beside the messages.
struct Echoes {
    /// None on loopback.
    link: Option<Timeline>,
    player_ns: u64,
}

impl Echoes {
    fn series(&mut self, series: Series) -> Vec<Echo> {
        (0..series.count)
            .map(|seq| self.echo(seq, series.start_ns + u64::from(seq) * series.interval_ns))
            .collect()
    }

    fn echo(&mut self, seq: u32, t_send_ns: u64) -> Echo {
        let t_reach_ns = self.crossed(Way::Up, t_send_ns);
        let t_back_ns = t_reach_ns.and_then(|t_ns| self.crossed(Way::Down, t_ns));
        Echo {
            seq,
            t_send_ns,
            t_reach_ns,
            t_back_ns,
        }
    }

    /// When what enters at `t_ns` comes out; `None` if it is lost.
    fn crossed(&mut self, way: Way, t_ns: u64) -> Option<u64> {
        let Some(link) = &mut self.link else {
            return Some(t_ns);
        };
        let state = link.state_at(way, t_ns);
        (!state.lost).then(|| t_ns + state.delay_ns + self.player_ns)
    }
}
