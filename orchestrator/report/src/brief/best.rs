//! Which client is best, wherever several closed the same loop.

use std::cmp::Ordering;

use super::{NAMED, place};
use crate::group::Estimate;
use crate::loops::Loop;
use crate::number::duration;

/// The quickest client where several closed the same loop; `None` if none can be compared.
pub(super) fn best(loops: &[Loop<'_>]) -> Option<String> {
    let places = analysis::grouped(loops, |one| (one.topology, one.system, one.fault, one.h_ns));
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
        return None;
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
        words += &match more {
            1 => " 1 more place is in the table.".to_owned(),
            more => format!(" {more} more places are in the table."),
        };
    }
    Some(words)
}
