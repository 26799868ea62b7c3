//! Figure 2: when the first 600 messages of the JavaScript client arrived, at 100 Hz without a
//! network.

use analysis::{Campaign, Run, lateness};
use chart::{Guide, GuideAt, Mark, Series};
use endpoint::Mode;

use super::entry::PanelEntry;
use crate::printed;
use record::ReadError;
use report::figure::{Figure, panel};
use report::origin::Origin;
use report::tone::OTHER_TONE;

/// Number of messages that the paper's figure shows.
const MESSAGES: u64 = 600;

pub(super) fn figure(
    campaign: &Campaign,
    shown: &[PanelEntry],
    figure: Figure,
) -> Result<Figure, ReadError> {
    let mut panel = panel("", "", "message", "arrival/s");
    let (mut origin, mut sentences) = (Origin::beside(printed::OPEN_LOOP_S), Vec::new());
    let groups = shown
        .iter()
        .flat_map(|shown| shown.groups(campaign, Mode::Open));
    for (subject, group) in groups {
        let Some(run) = origin.first(&group) else {
            continue;
        };
        let points = arrivals(run)?;
        if let Some((n, last_s)) = points.last() {
            sentences.push(format!(
                "{}: message {n} came {last_s:.2} s after the first, where {:.2} s were asked for.",
                subject.name(),
                due_s(*n),
            ));
        }
        // Beside the clients of 2011, one of today is quiet.
        let tone = if subject.preset.is_of_the_paper() {
            subject.tone()
        } else {
            OTHER_TONE
        };
        panel
            .series
            .push(Series::new(subject.name(), Mark::Line, tone, points));
    }
    if !panel.series.is_empty() {
        let last = MESSAGES as f64;
        panel.guides = vec![
            Guide {
                name: "on time".to_owned(),
                at: GuideAt::Line((1.0, 0.0), (last, due_s(last))),
            },
            Guide {
                name: format!("the paper's 600th: {} s", printed::FIG_2_600TH_S),
                at: GuideAt::Y(printed::FIG_2_600TH_S),
            },
        ];
    }
    Ok(figure.drawn(vec![panel], &sentences, &origin, campaign))
}

/// When the n-th message was due, s from the first.
fn due_s(n: f64) -> f64 {
    (n - 1.0) * printed::H_100_HZ_NS as f64 / 1e9
}

/// The number of each message, from 1, and its arrival, s from the first arrival.
fn arrivals(run: &Run) -> Result<Vec<(f64, f64)>, ReadError> {
    let mut first = None;
    let mut points = Vec::new();
    lateness::series(&run.folder, printed::H_100_HZ_NS, |late| {
        let (first_seq, first_due_s) = *first.get_or_insert((late.seq, late.due_s));
        let n = late.seq.saturating_sub(first_seq) + 1;
        if n <= MESSAGES {
            points.push((n as f64, late.due_s - first_due_s + late.late_ms / 1e3));
        }
    })?;
    Ok(points)
}
