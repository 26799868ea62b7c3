//! `webloop report DIR`: the paper's tables, figures and claims of a results folder, and the page.

use std::io::Write;
use std::path::Path;

use analysis::Campaign;
use anyhow::{Context, anyhow};
use report::Report;

use crate::argument;
use crate::exit::{Exit, Failure, Outcome};
use crate::results::Results;

/// Makes the report, says where it is and what is missing or damaged in the folder.
pub(crate) fn run(argument: &argument::Report) -> Outcome {
    let campaign = Campaign::read(&argument.folder).map_err(Failure::usage)?;
    let report = Report::of(&campaign).map_err(|error| anyhow!(error))?;
    let own = argument.folder.join("report");
    let out = argument.out.as_deref().unwrap_or(&own);
    report::write(&report, out)
        .with_context(|| {
            format!(
                "cannot write the report into {}; choose another folder with --out",
                out.display()
            )
        })
        .map_err(Failure::usage)?;
    // What cannot be read is told below; the tables of before stay as they were.
    let is_readable = campaign.runs.iter().all(|run| run.problem.is_none());
    if argument.out.is_none() && is_readable {
        describe(&campaign, &argument.folder)?;
    }
    let mut stdout = std::io::stdout();
    writeln!(stdout, "{}", out.join("report.html").display())?;
    let troubles = troubles(&report);
    for trouble in &troubles {
        eprintln!("webloop: {trouble}");
    }
    Ok(match troubles.is_empty() {
        true => Exit::Fine,
        false => Exit::Failed,
    })
}

/// What is made of the rows and lies beside them.
fn describe(campaign: &Campaign, folder: &Path) -> anyhow::Result<()> {
    let results = Results::of(campaign, |_| false)?;
    for (name, text) in [
        ("summary.csv", results.csv()),
        ("table.txt", results.table()),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Why the folder is not whole, a sentence each.
fn troubles(report: &Report<'_>) -> Vec<String> {
    let damage = report
        .damage
        .iter()
        .map(|damage| format!("{}: {}", damage.path.display(), damage.problem));
    let problems = report
        .campaign
        .runs
        .iter()
        .filter_map(|run| run.problem.clone());
    let absent: Vec<&str> = report
        .campaign
        .absent()
        .map(|run| run.cell.id.as_str())
        .collect();
    let missing = (!absent.is_empty()).then(|| {
        format!(
            "{} of {} cells have not been run: {}",
            absent.len(),
            report.campaign.runs.len(),
            shortened(&absent)
        )
    });
    damage.chain(problems).chain(missing).collect()
}

/// The first few, and how many more there are.
fn shortened(ids: &[&str]) -> String {
    const SHOWN: usize = 5;
    let first = ids[..ids.len().min(SHOWN)].join(", ");
    match ids.len().saturating_sub(SHOWN) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}
