//! A plant of one's own: its program, started with what it is told.

use std::time::Duration;

use agent::plant::{PlantProgram, Start};
use endpoint::SampleTime;
use plan::Program;

/// How long a program may take from its start to its first y: an interpreter with its libraries needs
/// seconds.
const START_WITHIN: Duration = Duration::from_secs(30);

/// How long a step may take in a real run before the program counts as broken; that it is merely slow, the
/// ticks tell that come late.
const REAL_STEP_WITHIN: Duration = Duration::from_secs(1);

/// How long it may take in virtual time, which waits for it.
const SIMULATED_STEP_WITHIN: Duration = Duration::from_secs(60);

/// Starts a program as the plant of a real run, with so many inputs and for steps of h, and confines it where
/// this user may.
///
/// # Errors
/// A sentence that says what the program does in place of printing its first y.
pub fn start_plant(
    program: &Program,
    inputs: usize,
    h: SampleTime,
    seed: u64,
) -> Result<PlantProgram, String> {
    start(program, inputs, h, seed, REAL_STEP_WITHIN, true)
}

/// Starts a program as a plant in virtual time.
pub(crate) fn start_simulated(
    program: &Program,
    inputs: usize,
    h: SampleTime,
    seed: u64,
) -> Result<PlantProgram, String> {
    start(program, inputs, h, seed, SIMULATED_STEP_WITHIN, false)
}

fn start(
    program: &Program,
    inputs: usize,
    h: SampleTime,
    seed: u64,
    step_within: Duration,
    is_confined: bool,
) -> Result<PlantProgram, String> {
    // The program inherits it, so it may be closed here once that has started.
    let package = python::package().map_err(|problem| problem.to_string())?;
    PlantProgram::start(&Start {
        run: &program.run,
        environment: vec![
            ("WEBLOOP_H_S", format!("{:?}", h.seconds()).into()),
            ("WEBLOOP_SEED", seed.to_string().into()),
            ("PYTHONPATH", python::path(&package)),
        ],
        inputs,
        h_ns: h.ns(),
        start_within: START_WITHIN,
        step_within,
        is_confined,
    })
}
