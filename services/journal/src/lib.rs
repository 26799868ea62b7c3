//! Writes rows from a measured thread to a CSV file, without holding up that thread.
//!
//! A [`Recorder`] puts rows into a ring of fixed size, without an allocation, a lock or a system call. The
//! [`Journal`] is a thread that moves the rows from the ring to the file several times a second, so that a
//! run that is killed leaves its rows on disk. Losses are never silent: rows that find the ring full are
//! counted, and [`Journal::finish`] returns an error of the file with its name.
//!
//! Files are only appended to, and an existing file is rejected. The meaning of rows is left to their types.
#![forbid(unsafe_code)]

use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
    thread::{self, JoinHandle},
    time::Duration,
};

use endpoint::report::Written;
use rtrb::{Consumer, Producer, RingBuffer};
use serde::Serialize;

/// Interval at which rows are written to the file.
const FLUSH_EVERY: Duration = Duration::from_millis(100);

/// Number of rows in the ring: the file may stall for over a minute at 1 kHz, for six seconds at 10 kHz.
pub const CAPACITY: usize = 1 << 16;

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
    /// The file could not take all rows.
    #[error("cannot write {path}: {source}; its rows end early, so free some space and run again")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: csv::Error,
    },
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
    /// Creates the file with its header, and the folder if necessary.
    ///
    /// # Errors
    /// [`JournalError`] if the folder or the file cannot be created or written, or if the file exists.
    pub fn create<R>(path: &Path, columns: &[&str]) -> Result<(Recorder<R>, Self), JournalError>
    where
        R: Serialize + Send + 'static,
    {
        Self::with_capacity(path, columns, CAPACITY)
    }

    fn with_capacity<R>(
        path: &Path,
        columns: &[&str],
        capacity: usize,
    ) -> Result<(Recorder<R>, Self), JournalError>
    where
        R: Serialize + Send + 'static,
    {
        let create = |source| JournalError::Create {
            path: path.to_owned(),
            source,
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(create)?;
        }
        let file = File::create_new(path).map_err(create)?;
        let mut sheet = Sheet {
            path: path.to_owned(),
            // The header is written here, so that a file without rows has one too.
            csv: csv::WriterBuilder::new()
                .has_headers(false)
                .from_writer(file),
            rows: 0,
        };
        sheet.header(columns)?;
        let (producer, consumer) = RingBuffer::new(capacity);
        let writer = thread::Builder::new()
            .name("journal".to_owned())
            .spawn(move || sheet.fill(consumer))
            .map_err(create)?;
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
    pub fn finish<R>(self, recorder: Recorder<R>) -> Result<Written, JournalError> {
        let Recorder { ring, overflow } = recorder;
        // The writer ends when the other side of its ring is dropped.
        drop(ring);
        self.writer.thread().unpark();
        match self.writer.join() {
            Ok(result) => result.map(|rows| Written { rows, overflow }),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

/// A CSV file being written.
struct Sheet {
    path: PathBuf,
    csv: csv::Writer<File>,
    rows: u64,
}

impl Sheet {
    fn header(&mut self, columns: &[&str]) -> Result<(), JournalError> {
        let result = self.csv.write_record(columns);
        let result = result.and_then(|()| Ok(self.csv.flush()?));
        result.map_err(|source| self.broken(source))
    }

    /// Empties the ring into the file until the recorder is gone.
    fn fill<R: Serialize>(mut self, mut ring: Consumer<R>) -> Result<u64, JournalError> {
        loop {
            // Checked before the ring is emptied, so that rows recorded before the end are certainly written.
            let last = ring.is_abandoned();
            self.drain(&mut ring)
                .map_err(|source| self.broken(source))?;
            if last {
                return Ok(self.rows);
            }
            thread::park_timeout(FLUSH_EVERY);
        }
    }

    fn drain<R: Serialize>(&mut self, ring: &mut Consumer<R>) -> csv::Result<()> {
        while let Ok(row) = ring.pop() {
            self.csv.serialize(row)?;
            self.rows += 1;
        }
        Ok(self.csv.flush()?)
    }

    fn broken(&self, source: csv::Error) -> JournalError {
        JournalError::Write {
            path: self.path.clone(),
            source,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Serialize)]
    struct Row {
        n: u64,
        x: Option<f64>,
    }

    const COLUMNS: &[&str] = &["n", "x"];

    #[test]
    fn every_row_is_in_the_file_in_order_and_an_empty_file_has_its_header() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deeper").join("rows.csv");
        let (mut recorder, journal) = Journal::create(&path, COLUMNS).expect("a new file");
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
            Written {
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
        let (mut recorder, journal) = Journal::create(&path, COLUMNS).expect("a new file");
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
            Journal::with_capacity(&path, COLUMNS, 4).expect("a new file");
        for n in 0..10_000 {
            recorder.record(Row { n, x: None });
        }
        let Written { rows, overflow } = journal.finish(recorder).expect("a writable file");
        assert_eq!(rows + overflow, 10_000);
        assert!(overflow > 0);
    }

    #[test]
    fn rows_of_an_earlier_run_are_refused_and_kept() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rows.csv");
        std::fs::write(&path, "n,x\n1,\n").expect("a writable folder");
        let error = Journal::create::<Row>(&path, COLUMNS).expect_err("the file exists");
        assert!(error.to_string().contains("rows.csv"), "{error}");
        assert_eq!(
            std::fs::read_to_string(&path).expect("the file"),
            "n,x\n1,\n"
        );
    }

    #[test]
    fn a_full_disk_is_an_error_that_names_the_file() {
        // /dev/full refuses every write with ENOSPC, and opens like a file.
        let path = Path::new("/dev/full");
        let file = File::options()
            .write(true)
            .open(path)
            .expect("Linux has /dev/full");
        let csv = csv::WriterBuilder::new()
            .has_headers(false)
            .from_writer(file);
        let sheet = Sheet {
            path: path.to_owned(),
            csv,
            rows: 0,
        };
        let (mut producer, consumer) = RingBuffer::new(4);
        producer.push(Row { n: 1, x: None }).expect("room for one");
        drop(producer);
        let error = sheet.fill(consumer).expect_err("nothing can be written");
        assert!(error.to_string().contains("/dev/full"), "{error}");
        assert!(error.to_string().contains("No space left"), "{error}");
    }
}
