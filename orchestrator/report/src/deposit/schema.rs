//! The columns of the files that webloop writes, and their meaning.
//!
//! They are in `columns.tsv`, one per line. Names and order are those of the row types, which a test
//! checks. A report's own tables and figures describe themselves by their headers and are not there.

use plan::file_name;

use super::field::{Constraints, Field, Kind};

/// For each column: the kind of its file, its name, the type of its entries, `always` if no entry is
/// empty, the words that are allowed, and its meaning.
const COLUMNS: &str = include_str!("schema/columns.tsv");

/// The columns of a kind of file, `summary` or one of [`ROW_FILES`]; empty for an unknown kind.
#[must_use]
pub fn columns(file: &str) -> Vec<Field> {
    let lines = COLUMNS.lines().skip(1);
    lines.filter_map(|line| column(line, file)).collect()
}

/// The column on a line, if it belongs to that kind of file.
fn column(line: &'static str, file: &str) -> Option<Field> {
    let entries: Vec<&'static str> = line.split('\t').collect();
    let [of, name, kind, entry, words, description] = entries[..] else {
        return None;
    };
    (of == file).then(|| Field {
        constraints: Constraints {
            required: entry == "always",
            words: words.split_whitespace().collect(),
        },
        ..Field::new(name, Kind::of(kind), description)
    })
}

/// A kind of file that cells leave.
#[derive(Debug, Clone)]
pub struct RowFile {
    /// Name of the kind.
    pub name: &'static str,
    /// Names of the files of this kind in a cell's folder.
    pub files: &'static [&'static str],
    /// The player whose files these are; `None` if the player makes no difference.
    pub player: Option<&'static str>,
    /// What a row is.
    pub description: &'static str,
}

/// Every kind of file of rows.
pub const ROW_FILES: [RowFile; 8] = [
    RowFile {
        name: "ticks",
        files: &[file_name::TICKS],
        player: None,
        description: "The plant: a row for each tick, one every h.",
    },
    RowFile {
        name: "second",
        files: &[file_name::SECOND],
        player: None,
        description: "The plant, where it has a second input or output: a row for each tick.",
    },
    RowFile {
        name: "arrivals",
        files: &[file_name::ARRIVALS],
        player: None,
        description: "The plant: a row for each command that reached it, in order of arrival.",
    },
    RowFile {
        name: "messages",
        files: &[file_name::MESSAGES],
        player: None,
        description: "The controller: a row for each deadline and its message, in the order in \
                      which they ended.",
    },
    RowFile {
        name: "probes",
        files: &[file_name::PROBES],
        player: None,
        description: "The link's proof: a row for each echo, with the delay that the link had for \
                      it.",
    },
    RowFile {
        name: "packets",
        files: &[file_name::PACKETS],
        player: None,
        description: "The queue's history, where a link has a rate limit: a row for each packet \
                      that entered it.",
    },
    RowFile {
        name: "link",
        files: LINK_FILES,
        player: Some("user"),
        description: "The link played by webloop: a row for each way and second.",
    },
    RowFile {
        name: "link-tc",
        files: LINK_FILES,
        player: Some("tc"),
        description: "The link played by the kernel's netem: a row for each way and second.",
    },
];

/// One file if one process plays both directions, or one for each direction if two do.
const LINK_FILES: &[&str] = &[file_name::LINK, file_name::LINK_UP, file_name::LINK_DOWN];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_a_column_of_a_kind_of_file() {
        let kinds = ROW_FILES.iter().map(|kind| kind.name).chain(["summary"]);
        let known: usize = kinds.map(|kind| columns(kind).len()).sum();
        assert_eq!(known, COLUMNS.lines().count() - 1);
        for line in COLUMNS.lines().skip(1) {
            let kind = line.split('\t').nth(2).unwrap_or_default();
            let word = serde_json::to_value(Kind::of(kind)).expect("a word");
            assert_eq!(word, kind, "{line}");
        }
    }
}
