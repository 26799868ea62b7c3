//! What a run is called in prose: where it ran, what tells it apart from others there, and which repeat it was.
//! Its id is for files and links.

use analysis::{Campaign, LoopVerdict, Run, grouped};
use endpoint::Mode;
use plan::{SetBy, Setup};

/// Whether a loop holds and never had to settle: it follows what moves, or was in its band from the start.
#[must_use]
pub fn is_kept(run: &Run) -> bool {
    let is_held = run.summary.loop_verdict.is_some_and(LoopVerdict::is_held);
    is_held && run.summary.settling_ms.is_none_or(|ms| ms == 0.0)
}

/// What such a loop does.
#[must_use]
pub fn kept(run: &Run) -> &'static str {
    match (run.cell.moving_reference(), run.summary.band) {
        (Some(_), _) => "follows r",
        (None, Some(_)) => "stays in its band",
        (None, None) => "stays, with no band asked",
    }
}

/// A run's setup without its system and its fault, which stand beside it.
fn beside_fault(run: &Run) -> Setup {
    run.summary.setup.beside(&[SetBy::System, SetBy::Fault])
}

/// `diego-vpn, run 1`; `couva, tank, python, 100 Hz, run 3` where systems, clients and rates are several.
#[must_use]
pub fn called(campaign: &Campaign, run: &Run) -> String {
    let (runs, cell) = (&campaign.runs, &run.cell);
    let mut words = vec![cell.topology.clone()];
    words.extend(cell.fault.clone());
    if grouped(runs.iter(), |one| &one.cell.system).len() > 1 {
        words.push(cell.system.clone());
    }
    if grouped(runs.iter(), |one| one.cell.client).len() > 1 {
        words.push(cell.client.to_string());
    }
    let same = runs.iter().filter(|one| one.cell.client == cell.client);
    if grouped(same, |one| beside_fault(one)).len() > 1 {
        words.push(beside_fault(run).to_string());
    }
    let is_open = cell.settings.mode == Mode::Open;
    if is_open && grouped(runs.iter(), |one| one.cell.settings.mode).len() > 1 {
        words.push("open".to_owned());
    }
    if grouped(runs.iter(), |one| one.cell.settings.h.ns()).len() > 1 {
        words.push(cell.rate());
    }
    words.push(format!("run {}", cell.repeat));
    words.join(", ")
}
