//! A row: a promise, what was asked of it, and the commands that measure it.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use serde::Deserialize;

use crate::ROOT;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Row {
    pub(crate) number: u32,
    /// What a user may rely on.
    pub(crate) promise: String,
    /// The figure that was asked for.
    pub(crate) asked: String,
    /// Lines for a shell; each prints one line `row N: figure` or more.
    pub(crate) commands: Vec<String>,
    /// Why it falls short, or what of it could not be measured; empty if nothing.
    #[serde(default)]
    pub(crate) short: String,
}

/// All rows, in order.
pub(crate) fn all() -> Vec<Row> {
    #[derive(Deserialize)]
    struct File {
        row: Vec<Row>,
    }
    let file: File = toml::from_str(include_str!("rows.toml")).unwrap();
    file.row
}

/// What the commands that were run printed of each row: several rows may share one.
#[derive(Default)]
pub(crate) struct Printed(BTreeMap<String, Result<Vec<(u32, String)>, String>>);

impl Row {
    /// Runs the commands, unless they were, and returns the lines that they print of this row.
    pub(crate) fn measure(&self, printed: &mut Printed) -> Result<String, String> {
        let mut figures = Vec::new();
        for command in &self.commands {
            println!("  $ {command}");
            let lines = printed.0.entry(command.clone());
            let lines = lines.or_insert_with(|| run(command)).clone()?;
            let own = lines.into_iter().filter(|(row, _)| *row == self.number);
            figures.extend(own.map(|(_, words)| words));
        }
        if figures.is_empty() {
            return Err(format!("no command printed a line `row {}: `", self.number));
        }
        Ok(figures.join("\n"))
    }
}

/// Runs a command. Returns its lines `row N: words`.
fn run(command: &str) -> Result<Vec<(u32, String)>, String> {
    let mut child = Command::new("sh")
        .args(["-c", &format!("{command} 2>&1")])
        .current_dir(ROOT)
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|problem| problem.to_string())?;
    let (mut figures, mut last) = (Vec::new(), String::new());
    let output = child.stdout.take().map(BufReader::new);
    let lines = output.into_iter().flat_map(BufRead::lines);
    for line in lines.map_while(Result::ok) {
        // The test runner's own words may stand before it.
        let figure = line.split_once("row ").and_then(|(_, rest)| {
            let (row, words) = rest.split_once(": ")?;
            Some((row.parse().ok()?, words.trim().to_owned()))
        });
        figures.extend(figure);
        if !line.trim().is_empty() {
            last = line;
        }
    }
    let status = child.wait().map_err(|problem| problem.to_string())?;
    if status.success() {
        Ok(figures)
    } else {
        Err(format!("`{command}` ended with {status}: {last}"))
    }
}
