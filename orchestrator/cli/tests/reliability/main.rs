//! What webloop promises of its reliability, and the figures that were measured: docs/reliability.md is made of both.
//!
//! As a test it holds the page against them and measures nothing. As a command it measures:
//!
//! ```sh
//! cargo test --release -p webloop --test reliability -- --measure        # every row; hours
//! cargo test --release -p webloop --test reliability -- --measure 5 17   # these
//! ```
//!
//! It runs the commands of `rows.toml` one after another, and keeps what they print of their row in
//! results/reliability/figures.csv, each with its day and commit.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod figure;
mod page;
mod row;

use std::fs;
use std::process::ExitCode;

use crate::figure::Figures;
use crate::row::{Printed, Row};

/// The folder of the project, in which commands are run.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let rows = row::all();
    if arguments.any(|word| word == "--measure") {
        let numbers: Vec<u32> = arguments.map(|word| word.parse().unwrap()).collect();
        measure(&rows, &numbers)
    } else {
        serial::run(
            vec![serial::test(
                "the_page_is_made_of_rows_and_figures",
                is_page_true,
            )],
            || None,
        )
    }
}

/// Measures the rows of these numbers, or all, and writes figures and page after each.
fn measure(rows: &[Row], numbers: &[u32]) -> ExitCode {
    let (mut figures, mut printed) = (Figures::read(), Printed::default());
    let mut exit = ExitCode::SUCCESS;
    for row in rows {
        if !numbers.is_empty() && !numbers.contains(&row.number) {
            continue;
        }
        println!("row {}: {}", row.number, row.promise);
        match row.measure(&mut printed) {
            Ok(words) => {
                words.lines().for_each(|line| println!("  {line}"));
                figures.put(row.number, words);
            }
            Err(problem) => {
                println!("  not measured: {problem}");
                exit = ExitCode::FAILURE;
            }
        }
        figures.write();
        fs::write(page::PATH, page::text(rows, &figures)).unwrap();
    }
    exit
}

fn is_page_true() {
    let (rows, figures) = (row::all(), Figures::read());
    let numbers: Vec<u32> = rows.iter().map(|row| row.number).collect();
    assert_eq!(numbers, (1..=26).collect::<Vec<_>>(), "a row each");
    let text = page::text(&rows, &figures);
    if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
        fs::write(page::PATH, &text).unwrap();
    }
    assert!(
        fs::read_to_string(page::PATH).unwrap_or_default() == text,
        "{}: WEBLOOP_TEST_WRITE=1 writes it anew",
        page::PATH
    );
}
