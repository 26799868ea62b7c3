//! `webloop report DIR`: the report on a results folder, and the page to open.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use analysis::Campaign;
use analysis::outline::{self, Outlined};
use analysis::repeats::Over;
use anyhow::{Context, anyhow, bail};
use campaign::Results;
use plan::file_name;
use record::file;
use report::claim::{Finding, Verdict};
use report::deposit::{package, provenance};
use report::figure::LaidOut;
use report::{Exhibits, Report, answer::Answer};

use crate::argument::{self, Publication};
use crate::exit::{Exit, Failure, Outcome};
use crate::expectation::{judged, print};
use crate::results;

/// Makes the report. Prints where it is, and what is missing or damaged in the folder.
pub(crate) fn run(argument: &argument::Report) -> Outcome {
    let campaign = results::read(&argument.folder)?;
    // If a folder was kept without its rows, leave the files that were derived from them.
    if campaign.absent().count() == campaign.runs.len() {
        return Err(Failure::usage(anyhow!(
            "{} has no cell's rows, so there is nothing to report; `webloop run {} --out DIR` \
             makes them",
            argument.folder.display(),
            argument.folder.join(file_name::PLAN).display()
        )));
    }
    let report = of(&campaign, argument.with)?;
    let rows = outline::of(&campaign);
    let asked: Vec<&Outlined> = rows.iter().collect();
    let expectations = judged(&campaign.plan, &asked, &argument.require);
    let report = report.with_expectations(expectations);
    let own = argument.folder.join(file_name::REPORT);
    let out = argument.out.as_deref().unwrap_or(&own);
    let drawn = report.draw();
    let mut files = report.files(&drawn);
    if argument.png {
        files.extend(drawn.iter().map(LaidOut::picture));
    }
    // Under its own name, the report goes into this folder and not to where a link leads.
    file::check_folder(&own).map_err(Failure::usage)?;
    report::write(&files, out)
        .with_context(|| {
            format!(
                "cannot write the report into {}; choose another folder with --out",
                out.display()
            )
        })
        .map_err(Failure::usage)?;
    // Damage is reported below; the earlier tables then stay as they were.
    if argument.out.is_none() && report.damage.is_empty() {
        describe(&report, &files, &argument.folder)?;
    }
    let mut stdout = crate::console::out();
    let page = out.join("report.html");
    for sentence in Answer::of(&campaign).words() {
        writeln!(stdout, "{sentence}")?;
    }
    if !report.claims.is_empty() {
        writeln!(stdout, "{}", claims(&report))?;
    }
    writeln!(stdout, "Report: {}", page.display())?;
    print(&report.expectations, &mut stdout)?;
    if argument.open {
        open(&page)?;
    }
    let troubles = troubles(&report);
    for trouble in &troubles {
        say!("webloop: {trouble}");
    }
    Ok(if troubles.is_empty() && report.expectations.holds() {
        Exit::Fine
    } else {
        Exit::Failed
    })
}

/// The report on a campaign, with the exhibits of its publication or of the one that is asked for.
pub(crate) fn of(campaign: &Campaign, with: Option<Publication>) -> anyhow::Result<Report<'_>> {
    let exhibits = if paper::is_of(&campaign.plan) || with == Some(Publication::Paper) {
        paper::exhibits(campaign)?
    } else {
        Exhibits::default()
    };
    Ok(Report::of(campaign, exhibits)?)
}

/// Opens a page in the desktop's browser.
fn open(page: &Path) -> anyhow::Result<()> {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    let ended = Command::new(program).arg(page).status();
    let ended = ended.with_context(|| {
        format!(
            "--open needs `{program}` on this machine; open {} by hand",
            page.display()
        )
    })?;
    if !ended.success() {
        bail!(
            "`{program}` could not open {}; open it by hand",
            page.display()
        );
    }
    Ok(())
}

/// Writes what is derived from the rows beside them, and the files that describe the whole folder.
fn describe(
    report: &Report<'_>,
    files: &[(PathBuf, Vec<u8>)],
    folder: &Path,
) -> anyhow::Result<()> {
    let leave = |name: &str, text: String| {
        let path = folder.join(name);
        file::write(&path, text.as_bytes())
            .with_context(|| format!("cannot write {}", path.display()))
    };
    let results = Results::of(report.campaign, |_| false)?;
    leave(file_name::SUMMARY, results.csv().collect())?;
    leave(file_name::TABLE, results.table(Over::Complete))?;
    // These two list what is there, so they come last.
    leave(package::FILE, package::json(report, files))?;
    leave(provenance::FILE, provenance::json(report, files))
}

/// How many of the paper's claims had which outcome.
fn claims(report: &Report<'_>) -> String {
    let count = |verdict| {
        let of_it = |finding: &&Finding| finding.verdict == verdict;
        report.strict().filter(of_it).count()
    };
    format!(
        "Of {} claims of the paper {} agree, {} differ, {} are undecided, {} were not run.",
        report.strict().count(),
        count(Verdict::Agrees),
        count(Verdict::Differs),
        count(Verdict::CannotBeTold),
        count(Verdict::NotRun)
    )
}

/// Why the folder is not whole: one sentence for each reason.
fn troubles(report: &Report<'_>) -> Vec<String> {
    let damage = report.damage.iter().map(ToString::to_string);
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
    damage.chain(missing).collect()
}

/// The first few ids, and the number of the others.
pub(crate) fn shortened(ids: &[&str]) -> String {
    const SHOWN: usize = 5;
    let first = ids[..ids.len().min(SHOWN)].join(", ");
    match ids.len().saturating_sub(SHOWN) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}
