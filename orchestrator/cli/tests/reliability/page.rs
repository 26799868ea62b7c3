//! docs/reliability.md, made of rows and figures.

use std::fmt::Write;

use crate::figure::Figures;
use crate::row::Row;

pub(crate) const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reliability.md");

const HEAD: &str = "# Reliability in figures

What webloop promises when things go wrong, what was asked of each promise, and what was measured. The suite writes this page: `just faults` measures every row anew, which takes hours, and `just faults 5 17` these two.

The figures are of a shared virtual machine with two cores, on which attacker, loop and the network's player share the processors. Each is what its commands printed on that day, at that commit (`+`: and what was changed since). The commands are typed in a clone, as root, with what [CONTRIBUTING.md](../CONTRIBUTING.md) says some tests need.
";

/// The page's text.
pub(crate) fn text(rows: &[Row], figures: &Figures) -> String {
    let mut page = HEAD.to_owned();
    page += "\n| row | promise | reached |\n|---|---|---|\n";
    for row in rows {
        let reached = match (figures.get(row.number), row.short.is_empty()) {
            (None, _) => "not measured",
            (Some(_), true) => "yes",
            (Some(_), false) => "in part",
        };
        let _ = writeln!(page, "| {} | {} | {reached} |", row.number, row.promise);
    }
    for row in rows {
        let _ = write!(page, "\n## {}. {}\n\n", row.number, sentence(&row.promise));
        let _ = write!(page, "Asked: {}.\n\n", row.asked);
        if let Some(figure) = figures.get(row.number) {
            let _ = write!(
                page,
                "Measured on {}, at {}:\n\n",
                figure.day, figure.commit
            );
            for line in figure.measured.lines() {
                let _ = writeln!(page, "- {line}");
            }
            page += "\n";
        }
        if !row.short.is_empty() {
            let _ = write!(page, "What is short: {}\n\n", row.short);
        }
        page += "```sh\n";
        for command in &row.commands {
            let _ = writeln!(page, "{command}");
        }
        page += "```\n";
    }
    page
}

/// The same words with a capital.
fn sentence(words: &str) -> String {
    let mut characters = words.chars();
    let first = characters.next().map(|first| first.to_ascii_uppercase());
    first.into_iter().chain(characters).collect()
}
