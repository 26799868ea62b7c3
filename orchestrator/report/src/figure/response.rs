//! Figures A and B: the step responses of all closed loops, and the plant's inputs.
//!
//! Whatever ran at one place is in one panel, so that controllers are compared over the same links.

use analysis::{Campaign, LoopVerdict, Run, grouped};
use chart::{Mark, Panel, Scale, Series};
use endpoint::Reference;
use plan::system::System;
use record::ReadError;

use super::median::{Signal, Traces};
use super::reach::{about, held_ends, held_range, left_at, within};
use super::scale::{Which, share_all, shared};
use super::step::{guides, horizon_s, range, settled};
use super::{Figure, fault, panel};
use crate::called::{is_kept, kept};
use crate::delays::nearest_to_failing;
use crate::group::{Estimate, Group};
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
        let ends: Vec<_> = places
            .iter()
            .map(|place| Some((0.0, place.end_s())))
            .collect();
        let ends = shared(&ends, Scale::Linear);
        for (place, end) in places.iter().zip(ends) {
            for one in &place.loops {
                origin.all(&one.group);
            }
            let end_s = end.map_or(0.0, |(_, end_s)| end_s);
            let panel = place.draw(signal, end_s, campaign, &tones, traces)?;
            let curves = panel.series.iter().map(|series| series.name.as_str());
            let curves: Vec<&str> = curves.filter(|name| !name.is_empty()).collect();
            if !curves.is_empty() && signal == Signal::Y {
                sentences.push(format!("{}: {}.", panel.title, curves.join("; ")));
            }
            panels.push(panel);
        }
        if signal == Signal::U {
            sentences.push("The inputs of the loops of figure A.".to_owned());
        }
        share_all(&mut panels, Which::Y);
        if panels.is_empty() {
            continue;
        }
        let (number, title) = match signal {
            Signal::Y => ("A", "Step responses"),
            Signal::U => ("B", "Inputs of the plant"),
        };
        let mut caption = caption(signal, &places);
        if left_out > 0 {
            caption +=
                &format!(" {left_out} more places, where the loops held, are in the tables alone.");
        }
        let figure = Figure::new(number, title, places.len().min(COLUMNS), &caption, None);
        figures.push(figure.drawn(panels, &sentences, &origin, campaign));
    }
    Ok(figures)
}

/// What the curves are, without what is not there: repeats, loops that do not hold, other panels.
fn caption(signal: Signal, places: &[&Place<'_>]) -> String {
    let mut loops = places.iter().flat_map(|place| &place.loops);
    let is_repeated = loops.any(|one| one.group.runs.len() > 1);
    let mut caption = match (signal, is_repeated) {
        (Signal::Y, true) => "Outputs from the first deadline to the planned end of the run, all that ran at one place together: the \
             median over the repeats at each instant, and the band in which half of them lie; dashed, the repeat \
             nearest to failing. The time is the median settling into the band about the reference, after its last \
             step where it moves."
            .to_owned(),
        (Signal::Y, false) => "Outputs from the first deadline to the planned end of the run, all that ran at one place together. The \
             time is the settling into the band about the reference, after its last step where it moves."
            .to_owned(),
        (Signal::U, true) => "Inputs of the same loops, over the same time: medians, the bands in which half of them lie, and dashed \
             the repeat nearest to failing."
            .to_owned(),
        (Signal::U, false) => "Inputs of the same loops, over the same time.".to_owned(),
    };
    if signal == Signal::Y && places.iter().any(|place| !place.held()) {
        caption += " A loop that does not hold is cut where it leaves the range of those that do, or, where none does, \
                    twice as far out as its limits; no loop that holds is.";
    }
    if places.len() > 1 {
        caption += " Panels have the same axes, unless they differ tenfold.";
    }
    caption
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
        loops.all(|one| one.holding() == one.group.runs.len())
    }

    /// A run, if one is complete.
    fn first(&self) -> Option<&Run> {
        let mut runs = self.loops.iter().flat_map(|one| &one.group.runs);
        runs.next().copied()
    }

    /// Until when its loops are worth showing, s.
    fn end_s(&self) -> f64 {
        let Some(first) = self.first() else {
            return 0.0;
        };
        match (first.cell.moving_reference(), self.fault) {
            (None, None) => horizon_s(self.loops.iter().map(|kind| &kind.group)),
            _ => first.cell.duration_ns as f64 / 1e9,
        }
    }

    /// Its topology, with fault, system and rate.
    fn title(&self, campaign: &Campaign) -> String {
        let rate = self
            .first()
            .map_or_else(String::new, |run| format!(", {}", run.cell.rate()));
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
        format!("{}{fault}{system}{rate}", self.topology)
    }

    /// The panel of this place up to a time; empty if nothing here is complete.
    fn draw(
        &self,
        signal: Signal,
        end_s: f64,
        campaign: &Campaign,
        tones: &Tones,
        traces: &mut Traces,
    ) -> Result<Panel, ReadError> {
        let y = if signal == Signal::Y { "y" } else { "u" };
        let mut panel = panel("", self.title(campaign), "time/s", y);
        let Some(first) = self.first() else {
            return Ok(panel);
        };
        panel.x.range = Some((0.0, end_s));
        panel.guides = fault::guides(&campaign.plan.fault_spells(&first.cell));
        let (series, held) = self.curves(signal, end_s, tones, traces)?;
        panel.series = series;
        match (signal, first.cell.moving_reference()) {
            (Signal::U, _) => panel.y.range = held_range(&panel.series, &held),
            (Signal::Y, Some(moving)) => show_moving(&mut panel, &moving, end_s, &held),
            (Signal::Y, None) => self.show_resting(&mut panel, first.cell.settings.r, &held),
        }
        Ok(panel)
    }

    /// The curves: the median of each loop and, of several runs, the one nearest to failing. Of each, too, whether
    /// what it shows holds.
    fn curves(
        &self,
        signal: Signal,
        end_s: f64,
        tones: &Tones,
        traces: &mut Traces,
    ) -> Result<(Vec<Series>, Vec<bool>), ReadError> {
        let (mut curves, mut held) = (Vec::new(), Vec::new());
        for kind in &self.loops {
            let Some(settling_ms) = kind.group.settling_ms() else {
                continue;
            };
            let tone = tones.tone(kind.client);
            held.push(is_held(&kind.group.runs));
            curves.push(Series {
                name: self.curve(kind, signal, settling_ms),
                tone,
                ..traces.median(&kind.group, signal, self.h_ns, end_s)?
            });
            let worst = nearest_to_failing(kind.group.runs.iter().copied());
            if let Some(worst) = worst.filter(|_| kind.group.runs.len() > 1) {
                held.push(is_held(&[worst]));
                curves.push(Series {
                    tone,
                    ..traces.single(worst, signal, self.h_ns, end_s)?
                });
            }
        }
        Ok((curves, held))
    }

    /// Shows a reference that rests, with its band, and as much of the outputs as there is to see.
    fn show_resting(&self, panel: &mut Panel, r: f64, held: &[bool]) {
        let band = widest_band(&self.loops);
        panel.guides.extend(guides(r, band));
        // What asks for room: the loops that hold, and the band that they are judged by.
        let held = held_ends(&panel.series, held);
        let half = band.unwrap_or_default();
        let held = held.map(|(low, high)| (low.min(r - half), high.max(r + half)));
        let seen = range(&panel.series, r, band).map(|seen| within(seen, [r], held));
        panel.y.range = match held {
            Some(_) => seen,
            None => seen.map(|seen| about(seen, r, farthest(&self.loops, r))),
        };
    }
}

