//! Echoes with their two halves in two places: sent beside the controller, seen beside the plant.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clock::now::now_ns;
use containers::{RemoteRun, RoleState};
use link::certificate::{Echo, Sighting, merge};
use plan::file_name;
use serde::de::DeserializeOwned;
use shaper::ProbePlan;

use crate::error::RunError;

/// How often to check for the end of a series that is nearly over.
const POLL: Duration = Duration::from_millis(100);

/// How near its end a series has to be for that: a request is work for a machine that is measuring.
const NEARLY: Duration = Duration::from_secs(1);

/// How long the plant's side may take to write down what it has seen.
const SEEN_WITHIN: Duration = Duration::from_secs(2);

/// Asks for a series of echoes to be sent, and waits for its end.
pub(crate) fn ask(
    run: &RemoteRun,
    plan: &ProbePlan,
    stop: &AtomicBool,
) -> Result<Vec<Echo>, RunError> {
    let instance = format!("ask-{}", plan.id);
    // Plain numbers under fixed names: serialising them cannot fail.
    run.start(
        &instance,
        "ask",
        serde_json::to_value(plan).unwrap_or_default(),
    )?;
    let last_ns = plan.start_ns + u64::from(plan.count()) * plan.interval_ns;
    loop {
        if stop.load(Ordering::Relaxed) {
            run.stop(&instance)?;
            return Err(RunError::Interrupted);
        }
        let left = Duration::from_nanos(last_ns.saturating_sub(now_ns()));
        if left > NEARLY {
            thread::sleep(POLL);
            continue;
        }
        match run.state(&instance)? {
            RoleState::Running => thread::sleep(POLL),
            RoleState::Ended { code: 0, .. } => break,
            RoleState::Ended { code, words } => {
                return Err(RunError::Echoes(format!(
                    "the echoes ended with exit code {code}: {words}"
                )));
            }
        }
    }
    rows(run, &format!("echoes-{}.csv", plan.id))
}

/// Completes the echoes with what was seen of them at the plant.
pub(crate) fn completed(
    witness: &RemoteRun,
    echoes: &[Echo],
    id: u16,
) -> Result<Vec<Echo>, RunError> {
    let deadline = Instant::now() + SEEN_WITHIN;
    loop {
        let sightings: Vec<Sighting> = rows(witness, file_name::SIGHTINGS)?;
        let merged = merge(echoes, id, &sightings);
        // An echo that was answered was seen, though the row may not be written yet.
        let all = merged
            .iter()
            .all(|echo| echo.t_back_ns.is_none() || echo.t_reach_ns.is_some());
        if all || Instant::now() > deadline {
            return Ok(merged);
        }
        thread::sleep(POLL);
    }
}

fn rows<T: DeserializeOwned>(run: &RemoteRun, name: &str) -> Result<Vec<T>, RunError> {
    let bytes = run.file(name)?.unwrap_or_default();
    // Leaves out a row that is still being written.
    let whole = bytes
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |end| end + 1);
    csv::Reader::from_reader(&bytes[..whole])
        .deserialize()
        .collect::<Result<_, _>>()
        .map_err(|problem| RunError::Echoes(format!("{name} cannot be read: {problem}")))
}
