//! A cell from its plan to its manifest: folder, site, verdict, checksums.

use std::fs;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use agent::last_words;
use link::Profile;
use plan::{Cell, Plan, ProfileText, Verdict};
use serde_json::Value;
use shaper::Authority;
use system::System;

use crate::attach::{Attach, Texts};
use crate::course;
use crate::evidence::{self, Evidence};
use crate::link_check::LinkCheck;
use crate::netns::Netns;
use crate::{Agents, Manifest, Player, RunError, Timings, folder, record, report, simulated};

/// The file in which a cell's folder keeps its link's profile.
const PROFILE_FILE: &str = "profile.toml";
/// The file in which it keeps its system, where that is not the paper's.
const SYSTEM_FILE: &str = "system.toml";

/// The folder of a cell inside a campaign's folder.
#[must_use]
pub fn cell_folder(campaign: &Path, cell: &Cell) -> PathBuf {
    campaign.join(cell.folder())
}

/// The manifest of a cell that has been run, whatever its verdict; `None` if it has not.
///
/// # Errors
/// When there is one that cannot be read; names the file.
pub fn manifest(campaign: &Path, cell: &Cell) -> Result<Option<Manifest>, String> {
    let path = cell_folder(campaign, cell).join(Manifest::FILE);
    match file::text(&path, file::MANIFEST_BYTES) {
        Ok(text) => Manifest::from_json(&text)
            .map(Some)
            .map_err(|problem| format!("{}: {problem}", path.display())),
        Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(problem) => Err(format!("{}: {problem}", path.display())),
    }
}

/// Where a cell is run, and what that needs.
#[derive(Debug)]
pub enum Backend {
    /// In namespaces on this machine.
    Netns {
        /// What [`shaper::become_root`] gave.
        authority: shaper::Result<Authority>,
        /// The link's epoch is no earlier, ns on the monotonic clock: who runs beside is not up before.
        not_before_ns: u64,
    },
    /// By agents that run already, as in containers.
    Attach(Agents),
    /// In virtual time, with what a machine's programs take.
    Sim(Box<Timings>),
}

/// A try at a cell.
#[derive(Debug, Clone, Default)]
pub struct Attempt {
    /// The time of day, for people.
    pub started: String,
    /// What became of the tries before this one.
    pub earlier: Vec<String>,
}

/// Runs a cell and writes its manifest, whatever the verdict.
///
/// What an earlier try left in the folder is moved
/// aside, never overwritten.
///
/// # Errors
/// [`RunError::Write`] when the results folder cannot be written: then there is no manifest.
/// Everything else that can go wrong is a verdict.
pub fn run_cell(
    plan: &Plan,
    cell: &Cell,
    campaign: &Path,
    backend: &Backend,
    player: Player,
    attempt: Attempt,
    stop: &AtomicBool,
) -> Result<Manifest, RunError> {
    let clock = Instant::now();
    let folder = cell_folder(campaign, cell);
    make_room(campaign, &folder)?;
    let profile = write_profile(plan, cell, &folder);
    let system = plan.system(cell).map_err(RunError::Link);
    let described = describe(backend);
    let outcome = profile.and_then(|(text, profile)| {
        let file = folder.join(PROFILE_FILE);
        let system = system?;
        let own = write_system(&system, &folder)?;
        let seen = match backend {
            Backend::Netns {
                authority,
                not_before_ns,
            } => {
                authority.as_ref()?;
                let mut site = Netns::new(&profile, player, &file, own.as_deref(), &folder)?;
                site.wait_until(*not_before_ns);
                course::run(&site, cell, &profile, stop)?
            }
            Backend::Attach(agents) => {
                let texts = Texts {
                    profile: text,
                    system: system.own_text(),
                };
                let site = Attach::new(agents, cell, texts, &profile, player, &folder)?;
                let seen = course::run(&site, cell, &profile, stop);
                // What has come is kept, however it ended.
                let kept = site.finish();
                seen.and_then(|seen| kept.map(|()| seen))?
            }
            Backend::Sim(timings) => {
                let timing = timings.of(cell);
                simulated::run(cell, &system, &profile, timing, &folder)?
            }
        };
        let link_check = LinkCheck {
            target: Ipv4Addr::LOCALHOST,
            profile: &profile,
            seed: cell.link_seed,
            epoch_ns: seen.epoch_ns,
            entered: &record::entered(&folder)?,
        };
        evidence::write_rows(&link_check, &seen.echoes, &folder.join("probes.csv"))?;
        evidence::judge(&link_check, cell, &seen, &folder)
    });
    // A terminal's Ctrl-C reaches the roles too, which then end as if by themselves.
    let outcome = match stop.load(Ordering::Relaxed) {
        true => Err(RunError::Interrupted),
        false => outcome,
    };
    let page = report::of_role(&folder, "page");
    let trouble = match backend {
        // In virtual time there is no browser that could have any.
        Backend::Sim(_) => None,
        Backend::Netns { .. } | Backend::Attach(_) => {
            report::page_failure(cell.client, page.as_ref())
        }
    };
    let outcome = outcome.and_then(|evidence| match trouble {
        Some(trouble) => Err(RunError::role("page", trouble)),
        None => Ok(evidence),
    });
    let reports = [
        report::of_role(&folder, "plant"),
        report::of_role(&folder, "controller"),
        report::of_link(&folder),
    ];
    let (verdict, reasons, evidence) = judge(outcome, &reports, &folder);
    let [plant, controller, link] = reports;
    let manifest = Manifest {
        version: Manifest::VERSION,
        verdict,
        reasons,
        disturbances: evidence.judgement.disturbances,
        earlier: attempt.earlier,
        experiment: plan.experiment.clone(),
        campaign_seed: plan.seed,
        cell: cell.clone(),
        profile: cell.topology.clone(),
        backend: described.name,
        engine: described.engine,
        player: report::played_by(link.as_ref()),
        webloop: env!("CARGO_PKG_VERSION").to_owned(),
        machine: crate::machine(),
        authority: described.authority,
        started: attempt.started,
        wall_s: (clock.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        epoch_ns: evidence.epoch_ns,
        start_ns: evidence.start_ns,
        certificate: evidence.certificate,
        messages: evidence.messages,
        pulse: evidence.pulse,
        watched: evidence.watched,
        plant,
        controller,
        page,
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
    reports: &[Option<Value>; 3],
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
                let words = last_words(folder, &role);
                reasons.extend((!words.is_empty()).then_some(words));
            }
            (Verdict::Failed, reasons, Evidence::default())
        }
        Ok(mut evidence) => {
            let lost_rows = report::lost_rows(reports);
            evidence.is_other |= lost_rows.is_some();
            evidence
                .doubts
                .extend(report::lost_by_the_player(reports[2].as_ref()));
            evidence.doubts.extend(lost_rows);
            let judgement = &evidence.judgement;
            let verdict = judgement.verdict(&evidence.doubts, evidence.is_other);
            // The cause first, and then what came of it.
            let causes = judgement.disturbances.iter().map(|one| one.words.clone());
            let faults = judgement.faults.iter().cloned();
            let doubts = std::mem::take(&mut evidence.doubts);
            let reasons = causes.chain(faults).chain(doubts).collect();
            (verdict, reasons, evidence)
        }
    }
}

