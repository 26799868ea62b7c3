//! Figure 7: the plant's own intervals from tick to tick, at h = 1 ms and 3 ms.

use analysis::{Campaign, Run, trace};
use chart::{Guide, GuideAt, Mark, Panel, Series};
use endpoint::Mode;

use super::entry::PanelEntry;
use crate::printed::{self, SampleIntervals};
use record::ReadError;
use report::figure::{Figure, panel};
use report::origin::Origin;
use report::tone::PLANT_TONE;

pub(super) fn figure(
    campaign: &Campaign,
    shown: &[PanelEntry],
    figure: Figure,
) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    for shown in shown {
        let mut panel = panel(&shown.letter, shown.title(), "tick", "interval/ms");
        let groups = shown.groups(campaign, Mode::Closed);
        let run = groups.iter().find(|(_, group)| !group.runs.is_empty());
        if let Some((_, group)) = run.or(groups.last())
            && let Some(run) = origin.first(group)
        {
            draw(&mut panel, run, shown.h.ns())?;
            sentences.push(format!("{}.", panel.title));
        }
        panels.push(panel);
    }
    Ok(figure.drawn(panels, &sentences, &origin, campaign))
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
