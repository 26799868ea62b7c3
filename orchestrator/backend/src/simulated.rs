//! Runs a cell in virtual time: `sim` does the run, and its rows and echoes go into the same files.
//!
//! Nothing here is measured, so a busy machine makes no difference. A [`Timing`] says how long a
//! machine's programs take.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

use endpoint::report::Written;
use endpoint::{
    ArrivalRow, MessageRow, Model, Policy, SecondRow, Surrounded, Thread, TickRow, Timer,
};
use link::certificate::{Echo, LinkReport};
use link::{PacketRow, Profile, Way};
use plan::series::Spacing;
use plan::system::System;
use plan::{Cell, End, EndEffect, EndFault, EndFaultDone, Phase, file_name};
use record::{FileFact, Held, ModelController, ModelPlant, Tally, folder};
use serde::Serialize;
use sim::{EPOCH, Outcome, Pool, Record, Series, Setup, Start, Timing};
use text::column::Row;

use crate::course::Seen;
use crate::error::RunError;
use crate::link_check::Sent;
use crate::own_plant::start_simulated;
use crate::schedule;
use crate::texts::Texts;

/// How long the plant goes on after the last message: as long as there are echoes.
const AFTER_NS: u64 = 1_200_000_000;

/// The loop's start, in virtual time.
const START_NS: u64 = EPOCH.t_ns(plan::START_AT);

/// Simulates a cell, and writes its rows and reports to `folder`.
pub(crate) fn run(
    cell: &Cell,
    system: &System,
    profile: &Profile,
    texts: Texts<'_>,
    timing: &Timing,
    folder: &Path,
) -> Result<Seen, RunError> {
    let h = cell.settings.h;
    let around = system.surroundings();
    let (seed, start_ns) = (cell.link_seed, Some(START_NS));
    let real = |fault: &EndFault| match fault.effect {
        EndEffect::Kill => Some(format!(
            "the fault kills the {}, and virtual time has no processes: use --backend netns or compose",
            fault.end
        )),
        EndEffect::Busy(_) => Some(
            "the fault keeps the machine busy, and virtual time has none: use --backend netns"
                .to_owned(),
        ),
        EndEffect::Freeze | EndEffect::Starve(_) => None,
    };
    if let Some(why) = texts.end_faults.iter().find_map(real) {
        return Err(RunError::Unsupported(why));
    }
    if cell.page.is_some_and(|page| page.chores_ns > 0) {
        return Err(RunError::Unsupported(
            "virtual time has the timing of pages that do nothing else, and this one has chores: use --backend netns or \
             compose"
                .to_owned(),
        ));
    }
    if cell.scheduling == Policy::Other {
        return Err(RunError::Unsupported(
            "virtual time has the timing of ends that run in real time, and scheduling is other: use --backend netns or \
             compose"
                .to_owned(),
        ));
    }
    let faults = texts.end_faults;
    let Some(program) = texts.plant_program else {
        let plant = system.at(h)?.plant;
        let plant = plant.stepper_from(system.x0());
        return match around {
            None => run_with(plant, system, cell, profile, faults, timing, folder),
            Some(around) => {
                let plant = Surrounded::new(plant, around, seed, start_ns);
                run_with(plant, system, cell, profile, faults, timing, folder)
            }
        };
    };
    let own = start_simulated(program, system.inputs(), h, seed)
        .map_err(|problem| RunError::Program(problem.to_string()))?;
    let plant = Surrounded::new(own.clone(), around.unwrap_or_default(), seed, start_ns);
    let seen = run_with(plant, system, cell, profile, faults, timing, folder)?;
    match own.problem() {
        Some(problem) => Err(RunError::Program(problem)),
        None => Ok(seen),
    }
}

