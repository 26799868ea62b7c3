//! Writes rows from a measured thread to a CSV file, without holding up that thread.
//!
//! A [`Recorder`] puts rows into a ring of fixed size, without an allocation, a lock or a system call. The
//! [`Journal`] is a thread that moves the rows from the ring to the file several times a second, so that a
//! run that is killed leaves its rows on disk. Losses are never silent: rows that find the ring full are
//! counted, and [`Journal::finish`] returns an error of the file with its name.
//!
//! Files are only appended to, and an existing file is rejected, unless it is to be [resumed](Journal::resume):
//! then its first writer was killed. What a row means, and how it is written as a line, is left to who opens the file.
#![forbid(unsafe_code)]

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom, Write},
    mem::MaybeUninit,
    path::{Path, PathBuf},
    thread::{self, JoinHandle},
    time::Duration,
};

use rtrb::{Consumer, Producer, RingBuffer};
use serde::de::DeserializeOwned;

/// Interval at which rows are written to the file.
const FLUSH_EVERY: Duration = Duration::from_millis(100);

/// Number of rows in the ring: the file may stall for half a minute at 1 kHz, for three seconds at 10 kHz. All of
/// it takes memory from the start, so that no row waits for a page of it: 1 to 5 MB a file.
pub const CAPACITY: usize = 1 << 15;

/// Rows are written at the latest when there are so many of them.
const WRITE_ROWS: usize = 1024;

/// Room for as many rows, with [`ROW_BYTES`] for each. Only what is filled takes memory.
const BUFFER_BYTES: usize = WRITE_ROWS * ROW_BYTES;

/// No row of a run is longer, in bytes; those who write rows test it.
pub const ROW_BYTES: usize = 256;

/// How much of a file's end is looked at for its last row.
const TAIL_BYTES: u64 = 16 << 10;

/// Why a file of rows is missing or incomplete.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The file could not be created.
    #[error(
        "cannot create {path}: {source}; give an output folder that is writable and has no rows of an earlier run"
    )]
    Create {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file is not one to go on with.
    #[error(
        "cannot go on with {path}: {source}; give the folder of a run that was killed, or run without `again`"
    )]
    Resume {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: io::Error,
    },
    /// The file could not take all rows.
    #[error("cannot write {path}: {source}; its rows end early, so free some space and run again")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
}

/// What a journal did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Rows in the file.
    pub rows: u64,
    /// Rows that found the ring full and are not in the file.
    pub overflow: u64,
}

/// The measured thread's side.
#[derive(Debug)]
pub struct Recorder<R> {
    ring: Producer<R>,
    overflow: u64,
}

impl<R> Recorder<R> {
    /// Passes on a row, or counts it as lost if the ring is full.
    pub fn record(&mut self, row: R) {
        if self.ring.push(row).is_err() {
            self.overflow += 1;
        }
    }
}

/// The file's side.
#[derive(Debug)]
pub struct Journal {
    writer: JoinHandle<Result<u64, JournalError>>,
}

impl Journal {
    /// Creates the file with its header, and the folder if necessary. `write` appends a row's line, with its end.
    ///
    /// # Errors
    /// [`JournalError`] if the folder or the file cannot be created or written, or if the file exists.
    pub fn create<R>(
        path: &Path,
        columns: &[&str],
        write: impl Fn(&R, &mut Vec<u8>) + Send + 'static,
    ) -> Result<(Recorder<R>, Self), JournalError>
    where
        R: Send + 'static,
    {
        Self::with_capacity(path, columns, write, CAPACITY)
    }

    /// Goes on with the file of an earlier life of the same run, which was killed, and gives its last row;
    /// creates the file if there is none.
    ///
    /// A last line without its end is no row. It stays, and is ended, so that no row is glued to it.
    ///
    /// # Errors
    /// [`JournalError`] as for [`Journal::create`], or if the file has another header, or no row at its end.
    pub fn resume<R>(
        path: &Path,
        columns: &[&str],
        write: impl Fn(&R, &mut Vec<u8>) + Send + 'static,
    ) -> Result<(Recorder<R>, Self, Option<R>), JournalError>
    where
        R: DeserializeOwned + Send + 'static,
    {
        let (file, last) = earlier(path, columns).map_err(|source| JournalError::Resume {
            path: path.to_owned(),
            source,
        })?;
        let (recorder, journal) = Self::start(Sheet::new(path, file), write, CAPACITY)?;
        Ok((recorder, journal, last))
    }

