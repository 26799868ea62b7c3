//! Every run: a line each, by topology and client, with its details folded in.

use analysis::{Campaign, Run, grouped};
use maud::{Markup, html};

use super::badge;
use super::detail;
use super::place::anchor;
use crate::number::duration;

pub(super) fn render(campaign: &Campaign) -> Option<Markup> {
    if campaign.runs.is_empty() {
        return None;
    }
    let topologies = grouped(&campaign.runs, |run| run.cell.topology.as_str());
    let topologies = topologies.into_iter().map(|(topology, runs)| {
        let mut groups = grouped(runs, |run| run.summary.condition());
        groups.sort_by_key(|(condition, _)| condition.client);
        (topology, groups)
    });
    Some(html! {
        p {
            "A line for each run: how it ended, what became of its loop, settling, messages sent of \
             due, and the median round trip of a message. Certificate and checksums are inside; the raw rows are in " code { "cells/" } " beside the report."
        }
        @for (topology, groups) in topologies {
            h3 { (topology) }
            @for (_, group) in &groups { (folded(campaign, group)) }
        }
    })
}

fn folded(campaign: &Campaign, group: &[&Run]) -> Markup {
    let Some(first) = group.first() else {
        return html! {};
    };
    let complete = group.iter().filter(|run| run.is_complete()).count();
    let summary = &first.summary;
    html! {
        details.group {
            summary {
                b { (summary.client) } " " span.setup { (summary.setup) }
                span { (summary.mode) } span { (summary.rate) }
                span.fine { (complete) " of " (group.len()) " complete" }
            }
            (detail::settings(first))
            @for run in group { (line(campaign, run)) }
        }
    }
}

/// The median round trip of a run's messages; if it falls among those without an answer, that it is beyond the
/// time-out.
fn rtt(run: &Run) -> Option<String> {
    let summary = &run.summary;
    let rtt_ms = summary.or_never(0.5, summary.message_rtt_p50_ms)?;
    let timeout_ms = run.cell.settings.timeout_ns as f64 / 1e6;
    Some(if rtt_ms.is_finite() {
        duration(rtt_ms)
    } else {
        format!("> {}", duration(timeout_ms))
    })
}

fn line(campaign: &Campaign, run: &Run) -> Markup {
    let summary = &run.summary;
    html! {
        details.run id=(anchor(run)) {
            summary {
                span.repeat { "r" (format!("{:02}", run.cell.repeat)) }
                span { (badge::of_run(run.verdict())) }
                @if let Some(verdict) = summary.loop_verdict { span { (badge::of_loop(verdict)) } }
                @if let Some(settling) = summary.settling_ms { span { "settled in " (duration(settling)) } }
                @if let Some(sent) = summary.messages_sent { span { "sent " (sent) " of " (summary.messages_due) } }
                @if let Some(rtt) = rtt(run) { span { "RTT " (rtt) } }
            }
            (detail::render(campaign, run))
        }
    }
}
