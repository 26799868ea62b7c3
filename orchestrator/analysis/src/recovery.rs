//! What a fault did to a loop: how far off it was, how long until the plant was safe, and how long until it was
//! back.
//!
//! A loop is back when the error comes into 2 % of the reference's range and stays there until the reference next
//! moves, or the run ends. All times are those at which ticks were due.

use std::path::Path;

use endpoint::TickRow;
use plan::{Cell, FaultSpell, file_name};
use record::ReadError;
use record::rows::read;
use serde::{Deserialize, Serialize};

/// Back means within this fraction of the reference's range.
const BAND: f64 = 0.02;

/// The fewest ticks within the band that show it.
const TICKS_MIN: usize = 5;

/// How a run came through its fault.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Recovery {
    /// The greatest error from the fault's beginning until the loop was back.
    pub worst: f64,
    /// From the tick that took the last command to the first one in the plant's safe state, ms: where what is
    /// applied changes although no command came. `None` if there is none.
    pub safe_ms: Option<f64>,
    /// From the fault's end until the loop was back, ms; 0 if it was never away. `None` if it did not come back.
    pub back_ms: Option<f64>,
}

/// Reads how a run came through its fault, from the ticks in its folder; `None` without a fault.
///
/// # Errors
/// [`ReadError`] if the ticks cannot be read.
pub fn read_recovery(
    folder: &Path,
    cell: &Cell,
    spells: &[FaultSpell],
    start_ns: u64,
) -> Result<Option<Recovery>, ReadError> {
    let Some(mut trace) = Trace::new(cell, spells, start_ns) else {
        return Ok(None);
    };
    let path = folder.join(file_name::TICKS);
    read(&path, |row| trace.push(row))?;
    Ok(trace.finish())
}

/// The ticks of a run from its fault's beginning on.
struct Trace {
    /// The fault's beginning and end, and the end of the loop, ns.
    from_ns: u64,
    to_ns: u64,
    end_ns: u64,
    /// The reference from each instant on, ns.
    changes: Vec<(u64, f64)>,
    band: f64,
    /// The ticks: when each was due, and its error.
    errors: Vec<(u64, f64)>,
    /// The newest command: the tick that took it, its number, and what was applied then.
    newest: Option<(u64, u64, f64)>,
    /// From the last command to the safe state, ns.
    safe_ns: Option<u64>,
}

impl Trace {
    fn new(cell: &Cell, spells: &[FaultSpell], start_ns: u64) -> Option<Trace> {
        let from_ns = spells.iter().map(|spell| spell.from_ns).min()?;
        let to_ns = spells.iter().map(|spell| spell.to_ns).max()?;
        let changes = match cell.moving_reference() {
            Some(moving) => moving
                .changes()
                .iter()
                .map(|(t_ns, r)| (start_ns + t_ns, *r))
                .collect(),
            None => vec![(start_ns, cell.settings.r)],
        };
        let values = || changes.iter().map(|(_, r)| *r).chain([cell.y0]);
        let span =
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
        Some(Trace {
            from_ns: start_ns + from_ns,
            to_ns: start_ns + to_ns.min(cell.duration_ns),
            end_ns: start_ns + cell.duration_ns,
            band: BAND * span,
            changes,
            errors: Vec::new(),
            newest: None,
            safe_ns: None,
        })
    }

    fn push(&mut self, row: &TickRow) {
        let t_ns = row.t_due_ns;
        if t_ns >= self.end_ns {
            return;
        }
        if let (Some(seq), Some(applied)) = (row.seq, row.u_applied) {
            match self.newest {
                Some((taken_ns, newest, then)) if newest == seq => {
                    if t_ns >= self.from_ns && applied.to_bits() != then.to_bits() {
                        self.safe_ns.get_or_insert(t_ns - taken_ns);
                    }
                }
                _ => self.newest = Some((t_ns, seq, applied)),
            }
        }
        if t_ns >= self.from_ns {
            let at = self
                .changes
                .partition_point(|(from_ns, _)| *from_ns <= t_ns);
            let r = self.changes[at.saturating_sub(1)].1;
            self.errors.push((t_ns, (row.y - r).abs()));
        }
    }

    fn finish(self) -> Option<Recovery> {
        let back_ns = self.back_ns();
        let until_ns = back_ns.unwrap_or(u64::MAX);
        let away = self.errors.iter().take_while(|(t_ns, _)| *t_ns <= until_ns);
        let worst = away.map(|(_, error)| *error).fold(None, |worst, error| {
            // An output that is no longer finite is as far off as can be.
            let error = if error.is_nan() { f64::INFINITY } else { error };
            Some(error.max(worst.unwrap_or_default()))
        })?;
        let ms = |from_ns: u64, to_ns: u64| to_ns.saturating_sub(from_ns) as f64 * 1e-6;
        Some(Recovery {
            worst,
            safe_ms: self.safe_ns.map(|ns| ns as f64 * 1e-6),
            back_ms: back_ns.map(|back_ns| ms(self.to_ns, back_ns)),
        })
    }

