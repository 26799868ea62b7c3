//! Checks the README and the book: their links lead somewhere, their commands run, their tables are
//! those of results/, and their reference is made from schemas and help texts.
//!
//! Commands that need a network, a container or a browser are only parsed.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

mod command;
mod number;
mod page;
mod point;
mod reference;

use std::collections::BTreeSet;
use std::fs;

use page::{Page, ROOT};

#[test]
fn each_link_leads_to_a_file() {
    for page in Page::all() {
        for target in page.links() {
            let path = page.folder().join(&target);
            assert!(path.exists(), "{} links to {target}", page.name);
        }
    }
}

#[test]
fn each_page_is_in_the_contents() {
    let contents = Page::read("docs/SUMMARY.md");
    let listed: BTreeSet<String> = contents.links().map(|to| format!("docs/{to}")).collect();
    let there = Page::all().map(|page| page.name);
    let there: BTreeSet<String> = there
        .filter(|name| name.starts_with("docs/") && !name.starts_with("docs/decisions/"))
        .filter(|name| name != "docs/SUMMARY.md")
        .collect();
    assert_eq!(there, listed);
}

/// Maximum characters of a paragraph: a reader gives up on a longer one.
const LONGEST_PARAGRAPH: usize = 500;

#[test]
fn no_paragraph_is_long() {
    for page in Page::all().filter(Page::is_written_by_hand) {
        for paragraph in page.paragraphs() {
            let length = paragraph.chars().count();
            assert!(
                length <= LONGEST_PARAGRAPH,
                "{}: {length} characters: {paragraph}",
                page.name
            );
        }
    }
}

#[test]
fn each_line_of_a_table_of_runs_is_in_results() {
    let folders = ["settling", "smoke", "clients", "quick"];
    let tables = folders.map(|folder| format!("{folder}/table.txt"));
    let tables: String = tables
        .iter()
        .map(String::as_str)
        .chain(["bench/bench.txt"])
        .map(|file| fs::read_to_string(format!("{ROOT}/results/{file}")).unwrap())
        .collect();
    let mut lines = 0;
    for page in Page::all() {
        for line in page.blocks("text").flat_map(|block| block.text.lines()) {
            let mut words = line.split_whitespace();
            let is_row = words.any(|word| word == "kHz" || word == "Hz");
            if is_row {
                assert!(tables.contains(line), "{}: {line}", page.name);
                lines += 1;
            }
        }
    }
    assert!(lines > 20, "{lines}");
}

/// The folders whose rows are in today's columns; a run before them left its table as it was then.
const TABLES: [&str; 3] = ["smoke", "quick", "systems"];

#[test]
fn a_table_of_results_is_the_one_of_its_rows() {
    for folder in TABLES {
        let path = format!("{ROOT}/results/{folder}/table.txt");
        let table = number::table(folder);
        if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
            fs::write(&path, &table).unwrap();
        }
        assert!(
            fs::read_to_string(&path).unwrap() == table,
            "{path}: WEBLOOP_TEST_WRITE=1 writes it anew"
        );
    }
}

#[test]
fn a_table_that_is_quoted_whole_is_that_of_results() {
    for (page, folder) in [
        ("docs/first-run.md", "quick"),
        ("docs/measured.md", "smoke"),
    ] {
        let table = fs::read_to_string(format!("{ROOT}/results/{folder}/table.txt")).unwrap();
        let text = fs::read_to_string(format!("{ROOT}/{page}")).unwrap();
        assert!(
            text.contains(&format!("```text\n{table}```")),
            "{page}: not the table of {folder}"
        );
    }
}

#[test]
fn each_number_in_a_sentence_is_that_of_results() {
    for (name, sentence) in number::sentences() {
        let page = fs::read_to_string(format!("{ROOT}/{name}")).unwrap();
        assert!(page.contains(&sentence), "{name}: {sentence}");
    }
}

#[test]
fn each_command_is_one() {
    for page in Page::all() {
        command::check(&page);
    }
}

#[test]
fn the_reference_is_made_from_schemas_and_help() {
    let is_to_write = std::env::var_os("WEBLOOP_TEST_WRITE").is_some();
    for (name, text) in reference::pages() {
        let path = format!("{ROOT}/docs/reference/{name}.md");
        if is_to_write {
            fs::create_dir_all(format!("{ROOT}/docs/reference")).unwrap();
            fs::write(&path, &text).unwrap();
        }
        let there = fs::read_to_string(&path).unwrap_or_default();
        assert!(there == text, "{path}: WEBLOOP_TEST_WRITE=1 writes it anew");
    }
}
