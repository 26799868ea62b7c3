//! Figures 3 and 4: lateness of the messages against their schedule, `(a_k - a_0) - k h` over `k h`,
//! from Python and from JavaScript on three topologies.

use analysis::{Campaign, Run, lateness};
use chart::{Mark, Panel, Series};
use endpoint::Mode;

use super::entry::PanelEntry;
use crate::printed;
use crate::subject::Subject;
use record::ReadError;
use report::figure::{Figure, panel};
use report::origin::Origin;
use text::significant;

pub(super) fn figure(
    campaign: &Campaign,
    shown: &[PanelEntry],
    figure: Figure,
) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    for shown in shown {
        let mut panel = panel(&shown.letter, shown.title(), "schedule/s", "late/s");
        for (subject, group) in shown.groups(campaign, Mode::Open) {
            if let Some(run) = origin.first(&group) {
                draw(&mut panel, subject, run, shown.h.ns())?;
            }
        }
        if !panel.series.is_empty() {
            let names: Vec<&str> = panel.series.iter().map(|s| s.name.as_str()).collect();
            sentences.push(format!("{}: {}.", panel.title, names.join(", ")));
        }
        panels.push(panel);
    }
    Ok(figure.drawn(panels, &sentences, &origin, campaign))
}

fn draw(panel: &mut Panel, subject: Subject, run: &Run, h_ns: u64) -> Result<(), ReadError> {
    let mut points = Vec::new();
    lateness::series(&run.folder, h_ns, |late| {
        points.push((late.due_s, late.late_ms / 1e3));
    })?;
    // Messages may overtake each other; the line goes through them in the order in which they were due.
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let slope = run.metrics.and_then(|metrics| metrics.arrivals.drift.slope);
    let name = match slope {
        Some(slope) => format!("{} {} ms/s", subject.client, ms_a_second(slope)),
        None => subject.client.to_string(),
    };
    let tone = subject.tone();
    panel
        .series
        .push(Series::new(name, Mark::Line, tone, points));
    Ok(())
}

/// A slope in ms/s as text, precise enough for the limit of 1 ms/s: with two decimals, from 1 ms/s on
/// with three digits, and without a sign before zero.
fn ms_a_second(slope: f64) -> String {
    let ms = 1e3 * slope;
    match (ms * 1e2).round() == 0.0 {
        true => "0.00".to_owned(),
        false if ms.abs() < 1.0 => format!("{ms:.2}"),
        false => significant(ms, 3),
    }
}

#[cfg(test)]
mod tests {
    use super::ms_a_second;

    #[test]
    fn slopes_have_two_decimals_or_three_digits_and_no_signed_zero() {
        for (slope, words) in [
            (-1e-9, "0.00"),
            (0.000_02, "0.02"),
            (-0.0024, "-2.40"),
            (0.0911, "91.1"),
            (1.967, "1967"),
        ] {
            assert_eq!(ms_a_second(slope), words);
        }
    }
}
