//! A page of Markdown, as far as these tests read one: its fenced blocks, links and paragraphs.

use std::fs;
use std::path::{Path, PathBuf};

pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A page.
pub(crate) struct Page {
    /// Its path from the root, with slashes.
    pub(crate) name: String,
    text: String,
}

/// A fenced block.
pub(crate) struct Block<'a> {
    language: &'a str,
    pub(crate) text: &'a str,
}

impl Page {
    pub(crate) fn read(name: &str) -> Page {
        Page {
            name: name.to_owned(),
            text: fs::read_to_string(format!("{ROOT}/{name}")).unwrap(),
        }
    }

    /// The README, its neighbours, and each page of the book.
    pub(crate) fn all() -> impl Iterator<Item = Page> {
        let mut names: Vec<String> = [
            "README.md",
            "ARCHITECTURE.md",
            "CONTRIBUTING.md",
            "SECURITY.md",
            "results/README.md",
        ]
        .map(str::to_owned)
        .into();
        for folder in ["docs", "docs/decisions", "docs/reference"] {
            for entry in fs::read_dir(format!("{ROOT}/{folder}")).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                if Path::new(&name).extension().is_some_and(|it| it == "md") {
                    names.push(format!("{folder}/{name}"));
                }
            }
        }
        names.into_iter().map(|name| Page::read(&name))
    }

    pub(crate) fn is_written_by_hand(&self) -> bool {
        !self.name.starts_with("docs/reference/") && self.name != "docs/reliability.md"
    }

    /// Where its links start from.
    pub(crate) fn folder(&self) -> PathBuf {
        Path::new(ROOT).join(&self.name).parent().unwrap().into()
    }

    /// Its text in pieces, in turn outside and inside of fences.
    fn pieces(&self) -> impl Iterator<Item = (bool, &str)> {
        let pieces = self.text.split("```").enumerate();
        pieces.map(|(i, piece)| (i % 2 == 1, piece))
    }

    fn prose(&self) -> impl Iterator<Item = &str> {
        let outside = self.pieces().filter(|(is_block, _)| !is_block);
        outside.map(|(_, piece)| piece)
    }

    pub(crate) fn blocks(&self, language: &str) -> impl Iterator<Item = Block<'_>> {
        self.pieces()
            .filter(|(is_block, _)| *is_block)
            .filter_map(|(_, piece)| piece.split_once('\n'))
            .map(|(language, text)| Block { language, text })
            .filter(move |block| block.language == language)
    }

    /// Targets of its links and pictures within the repository, without anchors.
    pub(crate) fn links(&self) -> impl Iterator<Item = String> {
        let starts = self.prose().flat_map(|piece| piece.split("](").skip(1));
        starts
            .filter_map(|rest| rest.split_once(')'))
            .map(|(target, _)| target.split('#').next().unwrap_or_default().to_owned())
            .filter(|target| !target.is_empty() && !target.contains(':'))
    }

    /// Paragraphs and items of lists, each of which is one line; no tables.
    pub(crate) fn paragraphs(&self) -> impl Iterator<Item = &str> {
        let lines = self.prose().flat_map(str::lines);
        lines.filter(|line| !line.starts_with('|'))
    }
}
