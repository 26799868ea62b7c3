//! Reads a CSV file of rows in one pass.
//!
//! A last line without a line end, as a killed writer leaves it, is dropped and counted, even if it
//! looks whole: a number may have lost its last digits. Anything else that is not a row is an error
//! with file, line and column. A line longer than 64 KiB is an error too: a row is a few hundred bytes, and a
//! line without an end would fill the memory.
//!
//! [`read`] takes a file as it is. [`read_whole`] takes one that a manifest vouches for, and checks
//! it against the manifest in the same pass.
//!
//! Lines in the form that webloop writes are parsed by [`column::plain`]. From the first line in
//! another form on, the csv crate and serde parse the file: they decide what is a row.

use std::cell::Cell;
use std::convert::Infallible;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use column::Row;
use manifest::{FileFact, Tally};
use thiserror::Error;

/// Size of the read buffer, bytes.
const BUFFER: usize = 1 << 17;

/// The longest line, bytes, with its end; far longer than a row.
const LINE_MAX: usize = 1 << 16;

/// Why a file of rows could not be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}; a cell that has run has this file in its folder")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file does not have the expected columns.
    #[error("{path} has the columns {found}, and this version of webloop reads {expected}")]
    Columns {
        /// The file.
        path: PathBuf,
        /// Its header.
        found: String,
        /// The header that its rows need.
        expected: String,
    },
    /// A line is not a row.
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
    /// The file does not match its manifest.
    #[error("{path}: {problem}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

impl ReadError {
    /// The path of the file, and what is wrong with the file.
    pub(crate) fn parts(self) -> (PathBuf, String) {
        match self {
            ReadError::File { path, source } if source.kind() == ErrorKind::NotFound => {
                (path, "it is gone".to_owned())
            }
            ReadError::File { path, source } => (path, source.to_string()),
            ReadError::Columns {
                path,
                found,
                expected,
            } => (
                path,
                format!("it has the columns {found}, and its rows have {expected}"),
            ),
            ReadError::Row {
                path,
                line,
                problem,
            } => (path, format!("line {line}: {problem}")),
            ReadError::Damaged { path, problem } => (path, problem),
        }
    }
}

/// What a file of rows contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Content {
    /// Number of whole rows.
    pub rows: u64,
    /// Whether its last line was torn.
    pub torn: bool,
}

/// Passes every whole row of the file to `each`, in order. Returns whether the last line was torn.
///
/// A file without a complete header has no rows.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, has other columns, or has a line that is not a row.
pub fn read<R: Row>(
    path: &Path,
    columns: &[&str],
    mut each: impl FnMut(&R),
) -> Result<bool, ReadError> {
    let mut file = Rows::open(path)?;
    let each = |row: &R| {
        each(row);
        Ok::<_, Infallible>(())
    };
    match file.whole {
        0 => Ok(file.torn),
        _ => file.each(columns, each).map(|content| content.torn),
    }
}

/// As [`read`], for a file that has to match its manifest. If `each` objects to a row, its message is
/// an error with the row's line.
///
/// # Errors
/// [`ReadError`]. The first objection comes before a checksum that differs from the manifest's.
pub fn read_whole<R: Row, E: Display>(
    path: &Path,
    columns: &[&str],
    asked: &FileFact,
    each: impl FnMut(&R) -> Result<(), E>,
) -> Result<Content, ReadError> {
    let damaged = |problem| ReadError::Damaged {
        path: path.to_owned(),
        problem,
    };
    let mut file = Rows::open(path)?;
    if file.length != asked.bytes {
        return Err(damaged(other_length(file.length, asked)));
    }
    if file.whole == 0 {
        return Err(damaged("it has no header".to_owned()));
    }
    file.tally = Some(Tally::default());
    let content = file.each(columns, each)?;
    // The checksum includes what follows the last whole line.
    io::copy(&mut file, &mut io::sink()).map_err(unreadable(path))?;
    if file.tally.map(Tally::fact).as_ref() == Some(asked) {
        Ok(content)
    } else {
        Err(damaged(OTHER_BYTES.to_owned()))
    }
}

/// The message for a file of the right length with other content.
pub(crate) const OTHER_BYTES: &str = "its checksum differs from the manifest's: a byte was changed";

/// The message for a file of the wrong length.
pub(crate) fn other_length(bytes: u64, asked: &FileFact) -> String {
    format!(
        "it has {bytes} bytes, and the manifest says {}",
        asked.bytes
    )
}

/// A file of rows and its length. Reading from it reads the file and updates the checksum.
struct Rows<'a> {
    path: &'a Path,
    file: io::Take<File>,
    /// Length of the file, bytes.
    length: u64,
    /// Length up to the last line end, bytes.
    whole: u64,
    /// Whether anything follows the last line end.
    torn: bool,
    /// Checksum of what was read, if it is wanted.
    tally: Option<Tally>,
}

