//! Writes the player's rows as CSV, on a thread of its own, so that a slow disk does not hold up a packet.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use serde::Serialize;

use crate::error::{Doing, Result};

/// Seconds of rows that may wait for the disk before rows are missed.
const WAITING: usize = 512;

/// A thread that writes a player's rows `R`, second by second.
#[derive(Debug)]
pub struct Record<R> {
    rows: SyncSender<Vec<R>>,
    missed: u64,
    writer: JoinHandle<io::Result<()>>,
}

impl<R: Serialize + Send + 'static> Record<R> {
    /// Starts the thread. Call this before [`play`](crate::play), or the thread would inherit its scheduling.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) if no thread can be started.
    pub fn start(sink: impl Write + Send + 'static) -> Result<Self> {
        let (rows, waiting) = sync_channel(WAITING);
        let writer = thread::Builder::new()
            .name("link record".into())
            .spawn(move || write(sink, &waiting))
            .doing("start the thread that records the link")?;
        Ok(Self {
            rows,
            missed: 0,
            writer,
        })
    }

    /// Passes on the rows of a second, one for each way that is played, without waiting.
    pub fn add<const WAYS: usize>(&mut self, rows: [R; WAYS]) {
        self.add_all(rows.into());
    }

    /// Passes on any number of rows, without waiting.
    pub fn add_all(&mut self, rows: Vec<R>) {
        let count = rows.len() as u64;
        if count > 0 && self.rows.try_send(rows).is_err() {
            self.missed += count;
        }
    }

    /// Writes the rows that wait and ends the thread.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) if a row could not be written, for instance because
    /// the disk is full, or so slow that rows were missed.
    pub fn finish(self) -> Result<()> {
        drop(self.rows);
        self.writer
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            .and_then(|()| match self.missed {
                0 => Ok(()),
                missed => Err(io::Error::other(format!(
                    "the disk was too slow for {missed} rows"
                ))),
            })
            .doing("record what the link did")
    }
}

fn write(sink: impl Write, rows: &Receiver<Vec<impl Serialize>>) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(sink);
    for second in rows {
        for row in second {
            csv.serialize(row)?;
        }
        // Every row should be on the disk within a second.
        csv.flush()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::player::tally::Tally;
    use link::Way;
    use link::certificate::LinkRow;
    use std::fs::{self, OpenOptions};

    fn second(t_ns: u64) -> [LinkRow; 2] {
        [Way::Up, Way::Down].map(|way| {
            let mut tally = Tally::new(way);
            tally.entered(1, 84, Ok(link::Twist::NONE));
            tally.left(1, 1_500, true);
            tally.row(t_ns)
        })
    }

    #[test]
    fn rows_are_on_the_disk_when_the_record_is_finished() {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        let mut record = Record::start(file.reopen().expect("the file")).expect("a thread");
        record.add(second(7));
        record.finish().expect("room on the disk");
        let text = fs::read_to_string(file.path()).expect("the file");
        assert_eq!(
            text,
            "t_ns,way,packets,bytes,delivered,lost,overflow,foreign,dropped,late_mean_us,late_max_us\n\
             7,up,1,84,1,0,0,0,0,1.5,1.5\n\
             7,down,1,84,1,0,0,0,0,1.5,1.5\n"
        );
    }

    #[test]
    fn a_full_disk_is_an_error_at_the_end() {
        let full = OpenOptions::new().write(true).open("/dev/full");
        let mut record = Record::start(full.expect("/dev/full")).expect("a thread");
        record.add(second(7));
        let error = record.finish().expect_err("no room");
        assert!(
            error.to_string().contains("record what the link did"),
            "{error}"
        );
    }
}
