//! Figures 8 and 9: the distribution of the intervals between arriving commands at 333 Hz.
//!
//! Bins are equally wide here, so that bars can be compared by eye; the histograms of
//! [`analysis::interval`] reach further, with wider bins.

use analysis::{Campaign, trace};
use chart::{Guide, GuideAt, Mark, Panel, Scale, Series};
use endpoint::Mode;

use super::entry::PanelEntry;
use crate::printed;
use crate::subject::Subject;
use record::ReadError;
use report::figure::{Figure, panel};
use report::origin::Origin;

const H_MS: f64 = printed::H_333_HZ_NS as f64 / 1e6;

pub(super) fn figure(
    campaign: &Campaign,
    shown: &[PanelEntry],
    figure: Figure,
) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    for shown in shown {
        let groups = shown.groups(campaign, Mode::Closed);
        let mut panel = panel(&shown.letter, shown.title(), "interval/ms", "share/%");
        let mut histogram = Histogram::new(shown.reach);
        for run in groups.iter().flat_map(|(_, group)| &group.runs) {
            let intervals_ms = trace::control_intervals_ms(&run.folder)?;
            intervals_ms.into_iter().for_each(|ms| histogram.push(ms));
        }
        groups.iter().for_each(|(_, group)| origin.all(group));
        if histogram.total > 0
            && let [subject, ..] = shown.who[..]
        {
            sentences.push(format!(
                "{}: of {} intervals {:.1} % are zero to within {:.3} ms, {:.1} % are h to within \
                 as much, and {:.1} % are longer than {} ms.",
                panel.title,
                histogram.total,
                histogram.percent(histogram.counts.first().copied()),
                histogram.width_ms / 2.0,
                histogram.percent(histogram.counts.get(Histogram::PER_H).copied()),
                histogram.percent(Some(histogram.beyond)),
                f64::from(shown.reach) * H_MS,
            ));
            draw(&mut panel, subject, &histogram);
        }
        panels.push(panel);
    }
    Ok(figure.drawn(panels, &sentences, &origin, campaign))
}

/// Lower end of the scale, %: below the share of one interval in a panel.
const LEAST_PERCENT: f64 = 0.001;

fn draw(panel: &mut Panel, subject: Subject, histogram: &Histogram) {
    let mark = Mark::Bars(histogram.width_ms);
    panel.series.push(Series::new(
        subject.name(),
        mark,
        subject.tone(),
        histogram.points(),
    ));
    let reach_ms = histogram.width_ms * (histogram.counts.len() as f64 - 0.5);
    panel.x.range = Some((-histogram.width_ms, reach_ms));
    panel.y.scale = Scale::Log;
    panel.y.range = Some((LEAST_PERCENT, 100.0));
    panel.guides = vec![Guide {
        name: format!("h = {H_MS} ms"),
        at: GuideAt::X(H_MS),
    }];
    let beyond = histogram.percent(Some(histogram.beyond));
    if beyond >= 0.05 {
        panel.title = format!("{}; {beyond:.1} % longer", panel.title);
    }
}

/// Counts of intervals in bins that are centred on multiples of their width.
struct Histogram {
    width_ms: f64,
    counts: Vec<u64>,
    /// Intervals beyond the last bin.
    beyond: u64,
    total: u64,
}

impl Histogram {
    /// Bins per h.
    const PER_H: usize = 20;

    /// Bins from zero to `reach`, in h.
    fn new(reach: u32) -> Histogram {
        Histogram {
            width_ms: H_MS / Self::PER_H as f64,
            counts: vec![0; reach as usize * Self::PER_H + 1],
            beyond: 0,
            total: 0,
        }
    }

    fn push(&mut self, interval_ms: f64) {
        self.total += 1;
        let bin = (interval_ms / self.width_ms).round().max(0.0);
        match self.counts.get_mut(bin as usize) {
            Some(count) => *count += 1,
            None => self.beyond += 1,
        }
    }

    fn percent(&self, count: Option<u64>) -> f64 {
        count.unwrap_or(0) as f64 / self.total as f64 * 100.0
    }

    /// The middle of each bin that is not empty, ms, and its share, %.
    fn points(&self) -> Vec<(f64, f64)> {
        let counts = self.counts.iter().enumerate();
        counts
            .filter(|(_, count)| **count > 0)
            .map(|(n, count)| {
                // Multiplied first, so that a multiple of h is written as one.
                let middle_ms = n as f64 * H_MS / Self::PER_H as f64;
                (middle_ms, self.percent(Some(*count)))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn h_is_in_the_middle_of_a_bin_and_so_is_zero() {
        let mut histogram = Histogram::new(2);
        for ms in [0.0, 0.07, 2.93, 3.0, 3.07, 6.07, 6.08, -0.001] {
            histogram.push(ms);
        }
        let shares = [(0.0, 37.5), (3.0, 37.5), (6.0, 12.5)];
        for ((ms, percent), (expected_ms, expected)) in histogram.points().into_iter().zip(shares) {
            assert!((ms - expected_ms).abs() < 1e-9 && (percent - expected).abs() < 1e-9);
        }
        assert_eq!((histogram.beyond, histogram.total), (1, 8));
    }

    proptest! {
        #[test]
        fn every_interval_is_in_a_bin_or_beyond(all in prop::collection::vec(0.0..100.0, 1..100)) {
            let mut histogram = Histogram::new(5);
            all.iter().for_each(|ms| histogram.push(*ms));
            let percent: f64 = histogram.points().iter().map(|(_, percent)| percent).sum();
            let beyond = histogram.percent(Some(histogram.beyond));
            prop_assert!((percent + beyond - 100.0).abs() < 1e-9);
        }
    }
}
