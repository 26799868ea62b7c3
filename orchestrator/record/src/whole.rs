//! Checks whether a cell's folder is whole: what its manifest has to say before any of its rows is
//! trusted.
//!
//! A manifest vouches for the files that it lists. So it has to list those that a run of its kind
//! leaves, and it has to belong to this plan: its cell, its seed, the text of its profile. The rows
//! themselves are checked while they are read, by whoever makes metrics of them, with what is gathered here. If
//! someone rewrites everything consistently, nothing detects it.

use std::collections::BTreeMap;
use std::path::Path;

use endpoint::report::Written;
use plan::{Cell, End, EndEffect, Plan, Verdict, file_name};
use serde::de::DeserializeOwned;

use crate::damage::Damage;
use crate::fact::FileFact;
use crate::manifest::Manifest;
use crate::order::{Disorder, Gaps};
use crate::report::{self, ControllerReport, PlantReport};

/// The files of rows that metrics are made of; a plant with a second input or output has one more.
pub const ROWS: [&str; 4] = [
    file_name::TICKS,
    file_name::ARRIVALS,
    file_name::MESSAGES,
    file_name::PROBES,
];
/// The back-end of virtual time, which leaves no page report and no rows of a link.
pub const VIRTUAL: &str = "sim";

/// What is between the two ends of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Medium {
    /// A link, which is played.
    Link,
    /// Nothing but the machine itself.
    Loopback,
}

/// What is wrong with a manifest for the plan's cell, one sentence per fault; empty if nothing is.
#[must_use]
pub fn faults(manifest: &Manifest, plan: &Plan, cell: &Cell, medium: Medium) -> Vec<String> {
    let mut faults = Vec::new();
    if !manifest.cell.is_same(cell) {
        faults.push("it describes another cell than the plan's of this name".to_owned());
    }
    if manifest.experiment != plan.experiment || manifest.campaign_seed != plan.seed {
        faults.push(format!(
            "it belongs to {}, seed {}, and the plan is {}, seed {}",
            manifest.experiment, manifest.campaign_seed, plan.experiment, plan.seed
        ));
    }
    if manifest.profile != cell.topology {
        faults.push(format!(
            "its profile is {}, and the plan's {}",
            manifest.profile, cell.topology
        ));
    }
    faults.extend(other_texts(manifest, plan, cell));
    if !has_rows(manifest.verdict) {
        return faults;
    }
    if manifest.files.is_empty() {
        faults.push("its list of files is empty, so nothing can be checked".to_owned());
        return faults;
    }
    faults.extend(
        lacking(manifest, plan, medium)
            .map(|name| format!("it does not list {name}, which such a run writes")),
    );
    if manifest.verdict == Verdict::Complete {
        faults.extend(contradictions(manifest, medium));
    }
    faults
}

/// Whether a run with this verdict left its rows. A failed or unsupported run may have none at all.
#[must_use]
pub fn has_rows(verdict: Verdict) -> bool {
    !matches!(verdict, Verdict::Failed | Verdict::Unsupported)
}

/// One sentence per text (profile, traces, system) with which the run was made and which differs from
/// the plan's.
fn other_texts(manifest: &Manifest, plan: &Plan, cell: &Cell) -> Vec<String> {
    let profile = plan.profile(cell);
    let profile = profile.as_deref();
    let own = profile.map(|text| (file_name::PROFILE, &text.source));
    let traces = profile.into_iter().flat_map(|text| &text.traces);
    let system = plan
        .systems
        .get(&cell.system)
        .map(|text| (file_name::SYSTEM, text));
    own.into_iter()
        .chain(traces.map(|(name, text)| (name.as_str(), text)))
        .chain(system)
        .filter(|(name, text)| {
            let listed = manifest.files.get(*name);
            let is_own =
                |fact: &FileFact| FileFact::of(text.as_bytes()).is_ok_and(|own| own == *fact);
            listed.is_some_and(|fact| !is_own(fact))
        })
        .map(|(name, _)| format!("its {name} differs from the plan's"))
        .collect()
}

/// The files that a run of its kind leaves and the manifest does not list.
fn lacking(manifest: &Manifest, plan: &Plan, medium: Medium) -> impl Iterator<Item = &'static str> {
    let is_virtual = manifest.backend == VIRTUAL;
    let mut asked = ROWS.to_vec();
    asked.extend([
        file_name::PROFILE,
        file_name::PLANT_REPORT,
        file_name::CONTROLLER_REPORT,
    ]);
    if manifest.cell.client.is_browser() && !is_virtual {
        asked.push(file_name::PAGE_REPORT);
    }
    if plan.systems.contains_key(&manifest.cell.system) {
        asked.push(file_name::SYSTEM);
    }
    let plant = manifest.plant.as_ref();
    if plant.is_some_and(|plant| plant.second_rows().is_some()) {
        asked.push(file_name::SECOND);
    }
    if medium == Medium::Link && is_virtual {
        asked.push(file_name::LINK_REPORT);
    } else if medium == Medium::Link {
        // One player for both directions, or one for each.
        asked.extend(if manifest.files.contains_key(file_name::LINK_UP_REPORT) {
            &[
                file_name::LINK_UP_REPORT,
                file_name::LINK_UP,
                file_name::LINK_DOWN_REPORT,
                file_name::LINK_DOWN,
            ][..]
        } else {
            &[file_name::LINK_REPORT, file_name::LINK]
        });
    }
    asked
        .into_iter()
        .filter(|name| !manifest.files.contains_key(*name))
}

