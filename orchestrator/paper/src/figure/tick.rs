//! Figure 7: the plant's own intervals from tick to tick, at h = 1 ms and 3 ms.

use analysis::{Campaign, ReadError, Run, trace};
use chart::{Guide, GuideAt, Mark, Panel, Series};
use endpoint::Mode;

use crate::printed::{self, SampleIntervals};
use crate::subject::{NATIVE, PYTHON};
use report::figure::{Figure, panel};
use report::group::Group;
use report::origin::Origin;
use report::tone::PLANT_TONE;

pub(super) fn figure(campaign: &Campaign) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    for (letter, h_ns, words) in [
        ("a", printed::H_1_KHZ_NS, "h = 1 ms"),
        ("b", printed::H_333_HZ_NS, "h = 3 ms"),
    ] {
        let mut panel = panel(letter, words, "tick", "interval/ms");
        let group = runs(campaign, h_ns);
        if let Some(run) = origin.first(&group) {
            draw(&mut panel, run, h_ns)?;
            sentences.push(format!("{}.", panel.title));
        }
        panels.push(panel);
    }
    let figure = Figure::new(
        "7",
        "The plant's sample intervals",
        2,
        "Time from each tick of the plant to the next, in the first closed loop without \
         a network. The paper's mean and standard deviation are lines.",
        Some(
            "Scattered widely about h on a desktop's operating system: mean 3.0 and 1.004 ms, \
         standard deviation 2.984 and 3.705 ms.",
        ),
    );
    Ok(figure.drawn(panels, &sentences, &origin, campaign))
}

/// Python's runs on arima, as in the paper; native's if there are none.
fn runs(campaign: &Campaign, h_ns: u64) -> Group<'_> {
    let python = PYTHON.runs(campaign, "arima", Mode::Closed, h_ns);
    if python.runs.is_empty() {
        NATIVE.runs(campaign, "arima", Mode::Closed, h_ns)
    } else {
        python
    }
}

fn draw(panel: &mut Panel, run: &Run, h_ns: u64) -> Result<(), ReadError> {
    let intervals_ms = trace::tick_intervals_ms(&run.folder)?;
    let ticks = run.metrics.map(|metrics| metrics.ticks);
    if let Some((avg_ms, sd_ms)) = ticks.and_then(|t| t.interval_avg_ms.zip(t.interval_sd_ms)) {
        panel.title = format!("{}: mean {avg_ms:.3} ms, sd {sd_ms:.3} ms", panel.title);
    }
    let points = (1..).map(f64::from).zip(intervals_ms.iter().copied());
    let points: Vec<(f64, f64)> = points.collect();
    panel.series.push(Series::new(
        "ticks".to_owned(),
        Mark::Dots,
        PLANT_TONE,
        points,
    ));
    let theirs = printed::FIG_7.iter().find(|theirs| theirs.h_ns == h_ns);
    panel.guides = theirs.map(guides).unwrap_or_default();
    panel.y.range = theirs.map(|theirs| range(theirs, &intervals_ms));
    Ok(())
}

fn guides(theirs: &SampleIntervals) -> Vec<Guide> {
    let level = |name: &str, y: f64| Guide {
        name: name.to_owned(),
        at: GuideAt::Y(y),
    };
    let SampleIntervals { avg_ms, sd_ms, .. } = theirs;
    vec![
        level("the paper's mean ± sd", avg_ms + sd_ms),
        level("the paper's mean", *avg_ms),
        level("the paper's mean ± sd", avg_ms - sd_ms),
    ]
}

/// The range of our intervals and the paper's standard deviation, with a small margin.
fn range(theirs: &SampleIntervals, intervals_ms: &[f64]) -> (f64, f64) {
    let ends = (theirs.avg_ms - theirs.sd_ms, theirs.avg_ms + theirs.sd_ms);
    let (low, high) = intervals_ms
        .iter()
        .fold(ends, |(low, high), ms| (low.min(*ms), high.max(*ms)));
    let air = 0.05 * (high - low);
    (low - air, high + air)
}
