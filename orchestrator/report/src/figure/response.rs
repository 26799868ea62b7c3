//! Figures A and B: the step responses of all closed loops, and the plant's inputs.
//!
//! Whatever ran at one place is in one panel, so that controllers are compared over the same links.

use analysis::{Campaign, LoopVerdict, ReadError, Run, grouped};
use chart::{Mark, Panel, Series};
use system::System;

use super::median::{Signal, Traces};
use super::step::{guides, horizon_s, range, settled};
use super::{Figure, fault, panel};
use crate::delays::nearest_to_failing;
use crate::group::Group;
use crate::loops::{self, Loop};
use crate::origin::Origin;
use crate::tone::{OTHER_TONE, Tones};

/// The most panels of each figure; further places are counted in its caption.
const MOST_OUTPUTS: usize = 25;
const MOST_INPUTS: usize = 12;
/// Panels side by side.
const COLUMNS: usize = 3;

/// Where loops ran that can be compared: over one topology, with one plant, through one fault, at one rate.
struct Place<'a> {
    topology: &'a str,
    system: &'a str,
    fault: Option<&'a str>,
    h_ns: u64,
    /// What ran there, in the plan's order: a curve each.
    loops: Vec<Loop<'a>>,
}

/// Figures A and B, the outputs and the inputs of the closed loops; none if no loop was closed.
pub(super) fn figures(campaign: &Campaign, traces: &mut Traces) -> Result<Vec<Figure>, ReadError> {
    let places = grouped(loops::all(campaign), |one| {
        (one.topology, one.system, one.fault, one.h_ns)
    });
    let mut places: Vec<Place<'_>> = places
        .into_iter()
        .map(|((topology, system, fault, h_ns), loops)| Place {
            topology,
            system,
            fault,
            h_ns,
            loops,
        })
        .collect();
    places.retain(|place| place.loops.iter().any(|one| !one.group.runs.is_empty()));
    let tones = Tones::of(campaign);
    let mut figures = Vec::new();
    for (signal, most) in [(Signal::Y, MOST_OUTPUTS), (Signal::U, MOST_INPUTS)] {
        let left_out = places.len().saturating_sub(most);
        let places = chosen(&places, most);
        let (mut origin, mut sentences, mut panels) = (Origin::default(), Vec::new(), Vec::new());
        for place in &places {
            for one in &place.loops {
                origin.all(&one.group);
            }
            let panel = place.draw(signal, campaign, &tones, traces)?;
            let curves = panel.series.iter().map(|series| series.name.as_str());
            let curves: Vec<&str> = curves.filter(|name| !name.is_empty()).collect();
            if !curves.is_empty() {
                sentences.push(format!("{}: {}.", panel.title, curves.join("; ")));
            }
            panels.push(panel);
        }
        if panels.is_empty() {
            continue;
        }
        let (number, title, what) = match signal {
            Signal::Y => ("A", "Step responses", "Outputs"),
            Signal::U => ("B", "Inputs of the plant", "Inputs"),
        };
        let mut caption = format!(
            "{what} from the first command that the plant applied, all that ran at one place together: the median \
             over the repeats at each instant, and the band in which half of them lie; dashed, the repeat nearest to failing. The time is the median settling into 2 % of the reference, after its last step \
             where it moves. A loop that leaves the range of those that hold is cut."
        );
        if left_out > 0 {
            caption +=
                &format!(" {left_out} more places, where the loops held, are in the tables alone.");
        }
        let figure = Figure::new(number, title, places.len().min(COLUMNS), &caption, None);
        figures.push(figure.drawn(panels, &sentences, &origin, campaign));
    }
    Ok(figures)
}

/// The places that are shown, in the plan's order: those where a loop did not hold are chosen first.
fn chosen<'b, 'a>(places: &'b [Place<'a>], most: usize) -> Vec<&'b Place<'a>> {
    let mut by_need: Vec<usize> = (0..places.len()).collect();
    by_need.sort_by_key(|at| places[*at].held());
    by_need.truncate(most);
    by_need.sort_unstable();
    by_need.into_iter().map(|at| &places[at]).collect()
}

