//! The columns that say which cell a row is of: where, who, with which settings, at which rate.

use crate::layout::{Column, number, text};
use crate::summary::Summary;

/// The columns; what all rows share is said above the table.
pub(crate) const COLUMNS: [Column; 7] = [
    text("topology").once(""),
    text("system").once(""),
    text("client").once(""),
    text("setup").once(""),
    text("changed").once(""),
    text("mode").once(""),
    number("", "rate").once(""),
];

/// The entries of a row in these columns.
///
/// The words of its setup are in three columns, so that each can be said once: the system, the preset, and
/// the settings that the experiment changed.
pub(crate) fn entries(row: &Summary) -> [String; 7] {
    let system = format!("system {}", row.system);
    let mut words = row.setup.split(", ").filter(|word| *word != system);
    let preset = words.next().unwrap_or_default().to_owned();
    let changed: Vec<&str> = words.collect();
    [
        row.topology.clone(),
        row.system.clone(),
        row.client.to_string(),
        preset,
        if changed.is_empty() {
            "-".to_owned()
        } else {
            changed.join(", ")
        },
        row.mode.to_string(),
        row.rate.clone(),
    ]
}
