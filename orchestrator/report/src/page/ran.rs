//! Every run: a line each, by topology and client, with its details folded in.

use analysis::{Campaign, Run};
use maud::{Markup, html};

use super::badge;
use super::detail;
use super::place::anchor;
use crate::number::duration;

/// The runs of one topology, client, setup, mode and rate.
type Group<'a> = Vec<&'a Run>;

pub(super) fn render(campaign: &Campaign) -> Option<Markup> {
    if campaign.runs.is_empty() {
        return None;
    }
    let mut topologies: Vec<(&str, Vec<Group<'_>>)> = Vec::new();
    for run in &campaign.runs {
        let topology = run.cell.topology.as_str();
        if !topologies.iter().any(|(name, _)| *name == topology) {
            topologies.push((topology, Vec::new()));
        }
        let Some((_, groups)) = topologies.iter_mut().find(|(name, _)| *name == topology) else {
            continue;
        };
        match groups
            .iter_mut()
            .find(|group| group.first().is_some_and(|first| is_like(first, run)))
        {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    for (_, groups) in &mut topologies {
        groups.sort_by_key(|group| group.first().map(|run| run.cell.client));
    }
    Some(html! {
        p {
            "A line for each run: how it ended, what became of its loop, settling, messages sent of \
             due, and the median round trip of a message. Certificate and checksums are inside; the raw rows are in " code { "cells/" } " beside the report."
        }
        @for (topology, groups) in &topologies {
            h3 { (topology) }
            @for group in groups { (folded(campaign, group)) }
        }
    })
}

fn is_like(one: &Run, other: &Run) -> bool {
    let key = |run: &Run| {
        let cell = &run.cell;
        (cell.client, cell.settings.mode, cell.settings.h.ns())
    };
    key(one) == key(other) && one.summary.setup == other.summary.setup
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
                @if let Some(rtt) = summary.message_rtt_p50_ms { span { "RTT " (duration(rtt)) } }
            }
            (detail::render(campaign, run))
        }
    }
}
