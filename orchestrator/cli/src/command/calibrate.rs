//! `webloop calibrate`: runs the experiment of that name, and writes the timings of this machine.

use std::io::Write;

use analysis::Campaign;
use anyhow::{Context, anyhow};
use campaign::{CampaignFolder, calibration};
use plan::Instead;

use crate::argument::{Argument, Calibrate, Command};
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

use super::run;

/// The experiment to run.
const EXPERIMENT: &str = "calibrate";

/// Runs the experiment, unless a folder of it is given, and writes the timings.
pub(crate) fn run(argument: &Calibrate) -> Outcome {
    let folder = match &argument.folder {
        Some(folder) => folder.clone(),
        None => {
            let plan = source::plan_of(EXPERIMENT, &Instead::default())?;
            let folder = CampaignFolder::fresh(&plan);
            let Command::Run(run) = Argument::of_run(EXPERIMENT, &folder).command else {
                return Err(anyhow!("`webloop run` cannot be parsed").into());
            };
            match run::run(&run)? {
                Exit::Fine => folder,
                exit => return Ok(exit),
            }
        }
    };
    let campaign = Campaign::read(&folder).map_err(Failure::usage)?;
    let timings = calibration::timings(&campaign)?;
    let text = timings.to_toml();
    std::fs::write(&argument.out, text)
        .with_context(|| format!("cannot write {}", argument.out.display()))?;
    let mut out = crate::console::out();
    writeln!(
        out,
        "\nWritten: {}\nUse it: webloop run --backend sim --timing {}",
        argument.out.display(),
        argument.out.display()
    )?;
    Ok(Exit::Fine)
}