/// Simulates a cell whose plant is `plant`.
fn run_with<M: Model + Clone>(
    plant: M,
    system: &System,
    cell: &Cell,
    profile: &Profile,
    faults: &[EndFault],
    timing: &Timing,
    folder: &Path,
) -> Result<Seen, RunError> {
    let h = cell.settings.h;
    let (law, _) = system.law_at(h)?;
    // The start of the last series is not known yet.
    let planned = [
        Spacing::Wide.empty(0),
        Spacing::Wide.before(EPOCH),
        schedule::during(START_NS, cell.duration_ns),
        Spacing::Wide.after(0),
    ];
    let echoes = planned.map(|series| Series {
        start: match series.phase {
            Phase::After => Start::AfterLast,
            _ => Start::At(series.start_ns),
        },
        interval_ns: series.interval_ns,
        count: series.count,
    });
    let stops = End::BOTH.map(|end| frozen(faults, end));
    let setup = Setup {
        profile,
        frozen: [&stops[0], &stops[1]],
        seed: cell.link_seed,
        settings: cell.settings,
        timer_floor_ns: timer_floor_ns(cell, timing),
        plant,
        plant_settings: cell.plant_settings(),
        reference: cell.moving_reference(),
        law,
        pool: if cell.client.spec().keeps_own_connections {
            Pool::Own
        } else {
            Pool::Shared
        },
        message_bytes: cell.client.message_bytes(cell.settings.transport),
        echoes: &echoes,
        timing,
        epoch: EPOCH,
        plant_start_ns: sim::plant_start_ns(cell.link_seed, h.ns()),
        start_ns: START_NS,
        duration_ns: cell.duration_ns,
        after_ns: AFTER_NS,
    };
    let mut files = Files::create(folder, profile.has_rate(), setup.plant.has_second())?;
    let outcome = sim::run(&setup, &mut files)
        .map_err(|problem| RunError::Unsupported(problem.to_string()))?;
    let written = files.finish(folder)?;
    write_reports(folder, written, outcome, timing)?;
    Ok(files.seen(planned.map(|series| series.phase), faults))
}

/// When an end stands still, in virtual time.
fn frozen(faults: &[EndFault], end: End) -> Vec<Range<u64>> {
    let own = faults.iter().filter(|fault| fault.end == end);
    own.flat_map(|fault| fault.stops(START_NS)).collect()
}

/// A fault as it was done: in virtual time just as it was asked for.
fn as_asked(fault: &EndFault) -> EndFaultDone {
    let [from_ns, to_ns] = [fault.from_ns, fault.to_ns].map(|ns| START_NS + ns);
    EndFaultDone {
        end: fault.end,
        effect: fault.effect,
        asked_from_ns: from_ns,
        asked_to_ns: to_ns,
        from_ns,
        to_ns,
        stood_ns: fault
            .stops(START_NS)
            .iter()
            .map(|stop| stop.end - stop.start)
            .sum(),
    }
}

/// Shortest wait of the client's timer, ns: the floor that its page is given, and the browser's own
/// minimum for nested timers.
fn timer_floor_ns(cell: &Cell, timing: &Timing) -> u64 {
    cell.page.map_or(0, |page| match (page.thread, page.timer) {
        (Thread::Main, Timer::Timeout) => page.floor_ns.max(u64::from(timing.clamp_ns)),
        _ => page.floor_ns,
    })
}

/// Writes the reports that the roles write in a real run, as far as they exist here.
fn write_reports(
    folder: &Path,
    [ticks, second, arrivals, messages]: [u64; 4],
    outcome: Outcome,
    timing: &Timing,
) -> Result<(), RunError> {
    let written = |rows: u64| Written { rows, overflow: 0 };
    let plant = ModelPlant {
        tick_rows: written(ticks),
        second_rows: (second > 0).then(|| written(second)),
        arrival_rows: written(arrivals),
    };
    write_report(folder, file_name::PLANT_REPORT, &plant)?;
    write_report(folder, file_name::LINK_REPORT, &LinkReport::model())?;
    let controller = ModelController {
        counts: outcome.counts,
        rows: written(messages),
        connections: outcome.connections,
        resent: outcome.resent,
        timing: timing.clone(),
    };
    write_report(folder, file_name::CONTROLLER_REPORT, &controller)
}

/// Writes a report with its fields sorted by name.
fn write_report(folder: &Path, name: &str, report: &impl Serialize) -> Result<(), RunError> {
    // Plain data of words and numbers: serialising it cannot fail.
    let report = serde_json::to_value(report).unwrap_or_default();
    let text = serde_json::to_string_pretty(&report).unwrap_or_default() + "\n";
    Ok(folder::write(&folder.join(name), text.as_bytes())?)
}

/// The files of rows, the rows by which the run is judged, and the echoes of each series.
struct Files {
    ticks: Sheet,
    /// Only if there is a second input or output.
    second: Option<Sheet>,
    arrivals: Sheet,
    messages: Sheet,
    /// Only if there is a rate limit.
    packets: Option<Sheet>,
    rows: Held,
    echoes: [Vec<Echo>; 4],
}

/// A file of rows being written.
struct Sheet {
    name: &'static str,
    file: File,
    /// Length and checksum of what is in the file.
    tally: Tally,
    /// Rows that are not in the file yet.
    text: Vec<u8>,
    rows: u64,
    problem: Option<io::Error>,
}

/// Rows are written to the file when there are so many bytes of them.
const SHEET_BYTES: usize = 1 << 16;

impl Sheet {
    /// Creates a file with its header, which it has even if no rows follow.
    fn create(folder: &Path, name: &'static str, columns: &[&str]) -> Result<Sheet, RunError> {
        let path = folder.join(name);
        let file = File::create_new(&path).map_err(|problem| RunError::write(&path, problem))?;
        let mut text = columns.join(",").into_bytes();
        text.push(b'\n');
        Ok(Sheet {
            name,
            file,
            tally: Tally::default(),
            text,
            rows: 0,
            problem: None,
        })
    }

