//! The parts of a message's way in which two campaigns differ: waiting at the deadline, up to the
//! plant, or down again.
//!
//! Quantiles of parts do not add up to a quantile of the whole, so these numbers only point to the
//! cause.

use analysis::Run;
use analysis::statistics::median;
use endpoint::MessageRow;
use plan::file_name;
use record::rows::read;
use serde::Serialize;

/// How much longer A's messages take than B's in each part, ms: the same quantile of both runs of a
/// pair, and the median over the pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parts {
    /// From the deadline to sending.
    pub late_ms: f64,
    /// From sending to the plant.
    pub up_ms: f64,
    /// From the plant back to the client.
    pub down_ms: f64,
}

/// The duration of a part of a message's way, ns.
type Way = fn(&MessageRow) -> Option<u64>;

const LATE: Way = |row| Some(row.t_send_ns?.saturating_sub(row.t_due_ns));
const UP: Way = |row| Some(row.t_arrive_ns?.saturating_sub(row.t_send_ns?));
const DOWN: Way = |row| Some(row.t_receive_ns?.saturating_sub(row.t_arrive_ns?));

impl Parts {
    /// The parts of pairs of runs, at a quantile from 0 to 1; `None` if rows cannot be read or there
    /// are none.
    pub(super) fn of(runs: &[(&Run, &Run)], quantile: f64) -> Option<Parts> {
        let mut off: [Vec<f64>; 3] = Default::default();
        for (a, b) in runs {
            let (a, b) = (quantiles_ms(a, quantile)?, quantiles_ms(b, quantile)?);
            for ((off, a), b) in off.iter_mut().zip(a).zip(b) {
                off.push(a - b);
            }
        }
        let [late, up, down] = off;
        Some(Parts {
            late_ms: median(&late)?,
            up_ms: median(&up)?,
            down_ms: median(&down)?,
        })
    }

    /// The parts that are at least a fifth of the greatest, in descending order:
    /// `up -1.20 ms, late -0.31 ms`.
    pub(super) fn words(&self) -> String {
        let mut parts = [
            ("late", self.late_ms),
            ("up", self.up_ms),
            ("down", self.down_ms),
        ];
        parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let most = parts[0].1.abs();
        let matter = parts.iter().filter(|(_, ms)| ms.abs() >= 0.2 * most);
        let words: Vec<String> = matter
            .map(|(name, ms)| format!("{name} {ms:+.2} ms"))
            .collect();
        words.join(", ")
    }
}

/// The quantile of each part over a run's answered messages, ms.
fn quantiles_ms(run: &Run, quantile: f64) -> Option<[f64; 3]> {
    let mut parts: [Vec<u64>; 3] = Default::default();
    let take = |row: &MessageRow| {
        if row.t_receive_ns.is_some() {
            for (part, way) in parts.iter_mut().zip([LATE, UP, DOWN]) {
                part.extend(way(row));
            }
        }
    };
    read(&run.folder.join(file_name::MESSAGES), take).ok()?;
    let mut found = [0.0; 3];
    for (found, part) in found.iter_mut().zip(&mut parts) {
        part.sort_unstable();
        let last = part.len().checked_sub(1)?;
        *found = part[(quantile * last as f64).round() as usize] as f64 / 1e6;
    }
    Some(found)
}
