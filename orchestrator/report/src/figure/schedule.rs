//! Figure G: how late messages arrived against their schedule, of open loops, which have no response to show.

use analysis::{Campaign, ReadError, grouped, lateness};
use chart::{Mark, Series};
use endpoint::Mode;

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
    for ((topology, h_ns), runs) in &places {
        let rate = runs.first().map_or_else(String::new, |run| run.cell.rate());
        let title = format!("{topology}, {rate}");
        let mut panel = panel("", title, "time/s", "late/ms");
        let kinds = grouped(runs.iter().copied(), |run| {
            (run.cell.client, run.cell.setup())
        });
        let clients = grouped(kinds.iter(), |((client, _), _)| *client);
        for ((client, setup), runs) in &kinds {
            let group = Group::complete(runs.iter().copied());
            let Some(run) = origin.first(&group) else {
                continue;
            };
            let mut points = Vec::new();
            lateness::series(&run.folder, *h_ns, |late| {
                points.push((late.due_s, late.late_ms));
            })?;
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
            let per = points.len().div_ceil(POINTS).max(1);
            let latest = |chunk: &[(f64, f64)]| {
                chunk
                    .iter()
                    .copied()
                    .max_by(|one, other| one.1.total_cmp(&other.1))
            };
            let points = points.chunks(per).filter_map(latest).collect();
            panel
                .series
                .push(Series::new(name, Mark::Line, tones.tone(*client), points));
        }
        panels.push(panel);
    }
    if panels.is_empty() {
        return Ok(None);
    }
    let columns = panels.len().min(3);
    let figure = Figure::new(
        "G",
        "Arrivals against their schedule",
        columns,
        "How late each message of an open loop reached the plant, if the first came on time; the first repeat of \
         each. A line that rises is a client that drifts; one that jumps and returns, a link that held messages up.",
        None,
    );
    Ok(Some(figure.drawn(panels, &sentences, &origin, campaign)))
}
