//! A sweep's results folder: its identity and the rows done so far. `findings` has what is computed
//! from them.
//!
//! Rows are appended to `points.csv` in the order in which they are done. Once all are there they
//! are sorted by number, so that the file does not depend on how it was made.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use backend::Timings;
use serde_json::{Map, Value, json};
use sweep::{Instead, Row, Sweep, checksum};

use crate::error::Error;
use crate::folder::Folder;
use crate::open_error::OpenError;

use identity::{MANIFEST, check, identity, manifest};
use record::file;
use record::folder::write_whole;

mod identity;

/// The file of rows.
const POINTS: &str = "points.csv";

/// A sweep's folder that only this process writes to.
#[derive(Debug)]
pub struct SweepFolder<'a> {
    sweep: &'a Sweep,
    folder: Folder,
    /// Everything that determines its rows.
    identity: Map<String, Value>,
    file: File,
    /// The rows done so far, in the order of the file.
    rows: Vec<Row>,
    /// Whether the last row was torn and has been dropped.
    is_torn: bool,
}

impl<'a> SweepFolder<'a> {
    /// Opens a folder for the sweep of this text: a new one, or one with the same sweep to be
    /// continued. Writes everything that determines the rows into it, so that the folder needs no
    /// other files.
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
        let mut file = file::open_or_create(&path).map_err(full)?;
        match found.whole {
            // A killed run's last row may be torn. Cut it off: the next row would be appended to it.
            Some(bytes) => file
                .set_len(bytes)
                .and_then(|()| file.seek(SeekFrom::End(0)))
                .map(drop),
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

    /// Writes what the sweep consists of: its text, timings, profiles and systems.
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

    /// Writes a file that can be deleted and made again.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn leave(&self, name: &str, content: &[u8]) -> Result<(), Error> {
        self.folder.leave(name, content)
    }

    /// The file of rows, if its last row was torn. That row was dropped, and its run is repeated.
    #[must_use]
    pub fn torn(&self) -> Option<PathBuf> {
        self.is_torn.then(|| self.folder.path().join(POINTS))
    }

    /// The rows done so far.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Numbers of the runs that have no row yet, in order.
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

    /// Appends rows.
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

    /// Sorts the rows by number, once all are there.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn settle(&mut self) -> Result<(), Error> {
        let sweep = self.sweep;
        self.rows.sort_by_key(|row| sweep.number(row.run));
        // Read each line back, so that a sweep run in one go and a continued one give the same
        // findings.
        let mut text = sweep.header() + "\n";
        for row in &mut self.rows {
            let line = sweep.line(row);
            *row = sweep.read(&line).map_err(Error::Row)?;
            text += &line;
            text.push('\n');
        }
        write_whole(&self.folder.path().join(POINTS), text.as_bytes())?;
        Ok(())
    }

    /// Records in the manifest that the sweep is complete.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn complete(mut self) -> Result<(), Error> {
        let rows = text(&self.folder.path().join(POINTS))?;
        let facts = [
            ("runs", json!(self.sweep.runs())),
            ("points_sha256", json!(checksum(&rows))),
        ];
        let facts = facts.map(|(name, value)| (name.to_owned(), value));
        self.identity.extend(facts);
        Ok(self.folder.identify(&manifest(&self.identity))?)
    }
}

/// Content of a file of rows.
#[derive(Default)]
struct Found {
    rows: Vec<Row>,
    /// Length of its whole lines in bytes; `None` if there is no file yet.
    whole: Option<u64>,
    /// Whether an incomplete line follows them.
    is_torn: bool,
}

fn text(path: &Path) -> io::Result<String> {
    io::read_to_string(file::open(path)?)
}

fn read(sweep: &Sweep, path: &Path) -> Result<Found, OpenError> {
    let text = match text(path) {
        Ok(text) => text,
        Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok(Found::default()),
        Err(problem) => {
            let path = path.to_owned();
            return Err(OpenError::Unreadable { path, problem });
        }
    };
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    if whole == 0 {
        // Not even the header is complete: the same as no file.
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
        let row = sweep
            .read(content)
            .map_err(|problem| damaged(&problem.to_string()))?;
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
