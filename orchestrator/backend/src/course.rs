//! The course of a run, the same at every site: what is started when, and what is waited for.
//!
//! It only runs the parts, and records how they looked meanwhile. `evidence` evaluates what echoes and
//! rows say about the link; the analysis later reads from the rows whether the loop survived.

mod busywork;
mod end;
mod share;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use link::{Epoch, LinkTime, Profile};
use plan::evidence::{Pulse, Watched};
use plan::{Cell, End, EndEffect, EndFault, EndFaultDone, Phase};
use record::Held;

use crate::error::RunError;
use crate::link_check::{LinkCheck, Sent};
use crate::pulse::Pulses;
use crate::role::{ControllerRole, LinkRole, PlantRole, RoleSettings};
use crate::schedule;
use crate::schedule::{Series, Spacing};
use crate::site::{Running, Site};
use crate::texts::Texts;

use busywork::Busywork;
use end::EndPart;
use share::{PartSeen, Shares};

/// How often to check whether a part has ended or an event is due.
const POLL: Duration = Duration::from_millis(10);

/// How often to count who used the processors, ns.
const COUNT_EVERY_NS: usize = 250_000_000;

/// Something that happens at an instant known before the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// Counts who used the processors.
    CountProcessors,
    /// A fault kills an end.
    Kill(End),
    /// What a fault has killed is started again.
    StartAgain(End),
    /// A fault lets so many programs compute on the machine.
    Load(u16),
    /// They end.
    Unload,
    /// Gives up on the controller: its duration, time-out and grace are over.
    GiveUp,
}

/// The events of a run, in order of their instants.
struct Events(VecDeque<(u64, Event)>);

impl Events {
    /// The events of a run of `cell` with these faults, whose controller has its deadlines within `loop_ns`.
    fn of(cell: &Cell, faults: &[EndFault], loop_ns: Range<u64>) -> Events {
        let from_ns = loop_ns.start;
        let give_up_ns = loop_ns
            .end
            .saturating_add(cell.settings.timeout_ns)
            .saturating_add(schedule::ns(cell.client.spec().grace));
        let counts_ns = loop_ns.step_by(COUNT_EVERY_NS);
        let counts = counts_ns.map(|t_ns| (t_ns, Event::CountProcessors));
        let hits = faults.iter().filter_map(|fault| {
            let [begins, ends] = match (fault.effect, fault.end) {
                (EndEffect::Kill, end) => [Event::Kill(end), Event::StartAgain(end)],
                // One machine has both ends.
                (EndEffect::Busy(programs), End::Plant) => [Event::Load(programs), Event::Unload],
                _ => return None,
            };
            Some([
                (from_ns + fault.from_ns, begins),
                (from_ns + fault.to_ns, ends),
            ])
        });
        let all = counts
            .chain(hits.flatten())
            .chain([(give_up_ns, Event::GiveUp)]);
        let mut all: Vec<(u64, Event)> = all.collect();
        all.sort_by_key(|(t_ns, _)| *t_ns);
        Events(all.into())
    }

    /// Time until the next event, at most [`POLL`].
    fn wait(&self, now_ns: u64) -> Duration {
        let next_ns = self.0.front().map_or(u64::MAX, |(t_ns, _)| *t_ns);
        POLL.min(Duration::from_nanos(next_ns.saturating_sub(now_ns)))
    }

    /// The next event, if its instant has come.
    fn next(&mut self, now_ns: u64) -> Option<Event> {
        let is_due = self.0.front().is_some_and(|(t_ns, _)| *t_ns <= now_ns);
        is_due.then(|| self.0.pop_front())?.map(|(_, event)| event)
    }
}

/// What was observed during a run.
#[derive(Debug)]
pub(crate) struct Seen {
    /// Link time 0, monotonic.
    pub(crate) epoch: Epoch,
    /// The link time from which on the link was in force.
    pub(crate) opens: LinkTime,
    /// When the controller's first message was due, monotonic.
    pub(crate) start_ns: u64,
    /// The echoes; those on the empty link come first.
    pub(crate) echoes: [Sent; 4],
    /// The rows, if they need not be read from their files.
    pub(crate) rows: Option<Held>,
    /// The pulse of the processors meanwhile; `None` in virtual time.
    pub(crate) pulse: Option<Pulse>,
    /// What was observed of each part while the controller ran, with the part's name.
    pub(crate) watched: Vec<(String, Watched)>,
    /// What a fault did to the ends.
    pub(crate) end_faults: Vec<EndFaultDone>,
}

