//! The rows by which a run is judged, once it is over.
//!
//! The analysis evaluates what they say about the loop. A file that cannot be read is an error here,
//! since its writer has just ended.

use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, TickRow};
use link::{PacketRow, Way};
use plan::file_name;
use record::ReadError;
use record::rows::all;

/// A run's rows.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    pub(crate) ticks: Vec<TickRow>,
    pub(crate) arrivals: Vec<ArrivalRow>,
    pub(crate) messages: Vec<MessageRow>,
}

impl Rows {
    pub(crate) fn read(folder: &Path) -> Result<Rows, ReadError> {
        Ok(Rows {
            ticks: all(&folder.join(file_name::TICKS), TickRow::COLUMNS)?,
            arrivals: all(&folder.join(file_name::ARRIVALS), ArrivalRow::COLUMNS)?,
            messages: all(&folder.join(file_name::MESSAGES), MessageRow::COLUMNS)?,
        })
    }
}

/// The packets that entered each way of a link with a rate limit; `None` if they were not recorded.
pub(crate) fn entered(folder: &Path) -> Result<[Option<Vec<PacketRow>>; 2], ReadError> {
    let one = |name: &str| {
        let path = folder.join(name);
        let read = || all::<PacketRow>(&path, PacketRow::COLUMNS);
        path.exists().then(read).transpose()
    };
    if let Some(both) = one(file_name::PACKETS)? {
        let (up, down) = both.into_iter().partition(|packet| packet.way == Way::Up);
        return Ok([Some(up), Some(down)]);
    }
    Ok([one(file_name::PACKETS_UP)?, one(file_name::PACKETS_DOWN)?])
}
