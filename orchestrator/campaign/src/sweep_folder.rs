//! A sweep's results folder: what it is of, and the rows that are done. What is made of them is in
//! `findings`.
//!
//! Rows are added at the end of `points.csv` in the order in which they come. When all are there
//! they are put in the order of their numbers, so that the file does not tell how it was made.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use backend::Timings;
use serde_json::{Map, Value, json};
use sweep::{Instead, Row, Sweep, checksum};

use crate::error::Error;
use crate::folder::Folder;
use crate::open_error::OpenError;

use identity::{MANIFEST, check, identity, manifest};

mod identity;

/// The rows.
const POINTS: &str = "points.csv";

/// A folder that this process, and no other, writes to.
#[derive(Debug)]
pub struct SweepFolder<'a> {
    sweep: &'a Sweep,
    folder: Folder,
    /// All that its rows follow from.
    identity: Map<String, Value>,
    file: File,
    /// The rows that are there, in the order of the file.
    rows: Vec<Row>,
    /// Whether the last row was torn, and dropped.
    is_torn: bool,
}

impl<'a> SweepFolder<'a> {
    /// Opens a folder for a sweep of this text: a new one, or one with the same sweep to be
    /// continued. Leaves in it all that its rows follow from, so that it needs nothing else.
    ///
    /// # Errors
    /// [`OpenError`] when it belongs to something else, is in use, is damaged or cannot be written.
    pub fn open(
        sweep: &'a Sweep,
        text: &str,
        timings: &Timings,
        instead: &Instead,
        path: &Path,
    ) -> Result<SweepFolder<'a>, Error> {
        let identity = identity(sweep, text, timings, instead)?;
        let folder = SweepFolder::continue_or_begin(sweep, identity, path)?;
        folder.describe(text, timings)?;
        Ok(folder)
    }

    fn continue_or_begin(
        sweep: &'a Sweep,
        identity: Map<String, Value>,
        path: &Path,
    ) -> Result<SweepFolder<'a>, OpenError> {
        let folder = Folder::open(path, MANIFEST)?;
        match folder.identity()? {
            Some(text) => check(&text, &identity, path)?,
            None => folder.identify(&manifest(&identity))?,
        }
        let path = folder.path().join(POINTS);
        let found = read(sweep, &path)?;
        let full = |source| folder.full(POINTS, source);
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .map_err(full)?;
        match found.whole {
            // A killed run's last row may be torn; appending behind it would spoil the next.
            Some(bytes) => file.set_len(bytes),
            None => writeln!(file, "{}", sweep.header()),
        }
        .map_err(full)?;
        Ok(SweepFolder {
            sweep,
            folder,
            identity,
            file,
            rows: found.rows,
            is_torn: found.is_torn,
        })
    }

    /// Leaves what the sweep is of.
    fn describe(&self, text: &str, timings: &Timings) -> Result<(), Error> {
        self.leave("sweep.toml", text.as_bytes())?;
        if self.sweep.grid.takes_time() {
            self.leave("timings.toml", timings.to_toml().as_bytes())?;
        }
        for profile in self.sweep.grid.profiles() {
            let name = format!("profiles/{}.toml", profile.name());
            self.leave(&name, profile.source().as_bytes())?;
        }
        for system in self.sweep.grid.systems() {
            let name = format!("systems/{}.toml", system.name());
            self.leave(&name, system.text().as_bytes())?;
        }
        Ok(())
    }

    /// Leaves a file that can be deleted and made again.
    pub(crate) fn leave(&self, name: &str, content: &[u8]) -> Result<(), Error> {
        self.folder.leave(name, content)
    }

    /// The file whose last row was torn: it was dropped, and is run again.
    #[must_use]
    pub fn torn(&self) -> Option<PathBuf> {
        self.is_torn.then(|| self.folder.path().join(POINTS))
    }

    /// The rows that are there.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The numbers of the runs that are not there, in order.
    #[must_use]
    pub fn pending(&self) -> Vec<usize> {
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
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn add(&mut self, rows: &[Row]) -> Result<(), Error> {
        let mut text = String::new();
        for row in rows {
            text += &self.sweep.line(row);
            text.push('\n');
        }
        self.file
            .write_all(text.as_bytes())
            .map_err(|source| self.folder.full(POINTS, source))?;
        self.rows.extend_from_slice(rows);
        Ok(())
    }

    /// Puts the rows in the order of their numbers; all are there.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn settle(&mut self) -> Result<(), Error> {
        let sweep = self.sweep;
        self.rows.sort_by_key(|row| sweep.number(row.run));
        // As they are read again, so that a sweep in one go and a continued one are told alike.
        let mut text = sweep.header() + "\n";
        for row in &mut self.rows {
            let line = sweep.line(row);
            *row = sweep.read(&line).map_err(Error::Row)?;
            text += &line;
            text.push('\n');
        }
        backend::write_whole(&self.folder.path().join(POINTS), text.as_bytes())?;
        Ok(())
    }

    /// Says in the manifest that all is there.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn complete(mut self) -> Result<(), Error> {
        let rows = fs::read_to_string(self.folder.path().join(POINTS))?;
        let facts = [
            ("runs", json!(self.sweep.runs())),
            ("points_sha256", json!(checksum(&rows))),
        ];
        let facts = facts.map(|(name, value)| (name.to_owned(), value));
        self.identity.extend(facts);
        Ok(self.folder.identify(&manifest(&self.identity))?)
    }
}

/// What a file of rows has.
#[derive(Default)]
struct Found {
    rows: Vec<Row>,
    /// How many of its bytes are whole lines; `None` where there is no file yet.
    whole: Option<u64>,
    /// Whether there were more bytes.
    is_torn: bool,
}

fn read(sweep: &Sweep, path: &Path) -> Result<Found, OpenError> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok(Found::default()),
        Err(problem) => {
            let path = path.to_owned();
            return Err(OpenError::Unreadable { path, problem });
        }
    };
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    if whole == 0 {
        // Not even the header: as good as no file.
        fs::remove_file(path).map_err(|source| OpenError::NotRemoved {
            path: path.to_owned(),
            source,
        })?;
        return Ok(Found::default());
    }
    let mut rows: Vec<Row> = Vec::new();
    let mut is_there = vec![false; sweep.runs()];
    for (line, content) in text[..whole].lines().enumerate() {
        let damaged = |problem: &str| OpenError::DamagedRow {
            path: path.to_owned(),
            line: line + 1,
            problem: problem.to_owned(),
        };
        if line == 0 {
            if content != sweep.header() {
                return Err(damaged("the header is not that of the sweep's rows"));
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
    Ok(Found {
        rows,
        whole: Some(whole as u64),
        is_torn: whole < text.len(),
    })
}
