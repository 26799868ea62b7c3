//! Which second hurt: the oldest y that steered the plant, what made it so old, and what to do about it.

use analysis::Campaign;
use analysis::blame::{Blame, Cause, End};
use analysis::silence::Doer;

use super::next::{doer, is_stopped_as_planned};
use crate::called::called;
use crate::delays::Nearest;

/// The oldest y of the run nearest to failing, what made it so old, and what to do about it.
pub(super) fn hurt(campaign: &Campaign, nearest: &Nearest<'_>) -> String {
    let name = called(campaign, nearest.run);
    let Some(blame) = &nearest.blame else {
        return format!("{name} has no tick of the plant, so it cannot be told.");
    };
    if blame.end == End::Lost && blame.to_ns == 0 {
        return format!("None: {name} was lost before anything could come through the network.");
    }
    let remedy = remedy(campaign, nearest, blame);
    if blame.stands_out() {
        format!("In {name}, {blame}. {remedy}")
    } else {
        format!("None stands out in {name}; {blame}. {remedy}")
    }
}

/// What helps against what is to blame: a link or an end that was gone is no matter of settings.
fn remedy(campaign: &Campaign, nearest: &Nearest<'_>, blame: &Blame) -> &'static str {
    let is_over = blame.end == End::Over;
    let is_planned = is_stopped_as_planned(campaign, nearest.run);
    match (doer(nearest.run), blame.cause()) {
        _ if nearest.is_cut && is_over => {
            "Nothing came through any more, so no setting of the sender helps."
        }
        _ if nearest.is_cut => {
            "Nothing came through meanwhile, so no setting of the sender helps: only what the plant does without \
             commands, its `hold`."
        }
        (Some(Doer::Controller), Cause::Controller) if is_over && is_planned => {
            "The controller sent nothing any more, since the experiment’s fault stopped it; link and plant had no part in it."
        }
        (Some(Doer::Controller), Cause::Controller) if is_over => {
            "The controller sent nothing any more: it ended, hung or waited for something, and no scheduling helps against that. \
             Link and plant had no part in it."
        }
        (Some(Doer::Plant), Cause::Plant) if is_over && is_planned => {
            "The plant took nothing any more, since the experiment’s fault stopped it; link and controller had no part in it."
        }
        (_, cause) => cause.remedy(),
    }
}
