//! What the roles report when they end, and what follows from it for the run.

use std::path::Path;

use endpoint::report::{Page, Policy, Scheduling};
use link::certificate::{LinkReport, OneWay};
use plan::Client;
use record::{ControllerReport, PlantReport};
use serde::de::DeserializeOwned;

/// The reports that a run left.
#[derive(Debug, Default)]
pub(crate) struct Reports {
    pub(crate) plant: Option<PlantReport>,
    pub(crate) controller: Option<ControllerReport>,
    pub(crate) page: Option<Page>,
    /// From one player of both ways, or from two that played one each.
    pub(crate) link: Option<LinkReport>,
    /// Why reports cannot be read: a sentence for each of them.
    pub(crate) unread: Vec<String>,
}

impl Reports {
    pub(crate) fn read(folder: &Path) -> Reports {
        let mut unread = Vec::new();
        let mut reports = Reports {
            plant: one(folder, "plant", &mut unread),
            controller: one(folder, "controller", &mut unread),
            page: one(folder, "page", &mut unread),
            link: one(folder, "link", &mut unread),
            unread: Vec::new(),
        };
        if reports.link.is_none() {
            let up: Option<OneWay> = one(folder, "link-up", &mut unread);
            let down: Option<OneWay> = one(folder, "link-down", &mut unread);
            reports.link = up.zip(down).map(|(up, down)| LinkReport::of_each(up, down));
        }
        Reports { unread, ..reports }
    }

    /// How a page failed, by its own report; a browser's process alone does not show it.
    pub(crate) fn page_failure(&self, client: Client) -> Option<String> {
        if !client.is_browser() {
            return None;
        }
        match &self.page {
            None => Some(format!("in {client} left no report at the plant")),
            Some(page) if page.outcome == "complete" => None,
            Some(Page {
                outcome, reason, ..
            }) => Some(format!("in {client} ended as {outcome}: {reason}")),
        }
    }

    /// What played the link, by its report; `none` if there was no link.
    pub(crate) fn played_by(&self) -> &'static str {
        let link = self.link.as_ref();
        link.map_or("none", |link| link.player().word())
    }

    /// A doubt if the player itself lost packets that its link did not lose.
    pub(crate) fn lost_by_the_player(&self) -> Option<String> {
        let dropped = self.link.as_ref().map_or(0, LinkReport::dropped);
        (dropped > 0)
            .then(|| format!("the player itself lost {dropped} packets: this machine is too busy"))
    }

    /// A doubt if rows are not in the files because the disk was too slow.
    pub(crate) fn lost_rows(&self) -> Option<String> {
        let plant = self.plant.as_ref().map_or(0, PlantReport::overflow);
        let controller = self.controller.as_ref();
        let lost = plant + controller.map_or(0, |controller| controller.rows().overflow);
        (lost > 0).then(|| format!("{lost} rows are missing: the disk was too slow for them"))
    }
}

/// Whether a thread had real-time scheduling, by its role's report; `true` in virtual time, which needs
/// none.
pub(crate) fn is_real_time(granted: Option<&Scheduling>) -> bool {
    granted.is_none_or(|granted| granted.policy == Policy::Fifo)
}

/// A role's report, if it left one.
fn one<R: DeserializeOwned>(folder: &Path, name: &str, unread: &mut Vec<String>) -> Option<R> {
    let name = format!("{name}.json");
    record::report::read(folder, &name).unwrap_or_else(|problem| {
        unread.push(format!(
            "this webloop cannot read the report {name}: {problem}"
        ));
        None
    })
}