/// Runs a cell at `site`. Its link opens after `patience` times what the parts usually need.
///
/// The calling thread starts the parts; those that are its child processes die with it.
pub(crate) fn run(
    site: &dyn Site,
    cell: &Cell,
    profile: &Profile,
    texts: Texts<'_>,
    patience: u64,
    stop: &AtomicBool,
) -> Result<Seen, RunError> {
    let begun_ns = site.now_ns();
    let lead_ns = site.lead_ns(cell.client.spec().start_time);
    let spacing = Spacing::of(profile);
    let opens = spacing.opens();
    let opens_ns = site
        .now_ns()
        .saturating_add(lead_ns.saturating_mul(patience));
    let epoch = Epoch::at_ns(opens_ns.saturating_sub(opens.ns()));
    let link = if profile.is_loopback() {
        None
    } else {
        let role = LinkRole::of(cell, texts.profile, epoch, opens);
        Some(site.start(RoleSettings::Link(role))?)
    };
    let conductor = Conductor {
        site,
        cell,
        texts,
        link_check: LinkCheck {
            target: site.plant_address(),
            ..LinkCheck::of(cell, profile, epoch, opens)
        },
        begun_ns,
        stop,
    };
    let (mut parts, empty) = conductor.start(link)?;
    conductor.passed("the empty link is measured");
    if site.now_ns() >= opens_ns {
        return Err(RunError::Late);
    }
    let pulses = Pulses::start();
    let mut shares = Shares::new(conductor.loop_ns());
    let [before, during, after] = conductor.control(&mut parts, &mut shares)?;
    conductor.passed("the echoes are back");
    let pulse = pulses.finish();
    let seen = parts.seen()?;
    let end_faults = parts.done(&seen)?;
    let watched = seen.map(|seen| seen.watched(&shares, &end_faults));
    parts.stop()?;
    conductor.passed("the parts have ended");
    Ok(Seen {
        epoch,
        opens,
        start_ns: conductor.loop_ns().start,
        echoes: [empty, before, during, after],
        rows: None,
        pulse: Some(pulse),
        watched: watched.into(),
        end_faults,
    })
}

/// Conducts a run: has what its steps have in common.
struct Conductor<'a> {
    site: &'a dyn Site,
    cell: &'a Cell,
    texts: Texts<'a>,
    link_check: LinkCheck<'a>,
    /// When the run began, monotonic.
    begun_ns: u64,
    stop: &'a AtomicBool,
}

impl<'a> Conductor<'a> {
    /// Says that a step is over, and how long after the run began.
    fn passed(&self, step: &str) {
        let ns = self.site.now_ns().saturating_sub(self.begun_ns);
        tracing::debug!(ms = ns / 1_000_000, "{step}");
    }

    /// When the controller has its deadlines, monotonic.
    fn loop_ns(&self) -> Range<u64> {
        let start_ns = self.link_check.epoch.t_ns(plan::START_AT);
        start_ns..start_ns + self.cell.duration_ns
    }

    /// Starts the ends, while echoes measure the empty link.
    fn start(&self, link: Option<Box<dyn Running + 'a>>) -> Result<(Parts<'a>, Sent), RunError> {
        let (site, stop, epoch) = (self.site, self.stop, self.link_check.epoch);
        thread::scope(|scope| {
            let series = Spacing::Close.empty(site.now_ns());
            let plan = self.link_check.plan(series);
            let empty = scope.spawn(move || Sent::send(site, Phase::Empty, &plan, stop));
            let parts = Parts::start(site, self.cell, self.texts, epoch, link);
            self.passed("the parts are ready");
            let empty = joined(empty);
            Ok((parts?, empty?))
        })
    }

    /// Waits for the controller, while echoes are sent. Returns those of before, during and after its loop.
    fn control(&self, parts: &mut Parts<'a>, shares: &mut Shares) -> Result<[Sent; 3], RunError> {
        let (site, link_check) = (self.site, &self.link_check);
        let send = |series: Series, stop: &AtomicBool| {
            Sent::send(site, series.phase, &link_check.plan(series), stop)
        };
        let (spacing, loop_ns) = (Spacing::of(link_check.profile), self.loop_ns());
        let in_loop = schedule::during(loop_ns.start, self.cell.duration_ns);
        let mut events = Events::of(self.cell, self.texts.end_faults, loop_ns);
        let abandon = AtomicBool::new(false);
        thread::scope(|scope| {
            let before = scope.spawn(|| send(spacing.before(link_check.epoch), &abandon));
            let during = scope.spawn(|| send(in_loop, &abandon));
            let ended = parts.await_controller(site, &mut events, shares, self.stop);
            self.passed("the controller has ended");
            let after = ended.and_then(|()| send(spacing.after(site.now_ns()), self.stop));
            // Ctrl-C in a terminal also ends the controller, as if it had ended by itself.
            if after.is_err() || self.stop.load(Ordering::Relaxed) {
                abandon.store(true, Ordering::Relaxed);
            }
            let (before, during) = (joined(before), joined(during));
            // Return the cause first: the echoes were abandoned because of it.
            let after = after?;
            Ok([before?, during?, after])
        })
    }
}

