//! A row: a promise, what was asked of it, and the commands that measure it.

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

impl Row {
    /// Runs the commands and returns what they print of this row.
    pub(crate) fn measure(&self) -> Result<String, String> {
        let mut figures = Vec::new();
        for command in &self.commands {
            println!("  $ {command}");
            figures.extend(self.run(command)?);
        }
        if figures.is_empty() {
            return Err(format!("no command printed a line `row {}: `", self.number));
        }
        Ok(figures.join("; "))
    }

    fn run(&self, command: &str) -> Result<Vec<String>, String> {
        let mut child = Command::new("sh")
            .args(["-c", &format!("{command} 2>&1")])
            .current_dir(ROOT)
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|problem| problem.to_string())?;
        let marker = format!("row {}: ", self.number);
        let (mut figures, mut last) = (Vec::new(), String::new());
        let output = child.stdout.take().map(BufReader::new);
        for line in output
            .into_iter()
            .flat_map(BufRead::lines)
            .map_while(Result::ok)
        {
            // The test runner's own words may stand before it.
            if let Some((_, words)) = line.split_once(&marker) {
                figures.push(words.trim().to_owned());
            }
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
}
