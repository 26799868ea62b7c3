//! A CSV file of rows, in one pass.
//!
//! A line that a killed writer left without its end is dropped and counted, even when what is left
//! of it looks whole: a number may have lost its last digits. Anything else that is not a row is
//! an error with its file and line.
//!
//! Lines in the form that webloop writes are read as [`crate::plain`] does. From the first that is
//! in another on, a file is left to the csv crate and serde: they decide what is a row.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::plain::Row;

/// How much of a file is asked for at a time.
const BUFFER: usize = 1 << 17;

/// Why a file of rows could not be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}; a cell that has run has this file in its folder")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file has other columns.
    #[error("{path} has the columns {found}, and this version of webloop reads {expected}")]
    Columns {
        /// The file.
        path: PathBuf,
        /// Its header.
        found: String,
        /// The header that its rows need.
        expected: String,
    },
    /// A line is no row.
    #[error(
        "{path}, line {line}: {problem}; rows are never edited, so restore the file or run the cell again"
    )]
    Row {
        /// The file.
        path: PathBuf,
        /// The line, from 1; the header is line 1.
        line: u64,
        /// What is wrong with it.
        problem: String,
    },
}

/// Hands every whole row of the file to `each`, in order, and says whether the last line was torn.
///
/// A file without even a whole header has no rows.
///
/// # Errors
/// [`ReadError`].
pub fn read<R: Row>(
    path: &Path,
    columns: &[&str],
    mut each: impl FnMut(&R),
) -> Result<bool, ReadError> {
    let fail = |source| ReadError::File {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(fail)?;
    let (whole, torn) = whole_lines(&mut file).map_err(fail)?;
    if whole == 0 {
        return Ok(torn);
    }
    let mut source = BufReader::with_capacity(BUFFER, file.take(whole));
    let (mut header, mut line) = (Vec::new(), Vec::new());
    source.read_until(b'\n', &mut header).map_err(fail)?;
    let mut before = 0;
    if header.strip_suffix(b"\n") == Some(columns.join(",").as_bytes()) {
        loop {
            line.clear();
            if source.read_until(b'\n', &mut line).map_err(fail)? == 0 {
                return Ok(torn);
            }
            match line.strip_suffix(b"\n").and_then(R::plain) {
                Some(row) => each(&row),
                None => break,
            }
            before += 1;
        }
    }
    let rest = header.chain(line.as_slice()).chain(source);
    by_serde(rest, columns, &mut each).map_err(|stop| stop.at(path, before))?;
    Ok(torn)
}

/// Hands the rows after the header to `each`, whatever form of CSV they are in.
fn by_serde<R: DeserializeOwned>(
    text: impl Read,
    columns: &[&str],
    mut each: impl FnMut(&R),
) -> Result<(), Stop> {
    let mut reader = csv::Reader::from_reader(text);
    let header = reader.headers()?.clone();
    if header.iter().ne(columns.iter().copied()) {
        return Err(Stop::Columns {
            found: header.iter().collect::<Vec<_>>().join(","),
            expected: columns.join(","),
        });
    }
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record)? {
        each(&record.deserialize(Some(&header))?);
    }
    Ok(())
}

/// Why [`by_serde`] came to no end.
#[derive(Debug, Error)]
enum Stop {
    #[error(transparent)]
    Csv(#[from] csv::Error),
    #[error("{found} where {expected} should be")]
    Columns { found: String, expected: String },
}

impl Stop {
    /// The error in the file at `path`, of which so many lines after the header had been read.
    fn at(self, path: &Path, before: u64) -> ReadError {
        let path = path.to_owned();
        match self {
            Stop::Columns { found, expected } => ReadError::Columns {
                path,
                found,
                expected,
            },
            Stop::Csv(error) => match error.position().map(csv::Position::line) {
                Some(line) => ReadError::Row {
                    path,
                    line: before + line,
                    problem: problem(&error),
                },
                None => ReadError::File {
                    path,
                    source: error.into(),
                },
            },
        }
    }
}

/// The csv crate's words without the position, which [`ReadError`] names itself, but with the
/// field.
fn problem(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => match err.field() {
            Some(field) => format!("field {}: {}", field + 1, err.kind()),
            None => err.kind().to_string(),
        },
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => {
            format!("{len} fields where the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { err, .. } => format!("field {}: not UTF-8", err.field() + 1),
        _ => error.to_string(),
    }
}

/// The length of the file up to its last line end, and whether anything follows it. The file is
/// left at its start.
fn whole_lines(file: &mut File) -> io::Result<(u64, bool)> {
    /// Far more than a row.
    const TAIL: u64 = 1 << 16;
    let length = file.seek(SeekFrom::End(0))?;
    let from = length.saturating_sub(TAIL);
    file.seek(SeekFrom::Start(from))?;
    let mut tail = Vec::new();
    // The file may be growing: what comes after its length is not looked at.
    Read::by_ref(file)
        .take(length - from)
        .read_to_end(&mut tail)?;
    file.rewind()?;
    let whole = tail
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |at| from + at as u64 + 1);
    Ok((whole, whole < length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use endpoint::TickRow;

    fn read_text(text: &str) -> Result<(Vec<u64>, bool), ReadError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("ticks.csv");
        std::fs::write(&path, text).expect("a writable folder");
        let mut ks = Vec::new();
        read(&path, TickRow::COLUMNS, |row: &TickRow| ks.push(row.k)).map(|torn| (ks, torn))
    }

    const HEADER: &str = "k,t_due_ns,t_tick_ns,u,y,seq\n";

    #[test]
    fn a_torn_last_line_is_dropped_even_when_it_looks_like_a_row() {
        let text = format!("{HEADER}0,10,11,0,0,\n1,20,21,0.5,0.25,1");
        assert_eq!(read_text(&text).expect("readable"), (vec![0], true));
        assert_eq!(
            read_text(&format!("{text}2\n")).expect("readable"),
            (vec![0, 1], false)
        );
    }

    #[test]
    fn a_file_without_a_whole_header_has_no_rows() {
        assert_eq!(read_text("").expect("readable"), (vec![], false));
        assert_eq!(read_text("k,t_du").expect("readable"), (vec![], true));
        assert_eq!(read_text(HEADER).expect("readable"), (vec![], false));
    }

    #[test]
    fn a_line_that_is_no_row_is_named_with_file_line_and_field() {
        let text = format!("{HEADER}0,10,11,0,0,\n1,20,x,0,0,\n2,30,31,0,0,\n");
        let message = read_text(&text).expect_err("x is no time").to_string();
        assert!(message.contains("ticks.csv, line 3: field 3:"), "{message}");
        let message = read_text(&format!("{HEADER}0,10\n"))
            .expect_err("too short")
            .to_string();
        assert!(
            message.contains("line 2: 2 fields where the header has 6"),
            "{message}"
        );
    }

    #[test]
    fn other_columns_are_refused_with_both_headers() {
        let message = read_text("a,b\n1,2\n").expect_err("no ticks").to_string();
        assert!(
            message.contains("a,b") && message.contains("k,t_due_ns"),
            "{message}"
        );
    }

    #[test]
    fn a_missing_file_is_named() {
        let error =
            read(Path::new("nowhere/ticks.csv"), &[], |_: &TickRow| {}).expect_err("missing");
        assert!(error.to_string().contains("nowhere/ticks.csv"), "{error}");
    }
}
