//! The rows by which a run is judged, once it is over.
//!
//! The analysis evaluates what they say about the loop. A file that cannot be read is an error here,
//! since its writer has just ended.

use std::path::Path;

use link::{PacketRow, Way};
use plan::file_name;
use record::rows::all;
use record::{Held, ReadError};

/// The rows that a real run left, but those of its echoes.
pub(crate) fn read(folder: &Path) -> Result<Held, ReadError> {
    let second = folder.join(file_name::SECOND);
    let has_second = second.exists();
    Ok(Held {
        ticks: all(&folder.join(file_name::TICKS))?,
        arrivals: all(&folder.join(file_name::ARRIVALS))?,
        messages: all(&folder.join(file_name::MESSAGES))?,
        second: has_second.then(|| all(&second)).transpose()?,
        ..Held::default()
    })
}

/// The packets that entered each way of a link with a rate limit; `None` if they were not recorded.
pub(crate) fn entered(folder: &Path) -> Result<[Option<Vec<PacketRow>>; 2], ReadError> {
    let one = |name: &str| {
        let path = folder.join(name);
        let read = || all::<PacketRow>(&path);
        path.exists().then(read).transpose()
    };
    if let Some(both) = one(file_name::PACKETS)? {
        let (up, down) = both.into_iter().partition(|packet| packet.way == Way::Up);
        return Ok([Some(up), Some(down)]);
    }
    Ok([one(file_name::PACKETS_UP)?, one(file_name::PACKETS_DOWN)?])
}
