//! The output lines of a running command: passed on as they come, and the last ones kept.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read};
use std::process::Child;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// Number of lines to keep: enough to see what went wrong, few enough to read.
const KEPT: usize = 12;

/// Output of a child on both its streams, read on threads so that the child never blocks.
pub(crate) struct Tail {
    kept: Arc<Mutex<VecDeque<String>>>,
    readers: Vec<JoinHandle<()>>,
}

impl Tail {
    /// Reads the output of `child` to its end, and calls `each` with every line.
    pub(crate) fn of(child: &mut Child, each: impl Fn(&str) + Clone + Send + 'static) -> Tail {
        let mut tail = Tail {
            kept: Arc::default(),
            readers: Vec::new(),
        };
        if let Some(stream) = child.stdout.take() {
            tail.read(stream, each.clone());
        }
        if let Some(stream) = child.stderr.take() {
            tail.read(stream, each);
        }
        tail
    }

    fn read(&mut self, stream: impl Read + Send + 'static, each: impl Fn(&str) + Send + 'static) {
        let kept = Arc::clone(&self.kept);
        self.readers.push(std::thread::spawn(move || {
            let mut stream = BufReader::new(stream);
            let mut bytes = Vec::new();
            while matches!(stream.read_until(b'\n', &mut bytes), Ok(n) if n > 0) {
                let line = String::from_utf8_lossy(&bytes);
                let line = line.trim_end();
                each(line);
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                if kept.len() == KEPT {
                    kept.pop_front();
                }
                kept.push_back(line.to_owned());
                drop(kept);
                bytes.clear();
            }
        }));
    }

    /// The last lines of a child that has ended, without Compose's own report of its steps, which
    /// is indented.
    pub(crate) fn words(&mut self) -> String {
        for reader in self.readers.drain(..) {
            let _ = reader.join();
        }
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let said: Vec<&str> = kept
            .iter()
            .map(String::as_str)
            .filter(|line| !line.is_empty() && !line.starts_with(' '))
            .collect();
        said.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Stdio};
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn every_line_is_handed_on_and_the_last_are_kept() {
        let mut child = Command::new("sh")
            .args([
                "-c",
                "i=0; while [ $i -lt 40 ]; do echo $i; i=$((i+1)); done; echo ' Container made' >&2",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("sh is there");
        let (sender, lines) = mpsc::channel();
        let mut tail = Tail::of(&mut child, move |line| {
            let _ = sender.send(line.to_owned());
        });
        child.wait().expect("it ends");
        let words = tail.words();
        assert!(
            words.ends_with("38\n39") && !words.contains("made"),
            "{words}"
        );
        assert!(words.lines().count() <= KEPT);
        assert_eq!(lines.iter().count(), 41);
    }
}
