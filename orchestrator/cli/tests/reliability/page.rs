//! docs/reliability.md, made of rows and figures.

use std::fmt::Write;

use crate::figure::Figures;
use crate::row::Row;

pub(crate) const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reliability.md");

const HEAD: &str = "# Reliability in figures

What webloop promises when things go wrong, what was asked of each promise, and what was measured. The suite writes this page: `just faults` measures every row anew, and `just faults 5 17` these two.

The figures are of a shared virtual machine with two cores, on which the attacker, the loop and the network's player share the processors. Each is what the last run of its commands printed, with the day and the commit; `+` means that the commit was not yet made. Where a row falls short of what was asked, it says so below.
";

/// The page's text.
pub(crate) fn text(rows: &[Row], figures: &Figures) -> String {
    let mut page = HEAD.to_owned();
    page += "\n| row | promise | asked | measured |\n|---|---|---|---|\n";
    for row in rows {
        let measured = figures.get(row.number).map_or_else(
            || "not measured".to_owned(),
            |figure| format!("{} ({}, {})", figure.measured, figure.day, figure.commit),
        );
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} |",
            row.number,
            cell(&row.promise),
            cell(&row.asked),
            cell(&measured)
        );
    }
    let mut short = rows.iter().filter(|row| !row.short.is_empty()).peekable();
    if short.peek().is_some() {
        page += "\n## Where it falls short\n\n";
        for row in short {
            let _ = writeln!(page, "- Row {}: {}", row.number, row.short);
        }
    }
    page += "\n## How each was measured\n\nIn a clone, as root, with what CONTRIBUTING.md says some tests need.\n";
    for row in rows {
        let _ = write!(page, "\nRow {}, {}:\n\n```sh\n", row.number, row.promise);
        for command in &row.commands {
            let _ = writeln!(page, "{command}");
        }
        page += "```\n";
    }
    page
}

/// Text that may stand in a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
