//! A sweep's results folder: its plan, and the rows done so far.
//!
//! Rows are appended to `points.csv` in the order in which they are done. Once all are there they
//! are sorted by number, so that the file does not depend on how it was made.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use analysis::sweep::{Row, header};
use backend::Timings;
use plan::sweep::Sweep;
use record::folder::write_whole;
use record::{FileFact, file};
use serde::{Deserialize, Serialize};

use crate::campaign_folder::CampaignFolder;
use crate::error::Error;
use crate::open_error::{FullError, OpenError};

/// The file of rows.
const POINTS: &str = "points.csv";
/// The file of the timings that they were made with, if programs take time in the sweep.
const TIMINGS: &str = "timings.toml";
/// The file that says which webloop made them, and their checksum once all are there.
const MANIFEST: &str = "manifest.json";

/// Its content.
#[derive(Serialize, Deserialize)]
struct Manifest {
    webloop: String,
    points: Option<FileFact>,
}

/// A sweep's folder that only this process writes to.
#[derive(Debug)]
pub struct SweepFolder<'a> {
    sweep: &'a Sweep,
    folder: &'a CampaignFolder,
    file: File,
    /// The rows done so far, in the order of the file.
    rows: Vec<Row>,
    /// Whether the last row was torn and has been dropped.
    is_torn: bool,
}

impl<'a> SweepFolder<'a> {
    /// Opens the rows of the sweep in the folder of its plan: none yet, or some to be continued with.
    ///
    /// # Errors
    /// [`OpenError`] when they were made with other timings, are damaged or cannot be written.
    pub fn open(
        sweep: &'a Sweep,
        timings: &Timings,
        folder: &'a CampaignFolder,
    ) -> Result<SweepFolder<'a>, Error> {
        let path = folder.path().join(POINTS);
        let found = read(sweep, &path)?;
        let timings = sweep.grid.takes_time().then(|| timings.to_toml());
        if found.whole.is_some() {
            check(folder.path(), timings.as_deref())?;
        } else {
            identify(folder, None)?;
        }
        if let Some(timings) = timings {
            folder.leave(TIMINGS, timings.as_bytes())?;
        }
        let full = |source| full(&path, source);
        let mut file = file::open_or_create(&path).map_err(full)?;
        match found.whole {
            // A killed run's last row may be torn. Cut it off: the next row would be appended to it.
            Some(bytes) => file
                .set_len(bytes)
                .and_then(|()| file.seek(SeekFrom::End(0)))
                .map(drop),
            None => writeln!(file, "{}", header(sweep)),
        }
        .map_err(full)?;
        Ok(SweepFolder {
            sweep,
            folder,
            file,
            rows: found.rows,
            is_torn: found.is_torn,
        })
    }

    /// The file of rows, if its last row was torn. That row was dropped, and its run is repeated.
    #[must_use]
    pub fn torn(&self) -> Option<PathBuf> {
        self.is_torn.then(|| self.path())
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
            text += &row.line(self.sweep);
            text.push('\n');
        }
        self.file
            .write_all(text.as_bytes())
            .map_err(|source| full(&self.path(), source))?;
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
        let mut text = header(sweep) + "\n";
        for row in &mut self.rows {
            let line = row.line(sweep);
            *row = Row::read(&line, sweep).map_err(Error::Row)?;
            text += &line;
            text.push('\n');
        }
        write_whole(&self.path(), text.as_bytes())?;
        identify(self.folder, Some(FileFact::of(text.as_bytes())?))
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(POINTS)
    }
}

fn full(path: &Path, source: io::Error) -> FullError {
    let path = path.to_owned();
    FullError { path, source }
}

/// Checks that the rows in a folder were made by this webloop, with these timings.
fn check(folder: &Path, timings: Option<&str>) -> Result<(), OpenError> {
    let before = text(&folder.join(MANIFEST)).unwrap_or_default();
    let before: Option<Manifest> = serde_json::from_str(&before).ok();
    let maker = if before.is_none_or(|before| before.webloop != env!("CARGO_PKG_VERSION")) {
        "by another webloop"
    } else if text(&folder.join(TIMINGS)).ok().as_deref() != timings {
        "with other timings"
    } else {
        return Ok(());
    };
    let path = folder.to_owned();
    Err(OpenError::OtherMaker { path, maker })
}

/// Writes who makes the rows, and their checksum once all are there.
fn identify(folder: &CampaignFolder, points: Option<FileFact>) -> Result<(), Error> {
    let manifest = Manifest {
        webloop: env!("CARGO_PKG_VERSION").to_owned(),
        points,
    };
    let text = serde_json::to_string_pretty(&manifest)? + "\n";
    folder.leave(MANIFEST, text.as_bytes())
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
            if content != header(sweep) {
                return Err(damaged("the header is not that of the sweep's rows"));
            }
            continue;
        }
        let row = Row::read(content, sweep).map_err(|problem| damaged(&problem.to_string()))?;
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
