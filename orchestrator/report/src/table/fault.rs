//! What faults did to the loops: how far off, how soon safe, how soon back.

use analysis::Campaign;
use analysis::layout::{number, text};

use super::{Entry, Table};
use crate::loops::{Loop, all};

/// A row for each closed loop that met a fault; `None` if none is complete.
#[must_use]
pub fn table(campaign: &Campaign) -> Option<Table> {
    let mut loops: Vec<Loop<'_>> = all(campaign);
    loops.retain(|one| one.fault.is_some() && !one.group.runs.is_empty());
    if loops.is_empty() {
        return None;
    }
    // By fault first: the question is what each does.
    loops.sort_by_key(|one| {
        let same = campaign.runs.iter();
        let same = same.map(|run| run.cell.fault.as_deref());
        same.clone().position(|fault| fault == one.fault)
    });
    let columns = vec![
        text("fault"),
        text("topology"),
        text("system"),
        text("client"),
        number("", "rate"),
        number("", "back"),
        number("", "of"),
        number("", "worst e"),
        number("after it/ms", "safe"),
        number("after it/ms", "back"),
        number("messages", "failed"),
        number("messages", "missed"),
    ];
    let row = |one: &Loop<'_>| {
        let group = &one.group;
        let came_back = |run: &&&analysis::Run| run.recovery.is_some_and(|of| of.back_ms.is_some());
        let back = group.runs.iter().filter(came_back).count();
        let median = |figure: fn(&analysis::Run) -> Option<f64>| {
            Entry::measured(group.median(figure).map(|of| of.value), 3)
        };
        vec![
            Entry::text(one.fault.unwrap_or_default()),
            Entry::text(one.topology),
            Entry::text(one.system),
            Entry::text(one.client.to_string()),
            Entry::text(one.rate.clone()),
            Entry::count(back as u64),
            Entry::count(group.runs.len() as u64),
            median(|run| Some(run.recovery?.worst)),
            median(|run| run.recovery?.safe_ms),
            median(|run| run.recovery?.back_ms),
            median(|run| {
                Some((run.summary.messages_failed? + run.summary.messages_timeout?) as f64)
            }),
            median(|run| Some(run.summary.messages_missed? as f64)),
        ]
    };
    let mut notes = vec![
        "Medians over the complete runs. Worst e: the greatest error from the fault's beginning until the loop \
         was back. Safe: from the last command to the first tick in the plant's safe state. Back: from the \
         fault's end until the error stays within 2 % of the reference's range."
            .to_owned(),
    ];
    for (name, fault) in &campaign.plan.faults {
        notes.push(format!("{name}: {}", fault.about));
    }
    let table = Table {
        name: "faults".to_owned(),
        title: "What the faults did".to_owned(),
        notes,
        columns,
        rows: loops.iter().map(row).collect(),
    };
    Some(table.filled())
}
