//! Figure F: the run nearest to failing, with the link over the same time axis, so that one sees which
//! second did it.

use analysis::blame::End;
use analysis::budget::{Budget, Part, timeline};
use analysis::{Campaign, Run};
use chart::{Guide, GuideAt, Mark, Panel, Scale, Series};
use link::Way;
use record::ReadError;

use super::budget::unanswered;
use super::median::{Signal, Traces};
use super::reach::{about, left_at, until};
use super::step::{guides, range};
use super::{Figure, panel};
use crate::called::called;
use crate::delays::Nearest;
use crate::group::Group;
use crate::origin::Origin;
use crate::tone::{OTHER_TONE, PART_TONES, Tones};

/// How often the link is asked, s.
const LOOK_S: f64 = 0.002;

/// At how many instants it is asked at most.
const LOOKS_MOST: u64 = 1_000_000;

/// The closed loop nearest to failing.
pub(super) fn figure(
    campaign: &Campaign,
    nearest: &Nearest<'_>,
    traces: &mut Traces,
) -> Result<Figure, ReadError> {
    let run = nearest.run;
    let end_s = run.cell.duration_ns as f64 / 1e9;
    let group = Group::complete(campaign.runs.iter().filter(|one| is_repeat(one, run)));
    let mut origin = Origin::default();
    origin.take(&group.runs);
    let mut panels = Vec::new();
    for (signal, title, name) in [(Signal::Y, "output", "y"), (Signal::U, "input", "u")] {
        let panel = panel("", title, "", name);
        panels.push(drawn(panel, signal, campaign, nearest, &group, traces)?);
    }
    let mut last = link(campaign, run, nearest.budget, end_s);
    last.x.label = "time/s".to_owned();
    panels.push(last);
    for panel in &mut panels {
        panel.x.range = Some((0.0, end_s));
        panel.guides.extend(blamed(nearest));
    }
    let name = called(campaign, run);
    let sentence = match &nearest.blame {
        Some(blame) if blame.stands_out() => format!("{name}: {blame}."),
        _ => format!("{name}: no moment stands out."),
    };
    let oldest = match &nearest.blame {
        Some(blame) if blame.end == End::Lost => "the oldest until the loop was lost",
        _ => "the oldest of the run",
    };
    let cut = match &nearest.blame {
        Some(blame) if blame.end == End::Lost => {
            " Output and input are cut at twice what they reached until then."
        }
        _ => "",
    };
    let figure = Figure::new(
        "F",
        "The run nearest to failing",
        1,
        &format!(
            "Output, input and link over the same time, in {name}. Between the two upright lines the plant was steered \
             by one y, {oldest}. Delay: of each message on its way up, and in lines what the link had each way at each instant; at the \
             foot, deadlines at which nothing was sent, and messages that were lost.{cut} {sentence}"
        ),
        None,
    );
    Ok(figure
        .with_parts()
        .drawn(panels, &[sentence], &origin, campaign))
}

/// Whether a run repeats another.
fn is_repeat(one: &Run, other: &Run) -> bool {
    one.cell.topology == other.cell.topology
        && one.summary.condition() == other.summary.condition()
        && one.cell.settings == other.cell.settings
}

/// A panel with a signal of the run, over the median of its repeats.
fn drawn(
    mut panel: Panel,
    signal: Signal,
    campaign: &Campaign,
    Nearest { run, budget, .. }: &Nearest<'_>,
    group: &Group<'_>,
    traces: &mut Traces,
) -> Result<Panel, ReadError> {
    let cell = &run.cell;
    let h_ns = cell.settings.h.ns();
    let end_s = cell.duration_ns as f64 / 1e9;
    if group.runs.len() > 1 {
        panel.series.push(Series {
            name: "median of its repeats".to_owned(),
            tone: OTHER_TONE,
            ..traces.median(group, signal, h_ns, end_s)?
        });
    }
    panel.series.push(Series {
        name: "this run".to_owned(),
        tone: Tones::of(campaign).tone(cell.client),
        ..traces.single(run, signal, h_ns, end_s)?
    });
    // A response begins with the first command that took effect; time here with the first deadline.
    let offset_s = budget.second(budget.effect_ns.unwrap_or(budget.start_ns));
    let series = panel.series.iter_mut();
    for (at_s, _) in series.flat_map(|series| &mut series.points) {
        *at_s += offset_s;
    }
    if signal == Signal::Y && cell.moving_reference().is_none() {
        let (r, band) = (cell.settings.r, run.summary.band);
        panel.guides = guides(r, band);
        panel.y.range = range(&panel.series, r, band).map(|seen| about(seen, r, left_at(run, r)));
    }
    // What a law asks for once its plant is gone would flatten all that it asked for before.
    let lost_s = run.metrics.as_ref().and_then(|of| of.response?.lost_s);
    if let (Signal::U, Some(lost_s)) = (signal, lost_s) {
        panel.y.range = until(&panel.series, lost_s);
    }
    Ok(panel)
}

/// The ends of the time in which the oldest y steered the plant, where it stands out.
fn blamed(nearest: &Nearest<'_>) -> Vec<Guide> {
    let blame = nearest.blame.as_ref().filter(|blame| blame.stands_out());
    blame.map_or(Vec::new(), |blame| {
        let ends_s = [blame.from_ns as f64 / 1e9, blame.at_s()];
        let guide = |at_s| Guide {
            name: String::new(),
            at: GuideAt::X(at_s),
        };
        ends_s.map(guide).to_vec()
    })
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
        let looks = ((end_s / LOOK_S) as u64).min(LOOKS_MOST);
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