    /// The first tick after the fault from which on the error stays in the band, until the reference next moves
    /// or the loop ends.
    fn back_ns(&self) -> Option<u64> {
        let after = self.errors.partition_point(|(t_ns, _)| *t_ns < self.to_ns);
        let mut rest = &self.errors[after..];
        while let Some(&(first_ns, _)) = rest.first() {
            let next = self.changes.iter().map(|(t_ns, _)| *t_ns);
            let next_ns = next.filter(|t_ns| *t_ns > first_ns).min();
            let length = rest.partition_point(|(t_ns, _)| next_ns.is_none_or(|next| *t_ns < next));
            let (stretch, later) = rest.split_at(length);
            let out = stretch
                .iter()
                .rposition(|(_, error)| error.is_nan() || *error > self.band);
            let within = &stretch[out.map_or(0, |at| at + 1)..];
            if within.len() >= TICKS_MIN {
                // The first tick after the fault comes up to h later.
                let is_never_away = out.is_none() && rest.len() == self.errors.len() - after;
                return match is_never_away {
                    true => Some(self.to_ns),
                    false => within.first().map(|(t_ns, _)| *t_ns),
                };
            }
            rest = later;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const START_NS: u64 = 7_000 * MS;

    /// How a loop with these outputs came through a fault from 200 to 300 ms; `command` has the number of the
    /// newest command, and what is applied.
    fn recovery(y: impl Fn(u64) -> f64, command: impl Fn(u64) -> (u64, f64)) -> Option<Recovery> {
        let mut trace = trace();
        push_all(&mut trace, y, command);
        trace.finish()
    }

    fn trace() -> Trace {
        Trace {
            from_ns: START_NS + 200 * MS,
            to_ns: START_NS + 300 * MS,
            end_ns: START_NS + 1_000 * MS,
            changes: vec![(START_NS, 1.0), (START_NS + 600 * MS, 0.0)],
            band: 0.02,
            errors: Vec::new(),
            newest: None,
            safe_ns: None,
        }
    }

    fn push_all(trace: &mut Trace, y: impl Fn(u64) -> f64, command: impl Fn(u64) -> (u64, f64)) {
        for k in 0..200 {
            let (seq, applied) = command(10 * k);
            trace.push(&TickRow {
                k,
                t_due_ns: START_NS + 10 * k * MS,
                t_tick_ns: 0,
                u: 0.3,
                y: y(10 * k),
                seq: Some(seq),
                u_applied: Some(applied),
            });
        }
    }

    #[test]
    fn a_loop_that_a_fault_leaves_alone_was_never_away() {
        let steady = |ms| if ms < 600 { 1.01 } else { 0.01 };
        let found = recovery(steady, |ms| (ms, 0.3)).expect("a fault");
        assert_eq!((found.back_ms, found.safe_ms), (Some(0.0), None));
        assert!((found.worst - 0.01).abs() < 1e-12);
    }

    #[test]
    fn one_that_was_never_away_is_back_at_once_though_its_next_tick_is_later() {
        let mut trace = Trace {
            from_ns: START_NS + 203 * MS,
            to_ns: START_NS + 303 * MS,
            ..trace()
        };
        push_all(&mut trace, |_| 1.01, |ms| (ms, 0.3));
        let found = trace.finish().expect("a fault");
        assert_eq!(found.back_ms, Some(0.0));
    }

    #[test]
    fn back_is_when_the_error_stays_small_and_safe_when_the_command_is_gone() {
        // Away by 0.5 from 250 ms to 400 ms; the command of 260 ms is held, and let go at 300 ms.
        let y = |ms: u64| {
            if (250..400).contains(&ms) {
                0.5
            } else if ms < 600 {
                1.0
            } else {
                0.0
            }
        };
        let command = |ms: u64| match ms {
            270..300 => (260, 0.3),
            300..350 => (260, 0.0),
            _ => (ms, 0.3),
        };
        let found = recovery(y, command).expect("a fault");
        assert_eq!(found.back_ms, Some(100.0));
        assert_eq!(found.safe_ms, Some(40.0));
        assert!((found.worst - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_loop_that_is_away_when_the_reference_moves_may_be_back_afterwards_or_never() {
        let late = |ms: u64| {
            if ms < 200 {
                1.0
            } else if ms < 700 {
                0.5
            } else {
                0.0
            }
        };
        assert_eq!(
            recovery(late, |ms| (ms, 0.3)).expect("a fault").back_ms,
            Some(400.0)
        );
        let lost = |ms: u64| if ms < 200 { 1.0 } else { f64::NAN };
        let found = recovery(lost, |ms| (ms, 0.3)).expect("a fault");
        assert_eq!((found.back_ms, found.worst), (None, f64::INFINITY));
    }
}