    fn write(&mut self, row: &impl Row) {
        self.rows += 1;
        row.write(&mut self.text);
        if self.text.len() >= SHEET_BYTES {
            self.flush();
        }
    }

    /// Keeps the first problem, since the simulation itself cannot fail.
    fn flush(&mut self) {
        // While they are in the processor's cache.
        self.tally.push(&self.text);
        if let Err(problem) = self.file.write_all(&self.text) {
            self.problem.get_or_insert(problem);
        }
        self.text.clear();
    }

    /// Completes the file; returns how many rows it has, and adds what it is known by to `files`.
    fn finish(&mut self, files: &mut BTreeMap<String, FileFact>) -> io::Result<u64> {
        self.flush();
        files.insert(self.name.to_owned(), std::mem::take(&mut self.tally).fact());
        self.problem.take().map_or(Ok(self.rows), Err)
    }
}

impl Files {
    fn create(folder: &Path, has_rate: bool, has_second: bool) -> Result<Files, RunError> {
        let sheet = |name, columns| Sheet::create(folder, name, columns);
        let packets = || sheet(file_name::PACKETS, PacketRow::COLUMNS);
        let second = || sheet(file_name::SECOND, SecondRow::COLUMNS);
        Ok(Files {
            ticks: sheet(file_name::TICKS, TickRow::COLUMNS)?,
            second: has_second.then(second).transpose()?,
            arrivals: sheet(file_name::ARRIVALS, ArrivalRow::COLUMNS)?,
            messages: sheet(file_name::MESSAGES, MessageRow::COLUMNS)?,
            packets: has_rate.then(packets).transpose()?,
            rows: Held {
                second: has_second.then(Vec::new),
                ..Held::default()
            },
            echoes: Default::default(),
        })
    }

    /// Completes the files; returns how many rows are in each: ticks, second inputs and outputs, arrivals and
    /// messages.
    fn finish(&mut self, folder: &Path) -> Result<[u64; 4], RunError> {
        let files = &mut self.rows.files;
        let mut finish = |sheet: Option<&mut Sheet>| {
            let rows = sheet.map_or(Ok(0), |sheet| sheet.finish(files));
            rows.map_err(|problem| RunError::write(folder, problem))
        };
        finish(self.packets.as_mut())?;
        let second = finish(self.second.as_mut())?;
        Ok([
            finish(Some(&mut self.ticks))?,
            second,
            finish(Some(&mut self.arrivals))?,
            finish(Some(&mut self.messages))?,
        ])
    }

    /// What was observed of the run, whose series of echoes had these phases, with faults that came as asked.
    fn seen(self, phases: [Phase; 4], faults: &[EndFault]) -> Seen {
        let mut phases = phases.into_iter();
        Seen {
            epoch: EPOCH,
            opens: Spacing::Wide.opens(),
            start_ns: START_NS,
            echoes: self.echoes.map(|mut echoes| {
                // They ended in a different order than they were sent.
                echoes.sort_unstable_by_key(|echo| echo.seq);
                Sent {
                    phase: phases.next().unwrap_or(Phase::After),
                    until_ns: vec![u64::MAX; echoes.len()],
                    echoes,
                }
            }),
            rows: Some(self.rows),
            pulse: None,
            watched: Vec::new(),
            end_faults: faults.iter().map(as_asked).collect(),
        }
    }
}

impl Record for Files {
    fn tick(&mut self, row: &TickRow) {
        self.rows.ticks.push(*row);
        self.ticks.write(row);
    }

    fn second(&mut self, row: &SecondRow) {
        if let (Some(second), Some(rows)) = (&mut self.second, &mut self.rows.second) {
            rows.push(*row);
            second.write(row);
        }
    }

    fn arrival(&mut self, row: &ArrivalRow) {
        self.rows.arrivals.push(*row);
        self.arrivals.write(row);
    }

    fn message(&mut self, row: &MessageRow) {
        self.rows.messages.push(*row);
        self.messages.write(row);
    }

    fn echo(&mut self, series: usize, echo: &sim::Echo) {
        self.echoes[series].push(Echo {
            seq: echo.seq,
            t_send_ns: echo.t_send_ns,
            t_reach_ns: echo.t_reach_ns,
            t_back_ns: echo.t_back_ns,
        });
    }

    fn packet(&mut self, way: Way, t_ns: u64, bytes: u32) {
        if let Some(packets) = &mut self.packets {
            packets.write(&PacketRow { t_ns, way, bytes });
        }
    }
}
