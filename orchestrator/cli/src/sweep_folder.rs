//! A sweep's results folder: what it is of, and the rows that are done.
//!
//! Rows are added at the end of `points.csv` in the order in which they come. When all are there
//! they are put in the order of their numbers, so that the file does not tell how it was made.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::{Context, anyhow};
use serde_json::{Map, Value};
use sweep::{Row, Sweep};

use crate::exit::Failure;
use crate::folder::Folder;

/// What the folder is of.
const MANIFEST: &str = "manifest.json";
/// The rows.
const POINTS: &str = "points.csv";

/// A folder that this process, and no other, writes to.
pub(crate) struct SweepFolder<'a> {
    sweep: &'a Sweep,
    folder: Folder,
    file: File,
    /// The rows that are there, in the order of the file.
    rows: Vec<Row>,
}

impl<'a> SweepFolder<'a> {
    /// Opens a folder for a sweep: a new one, or one with the same sweep to be continued. `identity`
    /// is all that its rows follow from.
    ///
    /// # Errors
    /// When it belongs to something else, is in use, is damaged or cannot be written; exit code 2.
    pub(crate) fn open(
        sweep: &'a Sweep,
        identity: &Map<String, Value>,
        path: &Path,
    ) -> Result<SweepFolder<'a>, Failure> {
        SweepFolder::try_open(sweep, identity, path).map_err(Failure::usage)
    }

    fn try_open(
        sweep: &'a Sweep,
        identity: &Map<String, Value>,
        path: &Path,
    ) -> anyhow::Result<SweepFolder<'a>> {
        let folder = Folder::open(path, MANIFEST)?;
        match folder.identity()? {
            Some(text) => check(&text, identity, path)?,
            None => folder.identify(&json(identity))?,
        }
        let path = folder.path().join(POINTS);
        let (rows, whole) = read(sweep, &path)?;
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .with_context(|| folder.full(POINTS))?;
        match whole {
            // A killed run's last row may be torn; appending behind it would spoil the next.
            Some(bytes) => file.set_len(bytes),
            None => writeln!(file, "{}", sweep.header()),
        }
        .with_context(|| folder.full(POINTS))?;
        Ok(SweepFolder {
            sweep,
            folder,
            file,
            rows,
        })
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Folder {
        &self.folder
    }

    /// The rows that are there.
    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The numbers of the runs that are not there, in order.
    pub(crate) fn pending(&self) -> Vec<usize> {
        let mut is_there = vec![false; self.sweep.runs()];
        for row in &self.rows {
            is_there[self.sweep.number(row.run)] = true;
        }
        let numbers = is_there.iter().enumerate();
        numbers
            .filter(|(_, there)| !**there)
            .map(|(n, _)| n)
            .collect()
    }

    /// Adds rows.
    pub(crate) fn add(&mut self, rows: &[Row]) -> anyhow::Result<()> {
        let mut text = String::new();
        for row in rows {
            text += &self.sweep.line(row);
            text.push('\n');
        }
        self.file
            .write_all(text.as_bytes())
            .with_context(|| self.folder.full(POINTS))?;
        self.rows.extend_from_slice(rows);
        Ok(())
    }

    /// Puts the rows in the order of their numbers; all are there.
    pub(crate) fn settle(&mut self) -> anyhow::Result<()> {
        let sweep = self.sweep;
        self.rows.sort_by_key(|row| sweep.number(row.run));
        // As they are read again, so that a sweep in one go and a continued one are told alike.
        let mut text = sweep.header() + "\n";
        for row in &mut self.rows {
            let line = sweep.line(row);
            *row = sweep.read(&line).map_err(|problem| anyhow!(problem))?;
            text += &line;
            text.push('\n');
        }
        backend::write_whole(&self.folder.path().join(POINTS), text.as_bytes())?;
        Ok(())
    }
}

/// The rows of a file, and how many of its bytes are whole lines; `None` where there is no file yet.
fn read(sweep: &Sweep, path: &Path) -> anyhow::Result<(Vec<Row>, Option<u64>)> {
    let named = path.display();
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok((Vec::new(), None)),
        Err(problem) => {
            return Err(anyhow!(
                "cannot read {named}: {problem}; choose another folder with --out"
            ));
        }
    };
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    if whole == 0 {
        // Not even the header: as good as no file.
        fs::remove_file(path).with_context(|| format!("cannot write {named}"))?;
        return Ok((Vec::new(), None));
    }
    if whole < text.len() {
        eprintln!("webloop: the last row of {named} is torn; it is dropped and run again");
    }
    let mut rows: Vec<Row> = Vec::new();
    let mut is_there = vec![false; sweep.runs()];
    for (line, content) in text[..whole].lines().enumerate() {
        let damaged = |problem: &str| {
            anyhow!(
                "{named}:{}: {problem}; delete the line, and its run is made again",
                line + 1
            )
        };
        if line == 0 {
            if content != sweep.header() {
                return Err(damaged("this is not the header of the sweep's rows"));
            }
            continue;
        }
        let row = sweep.read(content).map_err(|problem| damaged(&problem))?;
        let there = &mut is_there[sweep.number(row.run)];
        if *there {
            return Err(damaged("this run is there already"));
        }
        *there = true;
        rows.push(row);
    }
    Ok((rows, Some(whole as u64)))
}

/// Whether a folder is of the same sweep.
fn check(text: &str, identity: &Map<String, Value>, folder: &Path) -> anyhow::Result<()> {
    let named = folder.display();
    let before: Map<String, Value> = serde_json::from_str(text).map_err(|problem| {
        anyhow!("{named}/{MANIFEST} is damaged: {problem}; choose another folder with --out")
    })?;
    for (key, own) in identity {
        let other = before.get(key).unwrap_or(&Value::Null);
        if own != other {
            return Err(anyhow!(
                "{named} holds the results of another sweep: its {key} is {other}, and this one's \
                 is {own}; choose another folder with --out"
            ));
        }
    }
    Ok(())
}

/// A manifest as a file's text.
pub(crate) fn json(manifest: &Map<String, Value>) -> String {
    // Plain data of strings and finite numbers: serialising it cannot fail.
    serde_json::to_string_pretty(manifest).unwrap_or_default() + "\n"
}
