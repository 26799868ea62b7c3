//! Runs trials: starts the controllers, sees how they end, and judges what their plants heard.
//!
//! A few trials run at once, each on a thread of its own, which has to live as long as its controllers.

use std::fs;
use std::io;
use std::net::SocketAddr;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clock::now::now_ns;
use endpoint::Mode;
use endpoint::report::Own;
use process::{Role, last_words};

use crate::check::{OVERTIME_NS, TERM_WITHIN_NS};
use crate::error::Error;
use crate::outcome::TrialResult;
use crate::plant::Plant;
use crate::record::{Ending, Record};
use crate::trial::{LEAD_NS, Script, TERMINATE_NS, Trial};

/// The name under which a controller has to be started: its log and its report have it.
pub const NAME: &str = "controller";

/// How many trials run at once. Two processors are enough for five controllers at 100 Hz.
const TOGETHER: usize = 5;

/// How often to look at controllers.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// What starts a controller: for the plant at this address, with this start (`CLOCK_MONOTONIC`, ns), as
/// the trial says, and with its files in this folder.
pub type Start<'a> =
    dyn Fn(SocketAddr, u64, &Trial, &Path) -> Result<Role, process::Error> + Sync + 'a;

/// Runs trials, and gives their outcomes in the same order. Each controller has a folder of its own in
/// `folder`. Ends early when `stop` is set.
///
/// # Errors
/// [`Error`] if the trials cannot be run; whatever a controller does wrong is in its outcome.
pub fn run(
    trials: &[Trial],
    start: &Start<'_>,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<Vec<TrialResult>, Error> {
    let next = AtomicUsize::new(0);
    let work = || -> Result<Vec<(usize, TrialResult)>, Error> {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(trial) = trials.get(index) else {
                return Ok(done);
            };
            done.push((index, try_out(trial, start, folder, stop)?));
        }
    };
    let mut done = thread::scope(|scope| {
        let threads: Vec<_> = (0..TOGETHER)
            .map(|_| {
                let builder = thread::Builder::new().name("trial".to_owned());
                builder.spawn_scoped(scope, work)
            })
            .collect::<io::Result<_>>()?;
        let mut done = Vec::new();
        for thread in threads {
            let part = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
            done.extend(part?);
        }
        Ok::<_, Error>(done)
    })?;
    done.sort_by_key(|(index, _)| *index);
    Ok(done.into_iter().map(|(_, outcome)| outcome).collect())
}

/// Runs one trial.
fn try_out(
    trial: &Trial,
    start: &Start<'_>,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<TrialResult, Error> {
    let began = Instant::now();
    let start_ns = now_ns() + LEAD_NS;
    let mut controllers = Vec::new();
    for number in 1..=trial.controllers {
        let name = match trial.controllers {
            1 => trial.name.to_owned(),
            _ => format!("{}-{number}", trial.name),
        };
        let folder = folder.join(name);
        fs::create_dir_all(&folder).map_err(|source| Error::Folder {
            path: folder.clone(),
            source,
        })?;
        let plant = Plant::open(trial, start_ns)?;
        let role = start(plant.address, start_ns, trial, &folder)?;
        controllers.push(Controller {
            role,
            plant,
            folder,
            ending: Ending::default(),
        });
    }
    watch(trial, start_ns, &mut controllers, stop)?;
    let records = controllers
        .into_iter()
        .map(|controller| controller.record(trial, start_ns))
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(TrialResult::of(trial, &records, began.elapsed()))
}

/// Waits until all controllers have ended, or should have.
fn watch(
    trial: &Trial,
    start_ns: u64,
    controllers: &mut [Controller],
    stop: &AtomicBool,
) -> Result<(), Error> {
    /// Later than any accepted end, ns.
    const MARGIN_NS: u64 = 100_000_000;
    let term_ns = (trial.script == Script::Terminate).then_some(start_ns + TERMINATE_NS);
    let end_ns = match term_ns {
        Some(term_ns) => term_ns + TERM_WITHIN_NS + MARGIN_NS,
        None => trial.stop_ns(start_ns) + OVERTIME_NS + MARGIN_NS,
    };
    loop {
        let t_ns = now_ns();
        for controller in &mut *controllers {
            controller.look(t_ns, term_ns);
        }
        let mut endings = controllers.iter().map(|one| one.ending.ended_ns);
        if t_ns > end_ns || endings.all(|ended_ns| ended_ns.is_some()) {
            return Ok(());
        }
        if stop.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        thread::sleep(LOOK_EVERY);
    }
}

/// A running controller with its plant.
struct Controller {
    role: Role,
    plant: Plant,
    folder: PathBuf,
    ending: Ending,
}

impl Controller {
    /// Sees whether it has ended, and sends it SIGTERM when that is due.
    fn look(&mut self, t_ns: u64, term_ns: Option<u64>) {
        if self.ending.ended_ns.is_some() {
            return;
        }
        match self.role.ended() {
            Ok(false) => {
                let is_due = term_ns.is_some_and(|term_ns| t_ns >= term_ns);
                if is_due && self.ending.told_ns.is_none() {
                    self.role.terminate();
                    self.ending.told_ns = Some(t_ns);
                }
            }
            Ok(true) => self.ending.ended_ns = Some(t_ns),
            Err(problem) => {
                self.ending.ended_ns = Some(t_ns);
                self.ending.problem = Some(problem.to_string());
            }
        }
    }

    /// All that was seen of it. Ends it if it still runs.
    fn record(self, trial: &Trial, start_ns: u64) -> Result<Record, Error> {
        let Controller {
            mut role,
            plant,
            folder,
            mut ending,
        } = self;
        let lacks_something = role.lacks_something();
        // Its log and its report are whole when it has ended.
        drop(role);
        let heard = plant.close()?;
        let report = report(&folder);
        let words = last_words(&folder, NAME).replace("webloop: ", "");
        // Without a report the program was not even started.
        if lacks_something && report.is_none() && trial.mode == Mode::Closed {
            return Err(Error::Lacking(words));
        }
        ending.is_unsupported = lacks_something;
        ending.is_killed = report.as_ref().is_some_and(|report| report.killed);
        if let Some(problem) = &mut ending.problem
            && !words.is_empty()
        {
            let words = words.replace('\n', "; ");
            *problem = match report {
                // The supervisor did its work, and its words are the last.
                Some(_) => words,
                None => format!("{problem}: {words}"),
            };
        }
        Ok(Record {
            start_ns,
            heard,
            ending,
        })
    }
}

/// What the supervisor reports, if it has.
fn report(folder: &Path) -> Option<Own> {
    let text = fs::read(folder.join(format!("{NAME}.json"))).ok()?;
    serde_json::from_slice(&text).ok()
}
