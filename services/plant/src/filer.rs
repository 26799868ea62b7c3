//! The thread that receives a page's rows and report, and writes them to files.
//!
//! This thread parses and writes what a page sends, so that the thread that serves HTTP does not wait
//! for the disk, nor parse 64 KiB between two commands, which takes 0.14 ms for usual rows and up to
//! 0.5 ms for the shortest. The filer is started before any thread has real-time scheduling, so it
//! has none, and neither do the journals' threads that it starts. `session` decides who may send
//! before anything comes here.

use std::{
    fs::{self, File},
    io::{self, Write},
    panic,
    path::{Path, PathBuf},
    sync::mpsc::{self, Receiver, Sender},
    thread::{self, JoinHandle},
};

use clock::journal::{Journal, JournalError, Kept, Recorder};
use endpoint::{MessageRow, report::Written};
use hyper::body::Bytes;
use text::column::Row;
use tokio::sync::oneshot;

use crate::{
    chunk::{Chunks, OutOfTurn, Turn},
    ending::Ending,
    rows::{self, InvalidRow},
};

/// Why something was not stored.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FilingError {
    #[error("no row of this chunk was accepted: {0}")]
    Row(#[from] InvalidRow),
    #[error(transparent)]
    Turn(#[from] OutOfTurn),
    #[error("the report is not JSON: {0}; send one JSON object")]
    Report(#[from] serde_json::Error),
    #[error("this session is over, and its files are closed")]
    Closed,
    #[error(transparent)]
    Create(#[from] JournalError),
    #[error("cannot write {path}: {source}; make room in that folder and send it again")]
    Write { path: PathBuf, source: io::Error },
    #[error("the thread that writes rows has ended; start the plant again")]
    Gone,
}

/// The result of the filer.
#[derive(Debug, Default)]
pub(crate) struct Filed {
    /// Rows of all sessions.
    pub(crate) written: Written,
    /// The error of the first file with missing rows.
    pub(crate) problem: Option<JournalError>,
}

/// The handle of the filer.
#[derive(Debug)]
pub(crate) struct Filer {
    orders: Sender<Order>,
    thread: JoinHandle<Filed>,
}

/// The pending result of an order to the filer; the thread that serves HTTP awaits it.
pub(crate) struct Receipt<T>(oneshot::Receiver<Result<T, FilingError>>);

type Done<T> = oneshot::Sender<Result<T, FilingError>>;

enum Order {
    Open(u64, Done<()>),
    Rows(u64, Bytes, Done<u64>),
    Report(Bytes, Done<Ending>),
    Close(u64),
}

impl Filer {
    /// Starts the thread; its files are in `out`, and `again` if those of an earlier life may be there.
    pub(crate) fn start(out: &Path, again: bool) -> io::Result<Self> {
        let (orders, queue) = mpsc::channel();
        let files = Files {
            out: out.to_owned(),
            again,
            open: None,
            filed: Filed::default(),
        };
        let thread = thread::Builder::new()
            .name("filer".to_owned())
            .spawn(move || files.work(&queue))?;
        Ok(Self { orders, thread })
    }

    /// Opens the files of session `number`.
    pub(crate) fn open(&self, number: u64) -> Receipt<()> {
        self.order(|done| Order::Open(number, done))
    }

    /// Stores a chunk of rows of the open session; returns the session's total of rows.
    pub(crate) fn rows(&self, chunk: u64, text: Bytes) -> Receipt<u64> {
        self.order(|done| Order::Rows(chunk, text, done))
    }

    /// Stores the report of the open session and closes its files; returns how the session ended.
    pub(crate) fn report(&self, json: Bytes) -> Receipt<Ending> {
        self.order(|done| Order::Report(json, done))
    }

    /// Closes the files of session `number`, if they are still open.
    pub(crate) fn close(&self, number: u64) {
        // A filer that has ended has closed them.
        let _ = self.orders.send(Order::Close(number));
    }

    /// Ends the thread with all files closed.
    pub(crate) fn finish(self) -> Filed {
        drop(self.orders);
        match self.thread.join() {
            Ok(filed) => filed,
            Err(cause) => panic::resume_unwind(cause),
        }
    }

    fn order<T>(&self, order: impl FnOnce(Done<T>) -> Order) -> Receipt<T> {
        let (done, receipt) = oneshot::channel();
        // If the order cannot be sent, `done` is dropped, and the receipt reports that.
        let _ = self.orders.send(order(done));
        Receipt(receipt)
    }
}

impl<T> Receipt<T> {
    /// Waits for the result.
    pub(crate) async fn wait(self) -> Result<T, FilingError> {
        self.0.await.unwrap_or(Err(FilingError::Gone))
    }
}

/// The files of the open session.
struct Folder {
    number: u64,
    chunks: Chunks,
    rows: Recorder<MessageRow>,
    journal: Journal,
}

struct Files {
    out: PathBuf,
    again: bool,
    open: Option<Folder>,
    filed: Filed,
}

impl Files {
    fn work(mut self, queue: &Receiver<Order>) -> Filed {
        while let Ok(order) = queue.recv() {
            // The order is executed even if nobody waits for its result any more.
            match order {
                Order::Open(number, done) => drop(done.send(self.open(number))),
                Order::Rows(chunk, text, done) => drop(done.send(self.rows(chunk, &text))),
                Order::Report(json, done) => drop(done.send(self.report(&json))),
                Order::Close(number) => {
                    if self.open.as_ref().is_some_and(|open| open.number == number) {
                        self.close();
                    }
                }
            }
        }
        self.close();
        self.filed
    }

    fn open(&mut self, number: u64) -> Result<(), FilingError> {
        self.close();
        let path = self.out.join(name("messages", number, "csv"));
        let (rows, journal, _) =
            Journal::open(&path, MessageRow::COLUMNS, MessageRow::write, self.again)?;
        self.open = Some(Folder {
            number,
            chunks: Chunks::default(),
            rows,
            journal,
        });
        Ok(())
    }

    fn rows(&mut self, chunk: u64, text: &[u8]) -> Result<u64, FilingError> {
        let open = self.open.as_mut().ok_or(FilingError::Closed)?;
        if open.chunks.turn(chunk)? == Turn::New {
            let rows = rows::read(text)?;
            open.chunks.take(rows.len() as u64)?;
            for row in rows {
                open.rows.record(row);
            }
        }
        Ok(open.chunks.rows())
    }

    fn report(&mut self, json: &[u8]) -> Result<Ending, FilingError> {
        let ending = Ending::read(json)?;
        // A page that received no answer sends its report again.
        let Some(open) = &self.open else {
            return Ok(ending);
        };
        let path = self.out.join(name("page", open.number, "json"));
        write_whole(&path, json).map_err(|source| FilingError::Write { path, source })?;
        self.close();
        Ok(ending)
    }

    fn close(&mut self) {
        let Some(open) = self.open.take() else {
            return;
        };
        match open.journal.finish(open.rows) {
            Ok(Kept { rows, overflow }) => {
                self.filed.written.rows += rows;
                self.filed.written.overflow += overflow;
            }
            Err(problem) => {
                tracing::warn!(%problem, "rows of a page are missing");
                self.filed.problem.get_or_insert(problem);
            }
        }
    }
}

/// `messages.csv` of the first session, `messages-2.csv` of the second.
fn name(stem: &str, number: u64, extension: &str) -> String {
    match number {
        1 => format!("{stem}.{extension}"),
        _ => format!("{stem}-{number}.{extension}"),
    }
}

/// Writes a file completely or not at all.
fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let partial = path.with_extension("partial");
    let write = || {
        let mut file = File::create(&partial)?;
        file.write_all(content)?;
        file.sync_all()?;
        fs::rename(&partial, path)
    };
    write().inspect_err(|_| drop(fs::remove_file(&partial)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: &[u8] = b"0,5,,,,1,,,,,missed,\n";

    fn wait<T>(receipt: Receipt<T>) -> Result<T, FilingError> {
        receipt.0.blocking_recv().expect("the filer lives")
    }

    #[test]
    fn each_session_has_its_files_and_the_rows_are_summed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let filer = Filer::start(folder.path(), false).expect("a thread");
        let text = |name| fs::read_to_string(folder.path().join(name)).ok();
        wait(filer.open(1)).expect("a new file");
        let rows = |chunk, text| wait(filer.rows(chunk, Bytes::from_static(text)));
        assert_eq!(rows(0, ROW).expect("a row"), 1);
        assert_eq!(rows(0, ROW).expect("the same"), 1);
        assert!(matches!(rows(1, b"no row"), Err(FilingError::Row(_))));
        assert_eq!(rows(1, ROW).expect("another"), 2);
        assert!(matches!(rows(3, ROW), Err(FilingError::Turn(_))));
        let report = |text| wait(filer.report(Bytes::from_static(text)));
        assert!(matches!(report(b"{"), Err(FilingError::Report(_))));
        report(b"{\"a\": 1}").expect("JSON");
        report(b"{\"b\": 1}").expect("said before");
        assert!(matches!(rows(2, ROW), Err(FilingError::Closed)));
        assert_eq!(text("page.json").expect("the report"), "{\"a\": 1}");
        assert_eq!(text("messages.csv").expect("rows").lines().count(), 3);

        // The second session ends without a report; the third begins all the same.
        wait(filer.open(2)).expect("a new file");
        filer.close(1);
        assert_eq!(rows(0, ROW).expect("a row"), 1);
        wait(filer.open(3)).expect("a new file");
        filer.close(3);
        let filed = filer.finish();
        assert!(filed.problem.is_none());
        assert_eq!((filed.written.rows, filed.written.overflow), (3, 0));
        assert!(text("page-2.json").is_none());
        assert_eq!(text("messages-2.csv").expect("rows").lines().count(), 2);
        assert_eq!(text("messages-3.csv").expect("rows").lines().count(), 1);
    }

    #[test]
    fn a_file_that_is_there_already_is_named_and_kept() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("messages.csv"), "old").expect("a writable folder");
        let filer = Filer::start(folder.path(), false).expect("a thread");
        let error = wait(filer.open(1)).expect_err("the file is there");
        assert!(error.to_string().contains("messages.csv"), "{error}");
        filer.finish();
    }
}
