//! Figure F: the run nearest to failing, with the link over the same time axis, so that one sees which
//! second did it.

use analysis::budget::{Budget, Part, timeline};
use analysis::{Campaign, ReadError, Run};
use chart::{Guide, GuideAt, Mark, Panel, Scale, Series};
use link::Way;

use super::budget::unanswered;
use super::median::{Signal, Traces};
use super::step::{guides, range};
use super::{Figure, panel};
use crate::delays::Nearest;
use crate::group::Group;
use crate::origin::Origin;
use crate::tone::{OTHER_TONE, PART_TONES, Tones};

/// How often the link is asked, s.
const LOOK_S: f64 = 0.002;

/// The closed loop nearest to failing.
pub(super) fn figure(
    campaign: &Campaign,
    Nearest { run, budget, hold }: &Nearest<'_>,
    traces: &mut Traces,
) -> Result<Figure, ReadError> {
    let cell = &run.cell;
    let h_ns = cell.settings.h.ns();
    let end_s = cell.duration_ns as f64 / 1e9;
    let like = campaign.runs.iter().filter(|one| {
        let other = &one.cell;
        other.topology == cell.topology
            && other.client == cell.client
            && other.setup() == cell.setup()
            && other.settings == cell.settings
    });
    let group = Group::complete(like);
    let mut origin = Origin::default();
    origin.take(&group.runs);
    let effect_ns = budget.effect_ns.unwrap_or(budget.start_ns);
    let offset_s = budget.second(effect_ns);
    let tone = Tones::of(campaign).tone(cell.client);
    let mut panels = Vec::new();
    for (signal, title, name) in [(Signal::Y, "output", "y"), (Signal::U, "input", "u")] {
        let mut panel = panel("", title, "", name);
        if group.runs.len() > 1 {
            panel.series.push(Series {
                name: "median of its repeats".to_owned(),
                tone: OTHER_TONE,
                ..traces.median(&group, signal, h_ns, end_s)?
            });
        }
        panel.series.push(Series {
            name: "this run".to_owned(),
            tone,
            ..traces.single(run, signal, h_ns, end_s)?
        });
        // A response begins with the first command that took effect; time here with the first deadline.
        for (at_s, _) in panel
            .series
            .iter_mut()
            .flat_map(|series| &mut series.points)
        {
            *at_s += offset_s;
        }
        if signal == Signal::Y && cell.moving_reference().is_none() {
            panel.guides = guides(cell.settings.r);
            panel.y.range = range(&panel.series, cell.settings.r);
        }
        panels.push(panel);
    }
    panels.push(link(campaign, run, budget, end_s));
    for panel in &mut panels {
        panel.x.range = Some((0.0, end_s));
        if let Some(hold) = hold {
            let ends_s = [hold.at_s, hold.at_s + hold.length_ms / 1e3];
            panel.guides.extend(ends_s.map(|at_s| Guide {
                name: String::new(),
                at: GuideAt::X(at_s),
            }));
        }
    }
    if let Some(last) = panels.last_mut() {
        last.x.label = "time/s".to_owned();
    }
    let sentence = match hold {
        Some(hold) => format!("{}: {hold}.", cell.id),
        None => format!("{}: no moment stands out.", cell.id),
    };
    let figure = Figure::new(
        "F",
        "The run nearest to failing",
        1,
        &format!(
            "Output, input and link over the same time, in {}. Between the two upright lines the plant held one \
             command. Delay: of each message on its way up, and in lines what the link had each way at each instant; at the \
             foot, deadlines at which nothing was sent, and messages that were lost. {sentence}",
            cell.id
        ),
        None,
    );
    Ok(figure
        .with_parts()
        .drawn(panels, &[sentence], &origin, campaign))
}

/// The link's delay up, and what became of the messages.
fn link(campaign: &Campaign, run: &Run, budget: &Budget, end_s: f64) -> Panel {
    let mut panel = panel("", "messages and link", "time/s", "delay/ms");
    let ways = budget.trips.iter();
    let ways = ways.map(|trip| (budget.second(trip.t_send_ns), trip.up.ns() as f64 / 1e6));
    panel.series.push(Series::new(
        "way up of a message".to_owned(),
        Mark::Dots,
        PART_TONES[6],
        ways.collect(),
    ));
    if let Some(mut link) = timeline(run, &campaign.plan) {
        let looks = (end_s / LOOK_S) as u64;
        for (way, name, part) in [
            (Way::Up, "link up", Part::Up),
            (Way::Down, "link down", Part::Down),
        ] {
            let mut at = |look: u64| {
                let at_s = look as f64 * LOOK_S;
                let t_ns = budget.start_ns + (at_s * 1e9) as u64;
                (at_s, link.state_at(way, t_ns).delay_ns as f64 / 1e6)
            };
            let points: Vec<(f64, f64)> = (0..looks).map(&mut at).collect();
            if points.iter().any(|(_, ms)| *ms > 0.0) {
                let tone = PART_TONES[part as usize];
                panel
                    .series
                    .push(Series::new(name.to_owned(), Mark::Line, tone, points));
            }
        }
    }
    // A stall of the link is a hundred times its delay at other times.
    panel.y.scale = Scale::Log;
    let delays = panel.series.iter().flat_map(|series| &series.points);
    let least = delays
        .map(|(_, ms)| *ms)
        .filter(|ms| *ms > 0.0)
        .fold(f64::INFINITY, f64::min);
    if least.is_finite() {
        panel.series.extend(unanswered(budget, least));
    }
    panel
}
