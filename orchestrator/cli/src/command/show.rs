//! `webloop show DIR`: the table of a results folder, or a CSV, made again from its raw rows.

use std::io::Write;

use analysis::Campaign;
use analysis::outline::{self, Outlined};
use analysis::repeats::Over;
use anyhow::anyhow;
use campaign::{Results, check_rows, series};

use crate::argument::{Show, ShowFormat};
use crate::command::report::shortened;
use crate::exit::{Exit, Failure, Outcome};
use crate::expectation::{judged, print};
use crate::results;

/// Reads the folder and prints what is in it.
pub(crate) fn run(show: &Show) -> Outcome {
    if !show.require.is_empty() && show.format != ShowFormat::Table {
        return Err(Failure::usage(anyhow!(
            "--require is asked of the table; leave out --format"
        )));
    }
    let mut out = crate::console::out();
    match show.format {
        ShowFormat::Table | ShowFormat::Csv => rows(show, &mut out),
        ShowFormat::Lateness | ShowFormat::Intervals | ShowFormat::Budget => {
            let campaign = results::read(&show.folder)?;
            match show.format {
                ShowFormat::Lateness => series::lateness(&campaign, &mut out)?,
                ShowFormat::Intervals => series::intervals(&campaign, &mut out)?,
                _ => series::budget(&campaign, &mut out)?,
            }
            let rows = outline::of(&campaign);
            Ok(missing(&rows, show))
        }
    }
}

/// Prints a row for each cell, and what became of what is expected of them.
fn rows(show: &Show, out: &mut impl Write) -> Outcome {
    let plan = Campaign::plan(&show.folder).map_err(Failure::usage)?;
    let again = results::JudgeAgain::new(&plan, &show.folder);
    let rows = Campaign::each_row(&show.folder, &plan, |run| Outlined::of(again.judge(run)));
    again.tell_others();
    check_rows(&rows, &show.folder)?;
    let mut exit = missing(&rows, show);
    let judgement = {
        let asked: Vec<&Outlined> = rows.iter().collect();
        judged(&plan, &asked, &show.require)
    };
    let results = Results::of_rows(rows, (&show.folder, plan.seed), |_| false)?;
    if show.format == ShowFormat::Table {
        let over = if show.with_disturbed {
            Over::DisturbedToo
        } else {
            Over::Complete
        };
        write!(out, "{}", results.table(over))?;
        print(&judgement, out)?;
        if !judgement.holds() {
            exit = Exit::Failed;
        }
    } else {
        for part in results.csv() {
            out.write_all(part.as_bytes())?;
        }
    }
    Ok(exit)
}

/// The exit code of a folder in which cells of the plan may be missing; names the first few of them.
fn missing(rows: &[Outlined], show: &Show) -> Exit {
    let absent = || rows.iter().filter(|row| row.is_absent());
    let count = absent().count();
    if count == 0 || show.allow_missing {
        return Exit::Fine;
    }
    let ids: Vec<&str> = absent().map(|row| row.summary.cell.as_str()).collect();
    let all = rows.len();
    say!(
        "webloop: {count} of {all} cells have not been run: {}; --allow-missing accepts that",
        shortened(&ids)
    );
    Exit::Failed
}
