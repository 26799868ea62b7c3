//! Runs a cell, from its plan to its manifest: folder, site, verdict, checksums.

use std::borrow::Cow;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use agent::last_words;
use agent::program::OWN;
use link::Profile;
use manifest::Machine;
use plan::{Cell, EndFault, Plan, ProfileText, Verdict, file_name};
use shaper::Authority;
use system::System;

use crate::attach::Attach;
use crate::course::{self, Texts};
use crate::evidence::{self, Evidence};
use crate::link_check::LinkCheck;
use crate::made::Made;
use crate::netns::Netns;
use crate::patience::patiently;
use crate::report::Reports;
use crate::{Agents, Awake, Manifest, Player, RunError, Virtual, folder, own, record, simulated};

/// The folder of a cell inside a campaign's folder.
#[must_use]
pub fn cell_folder(campaign: &Path, cell: &Cell) -> PathBuf {
    campaign.join(cell.folder())
}

/// The manifest of a cell that has been run, whatever its verdict; `None` if it has not.
///
/// # Errors
/// If there is one that cannot be read; names the file.
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
        /// The result of [`shaper::become_root`].
        authority: shaper::Result<Authority>,
        /// When the link opens at the earliest, ns on the monotonic clock: other cells that run at the same time
        /// are not ready before it.
        not_before_ns: u64,
        /// Keeps this machine's processors from halting, if that is asked for.
        awake: Option<Awake>,
    },
    /// By agents that are already running, as in containers.
    Attach(Agents),
    /// In virtual time.
    Sim(Box<Virtual>),
}

/// An attempt to run a cell.
#[derive(Debug, Clone, Default)]
pub struct Attempt {
    /// Time of day at which it started, for people.
    pub started: String,
    /// What became of the earlier attempts.
    pub earlier: Vec<String>,
}

/// Runs a cell, whatever the verdict. Its manifest is not yet in its folder: see [`Made`].
///
/// What an earlier attempt left in the folder is moved aside, never overwritten.
///
/// # Errors
/// [`RunError::Write`] if the results folder cannot be written, [`RunError::InUse`] if another process runs the
/// cell in it; then there is no manifest. Everything else that can go wrong is a verdict.
pub fn run_cell(
    plan: &Plan,
    cell: &Cell,
    campaign: &Path,
    backend: &Backend,
    player: Player,
    attempt: Attempt,
    stop: &AtomicBool,
) -> Result<Made, RunError> {
    let clock = Instant::now();
    let folder = cell_folder(campaign, cell);
    let in_use = folder::make_room(campaign, &folder)?;
    let described = describe(backend);
    let once = |patience| execute(plan, cell, &folder, backend, player, patience, stop);
    let outcome = patiently(once, || {
        folder::clear(&folder).map_err(|problem| RunError::write(&folder, problem))
    });
    // Ctrl-C in a terminal also reaches the roles, which then end as if by themselves.
    let outcome = if stop.load(Ordering::Relaxed) {
        Err(RunError::Interrupted)
    } else {
        outcome
    };
    let reports = Reports::read(&folder);
    let trouble = match backend {
        // In virtual time there is no browser that could fail.
        Backend::Sim(_) => None,
        Backend::Netns { .. } | Backend::Attach(_) => reports.page_failure(cell.client),
    };
    let outcome = outcome.and_then(|evidence| match trouble {
        Some(trouble) => Err(RunError::role("page", trouble)),
        None => Ok(evidence),
    });
    let (verdict, reasons, evidence) = judge(outcome, &reports, &folder);
    tracing::debug!(ms = clock.elapsed().as_millis(), "judged");
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
        player: reports.played_by().to_owned(),
        webloop: env!("CARGO_PKG_VERSION").to_owned(),
        machine: Machine {
            awake: matches!(backend, Backend::Netns { awake: Some(_), .. }),
            ..crate::machine()
        },
        authority: described.authority,
        started: attempt.started,
        wall_s: (clock.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        epoch: evidence.epoch,
        start_ns: evidence.start_ns,
        certificate: evidence.certificate,
        messages: evidence.messages,
        pulse: evidence.pulse,
        watched: evidence.watched,
        end_faults: evidence.end_faults,
        plant: reports.plant,
        controller: reports.controller,
        page: reports.page,
        link: reports.link,
        files: folder::inventory(&folder, Manifest::FILE)
            .map_err(|problem| RunError::write(&folder, problem))?,
    };
    Ok(Made {
        manifest,
        folder,
        _in_use: in_use,
    })
}

