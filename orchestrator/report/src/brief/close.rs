//! How close was it: the run nearest to failing, and what delay the loop bears by analysis.

use analysis::statistics::percentile;
use analysis::{Campaign, LoopVerdict, Summary};
use control::{Analysis, largest_stable_blocking_round_trip_s};
use endpoint::Outstanding;
use plan::Cell;
use text::significant;

use crate::called::{called, is_kept, kept};
use crate::delays::{Delays, Nearest};
use crate::number::duration;

/// The run nearest to failing, and how far its delays are from what the loop bears by analysis.
pub(super) fn close(campaign: &Campaign, delays: &[Delays<'_>], nearest: &Nearest<'_>) -> String {
    let (cell, summary) = (&nearest.run.cell, &nearest.run.summary);
    let name = called(campaign, nearest.run);
    let length_ms = cell.duration_ns as f64 / 1e6;
    let mut words = match (summary.loop_verdict, summary.settling_ms) {
        (Some(verdict @ (LoopVerdict::Lost | LoopVerdict::Silent)), _) => {
            let reason = summary.loop_reason.as_deref().unwrap_or("its error grew");
            format!("{name} is {verdict}: {reason}.")
        }
        (Some(LoopVerdict::Unsettled), _) => {
            let reason = summary.loop_reason.as_deref();
            let reason = reason.map_or(String::new(), |of| format!(", {of}"));
            format!("{name} did not settle in {}{reason}.", duration(length_ms))
        }
        (_, Some(settling_ms)) if !is_kept(nearest.run) => format!(
            "The run nearest to failing, {name}, took {} % of its {} to settle{}.",
            significant(settling_ms / length_ms * 100.0, 2),
            duration(length_ms),
            overshot(summary)
        ),
        (_, _) => format!(
            "The run nearest to failing, {name}, {}{}.",
            kept(nearest.run),
            strayed(summary)
        ),
    };
    words += " ";
    let here = delays.iter().find(|of| of.has(nearest.run));
    words += &match borne(campaign, cell) {
        Bears::Untold(why) => format!("What delay the loop bears is not computed: {why}."),
        Bears::None => {
            "By analysis the loop is unstable at every round trip, even without a network."
                .to_owned()
        }
        Bears::Any => "By analysis the loop holds at any constant round trip.".to_owned(),
        Bears::Until { limit_ms } => {
            let mut words = format!(
                "By analysis the loop holds at any constant round trip up to {}",
                duration(limit_ms)
            );
            let round_trips = here.map_or(&[][..], |here| here.round_trip_ms.as_slice());
            match percentile(round_trips, 0.5) {
                Some(middle) => {
                    let within = round_trips.partition_point(|ms| *ms <= limit_ms);
                    words += &format!(
                        "; its messages took {} in the median, and {} % of them at most {}.",
                        duration(middle),
                        significant(within as f64 / round_trips.len() as f64 * 100.0, 3),
                        duration(limit_ms)
                    );
                }
                None => words += "; none of its messages was answered.",
            }
            words
        }
    };
    words
}

/// How far a loop that settled had overshot, where that is worth a word.
fn overshot(summary: &Summary) -> String {
    let pct = summary.overshoot_pct.filter(|pct| *pct >= 0.5);
    pct.map_or(String::new(), |pct| {
        format!(", and overshot by {pct:.0} % of its step")
    })
}

/// How far a loop that stays went, beside its band.
fn strayed(summary: &Summary) -> String {
    let Some(excursion) = summary.excursion else {
        return String::new();
    };
    let farthest = significant(excursion, 3);
    match summary.band {
        Some(band) => format!(
            ": its greatest error is {farthest}, and its band ± {}",
            significant(band, 3)
        ),
        None => format!(": its greatest error is {farthest}"),
    }
}

/// What constant round trip a loop bears, by analysis.
enum Bears {
    /// Any at all.
    Any,
    /// Up to this one.
    Until { limit_ms: f64 },
    /// Not even the shortest.
    None,
    /// There is no analysis, for this reason.
    Untold(String),
}

fn borne(campaign: &Campaign, cell: &Cell) -> Bears {
    if cell.client.is_own() {
        return Bears::Untold("its controller is a program".to_owned());
    }
    if campaign.plan.plant_program(cell).is_some() {
        return Bears::Untold("its plant is a program, of which there is no model".to_owned());
    }
    let system = campaign.plan.system(cell);
    let own = system.map_err(|none| none.to_string()).and_then(|system| {
        let own = system.at(cell.settings.h);
        own.map_err(|unfit| unfit.to_string())
    });
    let limit_s = own.and_then(|own| match cell.settings.outstanding {
        _ if own.law.measures_age() => Err("its filter measures how old outputs are".to_owned()),
        // Who waits for each answer also commands less often the longer that takes.
        Outstanding::ONE => largest_stable_blocking_round_trip_s(&own.plant, &own.law)
            .map_err(|untold| untold.to_string()),
        _ => {
            let open = own.open().map_err(|problem| problem.to_string())?;
            let found = Analysis::of(&open).map_err(|unsure| unsure.to_string())?;
            Ok(found.longest_s)
        }
    });
    match limit_s {
        Err(why) => Bears::Untold(why),
        Ok(None) => Bears::None,
        Ok(Some(limit_s)) if limit_s.is_infinite() => Bears::Any,
        Ok(Some(limit_s)) => Bears::Until {
            limit_ms: limit_s * 1e3,
        },
    }
}
