//! The course of a run, the same at every site: what is started when, and what is waited for.
//!
//! It only runs. What the echoes say of the link is in `evidence`; whether the loop survived is
//! read from the rows later, by others.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use link::Profile;
use plan::{Cell, Phase};
use shaper::{Echo, now_ns};

use crate::proof::Proof;
use crate::site::{Part, Running, Site, settings};
use crate::{RunError, client, schedule};

/// How often the parts are looked at.
const POLL: Duration = Duration::from_millis(10);

/// What was seen of the link in a run.
#[derive(Debug)]
pub(crate) struct Seen {
    /// Link time 0, monotonic.
    pub(crate) epoch_ns: u64,
    /// When the controller's first message was due, monotonic.
    pub(crate) start_ns: u64,
    /// The echoes, those on the empty link first.
    pub(crate) echoes: [(Phase, Vec<Echo>); 4],
}

/// Runs a cell at `site`.
///
/// The calling thread starts the parts: where they are its children, they die with it.
pub(crate) fn run(
    site: &dyn Site,
    cell: &Cell,
    profile: &Profile,
    stop: &AtomicBool,
) -> Result<Seen, RunError> {
    let given = &cell.settings;
    let epoch_ns = now_ns() + site.lead_ns(client::start_time(cell.client));
    let start_ns = epoch_ns + plan::START_AT_NS;
    let mut link = match profile.is_loopback() {
        true => None,
        false => Some(site.start(
            Part::Link,
            "link",
            settings(&[("seed", &cell.link_seed), ("epoch-ns", &epoch_ns)]),
        )?),
    };
    let plant_socket = site.plant_socket();
    let mut plant = site.start(
        Part::Plant,
        "plant",
        settings(&[
            ("listen", &plant_socket),
            ("h", &given.h),
            ("late", &given.late),
            ("hold", &cell.hold),
        ]),
    )?;
    let mut controller = site.start(
        Part::Controller,
        client::role(cell.client),
        client::told(cell, plant_socket, start_ns),
    )?;

    let proof = Proof {
        target: site.plant_address(),
        profile,
        seed: cell.link_seed,
        epoch_ns,
    };
    let send = |series, stop: &AtomicBool| site.echoes(&proof.plan(series), stop);
    let empty = send(schedule::empty(now_ns()), stop)?;
    if now_ns() >= epoch_ns {
        return Err(RunError::Link(
            "this machine was too busy to measure the empty link before the run".into(),
        ));
    }
    let abandon = AtomicBool::new(false);
    let echoes = thread::scope(|scope| {
        let before = scope.spawn(|| send(schedule::before(epoch_ns), &abandon));
        let during = scope.spawn(|| send(schedule::during(start_ns, cell.duration_ns), &abandon));
        let ended = await_controller(
            controller.as_mut(),
            plant.as_mut(),
            link.as_deref_mut(),
            cell,
            start_ns,
            stop,
        );
        let after = ended.and_then(|()| send(schedule::after(now_ns()), stop));
        // A terminal's Ctrl-C ends the controller too, as if it had ended by itself.
        if after.is_err() || stop.load(Ordering::Relaxed) {
            abandon.store(true, Ordering::Relaxed);
        }
        let (before, during) = (joined(before), joined(during));
        // The cause first: that the echoes were abandoned is what came of it.
        let after = after?;
        Ok::<_, RunError>([
            (Phase::Empty, empty),
            (Phase::Before, before?),
            (Phase::During, during?),
            (Phase::After, after),
        ])
    })?;
    controller.stop()?;
    plant.stop()?;
    link.map_or(Ok(()), Running::stop)?;
    Ok(Seen {
        epoch_ns,
        start_ns,
        echoes,
    })
}

/// Waits for the controller's own end, watching that the others live.
fn await_controller(
    controller: &mut dyn Running,
    plant: &mut dyn Running,
    mut link: Option<&mut (dyn Running + '_)>,
    cell: &Cell,
    start_ns: u64,
    stop: &AtomicBool,
) -> Result<(), RunError> {
    let deadline_ns = start_ns
        + cell.duration_ns
        + cell.settings.timeout_ns
        + u64::try_from(client::grace(cell.client).as_nanos()).unwrap_or(u64::MAX);
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

fn joined<T>(thread: thread::ScopedJoinHandle<'_, Result<T, RunError>>) -> Result<T, RunError> {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
