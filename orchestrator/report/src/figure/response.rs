//! Step responses of what is not the paper's: programs, systems and links of one's own.
//!
//! Whatever ran at one place is in one panel, so that controllers are compared over the same links. Figures 5
//! and 6 have the paper's own places.

use analysis::{Campaign, ReadError, Run};
use chart::{Panel, Series, Tone};
use endpoint::Mode;
use plan::Client;
use system::System;

use super::median::Traces;
use super::step::{guides, horizon_s, range, settled};
use super::{Figure, panel};
use crate::group::Group;
use crate::origin::Origin;
use crate::paper;
use crate::subject::{OWN_TONES, tone_of};

/// The most panels of the figure; further places are counted in its caption.
const MOST_PANELS: usize = 12;

/// Where loops ran that can be compared: over one topology, with one plant, at one rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place<'a> {
    topology: &'a str,
    system: &'a str,
    h_ns: u64,
}

/// One curve: the runs of one client with one setup.
struct Kind<'a> {
    client: Client,
    setup: String,
    group: Group<'a>,
}

/// Figure A; `None` for a campaign that has the paper's clients, plant and links alone.
pub(super) fn figure(campaign: &Campaign) -> Result<Option<Figure>, ReadError> {
    let mut places: Vec<Place<'_>> = Vec::new();
    for run in closed(campaign).filter(|run| is_own(run)) {
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
    places.truncate(MOST_PANELS);
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
         settling into 2 % of the reference.",
        "These programs, systems or links are not in it.",
    );
    if left_out > 0 {
        figure.caption += &format!(" {left_out} more places are in the tables alone.");
    }
    Ok(Some(figure.drawn(panels, &sentences, &origin, campaign)))
}

fn closed(campaign: &Campaign) -> impl Iterator<Item = &Run> {
    let runs = campaign.runs.iter();
    runs.filter(|run| run.cell.settings.mode == Mode::Closed)
}

/// Whether the paper has no such client, plant or link.
fn is_own(run: &Run) -> bool {
    let cell = &run.cell;
    cell.client.is_own()
        || cell.system != System::PAPER
        || !paper::TABLE_2
            .iter()
            .any(|ping| ping.topology == cell.topology)
}

impl<'a> Place<'a> {
    fn of(run: &'a Run) -> Place<'a> {
        Place {
            topology: &run.cell.topology,
            system: &run.cell.system,
            h_ns: run.cell.settings.h.ns(),
        }
    }

    /// What ran here, in the plan's order.
    fn kinds(self, campaign: &'a Campaign) -> Vec<Kind<'a>> {
        let here = || closed(campaign).filter(move |run| Place::of(run) == self);
        let mut kinds: Vec<Kind<'a>> = Vec::new();
        for run in here() {
            let (client, setup) = (run.cell.client, run.cell.setup());
            if kinds
                .iter()
                .any(|kind| kind.client == client && kind.setup == setup)
            {
                continue;
            }
            let same = here().filter(|run| run.cell.client == client && run.cell.setup() == setup);
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
        let r = first.cell.settings.r;
        let end_s = horizon_s(kinds.iter().map(|kind| &kind.group));
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
                name: format!("{}{setup}: {}", kind.client, settled(settling_ms)),
                tone: tone(kind.client, own_clients),
                ..traces.median(&kind.group, self.h_ns, end_s)?
            });
        }
        panel.guides = guides(r);
        panel.y.range = range(&panel.series, r);
        Ok(panel)
    }
}

/// A client's colour, the same in all panels; those of one's own take theirs in turn, in the plan's order.
fn tone(client: Client, own_clients: &[Client]) -> Tone {
    match own_clients.iter().position(|own| *own == client) {
        Some(nth) => OWN_TONES[nth % OWN_TONES.len()],
        None => tone_of(client),
    }
}
