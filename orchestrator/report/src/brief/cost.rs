//! What the network cost: settling and error against the same loop without one, and the link's share.

use text::significant;

use super::{NAMED, place};
use crate::delays::Delays;
use crate::loops::{Loop, baseline};
use crate::number::duration;

/// Settling and error over each link against those without one, and the link's share of the delay.
pub(super) fn cost(loops: &[Loop<'_>], delays: &[Delays<'_>]) -> Option<String> {
    let over_links = || loops.iter().filter(|one| !one.is_local);
    // What cost most comes first.
    let mut told: Vec<(f64, String)> = Vec::new();
    for one in over_links() {
        let Some(of) = baseline(loops, one)
            .filter(|of| of.is_local && of.client == one.client)
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
    let is_alone = !loops.is_empty() && loops.iter().all(|one| !one.is_local);
    let mut words = if named.is_empty() && is_alone {
        "No loop without a network ran here, so there is nothing to hold settling against: run arima beside it \
         (--topology arima). "
            .to_owned()
    } else if named.is_empty() {
        String::new()
    } else {
        named.join("; ") + ". "
    };
    if more > 0 {
        words += &match more {
            1 => "1 more is in the table. ".to_owned(),
            more => format!("{more} more are in the table. "),
        };
    }
    let shares = shares(loops, delays);
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

/// The link's share of a sample's delay, of one loop over each link.
fn shares(loops: &[Loop<'_>], delays: &[Delays<'_>]) -> Vec<String> {
    delays
        .iter()
        .filter(|of| {
            loops
                .iter()
                .any(|one| !one.is_local && one.topology == of.topology)
        })
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
        .collect()
}
