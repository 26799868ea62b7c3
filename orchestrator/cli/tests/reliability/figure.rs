//! What was measured: a line a row, with its day and commit, in results/reliability/figures.csv.

use std::collections::BTreeMap;
use std::process::Command;

use jiff::Zoned;
use serde::{Deserialize, Serialize};

use crate::ROOT;

const PATH: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../results/reliability/figures.csv"
);

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Figure {
    row: u32,
    pub(crate) measured: String,
    pub(crate) day: String,
    /// The commit that was measured; with `+`, and what was changed since.
    pub(crate) commit: String,
}

/// The figures, by the number of their row.
#[derive(Debug, Default)]
pub(crate) struct Figures(BTreeMap<u32, Figure>);

impl Figures {
    pub(crate) fn read() -> Figures {
        let Ok(mut reader) = csv::Reader::from_path(PATH) else {
            return Figures::default();
        };
        let figures = reader.deserialize().map(|figure| {
            let figure: Figure = figure.unwrap();
            (figure.row, figure)
        });
        Figures(figures.collect())
    }

    pub(crate) fn get(&self, row: u32) -> Option<&Figure> {
        self.0.get(&row)
    }

    /// Puts a figure in the place of an earlier one.
    pub(crate) fn put(&mut self, row: u32, measured: String) {
        let figure = Figure {
            row,
            measured,
            day: Zoned::now().date().to_string(),
            commit: commit(),
        };
        self.0.insert(row, figure);
    }

    pub(crate) fn write(&self) {
        let mut writer = csv::Writer::from_path(PATH).unwrap();
        for figure in self.0.values() {
            writer.serialize(figure).unwrap();
        }
        writer.flush().unwrap();
    }
}

fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git")
            .args(arguments)
            .current_dir(ROOT)
            .output();
        output.map_or_else(
            |_| String::new(),
            |output| String::from_utf8_lossy(&output.stdout).trim().to_owned(),
        )
    };
    let commit = git(&["rev-parse", "--short", "HEAD"]);
    // The figures themselves change while they are measured.
    let changed = git(&[
        "status",
        "--porcelain",
        "--untracked-files=no",
        "--",
        ".",
        ":!results/reliability",
        ":!docs/reliability.md",
    ]);
    format!("{commit}{}", if changed.is_empty() { "" } else { "+" })
}