impl Read for Rows<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.file.read(buffer)?;
        if let Some(tally) = &mut self.tally {
            tally.push(&buffer[..n]);
        }
        Ok(n)
    }
}

impl<'a> Rows<'a> {
    fn open(path: &'a Path) -> Result<Self, ReadError> {
        let open = || -> io::Result<Self> {
            let mut file = file::open(path)?;
            let (length, whole) = whole_lines(&mut file)?;
            Ok(Self {
                path,
                // The file may be growing: nothing beyond this length is read.
                file: file.take(length),
                length,
                whole,
                torn: whole < length,
                tally: None,
            })
        };
        open().map_err(unreadable(path))
    }

    /// Passes the whole rows to `each`; stops at its first objection.
    fn each<R: Row, E: Display>(
        &mut self,
        columns: &[&str],
        mut each: impl FnMut(&R) -> Result<(), E>,
    ) -> Result<Content, ReadError> {
        let (path, torn, whole) = (self.path, self.torn, self.whole);
        let mut source = BufReader::with_capacity(BUFFER, self.take(whole));
        let (mut header, mut line) = (Vec::new(), Vec::new());
        next_line(path, 1, &mut source, &mut header)?;
        let is =
            |columns: &[&str]| header.strip_suffix(b"\n") == Some(columns.join(",").as_bytes());
        let mut rows = 0;
        if let Some(lacking) = lacking::<R>(columns, is) {
            loop {
                // Nearly all lines are whole in the buffer, and are parsed where they are.
                let buffer = source.fill_buf().map_err(unreadable(path))?;
                let end =
                    memchr::memchr(b'\n', buffer).filter(|end| lacking == 0 && *end < LINE_MAX);
                if let Some(end) = end
                    && let Some(row) = R::plain(&buffer[..end])
                {
                    source.consume(end + 1);
                    each(&row).map_err(|problem| refused(path, rows + 2, &problem))?;
                    rows += 1;
                    continue;
                }
                line.clear();
                if next_line(path, rows + 2, &mut source, &mut line)? == 0 {
                    return Ok(Content { rows, torn });
                }
                let Some(row) = plain(&mut line, lacking) else {
                    break;
                };
                each(&row).map_err(|problem| refused(path, rows + 2, &problem))?;
                rows += 1;
            }
        }
        let rest = header.chain(line.as_slice()).chain(source);
        let others =
            by_serde(rest, columns, &mut each).map_err(|stop| stop.at(path, rows, columns))?;
        Ok(Content {
            rows: rows + others,
            torn,
        })
    }
}

/// The error of a file that cannot be read, from the system's.
fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> ReadError {
    move |source| ReadError::File {
        path: path.to_owned(),
        source,
    }
}

/// The error of a line that is not a row.
fn refused(path: &Path, line: u64, problem: &dyn Display) -> ReadError {
    ReadError::Row {
        path: path.to_owned(),
        line,
        problem: problem.to_string(),
    }
}

/// Reads the line with this number, and its end, behind what is in `line`. Returns its length, 0 at the end.
fn next_line(
    path: &Path,
    number: u64,
    source: &mut impl BufRead,
    line: &mut Vec<u8>,
) -> Result<usize, ReadError> {
    let most = LINE_MAX as u64 + 1;
    let read = source.take(most).read_until(b'\n', line);
    let length = read.map_err(unreadable(path))?;
    if length > LINE_MAX {
        Err(refused(path, number, &TOO_LONG))
    } else {
        Ok(length)
    }
}

/// How many of the last columns a file lacks, which is older than they; `None` if it has other columns. `is` tells
/// whether these are the file's.
fn lacking<R: Row>(columns: &[&str], is: impl Fn(&[&str]) -> bool) -> Option<usize> {
    (0..=R::NEW).find(|lacking| {
        let whole = columns.len().checked_sub(*lacking);
        whole.is_some_and(|whole| is(&columns[..whole]))
    })
}

/// The row of a line, if it is in the form that webloop writes. The line is left as it was.
fn plain<R: Row>(line: &mut Vec<u8>, lacking: usize) -> Option<R> {
    let length = line.strip_suffix(b"\n")?.len();
    line.truncate(length);
    // What an older file does not have is empty.
    line.resize(length + lacking, b',');
    let row = R::plain(line);
    line.truncate(length);
    line.push(b'\n');
    row
}

