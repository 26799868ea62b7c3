//! How close was it: the run nearest to failing, and what delay the loop bears by analysis.

use analysis::{Campaign, LoopVerdict};
use control::{largest_stable_blocking_round_trip_s, largest_stable_round_trip_s};
use endpoint::Outstanding;

use crate::delays::{Delays, Nearest, percentile};
use crate::number::{duration, significant};

/// The run nearest to failing, and how far its delays are from what the loop bears by analysis.
pub(super) fn close(campaign: &Campaign, delays: &[Delays<'_>], nearest: &Nearest<'_>) -> String {
    let (cell, summary) = (&nearest.run.cell, &nearest.run.summary);
    let length_ms = cell.duration_ns as f64 / 1e6;
    let mut words = match (summary.loop_verdict, summary.settling_ms) {
        (Some(LoopVerdict::Unstable), _) => format!("{} failed: its error grew.", cell.id),
        (Some(LoopVerdict::NotSettled), _) => {
            format!(
                "{} failed: it did not settle in {}.",
                cell.id,
                duration(length_ms)
            )
        }
        (_, Some(settling_ms)) => format!(
            "The run nearest to failing, {}, took {} % of its {} to settle.",
            cell.id,
            significant(settling_ms / length_ms * 100.0, 2),
            duration(length_ms)
        ),
        (_, None) => format!(
            "The run nearest to failing, {}, follows its reference.",
            cell.id
        ),
    };
    let own = campaign
        .plan
        .system(cell)
        .ok()
        .filter(|_| !cell.client.is_own())
        .and_then(|system| system.at(cell.settings.h).ok());
    let limit_s = own.and_then(|own| match cell.settings.outstanding {
        // Who waits for each answer also commands less often the longer that takes.
        Outstanding::ONE => largest_stable_blocking_round_trip_s(&own.plant, &own.law).ok()?,
        _ => largest_stable_round_trip_s(&own.open().ok()?),
    });
    let here = delays.iter().find(|of| of.has(nearest.run));
    if let (Some(limit_s), Some(here)) = (limit_s.filter(|s| s.is_finite()), here) {
        let round_trips = &here.round_trip_ms;
        let within = round_trips.partition_point(|ms| *ms <= limit_s * 1e3);
        if let Some(middle) = percentile(round_trips, 0.5) {
            words += &format!(
                " By analysis the loop holds at any constant round trip up to {}; its messages took {} in the \
                 median, and {} % of them no longer than that.",
                duration(limit_s * 1e3),
                duration(middle),
                significant(within as f64 / round_trips.len() as f64 * 100.0, 3)
            );
        }
    }
    words
}
