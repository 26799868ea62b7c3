//! Messages that were overtaken on their way: section 4.

use analysis::Campaign;
use endpoint::Outstanding;

use super::evidence::Evidence;
use super::row::Claim;
use report::claim::{Finding, Part};
use report::group::Estimate;

/// Counts over all complete cells, separately for clients with one outstanding request and with
/// several.
pub(super) fn out_of_order(campaign: &Campaign) -> Finding {
    let mut evidence = Evidence::default();
    let one = overtaken(campaign, &mut evidence, true);
    let several = overtaken(campaign, &mut evidence, false);
    evidence.decide(Part::judged(
        "messages out of order, several outstanding",
        "",
        None,
        several,
        (1.0, f64::INFINITY),
    ));
    evidence.decide(Part::judged(
        "messages out of order, one outstanding",
        "",
        None,
        one,
        (0.0, 0.0),
    ));
    evidence.on(Claim {
        id: "text-out-of-order",
        place: "Section 4",
        claim: "Control commands can be applied out of order.",
        check: "some messages were overtaken where a client may have several under way, and none \
                where it waits for each answer"
            .to_owned(),
        ..Claim::default()
    })
}

/// Messages that a later one overtook, out of all messages of cells with one outstanding request
/// (`one`) or with several.
fn overtaken(campaign: &Campaign, evidence: &mut Evidence, one: bool) -> Option<Estimate> {
    let runs = campaign.runs.iter().filter(|run| {
        run.is_complete() && (run.cell.settings.outstanding == Outstanding::ONE) == one
    });
    let (mut overtaken, mut messages) = (0, 0);
    for run in runs {
        evidence.ask_cell(&run.cell.id);
        let arrivals = run.metrics.as_ref().map(|metrics| metrics.arrivals);
        overtaken += arrivals.map_or(0, |arrivals| arrivals.out_of_order);
        messages += arrivals.map_or(0, |arrivals| arrivals.count);
    }
    (messages > 0).then(|| Estimate::exact(overtaken as f64, messages))
}
