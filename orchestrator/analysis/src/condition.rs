//! The columns that say which cell a row is of: where, who, with which settings, at which rate.

use plan::SetBy;

use crate::layout::{Column, number, text};
use crate::summary::Summary;

/// The columns; what all rows share is said above the table.
pub(crate) const COLUMNS: [Column; 8] = [
    text("topology").once(""),
    text("system").once(""),
    text("client").once(""),
    text("setup").once(""),
    text("changed").once(""),
    text("fault").unless_all(""),
    text("mode").once(""),
    number("", "rate").once(""),
];

/// The entries of a row in these columns.
///
/// The words of its setup are in four columns, so that each can be said once: the system, the preset, the
/// settings that the experiment changed, and the fault.
pub(crate) fn entries(row: &Summary) -> [String; 8] {
    let changed = row.setup.only(&[SetBy::Plant, SetBy::Client]);
    [
        row.topology.clone(),
        row.system.clone(),
        row.client.to_string(),
        row.setup.only(&[SetBy::Preset]).to_string(),
        if changed.is_empty() {
            "-".to_owned()
        } else {
            changed.to_string()
        },
        row.fault.clone().unwrap_or_default(),
        row.mode.to_string(),
        row.rate.clone(),
    ]
}
