//! `webloop sweep FILE`: what `webloop run FILE` does, from before sweeps were experiments.

use anyhow::anyhow;
use plan::{EXPERIMENTS, Instead};

use crate::argument::Run;
use crate::command::run;
use crate::exit::{Failure, Outcome};
use crate::source;

/// The sweep that had the name of another experiment.
const RENAMED: (&str, &str) = ("systems", "system-margins");

/// Runs a sweep, and says how it is run now.
pub(crate) fn run(mut argument: Run) -> Outcome {
    if argument.experiment == RENAMED.0 {
        RENAMED.1.clone_into(&mut argument.experiment);
    }
    let asked = argument.experiment();
    let plan = run::plan(&argument)?;
    if plan.sweep.is_none() {
        let names = EXPERIMENTS.iter().map(|(name, _)| *name);
        let sweeps: Vec<&str> = names.filter(|name| is_sweep(name)).collect();
        return Err(Failure::usage(anyhow!(
            "{asked} is no sweep; `webloop run` runs it, and the sweeps {}, or your own",
            sweeps.join(", ")
        )));
    }
    say!("webloop: a sweep is an experiment now: webloop run {asked}");
    run::run_plan(&argument, &plan, None)
}

/// Whether a built-in experiment is a sweep.
fn is_sweep(name: &str) -> bool {
    source::plan_of(name, &Instead::default()).is_ok_and(|plan| plan.sweep.is_some())
}
