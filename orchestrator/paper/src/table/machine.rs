//! Table 1: the machines, the paper's four and those that ran here.

use std::collections::{BTreeMap, BTreeSet};

use analysis::Campaign;
use analysis::layout::number as column;
use endpoint::report::{Policy, Scheduling};
use plan::Client;
use record::{ControllerReport, Manifest, PlantReport};

use report::table::{Entry, Table};

/// A row of the paper's Table 1: machine, Firefox, Python, processor.
const THE_PAPERS: [[&str; 4]; 4] = [
    ["arima", "6.02", "2.6.6:84292", "2.4 GHz Core 2 Duo"],
    ["buccoo", "3.6.12", "2.6.5:79063", "2.4 GHz Core i7"],
    ["couva", "3.6.13", "2.6.5:79063", "1.66 GHz Atom N450"],
    ["diego", "", "2.7.1:86832", "2.4 GHz QEMU Virtual"],
];

/// What the runs of one row have in common. Rows are sorted by these fields.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct RowKey {
    client: Client,
    program: String,
    processor: String,
    cores: usize,
    memory_mib: u64,
    kernel: String,
    clock_source: String,
    webloop: String,
    backend: String,
    client_priority: String,
    plant_priority: String,
}

pub(super) fn table(campaign: &Campaign) -> Table {
    let columns = [
        ("", "where"),
        ("", "client"),
        ("", "program"),
        ("machine", "processor"),
        ("machine", "cores"),
        ("machine", "memory/MiB"),
        ("machine", "kernel"),
        ("machine", "clock"),
        ("webloop", "version"),
        ("webloop", "back-end"),
        ("webloop", "player"),
        ("scheduled as", "client"),
        ("scheduled as", "plant"),
        ("", "runs"),
    ];
    let mut rows: Vec<Vec<Entry>> = THE_PAPERS
        .into_iter()
        .flat_map(the_papers)
        .map(|row| padded(row, columns.len()))
        .collect();
    rows.extend(here(campaign));
    Table {
        name: "table-1".to_owned(),
        title: "Table 1: the machines".to_owned(),
        notes: vec![
            "here: every run, whatever came of it.".to_owned(),
            "scheduled as: the policy and priority that the kernel granted; a browser has those of \
             a program."
                .to_owned(),
        ],
        columns: columns.map(|(group, name)| column(group, name)).into(),
        rows,
    }
}

/// The paper's machine, a row for each client that ran on it.
fn the_papers(row: [&str; 4]) -> Vec<Vec<Entry>> {
    let [machine, firefox, python, processor] = row;
    [(Client::Firefox, firefox), (Client::Python, python)]
        .into_iter()
        .filter(|(_, version)| !version.is_empty())
        .map(|(client, version)| {
            vec![
                Entry::text(format!("the paper, {machine}")),
                Entry::text(client.to_string()),
                Entry::text(format!("{} {version}", client.prose())),
                Entry::text(processor),
            ]
        })
        .collect()
}

fn padded(mut row: Vec<Entry>, length: usize) -> Vec<Entry> {
    row.resize(length, Entry::None);
    row
}

fn here(campaign: &Campaign) -> Vec<Vec<Entry>> {
    let mut kinds: BTreeMap<RowKey, (BTreeSet<&str>, u64)> = BTreeMap::new();
    for manifest in campaign.runs.iter().filter_map(|run| run.manifest.as_ref()) {
        let (players, runs) = kinds.entry(kind(manifest)).or_default();
        players.insert(&manifest.player);
        *runs += 1;
    }
    let row = |(kind, (players, runs)): (RowKey, (BTreeSet<&str>, u64))| {
        let players: Vec<&str> = players.into_iter().collect();
        vec![
            Entry::text("here"),
            Entry::text(kind.client.to_string()),
            known(kind.program),
            known(kind.processor),
            Entry::count(kind.cores as u64),
            Entry::count(kind.memory_mib),
            known(kind.kernel),
            known(kind.clock_source),
            known(kind.webloop),
            known(kind.backend),
            known(players.join(", ")),
            known(kind.client_priority),
            known(kind.plant_priority),
            Entry::count(runs),
        ]
    };
    kinds.into_iter().map(row).collect()
}

fn known(words: String) -> Entry {
    if words.is_empty() {
        Entry::None
    } else {
        Entry::Text(words)
    }
}

fn kind(manifest: &Manifest) -> RowKey {
    let machine = &manifest.machine;
    let client = manifest.cell.client;
    RowKey {
        client,
        program: program(client, manifest),
        processor: machine.processor.clone(),
        cores: machine.cores,
        memory_mib: machine.memory_mib,
        kernel: machine.kernel.clone(),
        clock_source: machine.clock_source.clone(),
        webloop: manifest.webloop.clone(),
        backend: manifest.backend.clone(),
        client_priority: priority(
            manifest
                .controller
                .as_ref()
                .and_then(ControllerReport::scheduling),
        ),
        plant_priority: priority(manifest.plant.as_ref().and_then(PlantReport::ticker)),
    }
}

/// The client's program, as its report names it; empty if it does not.
fn program(client: Client, manifest: &Manifest) -> String {
    match &manifest.controller {
        _ if client == Client::Native => format!("webloop {}", manifest.webloop),
        Some(ControllerReport::Python(of)) => format!("{} {}", of.implementation, of.python),
        Some(ControllerReport::Visit(of)) => of.browser.version.to_string(),
        Some(ControllerReport::Own(of)) => of.run.join(" "),
        Some(ControllerReport::Native(_) | ControllerReport::Model(_)) | None => String::new(),
    }
}

/// The policy and priority in a role's report, as `fifo 50`; empty if it has none.
fn priority(granted: Option<&Scheduling>) -> String {
    granted.map_or_else(String::new, |granted| {
        let policy = match granted.policy {
            Policy::Fifo => "fifo",
            Policy::Other => "other",
        };
        format!("{policy} {}", granted.priority)
    })
}
