//! Runs a cell's program as a process of its own, which dies with the thread that started it.

use std::fs::File;
use std::io::{self, Read};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use crate::error::Error;
use crate::jobs::Program;
use crate::queue::Turn;

/// How often to check the stop flag.
const POLL: Duration = Duration::from_millis(20);

/// How often to check on a process that has said its last words: it is about to end.
const SOON: Duration = Duration::from_millis(1);

/// Runs cells as processes, by the command that a function makes from a turn and its tries.
pub struct Processes<F>(pub F);

impl<F: Fn(&Turn<'_>, u8) -> Command + Sync> Program for Processes<F> {
    fn run(&self, turn: &Turn<'_>, tries: u8, stop: &AtomicBool) -> Result<String, Error> {
        let mut command = (self.0)(turn, tries);
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        backend::spawn::bind(&mut command, None::<&File>)?;
        let mut child = command.spawn().map_err(cannot("start"))?;
        wait(&mut child, stop)
    }
}

/// Waits for a process, which is told to end once `stop` is set; its last words.
fn wait(child: &mut Child, stop: &AtomicBool) -> Result<String, Error> {
    let (give, said) = mpsc::channel();
    // Read on a thread of its own, so that the process never blocks on a full pipe.
    if let Some(mut stderr) = child.stderr.take() {
        thread::spawn(move || {
            let mut said = Vec::new();
            let _ = stderr.read_to_end(&mut said);
            let _ = give.send(text::plain(String::from_utf8_lossy(&said).trim()).into_owned());
        });
    }
    let mut words: Option<String> = None;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(cannot("wait for"))? {
            break status;
        }
        if stop.load(Ordering::Relaxed) {
            backend::spawn::terminate(child);
        }
        if words.is_some() {
            thread::sleep(SOON);
        } else {
            words = match said.recv_timeout(POLL) {
                Err(RecvTimeoutError::Timeout) => None,
                said => Some(said.unwrap_or_default()),
            };
        }
    };
    let words = words.or_else(|| said.recv().ok()).unwrap_or_default();
    Ok(match words.as_str() {
        "" => format!("its process ended with {status}"),
        _ => words,
    })
}

fn cannot(step: &'static str) -> impl Fn(io::Error) -> Error {
    move |source| Error::Process { step, source }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use plan::Cell;

    use super::*;
    use crate::queue::Queue;
    use crate::sample::{now_ns, plan};

    /// The last words of a shell script, which is told to end once `stop` is set.
    fn said(script: &str, stop: &AtomicBool) -> String {
        let plan = plan(&[("\"native\"", "\"10ms\"", 1)]);
        let cells: Vec<&Cell> = plan.cells.iter().collect();
        let turn = Queue::new(&cells, None, now_ns)
            .next(&false.into())
            .unwrap();
        let program = Processes(|_: &Turn<'_>, tries: u8| {
            let mut command = Command::new("sh");
            command.args(["-c", script, "sh", &tries.to_string()]);
            command
        });
        program.run(&turn, 3, stop).unwrap()
    }

    #[test]
    fn a_process_says_its_last_words_and_else_how_it_ended() {
        let said = |script, stop: bool| said(script, &stop.into());
        assert_eq!(said("echo tries $1 >&2; echo not this", false), "tries 3");
        assert!(said("exit 7", false).contains('7'));
        assert!(said("exec sleep 60", true).contains("signal"));
        // One that says no more and goes on is waited for, and may be told to end.
        assert!(said("exec 2>&-; sleep 0.1; exit 7", false).contains('7'));
        assert!(said("exec sleep 60 2>&-", true).contains("signal"));
    }

    #[test]
    fn a_process_that_does_not_end_when_it_is_told_is_told_again() {
        let folder = tempfile::tempdir().unwrap();
        let ready = folder.path().join("ready");
        let script = format!(
            "n=0; trap 'n=$((n + 1)); [ $n -lt 3 ] || {{ echo told $n >&2; exit; }}' TERM; : > {}; \
             while :; do sleep 0.01; done",
            ready.display()
        );
        let stop = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                while !ready.exists() {
                    thread::sleep(SOON);
                }
                stop.store(true, Ordering::Relaxed);
            });
            assert_eq!(said(&script, &stop), "told 3");
        });
    }
}
