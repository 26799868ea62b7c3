//! How the server keeps its own sample time: Figure 7.

use analysis::Campaign;

use super::evidence::{Claim, Evidence, FIREFOX, PYTHON, Source};
use super::rule::ANY;
use super::words::number;
use super::{Finding, Limits, Part, together};
use crate::group::Estimate;
use crate::paper;

/// Part of h that the mean interval may be off.
const MEAN_WITHIN: f64 = 0.01;
/// Part of the paper's standard deviation that ours may have: its plant shared a desktop's clock.
const TIGHTER: f64 = 0.1;

/// Figure 7: the plant's sample intervals while Python closes the loop on arima.
pub(super) fn figure_7(campaign: &Campaign) -> Vec<Finding> {
    let (mut mean, mut spread, mut back): (Evidence, Evidence, Evidence) = Default::default();
    let open = Source::open(campaign, FIREFOX, "arima", paper::H_100_HZ_NS);
    let stamps = together::count(&open, |arrivals| arrivals.zero_10ms);
    let stamps = stamps.and_then(|count| Estimate::share(count.found, count.of));
    back.ask(&open);
    for of in paper::FIG_7 {
        let source = Source::closed(campaign, PYTHON, "arima", of.h_ns);
        let h_ms = source.h_s() * 1e3;
        for evidence in [&mut mean, &mut spread, &mut back] {
            evidence.ask(&source);
        }
        mean.decide(Part::judged(
            source.name("mean of the sample intervals"),
            "ms",
            Some(of.avg_ms),
            source.median(|run| run.metrics.as_ref()?.ticks.interval_avg_ms),
            (h_ms * (1.0 - MEAN_WITHIN), h_ms * (1.0 + MEAN_WITHIN)),
        ));
        let sd_ms = source.median(|run| run.metrics.as_ref()?.ticks.interval_sd_ms);
        if let Some(sd) = sd_ms.filter(|sd| sd.value > 0.0) {
            spread.note(format!(
                "At h = {} ms the paper's desktop has {} times the spread.",
                number(h_ms),
                number(of.sd_ms / sd.value)
            ));
        }
        spread.decide(Part::judged(
            source.name("sd of the sample intervals"),
            "ms",
            Some(of.sd_ms),
            sd_ms,
            (0.0, TIGHTER * of.sd_ms),
        ));
        back.decide(Part::judged(
            source.name("share of sample intervals that are zero or negative"),
            "",
            None,
            // Without the open loop there is nothing to be fewer than.
            stamps.and_then(|_| nonpositive(&source)),
            stamps.map_or(Limits::from(ANY), Limits::below),
        ));
    }
    back.show(Part::judged(
        open.name("share of messages in the same 10 ms as the one before"),
        "",
        None,
        stamps,
        ANY,
    ));
    vec![
        mean.on(Claim {
            id: "fig-7-mean",
            place: "Fig 7",
            claim: "The server's sample intervals are h in the mean.",
            check: "the mean is h within 1 %, in the median of the runs; the paper has 3.000 and \
                    1.004 ms",
        }),
        spread.on(Claim {
            id: "fig-7-spread",
            place: "Fig 7",
            claim: "A desktop's sample intervals scatter by 2.984 and 3.705 ms before any network is \
                    added.",
            check: "that is the computer's and not the loop's: with a plant that keeps deadlines the \
                    standard deviation is at most a tenth of it",
        }),
        back.on(Claim {
            id: "fig-7-nonpositive",
            place: "Fig 7",
            claim: "Fewer sample intervals are zero or negative than messages came at the same time \
                    in Table 3.",
            check: "their share is below JavaScript's at 100 Hz on arima, at 10 ms",
        }),
    ]
}

/// The share of intervals between ticks that are zero or negative, counted over all runs.
fn nonpositive(source: &Source<'_>) -> Option<Estimate> {
    let runs = source.group.runs.iter();
    let ticks = runs.filter_map(|run| Some(run.metrics.as_ref()?.ticks));
    let (mut found, mut all) = (0, 0);
    for ticks in ticks {
        let intervals = ticks.count.saturating_sub(1);
        let share = ticks.interval_nonpositive.unwrap_or(0.0);
        found += (share * intervals as f64).round() as u64;
        all += intervals;
    }
    Estimate::share(found, all)
}
