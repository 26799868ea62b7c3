//! What the roles say of themselves when they end, and what a run is to make of it.

use std::fs;
use std::path::Path;

use plan::Client;
use serde_json::Value;
use shaper::{Edge, TcReport};

/// A role's report, if it left one.
pub(crate) fn of_role(folder: &Path, name: &str) -> Option<Value> {
    let text = fs::read_to_string(folder.join(format!("{name}.json"))).ok()?;
    serde_json::from_str(&text).ok()
}

/// How a page failed, by its own word; a browser's process alone does not tell.
pub(crate) fn page_failure(client: Client, page: Option<&Value>) -> Option<String> {
    if !client.is_browser() {
        return None;
    }
    let Some(page) = page else {
        return Some(format!("in {client} left no report at the plant"));
    };
    match page["outcome"].as_str().unwrap_or("nothing") {
        "complete" => None,
        outcome => Some(format!(
            "in {client} ended as {outcome}: {}",
            page["reason"].as_str().unwrap_or_default()
        )),
    }
}

/// The players' report: of one that played both ways, or of two that played one each, by way.
pub(crate) fn of_link(folder: &Path) -> Option<Value> {
    of_role(folder, "link").or_else(|| {
        let (up, down) = (of_role(folder, "link-up")?, of_role(folder, "link-down")?);
        Some(serde_json::json!({ "player": up["player"], "up": up, "down": down }))
    })
}

/// How exactly the link's times were kept to: webloop always does, tc says it in its reports.
pub(crate) fn edge(folder: &Path) -> Edge {
    ["link-up", "link-down"]
        .iter()
        .filter_map(|name| of_role(folder, name))
        .filter_map(|report| serde_json::from_value::<TcReport>(report).ok())
        .fold(Edge::USER, |edge, report| edge.or(report.edge()))
}

/// Who played the link, as its report says; `none` where there was no link.
pub(crate) fn played_by(link: Option<&Value>) -> String {
    link.map_or("none", |link| link["player"].as_str().unwrap_or("user"))
        .to_owned()
}

/// Packets that the player itself lost were lost by no link.
pub(crate) fn lost_by_the_player(link: Option<&Value>) -> Option<String> {
    // One player's report of both ways, or of each way a player's: `shaped` and `carried` by
    // webloop, `traffic` by tc.
    let dropped: u64 = ["up", "down"]
        .iter()
        .filter_map(|way| link?.get(way))
        .flat_map(|way| {
            ["", "/shaped", "/carried", "/traffic"]
                .map(|part| way.pointer(&format!("{part}/dropped")))
        })
        .flatten()
        .filter_map(Value::as_u64)
        .sum();
    (dropped > 0)
        .then(|| format!("the player itself lost {dropped} packets: this machine is too busy"))
}

/// Rows that the disk was too slow for are not in the files.
pub(crate) fn lost_rows(reports: &[Option<Value>; 3]) -> Option<String> {
    let lost: u64 = reports
        .iter()
        .flatten()
        .flat_map(|report| {
            ["tick_rows", "arrival_rows", "page_rows", "rows"].map(|name| &report[name]["overflow"])
        })
        .filter_map(Value::as_u64)
        .sum();
    (lost > 0).then(|| format!("{lost} rows are missing: the disk was too slow for them"))
}