    /// [`Journal::resume`] if it is `again`, else [`Journal::create`].
    ///
    /// # Errors
    /// Those of either.
    pub fn open<R>(
        path: &Path,
        columns: &[&str],
        write: impl Fn(&R, &mut Vec<u8>) + Send + 'static,
        again: bool,
    ) -> Result<(Recorder<R>, Self, Option<R>), JournalError>
    where
        R: DeserializeOwned + Send + 'static,
    {
        if again {
            return Self::resume(path, columns, write);
        }
        let (recorder, journal) = Self::create(path, columns, write)?;
        Ok((recorder, journal, None))
    }

    fn with_capacity<R>(
        path: &Path,
        columns: &[&str],
        write: impl Fn(&R, &mut Vec<u8>) + Send + 'static,
        capacity: usize,
    ) -> Result<(Recorder<R>, Self), JournalError>
    where
        R: Send + 'static,
    {
        let file = create_folder_of(path).and_then(|()| File::create_new(path));
        let file = file.map_err(|source| JournalError::Create {
            path: path.to_owned(),
            source,
        })?;
        let mut sheet = Sheet::new(path, file);
        // The header is written here, so that a file without rows has one too.
        sheet.header(columns)?;
        Self::start(sheet, write, capacity)
    }

    fn start<R>(
        sheet: Sheet,
        write: impl Fn(&R, &mut Vec<u8>) + Send + 'static,
        capacity: usize,
    ) -> Result<(Recorder<R>, Self), JournalError>
    where
        R: Send + 'static,
    {
        let path = sheet.path.clone();
        let (producer, consumer) = ring(capacity);
        let writer = thread::Builder::new()
            .name("journal".to_owned())
            .spawn(move || sheet.fill(consumer, write))
            .map_err(|source| JournalError::Create { path, source })?;
        Ok((
            Recorder {
                ring: producer,
                overflow: 0,
            },
            Self { writer },
        ))
    }

    /// Completes the file with every row that was recorded.
    ///
    /// # Errors
    /// [`JournalError::Write`] if any write has failed since the beginning.
    pub fn finish<R>(self, recorder: Recorder<R>) -> Result<Kept, JournalError> {
        let Recorder { ring, overflow } = recorder;
        // The writer ends when the other side of its ring is dropped.
        drop(ring);
        self.writer.thread().unpark();
        match self.writer.join() {
            Ok(result) => result.map(|rows| Kept { rows, overflow }),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

/// A ring whose memory is there, so that the measured thread takes no page fault in its first lap.
fn ring<R>(capacity: usize) -> (Producer<R>, Consumer<R>) {
    let (mut producer, consumer) = RingBuffer::new(capacity);
    if let Ok(mut slots) = producer.write_chunk_uninit(capacity) {
        // Without a commit these are no rows.
        slots.as_mut_slices().0.fill_with(MaybeUninit::zeroed);
    }
    (producer, consumer)
}

fn create_folder_of(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), std::fs::create_dir_all)
}

/// Opens the file of an earlier life to append to it, with all lines ended; its last row.
fn earlier<R: DeserializeOwned>(path: &Path, columns: &[&str]) -> io::Result<(File, Option<R>)> {
    create_folder_of(path)?;
    let header = columns.join(",") + "\n";
    let header_bytes = header.len() as u64;
    let mut options = File::options();
    let mut file = options.read(true).append(true).create(true).open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(io::Error::other("it is no regular file"));
    }
    let mut start = Vec::new();
    (&file).take(header_bytes).read_to_end(&mut start)?;
    if start.is_empty() {
        file.write_all(header.as_bytes())?;
        return Ok((file, None));
    }
    if start != header.as_bytes() {
        let why = format!("its header is not {}", header.trim_end());
        return Err(io::Error::other(why));
    }
    let tail_at = metadata.len().saturating_sub(TAIL_BYTES);
    file.seek(SeekFrom::Start(tail_at.max(header_bytes)))?;
    let mut tail = String::new();
    file.read_to_string(&mut tail)?;
    let (mut lines, torn) = tail.rsplit_once('\n').unwrap_or(("", &tail));
    if tail_at > header_bytes {
        // The first may have lost its beginning.
        lines = lines.split_once('\n').map_or("", |(_, whole)| whole);
    }
    let row = |line: &str| {
        let fields: csv::StringRecord = line.split(',').collect();
        fields.deserialize(None).ok()
    };
    // Lines that are none were torn in lives before.
    let last = lines.rsplit('\n').find_map(row);
    if last.is_none() && !lines.is_empty() {
        return Err(io::Error::other("the lines at its end are no rows"));
    }
    if !torn.is_empty() {
        file.write_all(b"\n")?;
    }
    Ok((file, last))
}

