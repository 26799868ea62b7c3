//! Runs a cell's program as a process of its own, which dies with the thread that started it.

use std::fs::File;
use std::io::{self, Read};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use crate::error::Error;
use crate::jobs::{Program, Running};
use crate::queue::Turn;

/// Runs cells as processes, by the command that a function makes from a turn and its tries.
pub struct Processes<F>(pub F);

impl<F: Fn(&Turn<'_>, u8) -> Command + Sync> Program for Processes<F> {
    fn start(&self, turn: &Turn<'_>, tries: u8) -> Result<Box<dyn Running>, Error> {
        let mut command = (self.0)(turn, tries);
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        backend::spawn::bind(&mut command, None::<&File>)?;
        let mut child = command.spawn().map_err(cannot("start"))?;
        // Read on a thread of its own, so that the process never blocks on a full pipe.
        let said = child.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut said = Vec::new();
                let _ = stderr.read_to_end(&mut said);
                endpoint::plain(String::from_utf8_lossy(&said).trim()).into_owned()
            })
        });
        Ok(Box::new(Process { child, said }))
    }
}

/// A running process.
struct Process {
    child: Child,
    /// The thread that reads its standard error.
    said: Option<JoinHandle<String>>,
}

impl Running for Process {
    fn ended(&mut self) -> Result<Option<String>, Error> {
        let Some(status) = self.child.try_wait().map_err(cannot("wait for"))? else {
            return Ok(None);
        };
        let said = self.said.take().and_then(|reader| reader.join().ok());
        let said = said.filter(|said| !said.is_empty());
        Ok(Some(said.unwrap_or_else(|| {
            format!("its process ended with {status}")
        })))
    }

    fn terminate(&mut self) {
        backend::spawn::terminate(&mut self.child);
    }
}

fn cannot(step: &'static str) -> impl Fn(io::Error) -> Error {
    move |source| Error::Process { step, source }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::time::Duration;

    use plan::Cell;

    use super::*;
    use crate::queue::Queue;
    use crate::sample::{now_ns, plan};

    /// The last words of a shell script, which is told to end at once if `terminate`.
    fn said(script: &'static str, terminate: bool) -> String {
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
        let mut running = program.start(&turn, 3).unwrap();
        loop {
            if terminate {
                running.terminate();
            }
            if let Some(said) = running.ended().unwrap() {
                return said;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_process_says_its_last_words_and_else_how_it_ended() {
        assert_eq!(said("echo tries $1 >&2; echo not this", false), "tries 3");
        assert!(said("exit 7", false).contains('7'));
        assert!(said("exec sleep 60", true).contains("signal"));
    }
}
