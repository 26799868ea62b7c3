//! What `run` prints and leaves at the end: the table, the answer, how to go on, what was expected, and the page.

use std::io::Write;
use std::path::{Path, PathBuf};

use analysis::Campaign;
use analysis::expect::{Answered, Judgement};
use analysis::outline::Outlined;
use analysis::repeats::Over;
use anyhow::Context;
use campaign::Results;
use plan::{Verdict, file_name};
use record::file;
use report::answer::Answer;

use super::cells;
use super::ran::{PAGE_CELLS, Ran, Read};
use crate::argument::{Run, Undecided};
use crate::command;
use crate::exit::{Exit, Failure, Outcome};
use crate::expectation::{judged, print};

/// Prints the table and where the results are, and writes the table into the folder, also as CSV.
pub(super) fn conclude(argument: &Run, ran: &Ran<'_>) -> Outcome {
    let folder = ran.folder.path();
    if ran.ends_at_once() {
        say!(
            "webloop: interrupted; the same command with --out {0} goes on, `webloop show {0}` shows what there is",
            folder.display()
        );
        return Ok(Exit::Interrupted);
    }
    let Read { campaign, rows } = ran.read()?;
    let (judgement, exit, lost) = {
        let asked = ran.asked(&rows);
        let judgement = judged(ran.plan, &asked, &argument.require);
        let lost = asked.iter().filter(|row| did_not_hold(row)).count();
        (judgement, ran.exit(&asked), lost)
    };
    let asked = ran.indices();
    let is_asked = |row: &Outlined| asked.contains(&row.index);
    let results = Results::of_rows(rows, (folder, ran.plan.seed), is_asked)?;
    let table = results.table(Over::Complete);
    let mut out = crate::console::out();
    write!(out, "{table}")?;
    let shown = folder.display();
    let closed = campaign.as_ref().and_then(headline);
    if let Some(headline) = closed {
        writeln!(out, "\n{headline}")?;
    }
    writeln!(out, "\nResults: {shown}")?;
    if lost > 0 {
        let are = if lost == 1 { "is" } else { "are" };
        writeln!(
            out,
            "{} {are} not complete; again: {}",
            cells(lost),
            argument.again(folder)
        )?;
    }
    print(&judgement, &mut out)?;
    // Written after the table is printed, so that a full disk does not hide it.
    ran.folder.leave_parts(file_name::SUMMARY, results.csv())?;
    ran.folder.leave(file_name::TABLE, table.as_bytes())?;
    if !argument.no_report && !ran.is_interrupted {
        let words = page(campaign.as_ref(), judgement.clone(), folder)?;
        writeln!(out, "Report: {words}")?;
    }
    Ok(match exit {
        Exit::Fine | Exit::Unsupported if !passes(&judgement, argument.undecided) => Exit::Failed,
        exit => exit,
    })
}

/// Whether a run ended otherwise than it should have.
fn did_not_hold(row: &Outlined) -> bool {
    let verdict = row.verdict();
    verdict.is_some_and(|verdict| !matches!(verdict, Verdict::Complete | Verdict::Unsupported))
}

/// Makes the page of a campaign that was read whole; returns where it is, or why there is none.
pub(crate) fn page(
    campaign: Option<&Campaign>,
    judgement: Judgement,
    folder: &Path,
) -> Result<String, Failure> {
    Ok(match campaign {
        Some(campaign) => leave_report(campaign, judgement)?.display().to_string(),
        None => format!(
            "none by itself of more than {PAGE_CELLS} cells; `webloop report {}` makes it",
            folder.display()
        ),
    })
}

/// The answer that the page begins with; `None` without a closed loop.
fn headline(campaign: &Campaign) -> Option<String> {
    let answer = Answer::of(campaign);
    answer.survival()?;
    answer.words().into_iter().next()
}

/// Writes the report into the campaign's folder; returns the path of its page.
pub(crate) fn leave_report(read: &Campaign, judgement: Judgement) -> Result<PathBuf, Failure> {
    let report = command::report::of(read, None)?.with_expectations(judgement);
    let folder = read.folder.join(file_name::REPORT);
    file::check_folder(&folder).map_err(Failure::usage)?;
    report::write(&report.files(&report.draw()), &folder)
        .with_context(|| format!("cannot write the report into {}", folder.display()))?;
    Ok(folder.join("report.html"))
}

/// Whether what is expected does not fail.
fn passes(judgement: &Judgement, undecided: Undecided) -> bool {
    match judgement.answer() {
        Answered::Yes => true,
        Answered::No => false,
        Answered::CannotTell => undecided == Undecided::Passes,
    }
}