/// A CSV file being written.
struct Sheet {
    path: PathBuf,
    file: File,
    /// Whole rows that are not in the file yet.
    text: Vec<u8>,
    rows: u64,
}

impl Sheet {
    fn new(path: &Path, file: File) -> Self {
        Self {
            path: path.to_owned(),
            file,
            text: Vec::with_capacity(BUFFER_BYTES),
            rows: 0,
        }
    }

    fn header(&mut self, columns: &[&str]) -> Result<(), JournalError> {
        self.text.extend(columns.join(",").bytes());
        self.text.push(b'\n');
        self.flush().map_err(|source| self.broken(source))
    }

    /// Empties the ring into the file until the recorder is gone.
    fn fill<R>(
        mut self,
        mut ring: Consumer<R>,
        write: impl Fn(&R, &mut Vec<u8>),
    ) -> Result<u64, JournalError> {
        loop {
            // Checked before the ring is emptied, so that rows recorded before the end are certainly written.
            let last = ring.is_abandoned();
            self.drain(&mut ring, &write)
                .map_err(|source| self.broken(source))?;
            if last {
                return Ok(self.rows);
            }
            thread::park_timeout(FLUSH_EVERY);
        }
    }

    fn drain<R>(
        &mut self,
        ring: &mut Consumer<R>,
        write: impl Fn(&R, &mut Vec<u8>),
    ) -> io::Result<()> {
        loop {
            // Every write has whole rows, so a writer that is killed between two leaves no torn one.
            let count = ring.slots().min(WRITE_ROWS);
            let Ok(rows) = ring.read_chunk(count) else {
                return Ok(());
            };
            if rows.is_empty() {
                return Ok(());
            }
            let (first, rest) = rows.as_slices();
            for row in first.iter().chain(rest) {
                write(row, &mut self.text);
            }
            rows.commit_all();
            self.rows += count as u64;
            self.flush()?;
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        let written = self.file.write_all(&self.text);
        self.text.clear();
        written
    }

    fn broken(&self, source: io::Error) -> JournalError {
        JournalError::Write {
            path: self.path.clone(),
            source,
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    /// A row of these tests.
    #[derive(Debug, Deserialize)]
    struct Row {
        n: u64,
        /// A number or none.
        x: Option<f64>,
    }

    const COLUMNS: &[&str] = &["n", "x"];

    fn line(row: &Row, text: &mut Vec<u8>) {
        let x = row.x.map(|x| x.to_string()).unwrap_or_default();
        text.extend(format!("{},{x}\n", row.n).bytes());
    }

    #[test]
    fn every_row_is_in_the_file_in_order_and_an_empty_file_has_its_header() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deeper").join("rows.csv");
        let (mut recorder, journal) = Journal::create(&path, COLUMNS, line).expect("a new file");
        let head = std::fs::read_to_string(&path).expect("the header is there at once");
        assert_eq!(head, "n,x\n");
        for n in 0..1000 {
            recorder.record(Row {
                n,
                x: (n == 1).then_some(0.1),
            });
        }
        let written = journal.finish(recorder).expect("a writable file");
        assert_eq!(
            written,
            Kept {
                rows: 1000,
                overflow: 0
            }
        );
        let text = std::fs::read_to_string(&path).expect("the file");
        assert!(text.starts_with("n,x\n0,\n1,0.1\n2,\n"), "{text:.40}");
        assert_eq!(text.lines().count(), 1001);
    }

    #[test]
    fn rows_are_on_disk_within_a_second_while_the_run_goes_on() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rows.csv");
        let (mut recorder, journal) = Journal::create(&path, COLUMNS, line).expect("a new file");
        recorder.record(Row { n: 7, x: None });
        // A flush is due every 0.1 s; the test allows ten times that on a busy machine.
        let on_disk = (0..100).any(|_| {
            thread::sleep(Duration::from_millis(10));
            std::fs::read_to_string(&path).is_ok_and(|text| text.ends_with("7,\n"))
        });
        assert!(on_disk);
        journal.finish(recorder).expect("a writable file");
    }

    #[test]
    fn a_full_ring_is_counted_and_holds_nobody_up() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rows.csv");
        let (mut recorder, journal) =
            Journal::with_capacity(&path, COLUMNS, line, 4).expect("a new file");
        for n in 0..10_000 {
            recorder.record(Row { n, x: None });
        }
        let Kept { rows, overflow } = journal.finish(recorder).expect("a writable file");
        assert_eq!(rows + overflow, 10_000);
        assert!(overflow > 0);
    }

