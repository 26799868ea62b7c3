//! A cell from its plan to its manifest: folder, back-end, verdict, checksums.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use link::Profile;
use plan::{Cell, Plan, Verdict};
use shaper::Authority;

use crate::netns::{self, Evidence};
use crate::role::last_words;
use crate::{Machine, Manifest, RunError, folder};

/// The file in which a cell's folder keeps its link's profile.
const PROFILE_FILE: &str = "profile.toml";

/// The folder of a cell inside a campaign's folder.
#[must_use]
pub fn cell_folder(campaign: &Path, cell: &Cell) -> PathBuf {
    campaign.join("cells").join(&cell.id)
}

/// The manifest of a cell that has been run, whatever its verdict; `None` if it has not.
///
/// # Errors
/// When there is one that cannot be read; names the file.
pub fn manifest(campaign: &Path, cell: &Cell) -> Result<Option<Manifest>, String> {
    let path = cell_folder(campaign, cell).join(Manifest::FILE);
    match fs::read_to_string(&path) {
        Ok(text) => Manifest::from_json(&text)
            .map(Some)
            .map_err(|problem| format!("{}: {problem}", path.display())),
        Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(problem) => Err(format!("{}: {problem}", path.display())),
    }
}

/// Runs a cell and writes its manifest, whatever the verdict.
///
/// `authority` is what [`shaper::become_root`] gave; `started` is the time of day, for people.
/// What an earlier try left in the folder is moved aside, never overwritten.
///
/// # Errors
/// [`RunError::Write`] when the results folder cannot be written: then there is no manifest.
/// Everything else that can go wrong is a verdict.
pub fn run_cell(
    plan: &Plan,
    cell: &Cell,
    campaign: &Path,
    authority: shaper::Result<Authority>,
    started: String,
    stop: &AtomicBool,
) -> Result<Manifest, RunError> {
    let clock = Instant::now();
    let folder = cell_folder(campaign, cell);
    make_room(&folder)?;
    let profile = write_profile(plan, cell, &folder);
    let (authority_name, outcome) = match (authority, profile) {
        (Err(missing), _) => (String::new(), Err(RunError::from(missing))),
        (Ok(authority), Err(problem)) => (name(authority), Err(problem)),
        (Ok(authority), Ok(profile)) => {
            let file = folder.join(PROFILE_FILE);
            let outcome = netns::run(cell, &profile, &file, &folder, stop);
            // A terminal's Ctrl-C reaches the roles too, which then end as if by themselves.
            let interrupted = stop.load(Ordering::Relaxed);
            let outcome = if interrupted {
                Err(RunError::Interrupted)
            } else {
                outcome
            };
            (name(authority), outcome)
        }
    };
    let reports = ["plant", "controller", "link"].map(|role| netns::report(&folder, role));
    let (verdict, reasons, evidence) = judge(outcome, &reports, &folder);
    let [plant, controller, link] = reports;
    let manifest = Manifest {
        version: Manifest::VERSION,
        verdict,
        reasons,
        experiment: plan.experiment.clone(),
        campaign_seed: plan.seed,
        cell: cell.clone(),
        profile: cell.topology.clone(),
        backend: "netns".to_owned(),
        player: if link.is_some() { "user" } else { "none" }.to_owned(),
        webloop: env!("CARGO_PKG_VERSION").to_owned(),
        machine: Machine::here(),
        authority: authority_name,
        started,
        wall_s: (clock.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        epoch_ns: evidence.epoch_ns,
        start_ns: evidence.start_ns,
        certificate: evidence.certificate,
        plant,
        controller,
        link,
        files: folder::inventory(&folder, Manifest::FILE)
            .map_err(|problem| RunError::write(&folder, problem))?,
    };
    folder::write_whole(&folder.join(Manifest::FILE), manifest.to_json().as_bytes())?;
    Ok(manifest)
}

/// The verdict, with its reasons: on the machine, on the processes, on the link, on the rows.
fn judge(
    outcome: Result<Evidence, RunError>,
    reports: &[Option<serde_json::Value>; 3],
    folder: &Path,
) -> (Verdict, Vec<String>, Evidence) {
    match outcome {
        Err(problem @ RunError::Unsupported(_)) => (
            Verdict::Unsupported,
            vec![problem.to_string()],
            Evidence::default(),
        ),
        Err(problem) => {
            let mut reasons = vec![problem.to_string()];
            if let RunError::Role { role, .. } = problem {
                let words = last_words(folder, role);
                reasons.extend((!words.is_empty()).then_some(words));
            }
            (Verdict::Failed, reasons, Evidence::default())
        }
        Ok(mut evidence) => {
            evidence
                .doubts
                .extend(lost_by_the_player(reports[2].as_ref()));
            evidence.doubts.extend(lost_rows(reports));
            let reasons = std::mem::take(&mut evidence.doubts);
            let verdict = if reasons.is_empty() {
                Verdict::Complete
            } else {
                Verdict::Invalid
            };
            (verdict, reasons, evidence)
        }
    }
}

/// Packets that the player itself lost were lost by no link.
fn lost_by_the_player(link: Option<&serde_json::Value>) -> Option<String> {
    let dropped: u64 = ["up", "down"]
        .iter()
        .filter_map(|way| link?.get(way)?.get("dropped")?.as_u64())
        .sum();
    (dropped > 0)
        .then(|| format!("the player itself lost {dropped} packets: this machine is too busy"))
}

/// Rows that the disk was too slow for are not in the files.
fn lost_rows(reports: &[Option<serde_json::Value>; 3]) -> Option<String> {
    let lost: u64 = reports
        .iter()
        .flatten()
        .flat_map(|report| {
            ["tick_rows", "arrival_rows", "rows"].map(|name| &report[name]["overflow"])
        })
        .filter_map(serde_json::Value::as_u64)
        .sum();
    (lost > 0).then(|| format!("{lost} rows are missing: the disk was too slow for them"))
}

/// Makes the cell's folder; what a try without an end left there is moved aside.
fn make_room(folder: &Path) -> Result<(), RunError> {
    let fail = |problem| RunError::write(folder, problem);
    if folder.exists() {
        // Not `with_extension`: an id may have a point in it, as in `3.3hz`.
        let beside = |n: u32| PathBuf::from(format!("{}.unfinished-{n}", folder.display()));
        let aside = (1..).map(beside).find(|aside| !aside.exists());
        if let Some(aside) = aside {
            fs::rename(folder, aside).map_err(fail)?;
        }
    }
    fs::create_dir_all(folder).map_err(fail)
}

/// Leaves the profile's text, and its traces, where the player will read them.
fn write_profile(plan: &Plan, cell: &Cell, folder: &Path) -> Result<Profile, RunError> {
    let text = plan
        .profiles
        .get(&cell.topology)
        .ok_or_else(|| RunError::Link(format!("the plan has no profile `{}`", cell.topology)))?;
    folder::write_whole(&folder.join(PROFILE_FILE), text.source.as_bytes())?;
    for (name, trace) in &text.traces {
        folder::write_whole(&folder.join(name), trace.as_bytes())?;
    }
    text.profile(&cell.topology).map_err(|findings| {
        let first = findings
            .first()
            .map_or(String::new(), |finding| finding.message.clone());
        RunError::Link(format!(
            "the plan's profile `{}` cannot be played: {first}",
            cell.topology
        ))
    })
}

fn name(authority: Authority) -> String {
    match authority {
        Authority::Privileged => "privileged",
        Authority::UserNamespace => "user-namespace",
    }
    .to_owned()
}
