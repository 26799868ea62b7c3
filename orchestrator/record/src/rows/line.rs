//! A line of a file of rows: how long it may be, the columns of the first, and the row in one of the others.

use std::io::{BufRead, Read};
use std::path::Path;

use text::column::Row;

use super::error::{ReadError, refused, unreadable};

/// The longest line, bytes, with its end; far longer than a row.
pub(super) const LINE_MAX: usize = 1 << 16;

/// The words for a longer one.
pub(super) const TOO_LONG: &str = "it is longer than 64 KiB, and a row is a few hundred bytes";

/// Reads the line with this number, and its end, behind what is in `line`. Returns its length, 0 at the end.
pub(super) fn next_line(
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
pub(super) fn lacking<R: Row>(is: impl Fn(&[&str]) -> bool) -> Option<usize> {
    (0..=R::NEW).find(|lacking| {
        let whole = R::COLUMNS.len().checked_sub(*lacking);
        whole.is_some_and(|whole| is(&R::COLUMNS[..whole]))
    })
}

/// The row of a line, if it is in the form that webloop writes. The line is left as it was.
pub(super) fn plain<R: Row>(line: &mut Vec<u8>, lacking: usize) -> Option<R> {
    let length = line.strip_suffix(b"\n")?.len();
    line.truncate(length);
    // What an older file does not have is empty.
    line.resize(length + lacking, b',');
    let row = R::plain(line);
    line.truncate(length);
    line.push(b'\n');
    row
}