    #[test]
    fn rows_of_an_earlier_run_are_refused_and_kept() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rows.csv");
        std::fs::write(&path, "n,x\n1,\n").expect("a writable folder");
        let error = Journal::create(&path, COLUMNS, line).expect_err("the file exists");
        assert!(error.to_string().contains("rows.csv"), "{error}");
        assert_eq!(
            std::fs::read_to_string(&path).expect("the file"),
            "n,x\n1,\n"
        );
    }

    /// Resumes the file `left`, with a row n = 9; what is in it then, and what was its last row.
    fn resumed(left: Option<&str>) -> Result<(String, Option<u64>), JournalError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deeper").join("rows.csv");
        if let Some(left) = left {
            create_folder_of(&path).expect("a writable folder");
            std::fs::write(&path, left).expect("a writable folder");
        }
        let resumed = Journal::resume(&path, COLUMNS, line);
        let text = || std::fs::read_to_string(&path).expect("the file");
        let (mut recorder, journal, last) = resumed.inspect_err(|_| {
            assert_eq!(Some(text().as_str()), left, "it is kept");
        })?;
        recorder.record(Row { n: 9, x: None });
        let written = journal.finish(recorder).expect("a writable file");
        assert_eq!(written.rows, 1, "those of this life");
        Ok((text(), last.map(|row: Row| row.n)))
    }

    #[test]
    fn a_second_life_goes_on_behind_the_last_whole_row() {
        for (left, last, now) in [
            (None, None, "n,x\n9,\n"),
            (Some(""), None, "n,x\n9,\n"),
            (Some("n,x\n"), None, "n,x\n9,\n"),
            (Some("n,x\n1,\n2,0.5\n"), Some(2), "n,x\n1,\n2,0.5\n9,\n"),
            // Torn; whole but for its end, so it may have been longer; torn in an earlier life.
            (Some("n,x\n1,\n2"), Some(1), "n,x\n1,\n2\n9,\n"),
            (Some("n,x\n1,\n2,0.5"), Some(1), "n,x\n1,\n2,0.5\n9,\n"),
            (Some("n,x\n1"), None, "n,x\n1\n9,\n"),
            (Some("n,x\n1,\n2\n"), Some(1), "n,x\n1,\n2\n9,\n"),
        ] {
            let (text, row) = resumed(left).expect("rows to go on with");
            assert_eq!((text.as_str(), row), (now, last), "{left:?}");
        }
        let long: String = (0..10_000).map(|n| format!("{n},0.25\n")).collect();
        let (text, row) = resumed(Some(&format!("n,x\n{long}"))).expect("rows to go on with");
        assert_eq!((text, row), (format!("n,x\n{long}9,\n"), Some(9_999)));
    }

    #[test]
    fn what_an_earlier_life_cannot_have_left_is_refused_and_kept() {
        for (left, why) in [
            ("n,y\n1,\n", "its header is not n,x"),
            ("n,x", "its header is not n,x"),
            ("n,x\none,\n", "no rows"),
        ] {
            let error = resumed(Some(left)).expect_err(why).to_string();
            assert!(error.contains("rows.csv") && error.contains(why), "{error}");
        }
        let error = Journal::resume(Path::new("/dev/null"), COLUMNS, line).expect_err("no file");
        assert!(error.to_string().contains("no regular file"), "{error}");
    }

    #[test]
    fn a_full_disk_is_an_error_that_names_the_file() {
        // /dev/full refuses every write with ENOSPC, and opens like a file.
        let path = Path::new("/dev/full");
        let file = File::options()
            .write(true)
            .open(path)
            .expect("Linux has /dev/full");
        let sheet = Sheet::new(path, file);
        let (mut producer, consumer) = RingBuffer::new(4);
        producer.push(Row { n: 1, x: None }).expect("room for one");
        drop(producer);
        let error = sheet
            .fill(consumer, line)
            .expect_err("nothing can be written");
        assert!(error.to_string().contains("/dev/full"), "{error}");
        assert!(error.to_string().contains("No space left"), "{error}");
    }
}
