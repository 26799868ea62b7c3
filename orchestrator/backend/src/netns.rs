//! The `netns` back-end: one run on this machine, its ends in namespaces, its roles in processes.
//!
//! It only runs. Whether the loop survived is read from the rows later, by others.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use link::Profile;
use plan::{Cell, Phase};
use serde_json::Value;
use shaper::{Echo, now_ns};

use crate::proof::Proof;
use crate::role::Role;
use crate::{Lab, RunError, schedule};

/// Port of the plant; the namespaces are ours alone, so any would do.
const PORT: u16 = 8080;

/// How long after its last deadline and time-out a controller may take to end.
const CONTROLLER_GRACE: Duration = Duration::from_secs(10);

/// How often the roles are looked at.
const POLL: Duration = Duration::from_millis(10);

/// What a run has shown, for its manifest.
#[derive(Debug, Default)]
pub(crate) struct Evidence {
    pub(crate) epoch_ns: u64,
    pub(crate) start_ns: u64,
    pub(crate) certificate: Option<Value>,
    /// Why the run is not to be trusted; empty if it is.
    pub(crate) doubts: Vec<String>,
}

/// Runs a cell and leaves its rows in `folder`.
///
/// The calling thread starts the processes, so they die with it.
pub(crate) fn run(
    cell: &Cell,
    profile: &Profile,
    profile_file: &Path,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<Evidence, RunError> {
    let lab = Lab::new(profile)?;
    let plant_at = format!("{}:{PORT}", lab.plant_address());
    let out = folder.display().to_string();
    let settings = &cell.settings;

    let mut plant = Role::start(
        "plant",
        &words(&[
            ("listen", &plant_at),
            ("h", &settings.h),
            ("late", &settings.late),
            ("out", &out),
        ]),
        Some(lab.plant()),
        folder,
    )?;
    plant.wait_ready()?;

    let epoch_ns = now_ns() + schedule::EPOCH_AFTER_NS;
    let start_ns = epoch_ns + schedule::START_AT_NS;
    let mut link = None;
    if let Some(middle) = lab.middle() {
        let args = words(&[
            ("profile", &profile_file.display()),
            ("seed", &cell.link_seed),
            ("epoch-ns", &epoch_ns),
            ("out", &out),
        ]);
        let mut role = Role::start("link", &args, Some(middle), folder)?;
        role.wait_ready()?;
        link = Some(role);
    }
    let mut controller = Role::start(
        "controller",
        &words(&[
            ("plant", &plant_at),
            ("h", &settings.h),
            ("mode", &settings.mode),
            ("r", &settings.r),
            ("duration", &format!("{}ns", cell.duration_ns)),
            ("outstanding", &settings.outstanding),
            ("connection", &settings.connection),
            ("schedule", &settings.schedule),
            ("integrate", &settings.integrate),
            ("late", &settings.late),
            ("timeout", &format!("{}ns", settings.timeout_ns)),
            ("start-ns", &start_ns),
            ("out", &out),
        ]),
        Some(lab.controller()),
        folder,
    )?;

    let proof = Proof {
        lab: &lab,
        profile,
        seed: cell.link_seed,
        epoch_ns,
    };
    let empty = proof.series(schedule::empty(now_ns()), stop)?;
    if now_ns() >= epoch_ns {
        return Err(RunError::Link(
            "this machine was too busy to measure the empty link before the run".into(),
        ));
    }
    let abandon = AtomicBool::new(false);
    let echoes = thread::scope(|scope| {
        let before = scope.spawn(|| proof.series(schedule::before(epoch_ns), &abandon));
        let during =
            scope.spawn(|| proof.series(schedule::during(start_ns, cell.duration_ns), &abandon));
        let ended = await_controller(
            &mut controller,
            &mut plant,
            link.as_mut(),
            cell,
            start_ns,
            stop,
        );
        let after = ended.and_then(|()| Ok(proof.series(schedule::after(now_ns()), stop)?));
        // A terminal's Ctrl-C ends the controller too, as if it had ended by itself.
        if after.is_err() || stop.load(Ordering::Relaxed) {
            abandon.store(true, Ordering::Relaxed);
        }
        Ok::<_, RunError>([
            (Phase::Empty, empty),
            (Phase::Before, joined(before)?),
            (Phase::During, joined(during)?),
            (Phase::After, after?),
        ])
    })?;
    plant.stop()?;
    link.map_or(Ok(()), Role::stop)?;
    write_rows(&proof, &echoes, &folder.join("probes.csv"))?;
    let mut evidence = judge(&proof, &echoes);
    evidence.start_ns = start_ns;
    Ok(evidence)
}

/// Waits for the controller's own end, watching that the others live.
fn await_controller(
    controller: &mut Role,
    plant: &mut Role,
    mut link: Option<&mut Role>,
    cell: &Cell,
    start_ns: u64,
    stop: &AtomicBool,
) -> Result<(), RunError> {
    let deadline_ns = start_ns
        + cell.duration_ns
        + cell.settings.timeout_ns
        + u64::try_from(CONTROLLER_GRACE.as_nanos()).unwrap_or(u64::MAX);
    while !controller.ended()? {
        if stop.load(Ordering::Relaxed) {
            controller.terminate();
            return Err(RunError::Interrupted);
        }
        if plant.ended()? || link.as_mut().map_or(Ok(false), |link| link.ended())? {
            return Err(RunError::Link(
                "the plant or the link ended before the controller".into(),
            ));
        }
        if now_ns() > deadline_ns {
            return Err(RunError::role(
                "controller",
                "did not end after its duration and time-out",
            ));
        }
        thread::sleep(POLL);
    }
    Ok(())
}

/// Judges the link by its echoes, and the run by the link.
fn judge(proof: &Proof, phases: &[(Phase, Vec<Echo>); 4]) -> Evidence {
    let mut evidence = Evidence {
        epoch_ns: proof.epoch_ns,
        ..Evidence::default()
    };
    let Some(baseline) = proof.baseline(&phases[0].1) else {
        evidence
            .doubts
            .push("no echo came through the empty link".into());
        return evidence;
    };
    let echoes = in_order(&phases[1..]);
    if let Some(certificate) = proof.certificate(&echoes, baseline) {
        if let shaper::Verdict::Broken(reasons) = &certificate.verdict {
            evidence.doubts.extend(reasons.iter().cloned());
        }
        evidence.certificate = serde_json::to_value(certificate).ok();
    } else if echoes.iter().all(|echo| echo.t_back_ns.is_none()) {
        evidence
            .doubts
            .push("no echo came back over loopback".into());
    }
    evidence
}

/// The echoes of several series as one, in order of sending.
fn in_order(phases: &[(Phase, Vec<Echo>)]) -> Vec<Echo> {
    let mut echoes: Vec<_> = phases
        .iter()
        .flat_map(|(_, echoes)| echoes.iter().copied())
        .collect();
    echoes.sort_by_key(|echo| echo.t_send_ns);
    echoes
}

fn write_rows(proof: &Proof, phases: &[(Phase, Vec<Echo>)], path: &Path) -> Result<(), RunError> {
    let fail = |problem: csv::Error| RunError::write(path, std::io::Error::other(problem));
    let mut csv = csv::Writer::from_path(path).map_err(fail)?;
    for (phase, echoes) in phases {
        for row in proof.rows(*phase, echoes) {
            csv.serialize(row).map_err(fail)?;
        }
    }
    csv.flush()
        .map_err(|problem| RunError::write(path, problem))
}

fn joined<T>(thread: thread::ScopedJoinHandle<'_, shaper::Result<T>>) -> Result<T, RunError> {
    let outcome = thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    Ok(outcome?)
}

/// `--name value` pairs.
fn words(pairs: &[(&str, &dyn std::fmt::Display)]) -> Vec<String> {
    pairs
        .iter()
        .flat_map(|(name, value)| [format!("--{name}"), value.to_string()])
        .collect()
}

/// A role's report, if it left one.
pub(crate) fn report(folder: &Path, role: &str) -> Option<Value> {
    let text = fs::read_to_string(folder.join(format!("{role}.json"))).ok()?;
    serde_json::from_str(&text).ok()
}
