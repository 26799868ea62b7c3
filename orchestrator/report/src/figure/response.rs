//! Step responses of what is not the paper's: programs, systems and links of one's own.
//!
//! Whatever ran at one place is in one panel, so that controllers are compared over the same links. Figures 5
//! and 6 have the paper's own places.

use analysis::{Campaign, LoopVerdict, ReadError, Run};
use chart::{Mark, Panel, Series, Tone};
use endpoint::Mode;
use plan::Client;
use system::System;

use super::median::Traces;
use super::step::{guides, horizon_s, range, settled};
use super::{Figure, panel};
use crate::group::Group;
use crate::origin::Origin;
use crate::tone::{OTHER_TONE, OWN_TONES, tone_of};

/// The most panels of the figure; further places are counted in its caption.
const MOST_PANELS: usize = 12;

/// Where loops ran that can be compared: over one topology, with one plant, at one rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place<'a> {
    topology: &'a str,
    system: &'a str,
    h_ns: u64,
}

/// One curve: the runs of one client with one setup, which leaves the system to the panel's title.
struct Kind<'a> {
    client: Client,
    setup: String,
    group: Group<'a>,
}

/// Figure A; `None` for a campaign that has the paper's clients, plant and links alone.
pub(super) fn figure(campaign: &Campaign) -> Result<Option<Figure>, ReadError> {
    let mut places: Vec<Place<'_>> = Vec::new();
    for run in closed(campaign) {
        let place = Place::of(run);
        if !places.contains(&place) {
            places.push(place);
        }
    }
    if places.is_empty() {
        return Ok(None);
    }
    let mut own_clients: Vec<Client> = Vec::new();
    for client in closed(campaign).map(|run| run.cell.client) {
        if client.is_own() && !own_clients.contains(&client) {
            own_clients.push(client);
        }
    }
    let left_out = places.len().saturating_sub(MOST_PANELS);
    if left_out > 0 {
        // Those where a loop did not hold, then those that ran; in the plan's order.
        let mut by_need: Vec<usize> = (0..places.len()).collect();
        by_need.sort_by_key(|at| places[*at].need(campaign));
        by_need.truncate(MOST_PANELS);
        by_need.sort_unstable();
        places = by_need.into_iter().map(|at| places[at]).collect();
    }
    let (mut origin, mut sentences, mut panels) = (Origin::default(), Vec::new(), Vec::new());
    let mut traces = Traces::default();
    for place in &places {
        let kinds = place.kinds(campaign);
        for kind in &kinds {
            origin.all(&kind.group);
        }
        let panel = place.draw(&kinds, &own_clients, &mut traces)?;
        let curves = panel.series.iter().map(|series| series.name.as_str());
        let curves: Vec<&str> = curves.collect();
        if !curves.is_empty() {
            sentences.push(format!("{}: {}.", panel.title, curves.join("; ")));
        }
        panels.push(panel);
    }
    let mut figure = Figure::new(
        "A",
        "Step responses of one's own",
        places.len().min(3),
        "Step responses from the first command that the plant applied, all that ran at one place together: the \
         median over the repeats at each instant, and the band in which half of them lie. The time is the median \
         settling into 2 % of the reference, after its last step where it moves.",
        None,
    );
    if left_out > 0 {
        figure.caption += &format!(
            " {left_out} more places, where the loops held or did not run, are in the tables alone."
        );
    }
    Ok(Some(figure.drawn(panels, &sentences, &origin, campaign)))
}

fn closed(campaign: &Campaign) -> impl Iterator<Item = &Run> {
    let runs = campaign.runs.iter();
    runs.filter(|run| run.cell.settings.mode == Mode::Closed)
}

impl<'a> Place<'a> {
    fn of(run: &'a Run) -> Place<'a> {
        Place {
            topology: &run.cell.topology,
            system: &run.cell.system,
            h_ns: run.cell.settings.h.ns(),
        }
    }

    /// How much it needs a panel, the least first: where a loop did not hold, where all held, where none ran.
    fn need(self, campaign: &Campaign) -> u8 {
        let here = || closed(campaign).filter(|run| Place::of(run) == self);
        let mut verdicts = here().filter_map(|run| run.summary.loop_verdict).peekable();
        match verdicts.peek() {
            None => 2,
            Some(_) => u8::from(verdicts.all(|verdict| verdict == LoopVerdict::Stable)),
        }
    }

    /// What ran here, in the plan's order.
    fn kinds(self, campaign: &'a Campaign) -> Vec<Kind<'a>> {
        let here = || closed(campaign).filter(move |run| Place::of(run) == self);
        let mut kinds: Vec<Kind<'a>> = Vec::new();
        for run in here() {
            let (client, setup) = (run.cell.client, run.cell.setup_beside_system());
            if kinds
                .iter()
                .any(|kind| kind.client == client && kind.setup == setup)
            {
                continue;
            }
            let same = here()
                .filter(|run| run.cell.client == client && run.cell.setup_beside_system() == setup);
            kinds.push(Kind {
                client,
                group: Group::complete(same),
                setup,
            });
        }
        kinds
    }

    /// The panel of this place; empty if nothing here is complete.
    fn draw(
        self,
        kinds: &[Kind<'_>],
        own_clients: &[Client],
        traces: &mut Traces,
    ) -> Result<Panel, ReadError> {
        let first = kinds.iter().find_map(|kind| kind.group.runs.first());
        let rate = first.map_or_else(String::new, |run| format!(", {}", run.cell.rate()));
        let system = if self.system == System::PAPER {
            String::new()
        } else {
            format!(", {}", self.system)
        };
        let title = format!("{}{system}{rate}", self.topology);
        let mut panel = panel("", title, "time/s", "y");
        let Some(first) = first else {
            return Ok(panel);
        };
        let moving = first.cell.moving_reference();
        let end_s = match moving {
            Some(_) => first.cell.duration_ns as f64 / 1e9,
            None => horizon_s(kinds.iter().map(|kind| &kind.group)),
        };
        panel.x.range = Some((0.0, end_s));
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
            panel.series.push(Series {
                name: format!("{}{setup}: {}", kind.client, kind.end(settled(settling_ms))),
                tone: tone(kind.client, own_clients),
                ..traces.median(&kind.group, self.h_ns, end_s)?
            });
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
                panel.guides = guides(r);
                panel.y.range = range(&panel.series, r).map(|seen| within(seen, [r]));
            }
        }
        Ok(panel)
    }
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

impl Kind<'_> {
    /// How its runs ended, in words: when they settled, or that they follow a reference that does not rest.
    fn end(&self, settled: String) -> String {
        let follows = |run: &&Run| {
            let summary = &run.summary;
            summary.loop_verdict == Some(LoopVerdict::Stable) && summary.settling_ms.is_none()
        };
        if self.group.runs.iter().all(follows) {
            "follows r".to_owned()
        } else {
            settled
        }
    }
}

/// A client's colour, the same in all panels; those of one's own take theirs in turn, in the plan's order.
fn tone(client: Client, own_clients: &[Client]) -> Tone {
    match own_clients.iter().position(|own| *own == client) {
        Some(nth) => OWN_TONES[nth % OWN_TONES.len()],
        None => tone_of(client),
    }
}
