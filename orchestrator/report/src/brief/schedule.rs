//! Of open loops: which clients keep their schedule?

use analysis::Campaign;
use plan::SetBy;

use super::Brief;
use crate::number::duration;

/// Which clients keep their schedule, in a campaign of open loops; `None` without a complete one.
pub(super) fn schedule(campaign: &Campaign) -> Option<Brief> {
    /// A client that falls behind by less than this each second keeps its schedule, s/s.
    const KEPT: f64 = 1e-3;
    let complete = campaign.runs.iter().filter(|run| run.is_complete());
    let clients = analysis::grouped(complete, |run| {
        let setup = run.summary.setup.beside(&[SetBy::System]);
        (run.cell.client, setup)
    });
    let mut told: Vec<(f64, String)> = Vec::new();
    for ((client, setup), runs) in &clients {
        let is_alone = clients.iter().filter(|((of, _), _)| of == client).count() == 1;
        let name = if is_alone {
            client.to_string()
        } else {
            format!("{client} {setup}")
        };
        let worst = runs
            .iter()
            .filter_map(|run| Some((run.summary.schedule_slope?, *run)))
            .max_by(|(one, _), (other, _)| one.total_cmp(other));
        let Some((slope, run)) = worst else { continue };
        let words = if slope < KEPT {
            format!("{name} keeps it")
        } else {
            format!(
                "{name} falls behind by up to {} each second ({}, {})",
                duration(slope * 1e3),
                run.cell.topology,
                run.cell.rate()
            )
        };
        told.push((slope, words));
    }
    told.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let words: Vec<String> = told.into_iter().map(|(_, words)| words).collect();
    (!words.is_empty()).then(|| Brief {
        question: "Which clients keep their schedule?",
        answer: words.join("; ") + ".",
        shown_in: "fig-G",
    })
}
