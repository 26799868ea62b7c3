//! `webloop conform`: tests whether a controller or a plant keeps its contract, and prints the outcome of each
//! trial.

use std::fs::{self, File};
use std::io::Write;
use std::net::SocketAddr;
use std::path::{Path, absolute};

use ::conform::PlantFault;
use ::conform::{NAME, PLANT_TRIALS, Trial, Verdict, run_plant};
use anyhow::{Context, anyhow};
use backend::{ControllerRole, start_plant};
use endpoint::{ControllerSettings, Policy};
use plan::{Client, Program};
use process::{Launch, Role};

use crate::argument::Conform;
use crate::exit::{Exit, Failure, Outcome};
use crate::stop;

/// The controller's name in its settings and its report.
const CLIENT: &str = "mine";

/// The seed that a plant is told.
const SEED: u64 = 1;

/// Runs all trials, or lists them.
pub(crate) fn run(argument: &Conform) -> Outcome {
    if argument.plant {
        return test_plant(argument);
    }
    let trials = Trial::all(argument.h);
    let mut out = crate::console::out();
    if argument.list {
        for trial in &trials {
            writeln!(out, "{:<12}{}", trial.name, trial.asks)?;
        }
        return Ok(Exit::Fine);
    }
    // First of all: a user namespace can only be entered while there is one thread.
    shaper::become_root().map_err(Failure::unsupported)?;
    let stop = stop::told_to_end()?;
    let temporary = tempfile::tempdir().context("cannot make a folder for the trials")?;
    let folder = match &argument.keep {
        Some(folder) => fresh(folder)?,
        None => temporary.path(),
    };
    let folder = absolute(folder)?;
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    let client = Client::Own(CLIENT.parse()?);
    let start = |plant: SocketAddr, start_ns: u64, trial: &Trial, folder: &Path| {
        let role = ControllerRole {
            client,
            plant,
            settings: ControllerSettings {
                r: trial.r,
                ..ControllerSettings::new(trial.mode, trial.h)
            },
            claim: false,
            check: false,
            scheduling: Policy::Fifo,
            page: None,
            system: None,
            program: Some(Program::new(argument.command.clone())),
            start_ns: Some(start_ns),
            again: false,
            duration_ns: trial.duration_ns,
            reference: None,
        };
        // Plain fields under fixed names: serialising them cannot fail.
        let settings = serde_json::to_value(&role).unwrap_or_default();
        let launch = Launch {
            program: &program,
            role: client.spec().role,
            name: NAME,
            settings: &settings,
            folder,
            is_watched: false,
        };
        Role::launch(&launch, None::<&File>)
    };
    let outcomes = match ::conform::run(&trials, &start, &folder, &stop) {
        Ok(outcomes) => outcomes,
        Err(::conform::Error::Interrupted) => return Ok(Exit::Interrupted),
        Err(problem @ ::conform::Error::Lacking(_)) => return Err(Failure::unsupported(problem)),
        Err(problem) => return Err(problem.into()),
    };
    if tell(argument, &outcomes)? {
        return Ok(Exit::Fine);
    }
    match &argument.keep {
        Some(folder) => writeln!(out, "What it printed is in {}.", folder.display())?,
        None => writeln!(out, "With --keep DIR what it printed is kept.")?,
    }
    Ok(Exit::Failed)
}

/// The same for a plant. What it prints beside its numbers is printed here.
fn test_plant(argument: &Conform) -> Outcome {
    if argument.list {
        for trial in &PLANT_TRIALS {
            writeln!(crate::console::out(), "{:<12}{}", trial.name, trial.asks)?;
        }
        return Ok(Exit::Fine);
    }
    let stop = stop::told_to_end()?;
    let program = Program::new(argument.command.clone());
    let start = |h| {
        start_plant(&program, argument.inputs, h, SEED, None)
            .map_err(|problem| PlantFault::Broken(problem.to_string()))
    };
    match run_plant(&start, argument.h, &stop) {
        Ok(outcomes) if tell(argument, &outcomes)? => Ok(Exit::Fine),
        Ok(_) => Ok(Exit::Failed),
        Err(::conform::Error::Interrupted) => Ok(Exit::Interrupted),
        Err(problem) => Err(problem.into()),
    }
}

/// Prints the outcomes, and writes them where that is asked for. Returns whether no trial failed.
fn tell(argument: &Conform, outcomes: &[::conform::TrialResult]) -> Result<bool, Failure> {
    if let Some(file) = &argument.junit {
        fs::write(file, ::conform::junit(outcomes))
            .with_context(|| format!("cannot write {}; give another --junit", file.display()))
            .map_err(Failure::usage)?;
    }
    write!(crate::console::out(), "{}", ::conform::table(outcomes))?;
    Ok(outcomes.iter().all(|one| one.verdict != Verdict::Failed))
}

/// Makes the folder to keep. One that has files may have the logs of another controller.
fn fresh(folder: &Path) -> Result<&Path, Failure> {
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make {}; give another --keep", folder.display()))
        .map_err(Failure::usage)?;
    if fs::read_dir(folder)?.next().is_some() {
        return Err(Failure::usage(anyhow!(
            "{} is not empty; give --keep a new folder",
            folder.display()
        )));
    }
    Ok(folder)
}
