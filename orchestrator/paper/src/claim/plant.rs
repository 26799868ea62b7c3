//! How the server keeps its own sample time: Figure 7.

use super::evidence::Evidence;
use super::rare::Count;
use super::row::{Accepted, Claim, Judged, Metric, Row, Than};
use super::together::in_10_ms;
use super::words::{fraction, percent};
use crate::printed::{self, FIG_7};
use crate::subject::{FIREFOX_2011, PYTHON};
use report::claim::rule::ANY;
use report::number::number;

/// Share of h by which the mean interval may be off.
const MEAN_WITHIN: f64 = 0.01;
/// Greatest ratio of our standard deviation to the paper's, whose plant shared a desktop's clock.
const TIGHTER: f64 = 0.1;

const MEAN: Metric = Metric::median("mean of the sample intervals", "ms", |m| {
    m.ticks.interval_avg_ms
});
pub(super) const SPREAD: Metric = Metric::median("sd of the sample intervals", "ms", |m| {
    m.ticks.interval_sd_ms
});
const NONPOSITIVE: Metric = Metric::group(
    "share of sample intervals that are zero or negative",
    "",
    |source| {
        let count = Count::over(source, |m| (m.ticks.interval_nonpositive, m.ticks.count));
        Ok(count.and_then(Count::sampled))
    },
);
const SAME_STAMP: Metric = Metric::group(
    "share of messages in the same 10 ms as the one before",
    "",
    |source| Ok(in_10_ms(source).and_then(Count::sampled)),
);

/// Figure 7: the plant's sample intervals while Python closes the loop on arima.
pub(super) fn figure_7() -> Vec<Claim> {
    let closed = |h_ns| PYTHON.closed("arima", h_ns);
    let open = FIREFOX_2011.open("arima", printed::H_100_HZ_NS);
    let fewer = Accepted::Below(Than {
        asked: open,
        metric: SAME_STAMP,
        unknown: ANY,
    });
    let mean = |of: printed::SampleIntervals| {
        let h_ms = h_ms(of.h_ns);
        let accepted = (h_ms * (1.0 - MEAN_WITHIN), h_ms * (1.0 + MEAN_WITHIN));
        Row::new(closed(of.h_ns), MEAN, accepted).paper(of.avg_ms)
    };
    let spread = |of: printed::SampleIntervals| {
        Row::new(closed(of.h_ns), SPREAD, (0.0, TIGHTER * of.sd_ms)).paper(of.sd_ms)
    };
    let back = |of: printed::SampleIntervals| Row::new(closed(of.h_ns), NONPOSITIVE, fewer);
    let back = FIG_7.map(back).into_iter();
    vec![
        Claim {
            id: "fig-7-mean",
            place: "Fig 7",
            claim: "The server's sample intervals are h in the mean.",
            check: format!(
                "the mean is h within {}, in the median of the runs; the paper has 3.000 and 1.004 ms",
                percent(MEAN_WITHIN)
            ),
            rows: FIG_7.map(mean).into(),
            ..Claim::default()
        },
        Claim {
            id: "fig-7-spread",
            place: "Fig 7",
            claim: "A desktop's sample intervals scatter by 2.984 and 3.705 ms before any network is \
                    added.",
            check: format!(
                "that is the computer's and not the loop's: with a plant that keeps deadlines the \
                 standard deviation is at most {} of it",
                fraction(TIGHTER)
            ),
            rows: FIG_7.map(spread).into(),
            remark: Some(note_spread),
            ..Claim::default()
        },
        Claim {
            id: "fig-7-nonpositive",
            place: "Fig 7",
            claim: "Fewer sample intervals are zero or negative than messages came at the same time \
                    in Table 3.",
            check: "their share is below JavaScript's at 100 Hz on arima, at 10 ms".to_owned(),
            rows: back.chain([Row::shown(open, SAME_STAMP)]).collect(),
            ..Claim::default()
        },
    ]
}

fn h_ms(h_ns: u64) -> f64 {
    h_ns as f64 / 1e9 * 1e3
}

fn note_spread(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for judged in judged {
        let ours = judged.ours.filter(|sd| sd.value > 0.0);
        if let (Some(paper), Some(ours)) = (judged.row.paper, ours) {
            evidence.note(format!(
                "At h = {} ms the paper's desktop has {} times the spread.",
                number(h_ms(judged.source.asked.h_ns)),
                number(paper / ours.value)
            ));
        }
    }
}