const TOO_LONG: &str = "it is longer than 64 KiB, and a row is a few hundred bytes";

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
fn by_serde<R: Row, E: Display>(
    text: impl Read,
    columns: &[&str],
    mut each: impl FnMut(&R) -> Result<(), E>,
) -> Result<u64, Stop> {
    let left = Cell::new(LINE_MAX);
    let text = Bounded { text, left: &left };
    let mut reader = csv::Reader::from_reader(text);
    let header = reader.headers()?.clone();
    let is = |columns: &[&str]| header.iter().eq(columns.iter().copied());
    if lacking::<R>(columns, is).is_none() {
        return Err(Stop::Columns {
            found: header.iter().collect::<Vec<_>>().join(","),
            expected: columns.join(","),
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
enum Stop {
    #[error(transparent)]
    Csv(#[from] csv::Error),
    #[error("{found} where {expected} should be")]
    Columns { found: String, expected: String },
    #[error("line {line}: {problem}")]
    Row { line: u64, problem: String },
}

impl Stop {
    /// The error with its place in the file at `path`, with these columns, of which `before` rows had already been read.
    fn at(self, path: &Path, before: u64, columns: &[&str]) -> ReadError {
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

/// The length of the file, and its length up to the last line end. Rewinds the file.
fn whole_lines(file: &mut File) -> io::Result<(u64, u64)> {
    let length = file.seek(SeekFrom::End(0))?;
    let from = length.saturating_sub(LINE_MAX as u64);
    file.seek(SeekFrom::Start(from))?;
    let mut tail = Vec::new();
    Read::by_ref(file)
        .take(length - from)
        .read_to_end(&mut tail)?;
    file.rewind()?;
    match tail.iter().rposition(|byte| *byte == b'\n') {
        Some(at) => Ok((length, from + at as u64 + 1)),
        None if from == 0 => Ok((length, 0)),
        None => Err(io::Error::new(
            ErrorKind::InvalidData,
            format!("its last line: {TOO_LONG}"),
        )),
    }
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
        assert!(
            message.contains("ticks.csv, line 3: field 3, t_tick_ns:"),
            "{message}"
        );
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
    fn a_line_without_an_end_is_refused_wherever_it_stands_and_in_little_memory() {
        let long = "7".repeat(LINE_MAX);
        let row = "0,10,11,0,0,\n";
        let quoted = format!("\"{long}");
        for (text, words) in [
            (format!("{long}\n"), "line 1"),
            (format!("{HEADER}{row}{long}\n"), "line 3"),
            (
                format!("{HEADER}{row}\"1\",20,21,0,0,\n{long}\n{row}"),
                "line 4",
            ),
            (format!("{HEADER}{row}{quoted}\n{row}"), "line 3"),
            (format!("{HEADER}{row}{long}"), "last line"),
        ] {
            let message = read_text(&text).expect_err(words).to_string();
            assert!(message.contains(words), "{words}: {message}");
            assert!(message.contains("64 KiB"), "{message}");
        }
    }

    /// Reads `text` against a manifest that was written for `asked`; only rows with an even k are
    /// accepted.
    fn read_vouched(text: &str, asked: &str) -> Result<Content, String> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("ticks.csv");
        std::fs::write(&path, text).expect("a writable folder");
        let asked = FileFact::of(asked.as_bytes()).expect("in memory");
        let even = |row: &TickRow| match row.k % 2 {
            0 => Ok(()),
            _ => Err(format!("k is {}", row.k)),
        };
        read_whole(&path, TickRow::COLUMNS, &asked, even)
            .map_err(|error| error.to_string().replace(&path.display().to_string(), "it"))
    }

    #[test]
    fn a_file_is_held_against_its_manifest_while_it_is_read() {
        let text = format!("{HEADER}0,10,11,0,0,\n2,20,21,0,0,\n");
        let whole = |rows, torn| Ok(Content { rows, torn });
        assert_eq!(read_vouched(&text, &text), whole(2, false));
        // In any form of CSV, and with a torn last line.
        let quoted = text.replace("2,20", "\"2\",20");
        assert_eq!(read_vouched(&quoted, &quoted), whole(2, false));
        let torn = format!("{text}4,3");
        assert_eq!(read_vouched(&torn, &torn), whole(2, true));

        let said = |text: &str, asked: &str| read_vouched(text, asked).expect_err("damaged");
        for changed in [
            text.replace("21", "22"),
            torn.replace("4,3", "4,4"),
            quoted.replace("21", "22"),
        ] {
            let asked = [&text, &torn, &quoted]
                .into_iter()
                .find(|one| one.len() == changed.len())
                .expect("as long");
            assert!(said(&changed, asked).contains("checksum"), "{changed}");
        }
        assert!(said(&text, &torn).contains("bytes, and the manifest says"));
        assert!(said("", "").contains("it has no header"));
        for odd in [
            text.replace("2,20", "3,20"),
            quoted.replace("\"2\"", "\"3\""),
        ] {
            assert!(said(&odd, &odd).starts_with("it, line 3: k is 3"), "{odd}");
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let error =
            read(Path::new("nowhere/ticks.csv"), &[], |_: &TickRow| {}).expect_err("missing");
        assert!(error.to_string().contains("nowhere/ticks.csv"), "{error}");
    }
}
