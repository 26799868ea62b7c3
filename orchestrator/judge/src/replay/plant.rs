//! The plant's ticks, replayed from the commands that were held.

use std::collections::BTreeMap;

use control::Signals;
use endpoint::{ArrivalOutcome, ArrivalRow, Input, Process, SecondRow, Surrounded, TickRow};
use plan::End;

use super::{Both, Other, differs};

/// What came of it.
#[derive(Debug, Default)]
pub(super) struct Plant {
    /// Ticks that agreed.
    pub(super) ticks: u64,
    pub(super) other: Option<Other>,
    /// Number of the first tick, and what the sensors showed after it and those that follow.
    pub(super) first_k: u64,
    pub(super) shown: Vec<Signals>,
    /// What they showed before the first tick.
    pub(super) at_rest: Signals,
    /// The first tick that was not replayed, if one was not; what the sensors showed from then on is not known.
    pub(super) unknown_from_ns: Option<u64>,
}

impl Plant {
    /// What the sensors showed after a tick; `None` if it was not replayed.
    pub(super) fn shown(&self, tick: u64) -> Option<Signals> {
        let at = tick.checked_sub(self.first_k)?;
        self.shown.get(usize::try_from(at).ok()?).copied()
    }
}

/// Replays the ticks from the first one on.
pub(super) fn replay(both: &Both<'_>) -> Plant {
    let Both { cell, system, .. } = *both;
    let (Ok(at), Some(first)) = (system.at(cell.settings.h), both.ticks.first()) else {
        return Plant::default();
    };
    let around = system.surroundings().unwrap_or_default();
    let model = at.plant.stepper_from(system.x0());
    let start_ns = Some(both.start_ns);
    let model = Surrounded::new(model, around, cell.link_seed, start_ns);
    let mut process = Process::new(&cell.plant_settings(), model, first.t_due_ns);
    let mut plant = Plant {
        first_k: first.k,
        at_rest: process.output().y,
        ..Plant::default()
    };
    let commands = Commands::of(both.arrivals);
    let mut second = both.second.iter();
    let until_ns = both.until_ns(End::Plant);
    let mut was_commanded = false;
    for (k, row) in (first.k..).zip(both.ticks) {
        // A row that is missing is found elsewhere, and what follows it is not known.
        if row.k != k || row.t_due_ns >= until_ns {
            plant.unknown_from_ns = Some(row.t_due_ns);
            break;
        }
        let beside = second.next().filter(|beside| beside.k == k);
        // Only a reset returns to the input before the first command.
        if was_commanded && row.seq.is_none() {
            process.reset();
        }
        was_commanded = row.seq.is_some();
        let u = Signals {
            first: row.u,
            second: beside.and_then(|beside| beside.u2),
        };
        let command = row.seq.and_then(|seq| commands.held(seq, row.t_tick_ns));
        let input = Input {
            u,
            seq: row.seq,
            t_ns: command.map_or(0, |command| command.t_arrive_ns),
        };
        let due = process.tick(input, row.t_tick_ns);
        let what =
            unlike_command(row, command).or_else(|| unlike(row, &due, beside, process.second()));
        if let Some(what) = what {
            let place = format!("ticks.csv, k = {k}");
            let end = End::Plant;
            plant.other = Some(Other {
                end,
                row: place,
                what,
            });
            plant.unknown_from_ns = Some(row.t_due_ns);
            break;
        }
        plant.ticks += 1;
        plant.shown.push(process.output().y);
    }
    plant
}

/// The commands that were applied, by their numbers, in order of arrival.
struct Commands<'a>(BTreeMap<u64, Vec<&'a ArrivalRow>>);

impl<'a> Commands<'a> {
    fn of(arrivals: &'a [ArrivalRow]) -> Commands<'a> {
        let mut all: BTreeMap<u64, Vec<&ArrivalRow>> = BTreeMap::new();
        let applied = arrivals
            .iter()
            .filter(|row| row.outcome == ArrivalOutcome::Applied);
        for row in applied {
            all.entry(row.seq).or_default().push(row);
        }
        Commands(all)
    }

    /// The newest command of a number at a tick.
    fn held(&self, seq: u64, t_tick_ns: u64) -> Option<&'a ArrivalRow> {
        let all = self.0.get(&seq)?;
        let came = all.partition_point(|row| row.t_arrive_ns <= t_tick_ns);
        came.checked_sub(1).and_then(|last| all.get(last)).copied()
    }
}

/// How the input that is held differs from the command that it names.
fn unlike_command(row: &TickRow, command: Option<&ArrivalRow>) -> Option<String> {
    let Some(seq) = row.seq else {
        return differs("u", row.u, 0.0);
    };
    let Some(command) = command else {
        return Some(format!(
            "command {seq} is held, which arrivals.csv does not have as applied by then"
        ));
    };
    let unlike = differs("u", row.u, command.u)?;
    Some(format!("{unlike}, as command {seq} arrived"))
}

/// How a row differs from the one that is due.
fn unlike(
    row: &TickRow,
    due: &TickRow,
    beside: Option<&SecondRow>,
    beside_due: Option<SecondRow>,
) -> Option<String> {
    if row.t_due_ns != due.t_due_ns {
        return Some(format!(
            "t_due_ns is {}; by the plan's h it is {}",
            row.t_due_ns, due.t_due_ns
        ));
    }
    let both = |name: &str, found: Option<f64>, due: Option<f64>| {
        found
            .zip(due)
            .and_then(|(found, due)| differs(name, found, due))
    };
    let beside = beside.zip(beside_due);
    both("u_applied", row.u_applied, due.u_applied)
        .or_else(|| differs("y", row.y, due.y))
        .or_else(|| {
            beside.and_then(|(row, due)| both("u2_applied", row.u2_applied, due.u2_applied))
        })
        .or_else(|| beside.and_then(|(row, due)| both("y2", row.y2, due.y2)))
}
