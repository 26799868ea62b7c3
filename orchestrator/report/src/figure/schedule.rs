//! Figure G: how late messages arrived against their schedule, of open loops, which have no response to show.

use analysis::statistics::upper_median;
use analysis::{Campaign, Run, grouped, lateness};
use chart::{Mark, Series};
use endpoint::Mode;
use record::ReadError;

use super::scale::{Which, share_all};
use super::{Figure, panel};
use crate::group::Group;
use crate::number::duration;
use crate::origin::Origin;
use crate::tone::Tones;

/// The most points of a curve: each is the latest arrival of its time.
const POINTS: usize = 1500;

/// A panel for each topology and rate; `None` without an open loop.
pub(super) fn figure(campaign: &Campaign) -> Result<Option<Figure>, ReadError> {
    let open = campaign.runs.iter();
    let open = open.filter(|run| run.is_complete() && run.cell.settings.mode == Mode::Open);
    let places = grouped(open, |run| {
        (run.cell.topology.as_str(), run.cell.settings.h.ns())
    });
    let tones = Tones::of(campaign);
    let (mut origin, mut sentences, mut panels) = (Origin::default(), Vec::new(), Vec::new());
    for ((topology, _), runs) in &places {
        let rate = runs.first().map_or_else(String::new, |run| run.cell.rate());
        let title = format!("{topology}, {rate}");
        let mut panel = panel("", title, "time/s", "late/ms");
        let kinds = grouped(runs.iter().copied(), |run| {
            (run.cell.client, &run.summary.setup)
        });
        let clients = grouped(kinds.iter(), |((client, _), _)| *client);
        for ((client, setup), runs) in &kinds {
            let group = Group::complete(runs.iter().copied());
            let Some(run) = origin.first(&group) else {
                continue;
            };
            let points = arrivals(run)?;
            let is_alone = clients
                .iter()
                .any(|(of, kinds)| of == client && kinds.len() == 1);
            let name = if is_alone {
                client.to_string()
            } else {
                format!("{client}, {setup}")
            };
            let last = points.last().map_or(0.0, |(_, late_ms)| *late_ms);
            sentences.push(format!(
                "{}: {name}: the last of {} arrivals is {} late.",
                panel.title,
                points.len(),
                duration(last)
            ));
            let (tone, points) = (tones.tone(*client), latest(&points));
            panel
                .series
                .push(Series::new(name, Mark::Line, tone, points));
        }
        panels.push(panel);
    }
    if panels.is_empty() {
        return Ok(None);
    }
    share_all(&mut panels, Which::X);
    share_all(&mut panels, Which::Y);
    let columns = panels.len().min(3);
    let figure = Figure::new(
        "G",
        "Arrivals against their schedule",
        columns,
        "How late each message of an open loop reached the plant, against a schedule for which half of them came too \
         early and half too late; the first repeat of each. A line that rises is a client that drifts; one that jumps and returns, a link that held messages up.",
        None,
    );
    Ok(Some(figure.drawn(panels, &sentences, &origin, campaign)))
}

/// When each message of a run that arrived was due, s, and how late it was, ms.
fn arrivals(run: &Run) -> Result<Vec<(f64, f64)>, ReadError> {
    let mut points = Vec::new();
    lateness::series(&run.folder, run.cell.settings.h.ns(), |late| {
        points.push((late.due_s, late.late_ms));
    })?;
    zero_at_the_median(&mut points);
    Ok(points)
}

/// The points that are drawn.
fn latest(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let per = points.len().div_ceil(POINTS).max(1);
    let latest = |chunk: &[(f64, f64)]| {
        chunk
            .iter()
            .copied()
            .max_by(|one, other| one.1.total_cmp(&other.1))
    };
    points.chunks(per).filter_map(latest).collect()
}

/// Moves the zero to the median, since the first message may have been the late one.
fn zero_at_the_median(points: &mut [(f64, f64)]) {
    let mut late_ms: Vec<f64> = points.iter().map(|(_, late_ms)| *late_ms).collect();
    let middle_ms = upper_median(&mut late_ms, f64::total_cmp).unwrap_or(0.0);
    for (_, late_ms) in points {
        *late_ms -= middle_ms;
    }
}

#[cfg(test)]
mod tests {
    use super::zero_at_the_median;

    #[test]
    fn a_late_first_message_makes_no_other_early() {
        let mut points = vec![(0.0, 0.0), (1.0, -9.0), (2.0, -9.0), (3.0, -9.0)];
        zero_at_the_median(&mut points);
        assert_eq!(points, [(0.0, 9.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)]);
    }
}
