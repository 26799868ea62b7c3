//! How the server keeps its own sample time, and what it costs the loop where it does not: Figure 7 and section 4.3.

use std::ops::Range;

use analysis::Run;
use endpoint::TickRow;
use record::{ReadError, rows};

use super::evidence::Evidence;
use super::metric::Metric;
use super::rare::Count;
use super::row::Judged;
use super::together::in_10_ms;
use report::number::number;

pub(super) const FIGURES: &[Metric] = &[
    Metric::median("mean of the sample intervals", "ms", |m| {
        m.ticks.interval_avg_ms
    }),
    Metric::median("sd of the sample intervals", "ms", |m| {
        m.ticks.interval_sd_ms
    }),
    Metric::group(
        "share of sample intervals that are zero or negative",
        "",
        |source| {
            let count = Count::over(source, |m| (m.ticks.interval_nonpositive, m.ticks.count));
            Ok(count.and_then(Count::sampled))
        },
    ),
    Metric::group(
        "share of messages in the same 10 ms as the one before",
        "",
        |source| Ok(in_10_ms(source).and_then(Count::sampled)),
    ),
    Metric::group("IAE from the first command on", "s", |source| {
        source.group.try_median(iae_from_command)
    }),
];

/// The integral of the absolute error from the tick on that took the first command, in units of y times s.
pub(crate) fn iae_from_command(run: &Run) -> Result<Option<f64>, ReadError> {
    let settings = &run.cell.settings;
    let mut step = Commanded::new(run.lasts_ns(), settings.r);
    rows::read(&run.folder.join(TickRow::FILE), |row: &TickRow| {
        step.push(row);
    })?;
    let sum = step.has_begun.then_some(step.error_sum);
    Ok(sum.map(|sum| sum * settings.h.seconds()))
}

/// The absolute errors from the tick on that took the first command, added up.
///
/// A plant whose ticks are late takes its first command at a tick that was due before it was sent, even before the first
/// deadline, so that by the plant's time its step begins earlier. From that tick on two plants have the same step before
/// them.
struct Commanded {
    lasts_ns: Range<u64>,
    r: f64,
    has_begun: bool,
    error_sum: f64,
}

impl Commanded {
    fn new(lasts_ns: Range<u64>, r: f64) -> Commanded {
        Commanded {
            lasts_ns,
            r,
            has_begun: false,
            error_sum: 0.0,
        }
    }

    fn push(&mut self, row: &TickRow) {
        // What a tick took before the first deadline is no command of the run.
        self.has_begun |= row.seq.is_some() && row.t_tick_ns >= self.lasts_ns.start;
        if self.has_begun && row.t_due_ns < self.lasts_ns.end {
            self.error_sum += (self.r - row.y).abs();
        }
    }
}

pub(super) fn note_spread(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for judged in judged {
        let ours = judged.ours.filter(|sd| sd.value > 0.0);
        if let (Some(paper), Some(ours)) = (judged.row.paper, ours) {
            evidence.note(format!(
                "At h = {} ms the paper's desktop has {} times the spread.",
                number(judged.source.h_s() * 1e3),
                number(paper / ours.value)
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(t_due_ns: u64, late_ns: u64, y: f64, seq: Option<u64>) -> TickRow {
        TickRow {
            k: t_due_ns / 3,
            t_due_ns,
            t_tick_ns: t_due_ns + late_ns,
            u: 0.0,
            y,
            seq,
            u_applied: None,
        }
    }

    #[test]
    fn a_step_counts_from_its_first_command_whatever_ticks_are_late() {
        let step = |late_ns: u64, first: usize| {
            let mut of = Commanded::new(30..60, 1.0);
            for (nth, t_due_ns) in (0..60).step_by(3).enumerate() {
                let seq = nth.checked_sub(first).map(|seq| seq as u64);
                let y = seq.map_or(0.0, |seq| 1.0 - 0.5_f64.powi(seq as i32));
                of.push(&tick(t_due_ns, late_ns, y, seq));
            }
            of.error_sum
        };
        // The first command is sent at 30 ns. A plant that is 7 ns late has it at the tick that was due at 24.
        let (punctual, late) = (step(0, 10), step(7, 8));
        assert!((punctual - 2.0).abs() < 0.01 && (late - punctual).abs() < 0.01);
    }
}