/// Makes the cell's folder; what a try without an end left there is moved aside.
fn make_room(campaign: &Path, folder: &Path) -> Result<(), RunError> {
    let fail = |problem| RunError::write(folder, problem);
    let below = folder.strip_prefix(campaign).unwrap_or(folder);
    fs::create_dir_all(campaign).map_err(fail)?;
    // Looked at before anything in there is renamed: a link may lead to somebody else's.
    file::make_folder(campaign, below.parent().unwrap_or(below)).map_err(fail)?;
    folder::move_aside(folder).map_err(fail)?;
    file::make_folder(campaign, below).map_err(fail)?;
    Ok(())
}

/// Leaves the profile's text, and its traces, where the player will read them.
fn write_profile<'a>(
    plan: &'a Plan,
    cell: &Cell,
    folder: &Path,
) -> Result<(&'a ProfileText, Profile), RunError> {
    let text = plan
        .profiles
        .get(&cell.topology)
        .ok_or_else(|| RunError::Link(format!("the plan has no profile `{}`", cell.topology)))?;
    folder::write_whole(&folder.join(PROFILE_FILE), text.source.as_bytes())?;
    for (name, trace) in &text.traces {
        folder::write_whole(&folder.join(name), trace.as_bytes())?;
    }
    let profile = text.profile(&cell.topology).map_err(|findings| {
        let first = findings
            .first()
            .map_or(String::new(), |finding| finding.message.clone());
        RunError::Link(format!(
            "the plan's profile `{}` cannot be played: {first}",
            cell.topology
        ))
    })?;
    Ok((text, profile))
}

/// Leaves the system's text where the two ends will read it, unless they have it already.
fn write_system(system: &System, folder: &Path) -> Result<Option<PathBuf>, RunError> {
    let Some(text) = system.own_text() else {
        return Ok(None);
    };
    let path = folder.join(SYSTEM_FILE);
    folder::write_whole(&path, text.as_bytes())?;
    Ok(Some(path))
}

/// What a manifest says of a back-end.
struct Described {
    name: String,
    authority: String,
    engine: Option<String>,
}

fn describe(backend: &Backend) -> Described {
    match backend {
        Backend::Netns { authority, .. } => Described {
            name: "netns".to_owned(),
            authority: match authority {
                Ok(Authority::Privileged) => "privileged".to_owned(),
                Ok(Authority::UserNamespace) => "user-namespace".to_owned(),
                Err(_) => String::new(),
            },
            engine: None,
        },
        Backend::Attach(agents) => Described {
            name: agents.backend.clone(),
            authority: String::new(),
            engine: agents.engine.clone(),
        },
        Backend::Sim(_) => Described {
            name: "sim".to_owned(),
            authority: String::new(),
            engine: None,
        },
    }
}
