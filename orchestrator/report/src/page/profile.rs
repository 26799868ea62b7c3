//! The links: what each profile asks for, and whether the runs' links held.

use analysis::{Campaign, Run};
use link::certificate::Verdict;
use maud::{Markup, html};
use text::significant;

use super::badge::{Tone, badge};
use super::place::anchor;
use super::prose::kept;
use super::scroll::scroll;
use crate::called::called;

pub(super) fn render(campaign: &Campaign) -> Option<Markup> {
    if campaign.plan.profiles.is_empty() {
        return None;
    }
    Some(html! {
        p {
            "Echoes cross each link before, during and after a run, and each is held against the \
             delay that the link had for it. A run whose link did not hold is invalid, and nothing \
             here uses it."
        }
        (scroll("Certificates by topology", &certificates(campaign)))
        p.legend {
            "Residual: how far an echo’s round trip lay from what the link had for it at that instant; of \
             each figure the worst among the runs. A link is judged by the half: the median must lie within "
            (kept("0.5 ms")) ", and at most one echo in fifty may miss by more than " (kept("10 ms")) " and a tenth of its round \
             trip. So the 99 % may be large where the machine held an echo up for a time slice, and the link was the right one \
             all the same."
        }
        (broken(campaign))
        @for (name, text) in &campaign.plan.profiles {
            details {
                summary { "Profile " code { (name) } (about(campaign, name)) }
                pre { (text.source) }
            }
        }
    })
}

fn about(campaign: &Campaign, topology: &str) -> String {
    let profile = campaign.plan.profiles.get(topology);
    profile
        .and_then(|text| text.profile(topology).ok())
        .map_or_else(String::new, |profile| format!(": {}", profile.about()))
}

/// The sum of the certificates of one topology.
#[derive(Default)]
struct Sum {
    runs: usize,
    certificates: usize,
    held: usize,
    echoes: usize,
    answered: usize,
    median_ms: Option<f64>,
    p99_ms: Option<f64>,
    max_ms: Option<f64>,
}

fn sum(campaign: &Campaign, topology: &str) -> Sum {
    let mut sum = Sum::default();
    let own = campaign
        .runs
        .iter()
        .filter(|run| run.cell.topology == topology);
    for manifest in own.filter_map(|run| run.manifest.as_ref()) {
        sum.runs += 1;
        let Some(certificate) = &manifest.certificate else {
            continue;
        };
        sum.certificates += 1;
        sum.held += usize::from(certificate.verdict == Verdict::Holds);
        sum.echoes += certificate.sent;
        sum.answered += certificate.answered;
        let worst = |so_far: Option<f64>, own: f64| Some(so_far.map_or(own, |most| most.max(own)));
        if certificate.answered == 0 {
            continue;
        }
        let residual = certificate.residuals.rtt;
        sum.median_ms = worst(sum.median_ms, residual.median_ms);
        sum.p99_ms = worst(sum.p99_ms, residual.p99_ms);
        sum.max_ms = worst(sum.max_ms, residual.max_ms);
    }
    sum
}

fn certificates(campaign: &Campaign) -> Markup {
    html! {
        table {
            caption.unseen { "Certificates by topology" }
            thead {
                tr {
                    td rowspan="2" {}
                    th.group scope="colgroup" colspan="5" { "RTT asked for/ms" }
                    th.group scope="colgroup" colspan="2" { "certificates" }
                    th.group scope="colgroup" colspan="3" { "worst residual/ms" }
                }
                tr {
                    th.number scope="col" { "min" }
                    th.number scope="col" { "avg" }
                    th.number scope="col" { "max" }
                    th.number scope="col" { "sd" }
                    th.number scope="col" { "loss/%" }
                    th scope="col" { "held" }
                    th.number scope="col" { "echoes" }
                    th.number scope="col" { "median" }
                    th.number scope="col" { "99 %" }
                    th.number scope="col" { "max" }
                }
            }
            tbody { @for name in campaign.plan.profiles.keys() { (row(campaign, name)) } }
        }
    }
}

fn row(campaign: &Campaign, topology: &str) -> Markup {
    let sum = sum(campaign, topology);
    let profile = campaign.plan.profiles.get(topology);
    let profile = profile.and_then(|text| text.profile(topology).ok());
    let asked = profile.as_ref().and_then(link::Profile::asked);
    let or_none = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), |x| significant(x, 3));
    html! {
        tr {
            th scope="row" { (topology) }
            td.number { (or_none(asked.map(|asked| asked.rtt_min_ms))) }
            td.number { (or_none(asked.map(|asked| asked.rtt_avg_ms))) }
            td.number { (or_none(asked.map(|asked| asked.rtt_max_ms))) }
            td.number { (or_none(asked.map(|asked| asked.rtt_sd_ms))) }
            td.number { (asked.map_or_else(|| "–".to_owned(), |asked| significant(100.0 * asked.loss, 2))) }
            td { (held(&sum, profile.as_ref())) }
            td.number { (sum.echoes) @if sum.answered < sum.echoes { " (" (sum.echoes - sum.answered) " lost)" } }
            td.number { (or_none(sum.median_ms)) }
            td.number { (or_none(sum.p99_ms)) }
            td.number { (or_none(sum.max_ms)) }
        }
    }
}

fn held(sum: &Sum, profile: Option<&link::Profile>) -> Markup {
    match (sum.runs, sum.certificates) {
        (0, _) => badge(Tone::Quiet, "not run"),
        (_, 0) if profile.is_some_and(link::Profile::is_loopback) => badge(Tone::Quiet, "no link"),
        (_, 0) => badge(Tone::Quiet, "none"),
        (_, all) => {
            let tone = if sum.held == all {
                Tone::Good
            } else {
                Tone::Bad
            };
            badge(tone, &format!("{} of {all}", sum.held))
        }
    }
}

/// The runs whose links did not hold.
fn broken(campaign: &Campaign) -> Markup {
    let broken: Vec<&Run> = campaign
        .runs
        .iter()
        .filter(|run| {
            let manifest = run.manifest.as_ref();
            let certificate = manifest.and_then(|manifest| manifest.certificate.as_ref());
            certificate.is_some_and(|certificate| certificate.verdict != Verdict::Holds)
        })
        .collect();
    html! {
        @if !broken.is_empty() {
            p { "These did not hold:" }
            ul.ids { @for run in broken { li { a href={ "#" (anchor(run)) } { (kept(&called(campaign, run))) } } } }
        }
    }
}