/// Runs a cell in its folder, and judges what was observed; `patience` is that of [`course::run`].
fn execute(
    plan: &Plan,
    cell: &Cell,
    folder: &Path,
    backend: &Backend,
    player: Player,
    patience: u64,
    stop: &AtomicBool,
) -> Result<Evidence, RunError> {
    let text = write_profile(plan, cell, folder)?;
    let profile = match backend {
        Backend::Sim(virtual_time) => virtual_time.profile(&text, &cell.topology),
        Backend::Netns { .. } | Backend::Attach(_) => read_profile(&text, &cell.topology),
    }?;
    let system = plan.system(cell).map_err(RunError::Link)?;
    write_system(&system, folder)?;
    let end_faults = plan.end_faults(cell);
    if let Some(problem) = EndFault::undoable(&end_faults, &cell.client) {
        return Err(RunError::Unsupported(problem));
    }
    let texts = Texts {
        profile: &text,
        system: system.own_text(),
        program: plan.program(cell),
        plant_program: plan.plant_program(cell),
        end_faults: &end_faults,
    };
    if cell.client.is_own() && matches!(backend, Backend::Sim(_)) {
        return Err(RunError::Unsupported(format!(
            "`{}` is a program of your own, which runs in real time only: use --backend netns or compose",
            cell.client
        )));
    }
    if !matches!(backend, Backend::Attach(_)) {
        let mut programs = [texts.program, texts.plant_program].into_iter().flatten();
        if let Some(program) = programs.find(|program| program.run.is_empty()) {
            return Err(RunError::Unsupported(format!(
                "the image `{}` runs in a container only: use --backend compose, or give it a `run`",
                program.image.as_deref().unwrap_or_default()
            )));
        }
    }
    if !matches!(backend, Backend::Sim(_)) {
        player.check(&profile)?;
    }
    let seen = match backend {
        Backend::Netns {
            authority,
            not_before_ns,
            ..
        } => {
            authority.as_ref()?;
            let mut site = Netns::new(&profile, player, folder)?;
            site.wait_until(*not_before_ns);
            course::run(&site, cell, &profile, texts, patience, stop)?
        }
        Backend::Attach(agents) => {
            let site = Attach::new(agents, cell, &profile, player, folder)?;
            let seen = course::run(&site, cell, &profile, texts, patience, stop);
            // The rows copied so far are kept, however the run ended.
            let kept = site.finish(&folder.join(OWN));
            seen.and_then(|seen| kept.map(|()| seen))?
        }
        Backend::Sim(virtual_time) => {
            let timing = virtual_time.timing(cell);
            simulated::run(cell, &system, &profile, texts, timing, folder)?
        }
    };
    if cell.client.is_own() {
        own::settle(cell, seen.start_ns, folder)?;
    }
    let link_check = LinkCheck {
        target: Ipv4Addr::LOCALHOST,
        profile: &profile,
        seed: cell.link_seed,
        epoch: seen.epoch,
        opens: seen.opens,
        entered: &record::entered(folder)?,
    };
    evidence::write_rows(&link_check, &seen.echoes, &folder.join(file_name::PROBES))?;
    evidence::judge(&link_check, cell, &seen, folder)
}

/// The verdict, with its reasons: about the machine, the processes, the link and the rows.
fn judge(
    outcome: Result<Evidence, RunError>,
    reports: &Reports,
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
            reasons.extend(reports.unread.iter().cloned());
            (Verdict::Failed, reasons, Evidence::default())
        }
        Ok(mut evidence) => {
            let lost_rows = reports.lost_rows();
            evidence.is_other |= lost_rows.is_some() || !reports.unread.is_empty();
            evidence.doubts.extend(reports.lost_by_the_player());
            evidence.doubts.extend(lost_rows);
            evidence.doubts.extend(reports.unread.iter().cloned());
            let judgement = &evidence.judgement;
            let verdict = judgement.verdict(&evidence.doubts, evidence.is_other);
            // Causes first, then their effects.
            let causes = judgement.disturbances.iter().map(|one| one.words.clone());
            let faults = judgement.faults.iter().cloned();
            let doubts = std::mem::take(&mut evidence.doubts);
            let reasons = causes.chain(faults).chain(doubts).collect();
            (verdict, reasons, evidence)
        }
    }
}

/// Writes the profile's text and its traces beside the rows.
fn write_profile<'a>(
    plan: &'a Plan,
    cell: &Cell,
    folder: &Path,
) -> Result<Cow<'a, ProfileText>, RunError> {
    let text = plan
        .profile(cell)
        .ok_or_else(|| RunError::Link(format!("the plan has no profile `{}`", cell.topology)))?;
    folder::write(&folder.join(file_name::PROFILE), text.source.as_bytes())?;
    for (name, trace) in &text.traces {
        folder::write(&folder.join(name), trace.as_bytes())?;
    }
    Ok(text)
}

/// The link that a plan's text describes.
pub(crate) fn read_profile(text: &ProfileText, topology: &str) -> Result<Profile, RunError> {
    text.profile(topology).map_err(|findings| {
        let first = findings
            .first()
            .map_or(String::new(), |finding| finding.message.clone());
        RunError::Link(format!(
            "the plan's profile `{topology}` cannot be played: {first}"
        ))
    })
}

/// Writes the system's text beside the rows, unless it is the paper's.
fn write_system(system: &System, folder: &Path) -> Result<(), RunError> {
    match system.own_text() {
        Some(text) => folder::write(&folder.join(file_name::SYSTEM), text.as_bytes()),
        None => Ok(()),
    }
}

/// What a manifest says about a back-end.
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
