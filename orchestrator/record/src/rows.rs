//! Reads a CSV file of rows in one pass.
//!
//! A last line without a line end, as a killed writer leaves it, is dropped and counted, even if it
//! looks whole: a number may have lost its last digits. Anything else that is not a row is an error
//! with file, line and column. A line longer than 64 KiB is an error too: a row is a few hundred bytes, and a
//! line without an end would fill the memory.
//!
//! [`read`] takes a file as it is, [`read_while`] its beginning, and [`all`] one whose writer has just ended.
//! [`read_whole`] takes one that a manifest vouches for, and checks it against the manifest in the same pass.
//!
//! Lines in the form that webloop writes are parsed by [`text::column::plain`]. From the first line in
//! another form on, the csv crate and serde parse the file: they decide what is a row.

mod error;
mod foreign;
mod line;

use std::convert::Infallible;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::ops::ControlFlow;
use std::path::Path;

use text::column::Row;

use crate::fact::{FileFact, OTHER_BYTES, Tally, other_length};
use crate::file;

pub use error::ReadError;

use error::{refused, unreadable};
use foreign::by_serde;
use line::{LINE_MAX, TOO_LONG, lacking, next_line, plain};

/// Size of the read buffer, bytes.
const BUFFER: usize = 1 << 17;

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
pub fn read<R: Row>(path: &Path, mut each: impl FnMut(&R)) -> Result<bool, ReadError> {
    let mut file = Rows::open(path)?;
    let each = |row: &R| {
        each(row);
        Ok::<_, Infallible>(())
    };
    match file.whole {
        0 => Ok(file.torn),
        _ => file.each(each).map(|content| content.torn),
    }
}

/// As [`read`], as long as `each` says to go on: what follows is not looked at.
///
/// # Errors
/// As for [`read`], of the part that is read.
pub fn read_while<R: Row>(
    path: &Path,
    mut each: impl FnMut(&R) -> ControlFlow<()>,
) -> Result<(), ReadError> {
    let mut file = Rows::open(path)?;
    if file.whole == 0 {
        return Ok(());
    }
    let mut is_enough = false;
    let each = |row: &R| {
        is_enough = each(row).is_break();
        if is_enough { Err("enough") } else { Ok(()) }
    };
    match file.each(each) {
        Err(_) if is_enough => Ok(()),
        read => read.map(|_| ()),
    }
}

/// All rows of a file whose writer has ended, in order: a last line without an end is a row like any other.
///
/// # Errors
/// As for [`read`], and if the last line is not a row.
pub fn all<R: Row + Copy>(path: &Path) -> Result<Vec<R>, ReadError> {
    let mut file = Rows::open(path)?;
    (file.whole, file.torn) = (file.length, false);
    let mut rows = Vec::new();
    if file.length > 0 {
        file.each(|row: &R| {
            rows.push(*row);
            Ok::<_, Infallible>(())
        })?;
    }
    Ok(rows)
}

/// As [`read`], for a file that has to match its manifest. If `each` objects to a row, its message is
/// an error with the row's line.
///
/// # Errors
/// [`ReadError`]. The first objection comes before a checksum that differs from the manifest's.
pub fn read_whole<R: Row, E: Display>(
    path: &Path,
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
    let content = file.each(each)?;
    // The checksum includes what follows the last whole line.
    io::copy(&mut file, &mut io::sink()).map_err(unreadable(path))?;
    if file.tally.map(Tally::fact).as_ref() == Some(asked) {
        Ok(content)
    } else {
        Err(damaged(OTHER_BYTES.to_owned()))
    }
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
        mut each: impl FnMut(&R) -> Result<(), E>,
    ) -> Result<Content, ReadError> {
        let (path, torn, whole) = (self.path, self.torn, self.whole);
        let mut source = BufReader::with_capacity(BUFFER, self.take(whole));
        let (mut header, mut line) = (Vec::new(), Vec::new());
        next_line(path, 1, &mut source, &mut header)?;
        let is =
            |columns: &[&str]| header.strip_suffix(b"\n") == Some(columns.join(",").as_bytes());
        let mut rows = 0;
        if let Some(lacking) = lacking::<R>(is) {
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
        let others = by_serde(rest, &mut each).map_err(|stop| stop.at(path, rows, R::COLUMNS))?;
        Ok(Content {
            rows: rows + others,
            torn,
        })
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
mod tests;
