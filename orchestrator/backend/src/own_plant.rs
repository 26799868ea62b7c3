//! A plant of one's own: its program, started with what it is told.

use std::path::Path;
use std::time::Duration;

use endpoint::SampleTime;
use plan::{Program, file_name};
use process::Hidden;
use process::plant::{BrokenPlant, Confinement, PlantProgram, Start};

/// How long a program may take from its start to its first y: an interpreter with its libraries needs
/// seconds.
const START_WITHIN: Duration = Duration::from_secs(30);

/// How long a step may take in a real run before the program counts as broken; that it is merely slow, the
/// ticks tell that come late.
const REAL_STEP_WITHIN: Duration = Duration::from_secs(1);

/// How long it may take in virtual time, which waits for it.
const SIMULATED_STEP_WITHIN: Duration = Duration::from_secs(60);

/// What a program must not see of a run whose parts write to `out`: the folders of all cells, except `kept` in there.
/// `None` where `out` is no cell's folder in a campaign, as when an end is served by hand.
#[must_use]
pub fn hidden(out: &Path, kept: Option<&Path>) -> Option<Hidden> {
    let cells = out.parent()?;
    (cells.file_name()? == file_name::CELLS).then(|| Hidden {
        folder: cells.to_owned(),
        kept: kept.map(Path::to_owned),
    })
}

/// Starts a program as the plant of a real run, with so many inputs and for steps of h, and confines it where
/// this user may.
///
/// # Errors
/// [`BrokenPlant`] with what the program does in place of printing its first y.
pub fn start_plant(
    program: &Program,
    inputs: usize,
    h: SampleTime,
    seed: u64,
    hidden: Option<Hidden>,
) -> Result<PlantProgram, BrokenPlant> {
    let confinement = Confinement::Confined(hidden);
    start(program, inputs, h, seed, REAL_STEP_WITHIN, confinement)
}

/// Starts a program as a plant whose steps are waited for: in virtual time.
///
/// # Errors
/// [`BrokenPlant`] with what the program does in place of printing its first y.
pub fn start_simulated(
    program: &Program,
    inputs: usize,
    h: SampleTime,
    seed: u64,
) -> Result<PlantProgram, BrokenPlant> {
    let within = SIMULATED_STEP_WITHIN;
    start(program, inputs, h, seed, within, Confinement::None)
}

fn start(
    program: &Program,
    inputs: usize,
    h: SampleTime,
    seed: u64,
    step_within: Duration,
    confinement: Confinement,
) -> Result<PlantProgram, BrokenPlant> {
    PlantProgram::start(&Start {
        run: &program.run,
        environment: vec![
            ("WEBLOOP_H_S", format!("{:?}", h.seconds()).into()),
            ("WEBLOOP_SEED", seed.to_string().into()),
        ],
        inputs,
        h_ns: h.ns(),
        start_within: START_WITHIN,
        step_within,
        confinement,
    })
}
