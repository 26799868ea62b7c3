//! The machines that the runs were made on, and the versions of what ran there.

use analysis::Campaign;
use maud::{Markup, html};
use plan::Manifest;
use serde_json::Value;

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
    let word = |report: &Option<Value>, name: &str| {
        let value = report.as_ref()?.get(name)?.as_str()?;
        Some(value.to_owned())
    };
    let browser = word(&manifest.page, "user_agent");
    let python = word(&manifest.controller, "python").map(|version| {
        match word(&manifest.controller, "implementation") {
            Some(implementation) => format!("{implementation} {version}"),
            None => version,
        }
    });
    manifest.controller.as_ref().or(manifest.page.as_ref())?;
    let version = browser.or(python);
    let version = version.unwrap_or_else(|| format!("webloop {}", manifest.webloop));
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
