//! The machines that the runs were made on, and the versions of what ran there.

use analysis::{Campaign, grouped};
use maud::{Markup, html};
use record::{ControllerReport, Manifest};

use super::scroll::scroll;

pub(super) fn render(campaign: &Campaign) -> Option<Markup> {
    let manifests = || campaign.runs.iter().filter_map(|run| run.manifest.as_ref());
    let places = grouped(manifests().map(place), Clone::clone);
    if places.is_empty() {
        return None;
    }
    let clients = grouped(manifests().filter_map(client), Clone::clone);
    Some(html! {
        @for (place, runs) in &places {
            dl.facts {
                @for (name, value) in place { div { dt { (name) } dd { (value) } } }
                div { dt { "runs" } dd { (runs.len()) } }
            }
        }
        @if !clients.is_empty() { (scroll("Clients", &versions(&clients))) }
    })
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
        (
            "kept awake",
            if machine.awake { "yes" } else { "" }.to_owned(),
        ),
        ("back-end", manifest.backend.clone()),
        ("namespaces by", manifest.authority.clone()),
        ("engine", manifest.engine.clone().unwrap_or_default()),
        ("webloop", manifest.webloop.clone()),
    ];
    facts.retain(|(_, value)| !value.is_empty());
    facts
}

/// A client, and the version of what it runs in.
type Client = (String, String);

fn client(manifest: &Manifest) -> Option<Client> {
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

fn versions(clients: &[(Client, Vec<Client>)]) -> Markup {
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
                    tr { th scope="row" { (client) } td { (version) } td.number { (runs.len()) } }
                }
            }
        }
    }
}
