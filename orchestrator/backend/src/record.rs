//! Reads the rows by which a run is judged, once it is over.
//!
//! The analysis evaluates what they say about the loop. A file that cannot be read is an error here,
//! since its writer has just ended.

use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, TickRow};
use link::{PacketRow, Way};
use plan::file_name;
use serde::de::DeserializeOwned;

use crate::RunError;

/// A run's rows.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    pub(crate) ticks: Vec<TickRow>,
    pub(crate) arrivals: Vec<ArrivalRow>,
    pub(crate) messages: Vec<MessageRow>,
}

impl Rows {
    pub(crate) fn read(folder: &Path) -> Result<Rows, RunError> {
        Ok(Rows {
            ticks: rows(&folder.join(file_name::TICKS))?,
            arrivals: rows(&folder.join(file_name::ARRIVALS))?,
            messages: rows(&folder.join(file_name::MESSAGES))?,
        })
    }
}

/// The packets that entered each way of a link with a rate limit; `None` if they were not recorded.
pub(crate) fn entered(folder: &Path) -> Result<[Option<Vec<PacketRow>>; 2], RunError> {
    let one = |name: &str| {
        let path = folder.join(name);
        path.exists().then(|| rows::<PacketRow>(&path)).transpose()
    };
    if let Some(both) = one(file_name::PACKETS)? {
        let (up, down) = both.into_iter().partition(|packet| packet.way == Way::Up);
        return Ok([Some(up), Some(down)]);
    }
    Ok([one(file_name::PACKETS_UP)?, one(file_name::PACKETS_DOWN)?])
}

pub(crate) fn rows<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>, RunError> {
    let unread = |problem: csv::Error| RunError::Rows {
        path: path.display().to_string(),
        problem,
    };
    csv::Reader::from_path(path)
        .and_then(|mut reader| reader.deserialize().collect())
        .map_err(unread)
}
