//! The rows by which a run is judged, read once more when it is over.
//!
//! What they say of the loop is the analysis' business. A file that cannot be read is an error here:
//! its writer has just ended.

use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, TickRow};
use judge::Gap;
use link::{PacketRow, Way};
use serde::de::DeserializeOwned;
use serde_json::Value;
use shaper::Pause;

use crate::{RunError, report};

/// A run's rows.
pub(crate) struct Rows {
    pub(crate) ticks: Vec<TickRow>,
    pub(crate) arrivals: Vec<ArrivalRow>,
    pub(crate) messages: Vec<MessageRow>,
}

impl Rows {
    pub(crate) fn read(folder: &Path) -> Result<Rows, RunError> {
        Ok(Rows {
            ticks: rows(&folder.join("ticks.csv"))?,
            arrivals: rows(&folder.join("arrivals.csv"))?,
            messages: rows(&folder.join("messages.csv"))?,
        })
    }
}

/// The packets that entered each way of a link with a rate limit, by way; none where nobody wrote
/// them down.
pub(crate) fn entered(folder: &Path) -> Result<[Option<Vec<PacketRow>>; 2], RunError> {
    let one = |name: &str| {
        let path = folder.join(name);
        path.exists().then(|| rows::<PacketRow>(&path)).transpose()
    };
    if let Some(both) = one("packets.csv")? {
        let (up, down) = both.into_iter().partition(|packet| packet.way == Way::Up);
        return Ok([Some(up), Some(down)]);
    }
    Ok([one("packets-up.csv")?, one("packets-down.csv")?])
}

/// When the players were held up, by their reports, and whether all had real-time scheduling.
pub(crate) fn pauses(link: Option<&Value>) -> (Vec<Gap>, bool) {
    let Some(link) = link else {
        return (Vec::new(), true);
    };
    let reports = [link, &link["up"], &link["down"]];
    let pauses = reports
        .iter()
        .filter_map(|report| serde_json::from_value::<Vec<Pause>>(report["pauses"].clone()).ok())
        .flatten()
        .map(|pause| Gap {
            t_ns: pause.t_ns,
            ns: pause.ns,
        });
    let granted = |report: &&Value| report["scheduling"].as_str().map(|word| word == "fifo");
    let real_time = reports.iter().filter_map(granted).all(|fifo| fifo);
    (pauses.collect(), real_time)
}

/// Whether a role's thread had real-time scheduling, by its report; so in virtual time, which needs none.
pub(crate) fn is_real_time(folder: &Path, role: &str, thread: &str) -> bool {
    let report = report::of_role(folder, role);
    let policy = report
        .as_ref()
        .map(|report| &report["granted"][thread]["policy"]);
    policy
        .and_then(Value::as_str)
        .is_none_or(|policy| policy == "fifo")
}

fn rows<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>, RunError> {
    let unread = |problem: csv::Error| {
        RunError::Link(format!(
            "the rows of this run cannot be read to be judged: {}: {problem}",
            path.display()
        ))
    };
    csv::Reader::from_path(path)
        .and_then(|mut reader| reader.deserialize().collect())
        .map_err(unread)
}
