//! Rows in any form of CSV: what is not in the form that webloop writes, the csv crate and serde read.

use std::cell::Cell;
use std::fmt::Display;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use text::column::Row;
use thiserror::Error;

use super::error::ReadError;
use super::line::{LINE_MAX, TOO_LONG, lacking};

/// A reader that may read `left` bytes until `left` is set again.
struct Bounded<'a, T> {
    text: T,
    left: &'a Cell<usize>,
}

impl<T: Read> Read for Bounded<'_, T> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(self.left.get());
        if most == 0 && !buffer.is_empty() {
            return Err(io::Error::new(ErrorKind::InvalidData, TOO_LONG));
        }
        let n = self.text.read(&mut buffer[..most])?;
        self.left.set(self.left.get() - n);
        Ok(n)
    }
}

/// Passes the rows after the header to `each`, in any form of CSV. Returns the number of rows.
pub(super) fn by_serde<R: Row, E: Display>(
    text: impl Read,
    mut each: impl FnMut(&R) -> Result<(), E>,
) -> Result<u64, Stop> {
    let left = Cell::new(LINE_MAX);
    let text = Bounded { text, left: &left };
    let mut reader = csv::Reader::from_reader(text);
    let header = reader.headers()?.clone();
    let is = |columns: &[&str]| header.iter().eq(columns.iter().copied());
    if lacking::<R>(is).is_none() {
        return Err(Stop::Columns {
            found: header.iter().collect::<Vec<_>>().join(","),
            expected: R::COLUMNS.join(","),
        });
    }
    let mut record = csv::StringRecord::new();
    let mut rows = 0;
    loop {
        left.set(LINE_MAX);
        let line = reader.position().line();
        match reader.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => return Ok(rows),
            Err(error) if error.is_io_error() && left.get() == 0 => {
                return Err(Stop::Row {
                    line,
                    problem: TOO_LONG.to_owned(),
                });
            }
            Err(error) => return Err(error.into()),
        }
        let line = record.position().map_or(line, csv::Position::line);
        each(&record.deserialize(Some(&header))?).map_err(|problem| Stop::Row {
            line,
            problem: problem.to_string(),
        })?;
        rows += 1;
    }
}

/// Why [`by_serde`] did not reach the end of the file.
#[derive(Debug, Error)]
pub(super) enum Stop {
    #[error(transparent)]
    Csv(#[from] csv::Error),
    #[error("{found} where {expected} should be")]
    Columns { found: String, expected: String },
    #[error("line {line}: {problem}")]
    Row { line: u64, problem: String },
}

impl Stop {
    /// The error with its place in the file at `path`, with these columns, of which `before` rows had already been read.
    pub(super) fn at(self, path: &Path, before: u64, columns: &[&str]) -> ReadError {
        let path = path.to_owned();
        match self {
            Stop::Columns { found, expected } => ReadError::Columns {
                path,
                found,
                expected,
            },
            Stop::Row { line, problem } => ReadError::Row {
                path,
                line: before + line,
                problem,
            },
            Stop::Csv(error) => match error.position().map(csv::Position::line) {
                Some(line) => ReadError::Row {
                    path,
                    line: before + line,
                    problem: problem(&error, columns),
                },
                None => ReadError::File {
                    path,
                    source: error.into(),
                },
            },
        }
    }
}

/// The csv crate's message with field and column, but without the position, which [`ReadError`] gives itself.
fn problem(error: &csv::Error, columns: &[&str]) -> String {
    let place = |field: usize| match columns.get(field) {
        Some(column) => format!("field {}, {column}", field + 1),
        None => format!("field {}", field + 1),
    };
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => match err.field() {
            Some(field) => format!("{}: {}", place(field as usize), err.kind()),
            None => err.kind().to_string(),
        },
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => {
            format!("{len} fields where the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { err, .. } => format!("{}: not UTF-8", place(err.field())),
        _ => error.to_string(),
    }
}
