//! The kinds of files of rows that webloop writes. Their columns are declared with their rows.
//!
//! A report's own tables and figures describe themselves by their headers and are not here.

use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use link::PacketRow;
use link::certificate::{LinkRow, TcRow};
use plan::{ProbeRow, file_name};
use text::column::Column;

/// A kind of file that cells leave.
#[derive(Debug, Clone)]
pub struct RowFile {
    /// Name of the kind.
    pub name: &'static str,
    /// Names of the files of this kind in a cell's folder.
    pub files: &'static [&'static str],
    /// The player whose files these are; `None` if the player makes no difference.
    pub player: Option<&'static str>,
    /// Its columns.
    pub columns: &'static [Column],
    /// What a row is.
    pub description: &'static str,
}

/// Every kind of file of rows.
pub const ROW_FILES: [RowFile; 8] = [
    RowFile {
        name: "ticks",
        files: &[file_name::TICKS],
        player: None,
        columns: TickRow::SCHEMA,
        description: "The plant: a row for each tick, one every h.",
    },
    RowFile {
        name: "second",
        files: &[file_name::SECOND],
        player: None,
        columns: SecondRow::SCHEMA,
        description: "The plant, where it has a second input or output: a row for each tick.",
    },
    RowFile {
        name: "arrivals",
        files: &[file_name::ARRIVALS],
        player: None,
        columns: ArrivalRow::SCHEMA,
        description: "The plant: a row for each command that reached it, in order of arrival.",
    },
    RowFile {
        name: "messages",
        files: &[file_name::MESSAGES],
        player: None,
        columns: MessageRow::SCHEMA,
        description: "The controller: a row for each deadline and its message, in the order in \
                      which they ended.",
    },
    RowFile {
        name: "probes",
        files: &[file_name::PROBES],
        player: None,
        columns: ProbeRow::SCHEMA,
        description: "The link's proof: a row for each echo, with the delay that the link had for \
                      it.",
    },
    RowFile {
        name: "packets",
        files: &[file_name::PACKETS],
        player: None,
        columns: PacketRow::SCHEMA,
        description: "The queue's history, where a link has a rate limit: a row for each packet \
                      that entered it.",
    },
    RowFile {
        name: "link",
        files: LINK_FILES,
        player: Some("user"),
        columns: LinkRow::SCHEMA,
        description: "The link played by webloop: a row for each way and second.",
    },
    RowFile {
        name: "link-tc",
        files: LINK_FILES,
        player: Some("tc"),
        columns: TcRow::SCHEMA,
        description: "The link played by the kernel's netem: a row for each way and second.",
    },
];

/// One file if one process plays both directions, or one for each direction if two do.
const LINK_FILES: &[&str] = &[file_name::LINK, file_name::LINK_UP, file_name::LINK_DOWN];
