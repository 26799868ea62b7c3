//! Figures D and E: the delay budget of a sample, in the median for each loop, and sample by sample in the
//! run nearest to failing.

use analysis::Campaign;
use analysis::budget::{Budget, Part};
use analysis::statistics::percentile;
use chart::{Axis, Mark, Panel, Series};

use super::scale::{Which, share_all};
use super::{Figure, panel};
use crate::delays::{Delays, unstamped};
use crate::number::duration;
use crate::origin::Origin;
use crate::tone::{OTHER_TONE, PART_TONES};

/// The most panels of samples; the loops that took longest come first.
const MOST_PANELS: usize = 9;
/// Half the width of a bar.
const HALF: f64 = 0.36;
/// The most samples of a panel: each is the one of its time with the longest delay.
const MOST_SAMPLES: usize = 240;

/// Stacked medians, a panel for each topology; `None` if no loop is closed.
pub(super) fn medians(delays: &[Delays<'_>], campaign: &Campaign) -> Option<Figure> {
    let mut topologies: Vec<&str> = delays
        .iter()
        .filter(|of| of.parts_ms.is_some())
        .map(|of| of.topology)
        .collect();
    topologies.dedup();
    if topologies.is_empty() {
        return None;
    }
    let (mut origin, mut panels, mut sentences) = (Origin::default(), Vec::new(), Vec::new());
    for topology in &topologies {
        let here = || delays.iter().filter(|of| of.topology == *topology);
        let closed: Vec<(&Delays<'_>, [f64; 8])> =
            here().filter_map(|of| Some((of, of.parts_ms?))).collect();
        let mut panel = panel("", *topology, "", "delay/ms");
        panel.x.range = Some((-0.6, closed.len() as f64 - 0.4));
        panel.x.names = closed.iter().map(|(of, _)| of.label.clone()).collect();
        panel.series = stack(|part| {
            let bars = closed.iter().enumerate().flat_map(|(at, (_, parts_ms))| {
                let low: f64 = parts_ms[..part as usize].iter().sum();
                let high = low + parts_ms[part as usize];
                let at = at as f64;
                // The gap after a bar is a point that cannot be drawn.
                [
                    ((at - HALF, high), (low, high)),
                    ((at + HALF, high), (low, high)),
                    ((f64::NAN, f64::NAN), (low, high)),
                ]
            });
            bars.collect()
        });
        panel.y.range = None;
        for (of, parts_ms) in &closed {
            origin.take(&of.runs);
            let parts = Part::ALL
                .map(|part| format!("{} {}", part.name(), duration(parts_ms[part as usize])));
            sentences.push(format!("{topology}, {}: {}.", of.label, parts.join(", ")));
        }
        panels.push(panel);
    }
    share_all(&mut panels, Which::Y);
    let columns = topologies.len().min(3);
    let mut figure = Figure::new(
        "D",
        "Where a sample's delay comes from",
        columns,
        "The medians of its parts, in the middle one of the repeats, from the tick at which y was measured to the tick at which the u that follows \
         from it took effect, from below: y waits to be read; the answer's way down, at the ends and through the \
         link; it waits for the controller's next deadline; the client is late; the command's way up, through the \
         link and at the ends; u waits for the plant's next tick. The link's share is what it had at the instant of \
         sending; the ends' is the rest: processes, kernel, a connection that is opened, and what is sent again. Panels have the same axes, unless they \
         differ tenfold.",
        None,
    );
    figure.caption += &unstamped(delays);
    Some(
        figure
            .with_parts()
            .drawn(panels, &sentences, &origin, campaign),
    )
}

/// Stacked samples over time, a panel for each loop; `None` if no loop is closed.
pub(super) fn samples(delays: &[Delays<'_>], campaign: &Campaign) -> Option<Figure> {
    let mut closed: Vec<&Delays<'_>> = delays
        .iter()
        .filter(|of| !of.worst.1.samples.is_empty())
        .collect();
    if closed.is_empty() {
        return None;
    }
    let left_out = closed.len().saturating_sub(MOST_PANELS);
    if left_out > 0 {
        let longest = |of: &&Delays<'_>| percentile(&of.sample_ms, 0.99).unwrap_or(f64::INFINITY);
        let mut by_need = closed.clone();
        by_need.sort_by(|one, other| longest(other).total_cmp(&longest(one)));
        let last = by_need.get(MOST_PANELS).map_or(0.0, longest);
        closed.retain(|of| longest(of) > last);
        closed.truncate(MOST_PANELS);
    }
    let (mut origin, mut panels, mut sentences) = (Origin::default(), Vec::new(), Vec::new());
    for of in &closed {
        let (run, budget) = &of.worst;
        origin.take(&[run]);
        let title = format!("{}, {}", of.topology, of.label);
        let longest = budget
            .samples
            .iter()
            .map(analysis::budget::Sample::total_ns)
            .max();
        sentences.push(format!(
            "{title}: {} samples, the longest {}; {} deadlines missed, {} messages lost.",
            budget.samples.len(),
            duration(longest.unwrap_or(0) as f64 / 1e6),
            budget.missed_ns.len(),
            budget.lost_ns.len()
        ));
        panels.push(over_time(title, budget, run.cell.settings.h.seconds()));
    }
    share_all(&mut panels, Which::X);
    share_all(&mut panels, Which::Y);
    let mut figure = Figure::new(
        "E",
        "The delay of each sample, and what it is made of",
        panels.len().min(3),
        "The same parts over the time at which the command was due, in the run of each loop that was nearest to \
         failing. Where samples are too many to be told apart, the longest of each moment is shown. Where \
         the longest dwarf the others, the panel ends above the others and its title has the longest. Marks at the \
         foot: deadlines at which nothing was sent, and messages that were lost.",
        None,
    );
    if left_out > 0 {
        figure.caption += &format!(" {left_out} more loops, with shorter delays, are not shown.");
    }
    Some(
        figure
            .with_parts()
            .drawn(panels, &sentences, &origin, campaign),
    )
}

fn over_time(title: String, budget: &Budget, h_s: f64) -> Panel {
    let mut panel = panel("", title, "time/s", "delay/ms");
    let per = budget.samples.len().div_ceil(MOST_SAMPLES).max(1);
    let shown: Vec<_> = budget
        .samples
        .chunks(per)
        .filter_map(|chunk| chunk.iter().max_by_key(|sample| sample.total_ns()))
        .collect();
    // A sample holds until the next is due; over a longer time nothing is drawn.
    let holds_s = per as f64 * h_s;
    // A stall of the link is a hundred times what a sample takes otherwise.
    let totals_ms = shown.iter().map(|sample| sample.total_ns() as f64 / 1e6);
    panel.y.range = Axis::telling("", totals_ms.clone()).range;
    let longest_ms = totals_ms.fold(0.0, f64::max);
    if panel.y.range.is_some_and(|(_, most)| most < longest_ms) {
        panel.title += &format!("; up to {}", duration(longest_ms));
    }
    panel.series = stack(|part| {
        let mut points = Vec::new();
        for (at, sample) in shown.iter().enumerate() {
            let sum = sample.before_ns(part);
            let band = (sum as f64 / 1e6, (sum + sample.part_ns(part)) as f64 / 1e6);
            let from_s = budget.second(sample.t_due_ns);
            let next_s = shown
                .get(at + 1)
                .map_or(f64::INFINITY, |next| budget.second(next.t_due_ns));
            let to_s = next_s.min(from_s + 2.0 * holds_s);
            points.push(((from_s, band.1), band));
            points.push(((to_s, band.1), band));
            if to_s < next_s {
                points.push(((f64::NAN, f64::NAN), band));
            }
        }
        points
    });
    panel.series.extend(unanswered(budget, 0.0));
    panel
}

/// Marks at a height: deadlines at which nothing was sent, and messages that were lost.
pub(super) fn unanswered(budget: &Budget, height: f64) -> impl Iterator<Item = Series> {
    let times = [("not sent", &budget.missed_ns), ("lost", &budget.lost_ns)];
    let there = times.into_iter().filter(|(_, times)| !times.is_empty());
    there.map(move |(name, times)| {
        let at = times.iter().map(|t_ns| (budget.second(*t_ns), height));
        Series::new(name.to_owned(), Mark::Dots, OTHER_TONE, at.collect())
    })
}

/// A series for each part.
fn stack(points: impl Fn(Part) -> Vec<((f64, f64), (f64, f64))>) -> Vec<Series> {
    let series = |part: Part| {
        let (points, band): (Vec<_>, Vec<_>) = points(part).into_iter().unzip();
        Series {
            name: part.name().to_owned(),
            mark: Mark::Area,
            tone: PART_TONES[part as usize],
            points,
            band,
        }
    };
    Part::ALL.into_iter().map(series).collect()
}
