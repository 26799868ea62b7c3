//! Runs a cell, from its plan to its manifest: folder, site, verdict, checksums.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use link::Profile;
use plan::system::System;
use plan::{Cell, EndFault, Plan, Verdict, file_name};
use process::last_words;
use process::program::OWN;
use record::folder::{self, Unwritable};
use record::{Held, Machine, Made, Manifest};
use shaper::Authority;

use crate::agents::Agents;
use crate::attach::Attach;
use crate::awake::Awake;
use crate::course::{self, Seen};
use crate::error::RunError;
use crate::evidence::{self, Asked, Evidence};
use crate::link_check::LinkCheck;
use crate::netns::Netns;
use crate::patience::patiently;
use crate::player::Player;
use crate::report::Reports;
use crate::texts::{Texts, read_profile, write_profile, write_system};
use crate::virtual_time::Virtual;
use crate::{own, rows, simulated};

/// The folder of a cell inside a campaign's folder.
#[must_use]
pub fn cell_folder(campaign: &Path, cell: &Cell) -> PathBuf {
    campaign.join(cell.folder())
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
/// [`RunError::Folder`] if the results folder cannot be written, or another process runs the
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
    let execution = Execution {
        plan,
        cell,
        folder: &folder,
        backend,
        player,
        stop,
    };
    let once = |patience| execution.execute(patience);
    let outcome = patiently(once, || {
        folder::clear(&folder).map_err(|problem| Unwritable::failed(&folder, problem).into())
    });
    // Ctrl-C in a terminal also reaches the roles, which then end as if by themselves.
    let outcome = if stop.load(Ordering::Relaxed) {
        Err(RunError::Interrupted)
    } else {
        outcome
    };
    let (outcome, held) = match outcome {
        Ok((evidence, held)) => (Ok(evidence), held),
        Err(problem) => (Err(problem), None),
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
    let judged = judge(outcome, &reports, &folder);
    tracing::debug!(ms = clock.elapsed().as_millis(), "judged");
    let manifest = execution.manifest(attempt, reports, judged, held.as_ref(), clock)?;
    Ok(Made::new(manifest, folder, held, in_use))
}

/// A run of a cell: what is run, where, and into which folder.
#[derive(Clone, Copy)]
struct Execution<'a> {
    plan: &'a Plan,
    cell: &'a Cell,
    folder: &'a Path,
    backend: &'a Backend,
    player: Player,
    stop: &'a AtomicBool,
}

