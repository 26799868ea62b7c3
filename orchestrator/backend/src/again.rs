//! Judges a finished run once more, by what its folder still has: who changes a verdict and mends the checksums does not
//! change the rows that speak against it.
//!
//! It is the judgement of the run's end, over the same rows, with what the manifest says of machine and processes. Until
//! when each echo was waited for is not in the folder, so one that did not come back counts only where a later one of
//! its series did. A run in virtual time is not judged again: nothing could disturb it.

use std::path::Path;

use link::LinkTime;
use link::certificate::Echo;
use plan::{Cell, Phase, Plan, ProbeRow, Verdict, file_name};
use record::Manifest;
use record::rows::all;

use crate::course::Seen;
use crate::error::RunError;
use crate::evidence::Asked;
use crate::link_check::{LinkCheck, Sent};
use crate::report::Reports;
use crate::schedule::Spacing;
use crate::texts::{profile_text, read_profile};
use crate::{evidence, rows, run};

/// What comes of judging a run again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Again {
    /// The verdict by its rows, with the reasons for it.
    Judged(Verdict, Vec<String>),
    /// The predictions in its rows of echoes are not those of the plan's link as this webloop plays it: another version
    /// made the run, or somebody changed them.
    OtherLink,
    /// It was in virtual time, or its link was not judged at its end either.
    Unjudged,
}

/// Judges a run of a plan's cell by its folder, which has been checked against its manifest.
///
/// # Errors
/// [`RunError`] when rows cannot be read, or the plan's link cannot be played.
pub fn judge_again(
    plan: &Plan,
    cell: &Cell,
    folder: &Path,
    manifest: &Manifest,
) -> Result<Again, RunError> {
    if manifest.backend == "sim" || manifest.certificate.is_none() {
        return Ok(Again::Unjudged);
    }
    let text = profile_text(plan, cell)?;
    let profile = read_profile(&text, &cell.topology)?;
    let opens = Spacing::of(&profile).opens();
    let echoes: Vec<ProbeRow> = all(&folder.join(file_name::PROBES))?;
    let seen = seen(&echoes, manifest, opens);
    let link_check = LinkCheck {
        entered: &rows::entered(folder)?,
        ..LinkCheck::of(cell, &profile, manifest.epoch, opens)
    };
    let predicted = seen.echoes.iter();
    let predicted = predicted.flat_map(|sent| link_check.rows(sent.phase, &sent.echoes));
    if predicted.ne(echoes) {
        return Ok(Again::OtherLink);
    }
    let asked = Asked {
        cell,
        system: &plan.system(cell)?,
        is_plant_own: plan.plant_program(cell).is_some(),
    };
    let evidence = evidence::judge(&link_check, asked, &seen, folder)?;
    let (verdict, reasons, _) = run::judge(Ok(evidence), &Reports::read(folder), folder);
    Ok(Again::Judged(verdict, reasons))
}

/// What was observed during the run, as far as it was kept.
fn seen(rows: &[ProbeRow], manifest: &Manifest, opens: LinkTime) -> Seen {
    let series = |phase| Sent {
        phase,
        echoes: rows
            .iter()
            .filter(|row| row.phase == phase)
            .map(|row| Echo {
                seq: row.seq,
                t_send_ns: row.t_send_ns,
                t_reach_ns: row.t_reach_ns,
                t_back_ns: row.t_back_ns,
            })
            .collect(),
        until_ns: Vec::new(),
    };
    Seen {
        epoch: manifest.epoch,
        opens,
        start_ns: manifest.start_ns,
        echoes: [Phase::Empty, Phase::Before, Phase::During, Phase::After].map(series),
        rows: None,
        pulse: manifest.pulse.clone(),
        watched: manifest.watched.clone().into_iter().flatten().collect(),
        end_faults: manifest.end_faults.clone(),
    }
}
