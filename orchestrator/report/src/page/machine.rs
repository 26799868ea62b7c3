//! The machines that the runs were made on, and the versions of what ran there.

use analysis::Campaign;
use manifest::{ControllerReport, Manifest};
use maud::{Markup, html};

use super::scroll::scroll;

pub(super) fn render(campaign: &Campaign) -> Option<Markup> {
    let manifests = || campaign.runs.iter().filter_map(|run| run.manifest.as_ref());
    let places = counted(manifests().map(place));
    if places.is_empty() {
        return None;
    }
    let clients = counted(manifests().filter_map(client));
    Some(html! {
        @for (place, runs) in &places {
            dl.facts {
                @for (name, value) in place { div { dt { (name) } dd { (value) } } }
                div { dt { "runs" } dd { (runs) } }
            }
        }
        @if !clients.is_empty() { (scroll("Clients", &versions(&clients))) }
    })
}

/// Equal values once each, in order of their first, and how often they came.
fn counted<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<(T, usize)> {
    let mut counts: Vec<(T, usize)> = Vec::new();
    for value in values {
        match counts.iter_mut().find(|(same, _)| *same == value) {
            Some((_, count)) => *count += 1,
            None => counts.push((value, 1)),
        }
    }
    counts
}

fn place(manifest: &Manifest) -> Vec<(&'static str, String)> {
    let machine = &manifest.machine;
    let mut facts = vec![
        ("processor", machine.processor.clone()),
        ("cores", machine.cores.to_string()),
        ("memory", format!("{} MiB", machine.memory_mib)),
        ("kernel", machine.kernel.clone()),
        ("architecture", machine.architecture.clone()),
        ("clock source", machine.clock_source.clone()),
        ("back-end", manifest.backend.clone()),
        ("namespaces by", manifest.authority.clone()),
        ("engine", manifest.engine.clone().unwrap_or_default()),
        ("webloop", manifest.webloop.clone()),
    ];
    facts.retain(|(_, value)| !value.is_empty());
    facts
}

/// A client, and the version of what it runs in.
fn client(manifest: &Manifest) -> Option<(String, String)> {
    let version = match (&manifest.page, &manifest.controller) {
        (Some(page), _) => page.user_agent.clone(),
        (None, Some(ControllerReport::Python(of))) => {
            format!("{} {}", of.implementation, of.python)
        }
        (None, Some(_)) => format!("webloop {}", manifest.webloop),
        (None, None) => return None,
    };
    Some((manifest.cell.client.to_string(), version))
}

fn versions(clients: &[((String, String), usize)]) -> Markup {
    html! {
        table {
            caption.unseen { "Clients" }
            thead {
                tr {
                    th scope="col" { "client" }
                    th scope="col" { "version" }
                    th.number scope="col" { "runs" }
                }
            }
            tbody {
                @for ((client, version), runs) in clients {
                    tr { th scope="row" { (client) } td { (version) } td.number { (runs) } }
                }
            }
        }
    }
}