impl Place<'_> {
    /// What a curve is called: its client, and in the figure of outputs how it ended.
    fn curve(&self, kind: &Loop<'_>, signal: Signal, settling_ms: Estimate) -> String {
        let alike = self.loops.iter().filter(|one| one.client == kind.client);
        let who = match alike.count() {
            1 => kind.client.to_string(),
            _ => format!("{}, {}", kind.client, kind.setup),
        };
        match signal {
            Signal::Y => format!("{who}: {}", end(&kind.group, settling_ms)),
            Signal::U => who,
        }
    }
}

/// Shows a reference that moves, up to a time, and as much of the outputs as there is to see.
fn show_moving(panel: &mut Panel, moving: &Reference, end_s: f64, held: &[bool]) {
    let held = held_ends(&panel.series, held);
    let changes = moving.changes().iter();
    let changes = changes.map(|(t_ns, r)| (*t_ns as f64 / 1e9, *r));
    let mut points: Vec<_> = changes.filter(|(t_s, _)| *t_s <= end_s).collect();
    points.extend(points.last().map(|(_, r)| (end_s, *r)));
    let r = Series::new("r".to_owned(), Mark::Steps, OTHER_TONE, points);
    panel.series.insert(0, r);
    let values = moving.changes().iter().map(|(_, r)| *r);
    panel.y.range = range(&panel.series, 0.0, None).map(|seen| within(seen, values, held));
}

/// Whether more than half of these runs hold, well or badly.
fn is_held(runs: &[&Run]) -> bool {
    let holds = |run: &&&Run| run.summary.loop_verdict.is_some_and(LoopVerdict::is_held);
    2 * runs.iter().filter(holds).count() > runs.len()
}

/// The widest band that a run at one place was judged by: they differ where a program's plant begins elsewhere.
fn widest_band(loops: &[Loop<'_>]) -> Option<f64> {
    let runs = loops.iter().flat_map(|one| &one.group.runs);
    let bands = runs.filter_map(|run| run.summary.band);
    bands.max_by(f64::total_cmp)
}

/// How far from r outputs were when they left their limits, the farthest; `None` if none did.
fn farthest(loops: &[Loop<'_>], r: f64) -> Option<f64> {
    let runs = loops.iter().flat_map(|one| &one.group.runs);
    runs.filter_map(|run| left_at(run, r))
        .max_by(f64::total_cmp)
}

/// How a loop's runs ended, in words: when they settled, what they do instead, or how all of them failed.
fn end(group: &Group<'_>, settling_ms: Estimate) -> String {
    let first = group.runs.first();
    let all = |is: &dyn Fn(&Run) -> bool| group.runs.iter().all(|run| is(run));
    let verdict = first.and_then(|run| run.summary.loop_verdict);
    match (first, verdict) {
        (Some(first), _) if all(&is_kept) => kept(first).to_owned(),
        (_, Some(verdict))
            if !verdict.is_held() && all(&|run| run.summary.loop_verdict == Some(verdict)) =>
        {
            verdict.to_string()
        }
        _ => settled(settling_ms),
    }
}