/// The started parts of a run. Dropping them ends the controller first and the link last.
struct Parts<'a> {
    controller: EndPart<'a>,
    plant: EndPart<'a>,
    /// `None` on loopback.
    link: Option<Box<dyn Running + 'a>>,
    /// While the machine is kept busy.
    load: Option<Busywork>,
    /// When it was, from and to.
    loads_ns: Vec<[u64; 2]>,
}

impl<'a> Parts<'a> {
    /// Starts the ends beside the link, which has been started.
    fn start(
        site: &'a dyn Site,
        cell: &Cell,
        texts: Texts<'_>,
        epoch: Epoch,
        link: Option<Box<dyn Running + 'a>>,
    ) -> Result<Parts<'a>, RunError> {
        let address = site.plant_socket();
        let start_ns = epoch.t_ns(plan::START_AT);
        let start = |end, role| EndPart::start(site, end, role, texts.end_faults, start_ns);
        let role = PlantRole::of(cell, address, start_ns, texts);
        let plant = start(End::Plant, RoleSettings::Plant(role))?;
        let role = ControllerRole::of(cell, address, start_ns, texts);
        let controller = start(End::Controller, RoleSettings::Controller(role))?;
        let parts = Parts {
            controller,
            plant,
            link,
            load: None,
            loads_ns: Vec::new(),
        };
        let is_loaded = |fault: &EndFault| matches!(fault.effect, EndEffect::Busy(_));
        if texts.end_faults.iter().any(is_loaded) && !parts.are_beneath() {
            return Err(RunError::Unsupported(
                "the fault keeps this machine busy, and agents started the ends, who knows where: use --backend netns"
                    .to_owned(),
            ));
        }
        Ok(parts)
    }

    /// Waits until the controller ends by itself, checks that the other parts live, and handles
    /// `events`.
    fn await_controller(
        &mut self,
        site: &'a dyn Site,
        events: &mut Events,
        shares: &mut Shares,
        stop: &AtomicBool,
    ) -> Result<(), RunError> {
        loop {
            if self.controller.ended()? {
                // A load of the whole loop is over with it.
                self.unload(site);
                return Ok(());
            }
            if stop.load(Ordering::Relaxed) {
                self.controller.terminate();
                return Err(RunError::Interrupted);
            }
            let link = self.link.as_mut();
            if self.plant.ended()? || link.map_or(Ok(false), |link| link.ended())? {
                return Err(RunError::Ended);
            }
            while let Some(event) = events.next(site.now_ns()) {
                match event {
                    Event::CountProcessors => shares.count(site.now_ns()),
                    Event::Kill(end) => self.end(end).kill(site)?,
                    Event::StartAgain(end) => self.end(end).start_again(site)?,
                    Event::Load(programs) => {
                        self.loads_ns.push([site.now_ns(), u64::MAX]);
                        self.load = Some(Busywork::start(programs));
                    }
                    Event::Unload => self.unload(site),
                    Event::GiveUp => {
                        return Err(RunError::role(
                            "controller",
                            "did not end after its duration and time-out",
                        ));
                    }
                }
            }
            site.sleep(events.wait(site.now_ns()));
        }
    }

    /// Lets the machine rest again.
    fn unload(&mut self, site: &dyn Site) {
        if self.load.take().is_some()
            && let Some([_, to_ns]) = self.loads_ns.last_mut()
        {
            *to_ns = site.now_ns();
        }
    }

    /// Whether both ends descend from this process.
    fn are_beneath(&self) -> bool {
        self.plant.is_beneath() && self.controller.is_beneath()
    }

    /// What was observed of each part.
    fn seen(&self) -> Result<[PartSeen; 3], RunError> {
        let link = self.link.as_ref().map(|link| link.seen()).transpose()?;
        Ok([
            PartSeen::of_end(&self.plant)?,
            PartSeen::of_end(&self.controller)?,
            PartSeen::of_player(link.unwrap_or_default()),
        ])
    }

    /// What faults did to the ends, by what was `seen` of the parts.
    fn done(&self, seen: &[PartSeen]) -> Result<Vec<EndFaultDone>, RunError> {
        let mut done = Vec::new();
        for part in [&self.plant, &self.controller] {
            let own = seen.iter().find(|seen| seen.end == Some(part.end));
            let own = own.map(|seen| part.done(&seen.seen, &self.loads_ns));
            done.extend(own.transpose()?.unwrap_or_default());
        }
        done.sort_by_key(|one| one.from_ns);
        Ok(done)
    }

    fn end(&mut self, end: End) -> &mut EndPart<'a> {
        match end {
            End::Controller => &mut self.controller,
            End::Plant => &mut self.plant,
        }
    }

    /// Ends the parts, from the controller to the link.
    fn stop(self) -> Result<(), RunError> {
        self.controller.stop()?;
        self.plant.stop()?;
        self.link.map_or(Ok(()), Running::stop)
    }
}

fn joined<T>(thread: thread::ScopedJoinHandle<'_, Result<T, RunError>>) -> Result<T, RunError> {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

#[cfg(test)]
mod tests;