/// What the manifest of a complete run must not contain, one sentence each.
fn contradictions(manifest: &Manifest, medium: Medium) -> Vec<String> {
    let mut found = Vec::new();
    if let Some(reason) = manifest.reasons.first() {
        found.push(format!(
            "it says complete, and gives a reason against it: {reason}"
        ));
    }
    let held = manifest
        .certificate
        .as_ref()
        .map(|of| of.verdict == link::certificate::Verdict::Holds);
    match (medium, held) {
        (Medium::Link, None) => {
            found.push("it is complete without its link's certificate".to_owned());
        }
        (Medium::Link, Some(false)) => {
            found.push(
                "it is complete, and its certificate says that the link did not hold".to_owned(),
            );
        }
        (Medium::Loopback, _) | (Medium::Link, Some(true)) => {}
    }
    if (manifest.backend == VIRTUAL) != (manifest.player == "model") {
        found.push(format!(
            "it was run by {}, which has no player {}",
            manifest.backend, manifest.player
        ));
    }
    found
}

/// A role's report; `None` if the file is missing, which the check of the listed files reports.
fn read_report<R: DeserializeOwned>(folder: &Path, name: &str) -> Result<Option<R>, Vec<Damage>> {
    report::read(folder, name).map_err(|problem| {
        vec![Damage {
            path: folder.join(name),
            problem: format!("this webloop cannot read it: {problem}"),
        }]
    })
}

/// What the rows of a run are checked against.
#[derive(Debug)]
pub struct Vouched<'a> {
    /// Length and checksum by file name.
    pub files: &'a BTreeMap<String, FileFact>,
    /// Name of a file, the report that counts its rows, and the number of rows that were written. For
    /// echoes, those through the link are counted, not those on the empty link.
    pub counts: Vec<(&'static str, &'static str, u64)>,
    /// Whether rows are missing according to the run's own reports; then the run is `invalid`.
    pub has_gaps: bool,
    /// The ends that a fault killed, and started again.
    killed: Vec<End>,
}

impl<'a> Vouched<'a> {
    /// What the manifest, and the reports in the folder, vouch for.
    ///
    /// # Errors
    /// The damage if a report cannot be read: then it vouches for nothing.
    pub fn of(folder: &Path, manifest: &'a Manifest) -> Result<Self, Vec<Damage>> {
        // The manifest has a copy of each report: both have to be right.
        let plant: [Option<PlantReport>; 2] = [
            read_report(folder, file_name::PLANT_REPORT)?,
            manifest.plant.clone(),
        ];
        let controller: [Option<ControllerReport>; 2] = [
            read_report(folder, file_name::CONTROLLER_REPORT)?,
            manifest.controller.clone(),
        ];
        let is_page = manifest.cell.client.is_browser() && manifest.backend != VIRTUAL;
        let mut counts = Vec::new();
        for (origin, plant) in [file_name::PLANT_REPORT, "the plant's report"]
            .into_iter()
            .zip(&plant)
        {
            let Some(plant) = plant else { continue };
            counts.push((file_name::TICKS, origin, plant.tick_rows().rows));
            let second = plant.second_rows();
            counts.extend(second.map(|of| (file_name::SECOND, origin, of.rows)));
            counts.push((file_name::ARRIVALS, origin, plant.arrival_rows().rows));
            // The plant writes a page's rows; those of several sessions are in several files.
            let of_page = plant.page_rows();
            let of_page = of_page.filter(|_| is_page && plant.sessions() == 1);
            counts.extend(of_page.map(|Written { rows, .. }| (file_name::MESSAGES, origin, rows)));
        }
        let origins = [file_name::CONTROLLER_REPORT, "the controller's report"];
        for (origin, controller) in origins.into_iter().zip(&controller) {
            // The messages of a program of one's own are made from the plant's rows.
            let has_count = !is_page && !manifest.cell.client.is_own();
            if let (Some(controller), true) = (controller, has_count) {
                counts.push((file_name::MESSAGES, origin, controller.rows().rows));
            }
        }
        let sent = manifest.certificate.as_ref().map(|of| of.sent as u64);
        counts.extend(sent.map(|sent| (file_name::PROBES, "the certificate", sent)));
        let of_plant = plant.iter().flatten().map(PlantReport::overflow);
        let of_controller = controller.iter().flatten().map(|of| of.rows().overflow);
        let kills = manifest.end_faults.iter();
        let kills = kills.filter(|fault| fault.effect == EndEffect::Kill);
        Ok(Self {
            killed: kills.map(|fault| fault.end).collect(),
            files: &manifest.files,
            counts,
            has_gaps: of_plant.chain(of_controller).any(|lost| lost > 0),
        })
    }

    /// A file may lack rows if it has those of an end that was killed and started again: the end's report counts
    /// those of its last life.
    #[must_use]
    pub fn gaps(&self, name: &str) -> Gaps {
        let end = match name {
            file_name::MESSAGES => End::Controller,
            file_name::TICKS | file_name::SECOND | file_name::ARRIVALS => End::Plant,
            _ => return Gaps::None,
        };
        if self.killed.contains(&end) {
            Gaps::Allowed
        } else {
            Gaps::None
        }
    }

    /// Checks that a file has as many rows as were written.
    ///
    /// # Errors
    /// [`Disorder::Count`] with who counted other ones.
    pub fn count(&self, name: &str, found: u64) -> Result<(), Disorder> {
        let of_it = self.counts.iter().filter(|(file, ..)| *file == name);
        for (_, origin, written) in of_it {
            // The certificate counts only echoes that were waited for long enough to say something.
            let is_part = self.gaps(name) == Gaps::Allowed || name == file_name::PROBES;
            if found != *written && !(is_part && found > *written) {
                return Err(Disorder::Count {
                    found,
                    origin,
                    written: *written,
                });
            }
        }
        Ok(())
    }
}
