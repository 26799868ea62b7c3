//! `webloop collect DIR... --out D`: merges what several machines ran of one plan into one results
//! folder.
//!
//! The crate `campaign` merges the folders.

use std::collections::BTreeSet;
use std::io::Write;

use analysis::Run;
use analysis::repeats::Over;
use campaign::{CampaignFolder, Merged, Results, Sources};
use plan::{Verdict, file_name};

use crate::argument::Collect;
use crate::command::run::{cells, exit};
use crate::exit::{Exit, Outcome};

/// Merges the folders, and prints which cells of the plan are not complete.
pub(crate) fn run(argument: &Collect) -> Outcome {
    let sources = Sources::find(&argument.folders, &argument.out)?;
    let campaign = CampaignFolder::open_text(&sources.text, &argument.out)?;
    let folder = campaign.path();
    let merged = sources.merge_into(folder)?;
    for damage in &merged.damage {
        say!("webloop: {}: {}", damage.path.display(), damage.problem);
    }

    let read = analysis::Campaign::read(folder)?;
    let results = Results::of(&read, |_| false)?;
    campaign.leave_parts(file_name::SUMMARY, results.csv())?;
    campaign.leave(file_name::TABLE, results.table(Over::Complete).as_bytes())?;

    let mut out = crate::console::out();
    let Merged {
        copied,
        kept,
        damage,
    } = &merged;
    let total = read.runs.len();
    writeln!(
        out,
        "{}, seed {}: {} copied, {kept} left as they were, of {total}",
        sources.plan.experiment,
        sources.plan.seed,
        cells(*copied)
    )?;
    let lists = [
        (None, "Not run"),
        (Some(Verdict::Unsupported), "Unsupported"),
        (Some(Verdict::Disturbed), "Disturbed"),
        (Some(Verdict::Invalid), "Invalid"),
        (Some(Verdict::Failed), "Failed"),
    ];
    for (verdict, heading) in lists {
        let mut of = read
            .runs
            .iter()
            .filter(|run| run.verdict() == verdict)
            .peekable();
        if of.peek().is_some() {
            writeln!(out, "\n{heading}:")?;
        }
        for run in of {
            writeln!(out, "{:>4}  {}", run.cell.index, run.cell.id)?;
        }
    }
    let verdicts: BTreeSet<Option<Verdict>> = read.runs.iter().map(Run::verdict).collect();
    if verdicts
        .iter()
        .any(|verdict| *verdict != Some(Verdict::Complete))
    {
        let folder = folder.display();
        writeln!(
            out,
            "\n`webloop run {folder}/plan.json --out {folder}` runs what is not complete"
        )?;
    }
    writeln!(out, "\nResults: {}", folder.display())?;
    if damage.is_empty() {
        Ok(exit(verdicts.into_iter(), false))
    } else {
        Ok(Exit::Failed)
    }
}
