//! `webloop show DIR`: the table of a results folder, or a CSV, made again from its raw rows.

use std::io::Write;

use analysis::{Campaign, Run};
use anyhow::anyhow;
use campaign::{Results, series};

use crate::argument::{Show, ShowFormat};
use crate::command::run::{judged, print};
use crate::exit::{Exit, Failure, Outcome};

/// Reads the folder and prints what is in it.
pub(crate) fn run(show: &Show) -> Outcome {
    if !show.require.is_empty() && show.format != ShowFormat::Table {
        return Err(Failure::usage(anyhow!(
            "--require is asked of the table; leave out --format"
        )));
    }
    let campaign = Campaign::read(&show.folder).map_err(Failure::usage)?;
    let results = || Results::of(&campaign, |_| false);
    let mut exit = Exit::Fine;
    let mut out = crate::console::out();
    match show.format {
        ShowFormat::Table => {
            let results = results()?;
            write!(out, "{}", results.table(show.with_disturbed))?;
            let runs: Vec<&Run> = campaign.runs.iter().collect();
            let judgement = judged(&campaign.plan, &runs, &show.require);
            print(&judgement, &mut out)?;
            if !judgement.holds() {
                exit = Exit::Failed;
            }
        }
        ShowFormat::Csv => write!(out, "{}", results()?.csv())?,
        ShowFormat::Lateness => series::lateness(&campaign, &mut out)?,
        ShowFormat::Intervals => series::intervals(&campaign, &mut out)?,
        ShowFormat::Budget => series::budget(&campaign, &mut out)?,
    }
    Ok(exit)
}