impl Execution<'_> {
    /// Runs the cell in its folder, and judges what was observed; `patience` is that of [`course::run`]. Returns the
    /// rows too if nobody else can have written their files: in virtual time, without a program of one's own. Of any
    /// other run only what is on the disk counts.
    fn execute(self, patience: u64) -> Result<(Evidence, Option<Held>), RunError> {
        let Execution {
            plan, cell, folder, ..
        } = self;
        let text = write_profile(plan, cell, folder)?;
        let profile = match self.backend {
            Backend::Sim(virtual_time) => virtual_time.profile(&text, &cell.topology),
            Backend::Netns { .. } | Backend::Attach(_) => read_profile(&text, &cell.topology),
        }?;
        let system = plan.system(cell)?;
        write_system(&system, folder)?;
        let end_faults = plan.end_faults(cell);
        let texts = Texts {
            profile: &text,
            system: system.own_text(),
            program: plan.program(cell),
            plant_program: plan.plant_program(cell),
            end_faults: &end_faults,
        };
        self.check_ends(texts)?;
        if !matches!(self.backend, Backend::Sim(_)) {
            self.player.check(&profile)?;
        }
        let mut seen = self.observe(&system, &profile, texts, patience)?;
        if cell.client.is_own() {
            own::settle(cell, seen.start_ns, folder)?;
        }
        let link_check = LinkCheck {
            entered: &rows::entered(folder)?,
            ..LinkCheck::of(cell, &profile, seen.epoch, seen.opens)
        };
        let probes =
            evidence::write_rows(&link_check, &seen.echoes, &folder.join(file_name::PROBES))?;
        let asked = Asked {
            cell,
            system: &system,
            is_plant_own: texts.plant_program.is_some(),
        };
        let evidence = evidence::judge(&link_check, asked, &seen, folder)?;
        let held = seen.rows.take().filter(|_| !asked.is_plant_own);
        Ok((evidence, held.map(|held| Held { probes, ..held })))
    }

    /// Refuses faults that cannot be done to these ends, and programs of one's own that the back-end cannot run.
    fn check_ends(self, texts: Texts<'_>) -> Result<(), RunError> {
        let client = self.cell.client;
        if let Some(problem) = EndFault::undoable(texts.end_faults, &client) {
            return Err(RunError::Unsupported(problem));
        }
        if client.is_own() && matches!(self.backend, Backend::Sim(_)) {
            return Err(RunError::Unsupported(format!(
                "`{client}` is a program of your own, which runs in real time only: use --backend netns or compose"
            )));
        }
        if !matches!(self.backend, Backend::Attach(_)) {
            let mut programs = [texts.program, texts.plant_program].into_iter().flatten();
            if let Some(program) = programs.find(|program| program.run.is_empty()) {
                return Err(RunError::Unsupported(format!(
                    "the image `{}` runs in a container only: use --backend compose, or give it a `run`",
                    program.image.as_deref().unwrap_or_default()
                )));
            }
        }
        Ok(())
    }

    /// Runs the cell on its back-end, and returns what was observed.
    fn observe(
        self,
        system: &System,
        profile: &Profile,
        texts: Texts<'_>,
        patience: u64,
    ) -> Result<Seen, RunError> {
        match self.backend {
            Backend::Netns {
                authority,
                not_before_ns,
                ..
            } => {
                authority.as_ref()?;
                let mut site = Netns::new(profile, self.player, self.folder)?;
                site.wait_until(*not_before_ns);
                course::run(&site, self.cell, profile, texts, patience, self.stop)
            }
            Backend::Attach(agents) => {
                let site = Attach::new(agents, self.cell, profile, self.player, self.folder)?;
                let seen = course::run(&site, self.cell, profile, texts, patience, self.stop);
                // The rows copied so far are kept, however the run ended.
                let kept = site.finish(&self.folder.join(OWN));
                seen.and_then(|seen| kept.map(|()| seen))
            }
            Backend::Sim(virtual_time) => {
                let timing = virtual_time.timing(self.cell);
                simulated::run(self.cell, system, profile, texts, timing, self.folder)
            }
        }
    }

    /// The manifest of the run, which began when `clock` did, with what [`judge()`] says of it and the rows that are
    /// `held`.
    fn manifest(
        self,
        attempt: Attempt,
        reports: Reports,
        (verdict, reasons, evidence): (Verdict, Vec<String>, Evidence),
        held: Option<&Held>,
        clock: Instant,
    ) -> Result<Manifest, RunError> {
        let (backend, authority, engine) = describe(self.backend);
        let none = BTreeMap::new();
        let known = held.map_or(&none, |held| &held.files);
        Ok(Manifest {
            version: Manifest::VERSION,
            verdict,
            reasons,
            disturbances: evidence.judgement.disturbances,
            earlier: attempt.earlier,
            experiment: self.plan.experiment.clone(),
            campaign_seed: self.plan.seed,
            cell: self.cell.clone(),
            profile: self.cell.topology.clone(),
            backend: backend.to_owned(),
            engine,
            player: reports.played_by().to_owned(),
            webloop: env!("CARGO_PKG_VERSION").to_owned(),
            machine: Machine {
                awake: matches!(self.backend, Backend::Netns { awake: Some(_), .. }),
                ..crate::machine()
            },
            authority: authority.to_owned(),
            started: attempt.started,
            wall_s: (clock.elapsed().as_secs_f64() * 1e3).round() / 1e3,
            epoch: evidence.epoch,
            start_ns: evidence.start_ns,
            certificate: evidence.certificate,
            messages: evidence.messages,
            pulse: evidence.pulse,
            watched: evidence.watched,
            end_faults: evidence.end_faults,
            ends: evidence.ends,
            plant: reports.plant,
            controller: reports.controller,
            page: reports.page,
            link: reports.link,
            files: folder::inventory(self.folder, Manifest::FILE, known)
                .map_err(|problem| Unwritable::failed(self.folder, problem))?,
        })
    }
}

/// The verdict, with its reasons: about the machine, the processes, the link and the rows.
pub(crate) fn judge(
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
            let taken = evidence.taken.take();
            evidence.judgement.excuse(&evidence.doubts, taken);
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

/// What a manifest says about a back-end: its name, what this process may do in it, and its engine.
fn describe(backend: &Backend) -> (&str, &str, Option<String>) {
    match backend {
        Backend::Netns { authority, .. } => {
            let authority = match authority {
                Ok(Authority::Privileged) => "privileged",
                Ok(Authority::UserNamespace) => "user-namespace",
                Err(_) => "",
            };
            ("netns", authority, None)
        }
        Backend::Attach(agents) => (agents.backend.as_str(), "", agents.engine.clone()),
        Backend::Sim(_) => ("sim", "", None),
    }
}
