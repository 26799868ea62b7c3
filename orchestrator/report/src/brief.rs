//! The five questions with which people open a report, each answered in a sentence or two: does my loop
//! hold, how close was it, which second hurt, which client is best here, what did the network cost me.

use std::cmp::Ordering;

use analysis::{Campaign, LoopVerdict};
use control::{largest_stable_blocking_round_trip_s, largest_stable_round_trip_s};
use endpoint::Outstanding;

use crate::answer::Answer;
use crate::delays::{Delays, Nearest, percentile};
use crate::group::Estimate;
use crate::loops::{Loop, all, baseline};
use crate::number::{duration, significant};

/// The most places that are named in an answer; further ones are only counted.
const NAMED: usize = 4;

/// The first question, which the page's headline answers too.
pub(crate) const HOLDS: &str = "Does my loop hold?";

/// The answer where no loop was closed by several clients.
const ALONE: &str = "One client closed each loop here, so there is nothing to compare.";

/// A question, and its answer in sentences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Brief {
    /// The question.
    pub question: &'static str,
    /// The answer.
    pub answer: String,
    /// The figure or table that shows it, by its number or its name; empty if there is none.
    pub shown_in: &'static str,
}

/// The questions that the campaign answers: of open loops only whether their clients keep the schedule.
#[must_use]
pub fn all_of(
    campaign: &Campaign,
    delays: &[Delays<'_>],
    nearest: Option<&Nearest<'_>>,
) -> Vec<Brief> {
    let Some(nearest) = nearest else {
        return schedule(campaign).into_iter().collect();
    };
    let mut loops = all(campaign);
    loops.retain(|one| !one.group.runs.is_empty());
    let best = best(&loops);
    let headline = Answer::of(campaign).words().into_iter().next();
    [
        (HOLDS, headline, ""),
        (
            "How close was it?",
            Some(close(campaign, delays, nearest)),
            "",
        ),
        ("Which second hurt?", Some(hurt(nearest)), "fig-F"),
        (
            "Which client is best here?",
            Some(best.clone().unwrap_or_else(|| ALONE.to_owned())),
            if best.is_some() { "control" } else { "" },
        ),
        (
            "What did the network cost me?",
            cost(campaign, &loops, delays),
            "fig-D",
        ),
    ]
    .into_iter()
    .filter_map(|(question, answer, shown_in)| {
        Some(Brief {
            question,
            answer: answer?,
            shown_in,
        })
    })
    .collect()
}

/// Which clients keep their schedule, in a campaign of open loops; `None` without a complete one.
fn schedule(campaign: &Campaign) -> Option<Brief> {
    /// A client that falls behind by less than this each second keeps its schedule, s/s.
    const KEPT: f64 = 1e-3;
    let complete = campaign.runs.iter().filter(|run| run.is_complete());
    let clients = analysis::grouped(complete, |run| {
        (run.cell.client, run.cell.setup_beside_system())
    });
    let mut told: Vec<(f64, String)> = Vec::new();
    for ((client, setup), runs) in &clients {
        let is_alone = clients.iter().filter(|((of, _), _)| of == client).count() == 1;
        let name = if is_alone {
            client.to_string()
        } else {
            format!("{client} {setup}")
        };
        let worst = runs
            .iter()
            .filter_map(|run| Some((run.summary.schedule_slope?, *run)))
            .max_by(|(one, _), (other, _)| one.total_cmp(other));
        let Some((slope, run)) = worst else { continue };
        let words = if slope < KEPT {
            format!("{name} keeps it")
        } else {
            format!(
                "{name} falls behind by up to {} each second ({}, {})",
                duration(slope * 1e3),
                run.cell.topology,
                run.cell.rate()
            )
        };
        told.push((slope, words));
    }
    told.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let words: Vec<String> = told.into_iter().map(|(_, words)| words).collect();
    (!words.is_empty()).then(|| Brief {
        question: "Which clients keep their schedule?",
        answer: words.join("; ") + ".",
        shown_in: "fig-G",
    })
}

/// The run nearest to failing, and how far its delays are from what the loop bears by analysis.
fn close(campaign: &Campaign, delays: &[Delays<'_>], nearest: &Nearest<'_>) -> String {
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
        let middle = percentile(round_trips, 0.5).unwrap_or(0.0);
        if !round_trips.is_empty() {
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

fn hurt(nearest: &Nearest<'_>) -> String {
    match &nearest.hold {
        Some(hold) => format!("In {}, {hold}.", nearest.run.cell.id),
        None => format!(
            "None stands out in {}: a new command took effect at nearly every tick.",
            nearest.run.cell.id
        ),
    }
}

/// The quickest client where several closed the same loop; `None` if none can be compared.
fn best(loops: &[Loop<'_>]) -> Option<String> {
    let places = analysis::grouped(loops, |one| (one.topology, one.system, one.h_ns));
    // What can be told comes first, then by how much quicker the first is than the second.
    let mut told: Vec<(bool, f64, String)> = Vec::new();
    for (_, here) in &places {
        let mut by_settling: Vec<(&Loop<'_>, Estimate)> = here
            .iter()
            .filter_map(|one| Some((*one, one.group.settling_ms()?)))
            .collect();
        by_settling.sort_by(|(_, one), (_, other)| one.value.total_cmp(&other.value));
        let [(first, least), (second, next), ..] = by_settling[..] else {
            continue;
        };
        let place = place(first, loops);
        let name = |one: &Loop<'_>| {
            let is_alone = here.iter().filter(|of| of.client == one.client).count() == 1;
            if is_alone {
                one.client.to_string()
            } else {
                one.who()
            }
        };
        if !least.value.is_finite() {
            told.push((false, f64::INFINITY, format!("{place}: no client settles")));
            continue;
        }
        let is_clear = least.has_interval() && next.has_interval() && least.high < next.low;
        let other = if next.value.is_finite() {
            format!("then {} in {}", name(second), duration(next.value))
        } else {
            format!("and {} does not settle", name(second))
        };
        let doubt = if is_clear {
            ""
        } else {
            " (too few runs or too close to tell)"
        };
        let first = format!("{} settles in {}", name(first), duration(least.value));
        let words = format!("{place}: {first}, {other}{doubt}");
        told.push((is_clear, next.value / least.value, words));
    }
    if told.is_empty() {
        return Some(
            "One client closed each loop here, so there is nothing to compare.".to_owned(),
        );
    }
    told.sort_by(|one, other| {
        (other.0, other.1)
            .partial_cmp(&(one.0, one.1))
            .unwrap_or(Ordering::Equal)
    });
    let more = told.len().saturating_sub(NAMED);
    let named: Vec<String> = told
        .into_iter()
        .take(NAMED)
        .map(|(_, _, words)| words)
        .collect();
    let mut words = named.join("; ") + ".";
    if more > 0 {
        words += &format!(" {more} more places are in the table.");
    }
    Some(words)
}

/// Topology, and system and rate where they vary.
fn place(one: &Loop<'_>, loops: &[Loop<'_>]) -> String {
    let mut words = one.topology.to_owned();
    if loops.iter().any(|other| other.system != one.system) {
        words += &format!(", {}", one.system);
    }
    if loops.iter().any(|other| other.h_ns != one.h_ns) {
        words += &format!(", {}", one.rate);
    }
    words
}

/// Settling and error over each link against those without one, and the link's share of the delay.
fn cost(campaign: &Campaign, loops: &[Loop<'_>], delays: &[Delays<'_>]) -> Option<String> {
    let over_links = || {
        loops
            .iter()
            .filter(|one| !campaign.plan.is_loopback(one.topology))
    };
    // What cost most comes first.
    let mut told: Vec<(f64, String)> = Vec::new();
    for one in over_links() {
        let Some(of) = baseline(campaign, loops, one)
            .filter(|of| campaign.plan.is_loopback(of.topology) && of.client == one.client)
            .filter(|of| of.setup == one.setup)
        else {
            continue;
        };
        let (Some(own), Some(without)) = (one.group.settling_ms(), of.group.settling_ms()) else {
            continue;
        };
        let error = |of: &Loop<'_>| of.group.median(|run| run.summary.iae_s);
        let times = error(one)
            .zip(error(of))
            .and_then(|(own, without)| own.times(without));
        let settles = if own.value.is_finite() {
            format!(
                "settling {} instead of {}",
                duration(own.value),
                duration(without.value)
            )
        } else {
            "it does not settle".to_owned()
        };
        let error = times.map_or(String::new(), |times| {
            format!(", IAE {} ×", significant(times.value, 2))
        });
        let by = own.value / without.value;
        told.push((by, format!("{}: {settles}{error}", place(one, loops))));
    }
    told.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    let more = told.len().saturating_sub(NAMED);
    let named: Vec<String> = told
        .into_iter()
        .take(NAMED)
        .map(|(_, words)| words)
        .collect();
    let mut words = if named.is_empty() {
        String::new()
    } else {
        named.join("; ") + ". "
    };
    if more > 0 {
        words += &format!("{more} more are in the table. ");
    }
    let shares: Vec<String> = delays
        .iter()
        .filter(|of| !campaign.plan.is_loopback(of.topology))
        .filter_map(|of| {
            let whole: f64 = of.parts_ms?.iter().sum();
            Some((of, whole, of.link_ms()?))
        })
        .filter({
            // One loop for each link: the others' share is much the same.
            let mut known: Vec<&str> = Vec::new();
            move |(of, _, _)| {
                let is_new = !known.contains(&of.topology);
                known.push(of.topology);
                is_new
            }
        })
        .map(|(of, whole, link)| {
            let (link, whole) = (duration(link), duration(whole));
            format!("{link} of {whole} on {} ({})", of.topology, of.label)
        })
        .take(NAMED)
        .collect();
    if !shares.is_empty() {
        words += &format!(
            "Of the time from a measurement to its effect the link took {}.",
            shares.join(", ")
        );
    }
    let words = words.trim_end();
    if words.is_empty() {
        let is_local = over_links().next().is_none();
        return is_local.then(|| "There was no network: all loops ran on one machine.".to_owned());
    }
    Some(words.to_owned())
}
