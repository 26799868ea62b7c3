//! What to do next: about runs that are missing, then about the worst loop, else what makes the answer surer.

use analysis::reason::Reason;
use analysis::silence::Doer;
use analysis::{Campaign, LoopVerdict, Run};
use plan::End;

use super::trust::FEW;
use crate::delays::Nearest;
use crate::loops::Loop;
use crate::outcome::OutcomeKind;

/// The next step or two, about the run nearest to failing.
pub(super) fn next(campaign: &Campaign, loops: &[Loop<'_>], nearest: &Nearest<'_>) -> String {
    let mut steps = Vec::new();
    let is_open = |run: &&Run| {
        !matches!(
            OutcomeKind::of(run),
            OutcomeKind::Complete | OutcomeKind::Unsupported
        )
    };
    if campaign.runs.iter().any(|run| is_open(&run)) {
        steps.push("Make the runs that are not complete: webloop run … --failed.");
    }
    steps.extend(about(campaign, nearest));
    let unscaled = |run: &&Run| run.summary.band.is_none() && run.cell.moving_reference().is_none();
    if loops
        .iter()
        .flat_map(|one| one.group.runs.iter().copied())
        .any(|run| unscaled(&run))
    {
        steps.push(
            "Give the plant a `band` in units of y: it begins at r, so any error that does not grow counts as holding.",
        );
    }
    if steps.is_empty() {
        steps.push(surer(campaign, loops));
    }
    steps.join(" ")
}

/// Why a run's loop does not just hold.
fn reason(run: &Run) -> Option<Reason> {
    run.metrics.as_ref()?.response?.reason
}

/// Whose silence a run ended in; `None` if it did not.
pub(super) fn doer(run: &Run) -> Option<Doer> {
    match reason(run)? {
        Reason::Silence(silence) => Some(silence.by),
        _ => None,
    }
}

/// Whether a run ended in the silence of an end that its fault was to stop.
pub(super) fn is_stopped_as_planned(campaign: &Campaign, run: &Run) -> bool {
    let end = match doer(run) {
        Some(Doer::Controller) => End::Controller,
        Some(Doer::Plant) => End::Plant,
        Some(Doer::Link) | None => return false,
    };
    let faults = campaign.plan.end_faults(&run.cell);
    faults.iter().any(|fault| fault.end == end)
}

/// What helps the run whose loop ended worst; `None` if it holds well.
fn about(campaign: &Campaign, nearest: &Nearest<'_>) -> Option<&'static str> {
    let worst = nearest.run;
    let verdict = worst.summary.loop_verdict?;
    Some(match (verdict, reason(worst)) {
        (LoopVerdict::Holds, _) => return None,
        (_, Some(Reason::Silence(silence))) => match silence.by {
            _ if is_stopped_as_planned(campaign, worst) => ALONE,
            Doer::Link => ALONE,
            Doer::Controller => {
                "Find out why the controller stopped: controller.log in that run’s folder has what it printed."
            }
            Doer::Plant => {
                "Find out why the plant took no command: its refusals are in plant.json in that run’s folder."
            }
        },
        (_, Some(Reason::Limits { at_s: 0.0, .. })) => {
            "Let the plant’s program stand still until its first command: this loop was lost before it began."
        }
        (LoopVerdict::Lost, _) if nearest.is_cut => {
            "No law holds a plant that it cannot reach for so long: give the plant a safe way to be alone, such as \
             `hold = \"200ms then zero\"`, or the loop a link without such a gap."
        }
        (LoopVerdict::HoldsBadly, _) => {
            "If that is good enough, ask for it: `survives` in [expect], or `overshoot` in the system’s [plant]. If not, try less gain, a longer h or a law that knows the delay."
        }
        _ if worst.cell.client.is_own() || campaign.plan.plant_program(&worst.cell).is_some() => {
            "Try less gain, a longer h or a law that knows the delay, or the same loop over a better link (--topology)."
        }
        _ => {
            "Try less gain, a longer h or a law that knows the delay: webloop margin says what delay the loop bears."
        }
    })
}

/// What a plant is to be asked that was left alone.
const ALONE: &str = "Say what the plant shall do without commands, such as `hold = \"200ms then zero\"`, and look at y from then on.";

/// What makes a good answer surer.
fn surer(campaign: &Campaign, loops: &[Loop<'_>]) -> &'static str {
    let least = loops.iter().map(|one| one.group.runs.len()).min();
    if campaign.is_simulated() {
        "Run it for real: the same command without --backend sim."
    } else if least.is_some_and(|least| least < FEW) {
        "Run it more often: from six repeats on, medians have intervals."
    } else {
        "Keep it so: write it into [expect], and let webloop gate ask it of each change."
    }
}
