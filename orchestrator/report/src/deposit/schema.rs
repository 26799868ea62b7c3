//! The columns of the files that webloop writes: what each means.
//!
//! Names and order are those of the row types, which a test holds them against; a report's own
//! tables and figures describe themselves by their headers and are not here.

mod end;
mod link;
mod summary;

pub use end::{arrivals, messages, packets, probes, ticks};
pub use link::{link, link_tc};
pub use summary::summary;

use super::field::{Field, Kind};

/// A kind of file that cells leave.
#[derive(Debug, Clone)]
pub struct RowFile {
    /// What it is called among the kinds.
    pub name: &'static str,
    /// What files of this kind are called in a cell's folder.
    pub files: &'static [&'static str],
    /// The player whose files these are; `None` where it makes no difference.
    pub player: Option<&'static str>,
    /// What a row is.
    pub description: &'static str,
    /// The columns.
    pub fields: fn() -> Vec<Field>,
}

/// Every kind of file of rows.
pub const ROW_FILES: [RowFile; 7] = [
    RowFile {
        name: "ticks",
        files: &["ticks.csv"],
        player: None,
        description: "The plant: a row for each tick, one every h.",
        fields: ticks,
    },
    RowFile {
        name: "arrivals",
        files: &["arrivals.csv"],
        player: None,
        description: "The plant: a row for each command that reached it, in order of arrival.",
        fields: arrivals,
    },
    RowFile {
        name: "messages",
        files: &["messages.csv"],
        player: None,
        description: "The controller: a row for each deadline and its message, in the order in \
                      which they ended.",
        fields: messages,
    },
    RowFile {
        name: "probes",
        files: &["probes.csv"],
        player: None,
        description: "The link's proof: a row for each echo, with the delay that the link had for \
                      it.",
        fields: probes,
    },
    RowFile {
        name: "packets",
        files: &["packets.csv"],
        player: None,
        description: "The queue's history, where a link has a rate limit: a row for each packet \
                      that entered it.",
        fields: packets,
    },
    RowFile {
        name: "link",
        files: LINK_FILES,
        player: Some("user"),
        description: "The link played by webloop: a row for each way and second.",
        fields: link,
    },
    RowFile {
        name: "link-tc",
        files: LINK_FILES,
        player: Some("tc"),
        description: "The link played by the kernel's netem: a row for each way and second.",
        fields: link_tc,
    },
];

/// One file where one process plays both ways, and one for each way where two do.
const LINK_FILES: &[&str] = &["link.csv", "link-up.csv", "link-down.csv"];

/// A column that may be empty.
fn sometimes(name: &str, kind: Kind, description: &str) -> Field {
    Field::new(name, kind, description)
}

/// A column that never is.
fn always(name: &str, kind: Kind, description: &str) -> Field {
    Field::new(name, kind, description).always()
}
