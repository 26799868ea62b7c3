//! The run nearest to failing, of a loop and of a campaign.

use analysis::blame::{Blame, Cause};
use analysis::budget::{Budget, timeline};
use analysis::silence::is_cut;
use analysis::{Campaign, Run};

use super::Delays;

/// The run nearest to failing: one whose loop failed, or the one that took the largest part of its time
/// to settle; among equals the one that went farthest.
pub fn nearest_to_failing<'a>(runs: impl Iterator<Item = &'a Run>) -> Option<&'a Run> {
    runs.max_by(|one, other| {
        nearness(one)
            .partial_cmp(&nearness(other))
            .unwrap_or(std::cmp::Ordering::Equal)
    })
}

/// How near a run is to failing, by its verdict, its settling as a share of its length, and its overshoot.
fn nearness(run: &Run) -> (u8, f64, f64) {
    let summary = &run.summary;
    let verdict = match summary.loop_verdict {
        None => 0,
        Some(verdict) => 1 + verdict as u8,
    };
    let length_ms = run.cell.duration_ns as f64 / 1e6;
    let settled = summary.settling_ms.unwrap_or(0.0) / length_ms;
    (verdict, settled, summary.overshoot_pct.unwrap_or(0.0))
}

/// The run of a campaign nearest to failing, and what is to blame in it.
#[derive(Debug, Clone)]
pub struct Nearest<'a> {
    /// The run.
    pub run: &'a Run,
    /// Its messages.
    pub budget: &'a Budget,
    /// The oldest y by which its plant was steered; `None` without a tick.
    pub blame: Option<Blame>,
    /// Whether that is the link’s doing, which let nothing through meanwhile.
    pub is_cut: bool,
}

impl<'a> Nearest<'a> {
    /// Among the complete closed loops; `None` without one.
    #[must_use]
    pub fn of(campaign: &Campaign, delays: &'a [Delays<'a>]) -> Option<Nearest<'a>> {
        // It is the nearest of those that are the nearest of their loops.
        let closed = delays.iter().map(|of| of.worst.0);
        let closed = closed.filter(|run| run.summary.loop_verdict.is_some());
        let nearest = nearest_to_failing(closed);
        let of =
            nearest.and_then(|run| delays.iter().find(|of| of.worst.0.cell.id == run.cell.id))?;
        let ((run, budget), blame) = (&of.worst, of.blame);
        let is_cut = blame
            .as_ref()
            .is_some_and(|blame| lets_nothing_through(campaign, run, budget, blame));
        Some(Nearest {
            run,
            budget,
            blame,
            is_cut,
        })
    }
}

/// Whether an age that stands out is the link's, which let nothing through meanwhile.
fn lets_nothing_through(campaign: &Campaign, run: &Run, budget: &Budget, blame: &Blame) -> bool {
    let time_ns = budget.start_ns + blame.from_ns..budget.start_ns + blame.to_ns;
    let is_link = blame.stands_out() && matches!(blame.cause(), Cause::Link | Cause::Loss);
    is_link && timeline(run, &campaign.plan).is_some_and(|link| is_cut(link, time_ns))
}
