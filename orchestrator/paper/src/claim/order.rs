//! Messages that were overtaken on their way: section 4.

use analysis::Campaign;
use endpoint::Outstanding;

use super::evidence::Evidence;
use report::claim::Part;
use report::group::Estimate;

/// Counts over all complete cells, separately for clients with one outstanding request and with
/// several.
pub(super) fn out_of_order(campaign: &Campaign) -> Evidence {
    let mut evidence = Evidence::default();
    let one = overtaken(campaign, &mut evidence, |outstanding| {
        outstanding == Outstanding::ONE
    });
    let several = overtaken(campaign, &mut evidence, |outstanding| {
        outstanding != Outstanding::ONE
    });
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
    evidence
}

/// Messages that a later one overtook, out of all messages of cells with so many outstanding requests.
fn overtaken(
    campaign: &Campaign,
    evidence: &mut Evidence,
    is_asked: fn(Outstanding) -> bool,
) -> Option<Estimate> {
    let runs = campaign
        .runs
        .iter()
        .filter(|run| run.is_complete() && is_asked(run.cell.settings.outstanding));
    let (mut overtaken, mut messages) = (0, 0);
    for run in runs {
        evidence.ask_cell(&run.cell.id);
        let arrivals = run.metrics.as_ref().map(|metrics| metrics.arrivals);
        overtaken += arrivals.map_or(0, |arrivals| arrivals.out_of_order);
        messages += arrivals.map_or(0, |arrivals| arrivals.count);
    }
    (messages > 0).then(|| Estimate::exact(overtaken as f64, messages))
}
