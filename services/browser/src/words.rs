//! Keeps the end of a program's output on standard error.

use std::{
    collections::VecDeque,
    io::{BufRead, BufReader, Read},
    sync::{Arc, Mutex, PoisonError},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

/// Number of last lines that are kept and quoted.
const LINES: usize = 3;

/// Bytes of a line that are kept.
const LINE_BYTES: u64 = 300;

/// How long to wait for the last output.
const DRAIN: Duration = Duration::from_secs(1);

/// The last output of a program.
pub(crate) struct Words {
    lines: Arc<Mutex<VecDeque<String>>>,
    reader: JoinHandle<()>,
}

impl Words {
    /// Reads on a thread of its own, so that the program never waits for a
    /// full pipe. The thread ends when all writers have closed the pipe.
    pub(crate) fn of(stream: impl Read + Send + 'static) -> Self {
        let lines = Arc::new(Mutex::new(VecDeque::new()));
        let kept = Arc::clone(&lines);
        let reader = thread::spawn(move || {
            let mut stream = BufReader::new(stream);
            let mut bytes = Vec::new();
            loop {
                bytes.clear();
                // A longer line continues as the next line.
                match stream
                    .by_ref()
                    .take(LINE_BYTES)
                    .read_until(b'\n', &mut bytes)
                {
                    Ok(0) | Err(_) => break,
                    Ok(_) => {}
                }
                let line = text::plain(String::from_utf8_lossy(&bytes).trim()).into_owned();
                if line.is_empty() {
                    continue;
                }
                tracing::debug!("{line}");
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                if kept.len() == LINES {
                    kept.pop_front();
                }
                kept.push_back(line);
            }
        });
        Self { lines, reader }
    }

    /// Waits for all output of a program that has ended, at most `DRAIN`.
    pub(crate) fn drain(&self) {
        let deadline = Instant::now() + DRAIN;
        while !self.reader.is_finished() && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// The last lines joined into one.
    pub(crate) fn last(&self) -> String {
        let lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        if lines.is_empty() {
            "none".to_owned()
        } else {
            Vec::from_iter(lines.iter().map(String::as_str)).join(" / ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_lines_are_kept_and_none_is_endless() {
        let words = |text: Vec<u8>| {
            let words = Words::of(std::io::Cursor::new(text));
            words.drain();
            words.last()
        };
        assert_eq!(words(b"a\n\nb\r\n c \nd".to_vec()), "b / c / d");
        assert_eq!(words(Vec::new()), "none");
        assert!(words(vec![b'x'; 1 << 20]).len() <= 1000);
    }
}