impl Place<'_> {
    /// Whether all loops held here.
    fn held(&self) -> bool {
        let mut loops = self.loops.iter();
        loops.all(|one| one.stable() == one.group.runs.len())
    }

    /// The panel of this place; empty if nothing here is complete.
    fn draw(
        &self,
        signal: Signal,
        campaign: &Campaign,
        tones: &Tones,
        traces: &mut Traces,
    ) -> Result<Panel, ReadError> {
        let kinds = &self.loops;
        let first = kinds.iter().find_map(|kind| kind.group.runs.first());
        let rate = first.map_or_else(String::new, |run| format!(", {}", run.cell.rate()));
        // A fault's name takes its place in the title, unless there are several systems.
        let is_alone = self.fault.is_some() && campaign.plan.systems.len() == 1;
        let system = if self.system == System::PAPER || is_alone {
            String::new()
        } else {
            format!(", {}", self.system)
        };
        let fault = self
            .fault
            .map_or_else(String::new, |name| format!(", {name}"));
        let title = format!("{}{fault}{system}{rate}", self.topology);
        let mut panel = panel(
            "",
            title,
            "time/s",
            if signal == Signal::Y { "y" } else { "u" },
        );
        let Some(first) = first else {
            return Ok(panel);
        };
        let moving = first.cell.moving_reference();
        let end_s = match (&moving, self.fault) {
            (None, None) => horizon_s(kinds.iter().map(|kind| &kind.group)),
            _ => first.cell.duration_ns as f64 / 1e9,
        };
        panel.x.range = Some((0.0, end_s));
        panel.guides = fault::guides(&campaign.plan.fault_spells(&first.cell));
        let mut held = Vec::new();
        for kind in kinds {
            let Some(settling_ms) = kind.group.settling_ms() else {
                continue;
            };
            let is_alone = kinds.iter().filter(|one| one.client == kind.client).count() == 1;
            let setup = if is_alone {
                String::new()
            } else {
                format!(", {}", kind.setup)
            };
            let tone = tones.tone(kind.client);
            held.push(settling_ms.value.is_finite());
            panel.series.push(Series {
                name: format!(
                    "{}{setup}: {}",
                    kind.client,
                    end(&kind.group, settled(settling_ms))
                ),
                tone,
                ..traces.median(&kind.group, signal, self.h_ns, end_s)?
            });
            let worst = nearest_to_failing(kind.group.runs.iter().copied());
            if let Some(worst) = worst.filter(|_| kind.group.runs.len() > 1) {
                held.push(false);
                panel.series.push(Series {
                    tone,
                    ..traces.single(worst, signal, self.h_ns, end_s)?
                });
            }
        }
        if signal == Signal::U {
            panel.y.range = held_range(&panel.series, &held);
            return Ok(panel);
        }
        match moving {
            Some(moving) => {
                let changes = moving.changes().iter();
                let changes = changes.map(|(t_ns, r)| (*t_ns as f64 / 1e9, *r));
                let mut points: Vec<_> = changes.filter(|(t_s, _)| *t_s <= end_s).collect();
                points.extend(points.last().map(|(_, r)| (end_s, *r)));
                let r = Series::new("r".to_owned(), Mark::Steps, OTHER_TONE, points);
                panel.series.insert(0, r);
                let values = moving.changes().iter().map(|(_, r)| *r);
                panel.y.range = range(&panel.series, 0.0).map(|seen| within(seen, values));
            }
            None => {
                let r = first.cell.settings.r;
                panel.guides.extend(guides(r));
                panel.y.range = range(&panel.series, r).map(|seen| within(seen, [r]));
            }
        }
        Ok(panel)
    }
}

/// A range that shows the inputs of the loops that settle, with as much again above and below; `None` if that
/// cuts nothing, or none settles.
fn held_range(series: &[Series], held: &[bool]) -> Option<(f64, f64)> {
    let ends = |all: bool| {
        let shown = series.iter().zip(held).filter(|(_, held)| all || **held);
        let values = shown.flat_map(|(series, _)| series.points.iter().map(|(_, u)| *u));
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        values
            .filter(|u| u.is_finite())
            .fold(ends, |(low, high), u| (low.min(u), high.max(u)))
    };
    let ((low, high), whole) = (ends(false), ends(true));
    let (low, high) = (2.0 * low - high, 2.0 * high - low);
    (low < high && (whole.0 < low || whole.1 > high)).then_some((low, high))
}

/// The part of a range that shows a loop that holds: a loop that does not leaves the panel, and would
/// flatten the others.
fn within((low, high): (f64, f64), r: impl IntoIterator<Item = f64>) -> (f64, f64) {
    /// Farthest from r, in units of its largest step from rest.
    const FARTHEST: f64 = 2.0;
    let widen = |(least, most): (f64, f64), r: f64| (r.min(least), r.max(most));
    let (least, most) = r.into_iter().fold((0.0, 0.0), widen);
    let span = FARTHEST * (most - least);
    if span > 0.0 {
        (low.max(least - span), high.min(most + span))
    } else {
        (low, high)
    }
}

/// How a loop's runs ended, in words: when they settled, or that they follow a reference that does not rest.
fn end(group: &Group<'_>, settled: String) -> String {
    let follows = |run: &&Run| {
        let summary = &run.summary;
        summary.loop_verdict == Some(LoopVerdict::Stable) && summary.settling_ms.is_none()
    };
    if group.runs.iter().all(follows) {
        "follows r".to_owned()
    } else {
        settled
    }
}
