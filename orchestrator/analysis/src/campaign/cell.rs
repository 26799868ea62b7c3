//! The run of one cell, from its folder: the manifest, every file checked against it, and the metrics.

use std::path::Path;

use link::Timeline;
use plan::system::System;
use plan::{Cell, Plan, file_name};
use record::whole::{self, Medium, ROWS, Vouched};
use record::{Damage, Manifest};

use super::Run;
use crate::metrics::{CellFacts, Metrics};
use crate::reason::Reason;
use crate::recovery::read_recovery;
use crate::silence::{Doer, is_cut};
use crate::summary::{LinkFacts, Summary};

/// What is known of a cell from the rest of its folder.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    /// The back-end of the folder's first run that has a manifest.
    pub(super) backend: Option<&'a str>,
    pub(super) medium: Medium,
    pub(super) link: LinkFacts,
    /// Its system; `None` if the plan's text of it is none.
    pub(super) system: Option<&'a System>,
    /// Its metrics, if this process has just run it.
    pub(super) fresh: Option<&'a Metrics>,
}

impl Run {
    /// Reads the run of one cell in a campaign's folder, if there is one. Its summary has no link
    /// facts: the profile is not played over a long time for one cell alone.
    #[must_use]
    pub fn read(campaign: &Path, plan: &Plan, cell: &Cell) -> Run {
        let medium = if plan.is_loopback(&cell.topology) {
            Medium::Loopback
        } else {
            Medium::Link
        };
        let system = plan.system(cell).ok();
        let known = Known {
            backend: None,
            medium,
            link: LinkFacts::default(),
            system: system.as_ref(),
            fresh: None,
        };
        Run::of(campaign, plan, cell, known)
    }

    /// As [`read`](Run::read), with what is known of the cell.
    pub(super) fn of(campaign: &Path, plan: &Plan, cell: &Cell, known: Known<'_>) -> Run {
        let folder = campaign.join(cell.folder());
        let (manifest, mut damage) = match Manifest::read(&folder) {
            Ok(manifest) => (manifest, Vec::new()),
            Err(unreadable) => (None, vec![Damage::from(unreadable)]),
        };
        let mut metrics = None;
        if let Some(manifest) = &manifest {
            let mut faults = whole::faults(manifest, plan, cell, known.medium);
            if let Some(other) = known.backend.filter(|other| *other != manifest.backend) {
                faults.push(format!(
                    "it was run by {}, and the folder's first run by {other}; a campaign has one \
                     back-end",
                    manifest.backend
                ));
            }
            let path = folder.join(Manifest::FILE);
            damage.extend(faults.into_iter().map(|problem| Damage {
                path: path.clone(),
                problem,
            }));
            match known.system {
                Some(system) => {
                    let read = match known.fresh {
                        Some(metrics) => fresh(&folder, manifest, metrics),
                        None => read(&folder, cell, system, manifest),
                    };
                    metrics = read.map_err(|found| damage.extend(found)).ok().flatten();
                }
                None => damage.push(Damage {
                    path: campaign.join(file_name::PLAN),
                    problem: format!("its system `{}` cannot be read", cell.system),
                }),
            }
        }
        // If one file of a cell is damaged, none of its rows is trusted.
        let metrics = metrics.filter(|_| damage.is_empty());
        let metrics = metrics.map(|metrics| match &manifest {
            Some(manifest) => heard(metrics, plan, cell, manifest),
            None => metrics,
        });
        let started = manifest.as_ref().filter(|_| metrics.is_some());
        let recovery = started.and_then(|manifest| {
            let spells = plan.fault_spells(cell);
            // The ticks were read whole a moment ago.
            read_recovery(&folder, cell, &spells, manifest.start_ns).ok()?
        });
        let summary = Summary::new(cell, manifest.as_ref(), known.link, metrics.as_ref());
        let summary = summary.after_fault(cell, recovery.as_ref());
        Run {
            cell: cell.clone(),
            folder,
            manifest,
            metrics,
            recovery,
            summary,
            damage,
        }
    }
}

/// The metrics of a run that this process has just made, if it left rows. Checks the files that have none: those of
/// rows it wrote itself.
fn fresh(
    folder: &Path,
    manifest: &Manifest,
    metrics: &Metrics,
) -> Result<Option<Metrics>, Vec<Damage>> {
    let damage = Damage::among(folder, manifest, |name| !is_of_rows(name));
    if damage.is_empty() {
        Ok(whole::has_rows(manifest.verdict).then_some(*metrics))
    } else {
        Err(damage)
    }
}

/// Whether metrics are made of the rows of a file with this name.
fn is_of_rows(name: &str) -> bool {
    ROWS.contains(&name) || name == file_name::SECOND
}

/// The metrics of a run that left rows. Checks each file against the manifest while reading.
fn read(
    folder: &Path,
    cell: &Cell,
    system: &System,
    manifest: &Manifest,
) -> Result<Option<Metrics>, Vec<Damage>> {
    let has_rows = whole::has_rows(manifest.verdict);
    let mut damage = Damage::among(folder, manifest, |name| !(has_rows && is_of_rows(name)));
    if has_rows && ROWS.iter().all(|name| manifest.files.contains_key(*name)) {
        let read = Vouched::of(folder, manifest).and_then(|vouched| {
            Metrics::read_whole(
                folder,
                &CellFacts::new(cell, system, Some(manifest.start_ns)),
                &vouched,
            )
            .map_err(|faults| faults.into_iter().map(Damage::from).collect())
        });
        match read {
            Ok(metrics) if damage.is_empty() => return Ok(Some(metrics)),
            Ok(_) => {}
            Err(found) => damage.extend(found),
        }
    }
    if damage.is_empty() {
        Ok(None)
    } else {
        Err(damage)
    }
}

/// Metrics with what the link, and its fault, tell of the silence that a run ended in: it is the link's where it lost
/// all that a program without rows could have sent, and the controller's where it did not read an answer that came.
fn heard(mut metrics: Metrics, plan: &Plan, cell: &Cell, manifest: &Manifest) -> Metrics {
    let reason = metrics.response.as_mut().and_then(|of| of.reason.as_mut());
    let Some(Reason::Silence(silence)) = reason else {
        return metrics;
    };
    let profile = plan.profile(cell);
    if let Some(profile) = profile.and_then(|text| text.profile(&cell.topology).ok()) {
        let link = || {
            let link = Timeline::new(&profile, cell.link_seed, manifest.epoch);
            link.closing(cell.closes_at())
        };
        let from_ns = manifest.start_ns + (silence.from_s * 1e9) as u64;
        let to_ns = manifest.start_ns.saturating_add(cell.duration_ns);
        silence.by = match silence.sent.and_then(|sent| sent.unread_by(link(), to_ns)) {
            Some(other) => other,
            None if silence.by == Doer::Controller
                && cell.client.is_own()
                && is_cut(link(), from_ns..to_ns) =>
            {
                Doer::Link
            }
            None => silence.by,
        };
    }
    metrics
}
