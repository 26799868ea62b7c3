//! The course of a run, the same at every site: what is started when, and what is waited for.
//!
//! It only runs the parts, and records how they looked meanwhile. `evidence` evaluates what echoes and
//! rows say about the link; the analysis later reads from the rows whether the loop survived.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use certificate::Echo;
use judge::{Pulse, Watched};
use link::{Epoch, Profile};
use plan::{Cell, Phase, ProfileText, Program};

use crate::link_check::{LinkCheck, NOTHING_ENTERED};
use crate::pulse::Pulses;
use crate::role::{ControllerRole, LinkRole, PlantRole, RoleSettings};
use crate::site::{Running, Site};
use crate::{RunError, schedule};

/// How often to check whether a part has ended or an event is due.
const POLL: Duration = Duration::from_millis(10);

/// How often to count who used the processors, ns.
const COUNT_EVERY_NS: usize = 250_000_000;

/// Something that happens at an instant known before the run. A fault that an experiment injects would
/// be one more variant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// Counts who used the processors.
    CountProcessors,
    /// Gives up on the controller: its duration, time-out and grace are over.
    GiveUp,
}

/// The events of a run, in order of their instants.
struct Events(VecDeque<(u64, Event)>);

impl Events {
    /// The events of a run of `cell` whose controller has its deadlines between `from_ns` and `to_ns`.
    fn of(cell: &Cell, from_ns: u64, to_ns: u64) -> Events {
        let give_up_ns = to_ns
            .saturating_add(cell.settings.timeout_ns)
            .saturating_add(schedule::ns(cell.client.spec().grace));
        let counts_ns = (from_ns..to_ns).step_by(COUNT_EVERY_NS);
        let counts = counts_ns.map(|t_ns| (t_ns, Event::CountProcessors));
        Events(counts.chain([(give_up_ns, Event::GiveUp)]).collect())
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
    /// When the controller's first message was due, monotonic.
    pub(crate) start_ns: u64,
    /// The echoes; those on the empty link come first.
    pub(crate) echoes: [(Phase, Vec<Echo>); 4],
    /// The pulse of the processors meanwhile; `None` in virtual time.
    pub(crate) pulse: Option<Pulse>,
    /// What was observed of each part while the controller ran, with the part's name.
    pub(crate) watched: Vec<(String, Watched)>,
}

/// What a cell's parts need from the plan beside the cell.
#[derive(Clone, Copy)]
pub(crate) struct Texts<'a> {
    /// The link's profile.
    pub(crate) profile: &'a ProfileText,
    /// The system; `None` for the paper's.
    pub(crate) system: Option<&'a str>,
    /// The controller, where it is a program of one's own.
    pub(crate) program: Option<&'a Program>,
    /// The plant, where it is a program of one's own.
    pub(crate) plant_program: Option<&'a Program>,
}

/// Runs a cell at `site`.
///
/// The calling thread starts the parts; those that are its child processes die with it.
pub(crate) fn run(
    site: &dyn Site,
    cell: &Cell,
    profile: &Profile,
    texts: Texts<'_>,
    stop: &AtomicBool,
) -> Result<Seen, RunError> {
    let lead_ns = site.lead_ns(cell.client.spec().start_time);
    let epoch = Epoch::at_ns(site.now_ns() + lead_ns);
    let start_ns = epoch.t_ns(plan::START_AT);
    let mut parts = Parts::start(site, cell, profile, texts, epoch)?;
    let link_check = LinkCheck {
        target: site.plant_address(),
        profile,
        seed: cell.link_seed,
        epoch,
        entered: &NOTHING_ENTERED,
    };
    let send = |series, stop: &AtomicBool| site.echoes(&link_check.plan(series), stop);
    let empty = send(schedule::empty(site.now_ns()), stop)?;
    if epoch.link_time(site.now_ns()).is_some() {
        return Err(RunError::Link(
            "this machine was too busy to measure the empty link before the run".into(),
        ));
    }
    let pulses = Pulses::start();
    let end_ns = start_ns + cell.duration_ns;
    let mut shares = Shares::new(start_ns, end_ns);
    let mut events = Events::of(cell, start_ns, end_ns);
    let abandon = AtomicBool::new(false);
    let echoes = thread::scope(|scope| {
        let before = scope.spawn(|| send(schedule::before(epoch), &abandon));
        let during = scope.spawn(|| send(schedule::during(start_ns, cell.duration_ns), &abandon));
        let ended = parts.await_controller(site, &mut events, &mut shares, stop);
        let after = ended.and_then(|()| send(schedule::after(site.now_ns()), stop));
        // Ctrl-C in a terminal also ends the controller, as if it had ended by itself.
        if after.is_err() || stop.load(Ordering::Relaxed) {
            abandon.store(true, Ordering::Relaxed);
        }
        let (before, during) = (joined(before), joined(during));
        // Return the cause first: the echoes were abandoned because of it.
        let after = after?;
        Ok::<_, RunError>([
            (Phase::Empty, empty),
            (Phase::Before, before?),
            (Phase::During, during?),
            (Phase::After, after),
        ])
    })?;
    let pulse = pulses.finish();
    let watched = shares.watched(&parts)?;
    parts.stop()?;
    Ok(Seen {
        epoch,
        start_ns,
        echoes,
        pulse: Some(pulse),
        watched,
    })
}

/// The started parts of a run. Dropping them ends the controller first and the link last.
struct Parts<'a> {
    controller: Box<dyn Running + 'a>,
    plant: Box<dyn Running + 'a>,
    /// `None` on loopback.
    link: Option<Box<dyn Running + 'a>>,
}

impl<'a> Parts<'a> {
    fn start(
        site: &'a dyn Site,
        cell: &Cell,
        profile: &Profile,
        texts: Texts<'_>,
        epoch: Epoch,
    ) -> Result<Parts<'a>, RunError> {
        let link = if profile.is_loopback() {
            None
        } else {
            let role = LinkRole::of(cell, texts.profile, epoch);
            Some(site.start(RoleSettings::Link(role))?)
        };
        let address = site.plant_socket();
        let start_ns = epoch.t_ns(plan::START_AT);
        let role = PlantRole::of(cell, address, start_ns, texts);
        let plant = site.start(RoleSettings::Plant(role))?;
        let role = ControllerRole::of(cell, address, start_ns, texts);
        let controller = site.start(RoleSettings::Controller(role))?;
        Ok(Parts {
            controller,
            plant,
            link,
        })
    }

    /// Waits until the controller ends by itself, checks that the other parts live, and handles
    /// `events`.
    fn await_controller(
        &mut self,
        site: &dyn Site,
        events: &mut Events,
        shares: &mut Shares,
        stop: &AtomicBool,
    ) -> Result<(), RunError> {
        while !self.controller.ended()? {
            if stop.load(Ordering::Relaxed) {
                self.controller.terminate();
                return Err(RunError::Interrupted);
            }
            let link = self.link.as_mut();
            if self.plant.ended()? || link.map_or(Ok(false), |link| link.ended())? {
                return Err(RunError::Link(
                    "the plant or the link ended before the controller".into(),
                ));
            }
            while let Some(event) = events.next(site.now_ns()) {
                match event {
                    Event::CountProcessors => shares.count(site.now_ns()),
                    Event::GiveUp => {
                        return Err(RunError::role(
                            "controller",
                            "did not end after its duration and time-out",
                        ));
                    }
                }
            }
            site.sleep(POLL);
        }
        Ok(())
    }

    /// The parts by their names in a manifest, which calls the link `player`.
    fn by_name(&self) -> [(&'static str, Option<&(dyn Running + 'a)>); 3] {
        [
            ("plant", Some(&*self.plant)),
            ("controller", Some(&*self.controller)),
            ("player", self.link.as_deref()),
        ]
    }

    /// Ends the parts, from the controller to the link.
    fn stop(self) -> Result<(), RunError> {
        self.controller.stop()?;
        self.plant.stop()?;
        self.link.map_or(Ok(()), Running::stop)
    }
}

/// Who used the processors while the controller ran.
struct Shares {
    from_ns: u64,
    to_ns: u64,
    /// The first count and the last: when it was made, how long all processors had been busy, and how
    /// long this process and its descendants had run, in ns.
    taken: Option<[[u64; 3]; 2]>,
}

impl Shares {
    fn new(from_ns: u64, to_ns: u64) -> Shares {
        Shares {
            from_ns,
            to_ns,
            taken: None,
        }
    }

    fn count(&mut self, now_ns: u64) {
        let taken = [now_ns, agent::busy_ns(), agent::own_strain().ran_ns];
        let [first, _] = self.taken.unwrap_or([taken; 2]);
        self.taken = Some([first, taken]);
    }

    /// What was observed of each part meanwhile. For a controller that descends from this process, and
    /// may be a browser, this includes how long it waited while others had the processors. Elsewhere,
    /// those others cannot be told from the other parts of the run.
    fn watched(&self, parts: &Parts<'_>) -> Result<Vec<(String, Watched)>, RunError> {
        let mut found = Vec::new();
        for (name, part) in parts.by_name() {
            let seen = part.map(Running::seen).transpose()?.unwrap_or_default();
            let mut stops = seen.stops_within(self.from_ns, self.to_ns).peekable();
            let mut watched = Watched {
                looks: seen.looks_within(self.from_ns, self.to_ns),
                stopped_at_ns: stops.peek().copied().unwrap_or_default(),
                stopped: stops.count() as u64,
                ..Watched::default()
            };
            if name == "controller"
                && part.is_some_and(Running::is_beneath)
                && let Some(strain) = seen.strain_within(self.from_ns, self.to_ns)
            {
                watched.ran_ms = strain.ran_ns as f64 * 1e-6;
                watched.waited_ms = strain.waited_ns as f64 * 1e-6;
                watched.others = self.others();
            }
            found.push((name.to_owned(), watched));
        }
        Ok(found)
    }

    /// Share of the time of all processors, 0 to 1, that went to processes other than this one and its
    /// descendants; 0 if it was not counted.
    fn others(&self) -> f64 {
        let Some(
            [
                [first_ns, busy_first, own_first],
                [last_ns, busy_last, own_last],
            ],
        ) = self.taken
        else {
            return 0.0;
        };
        let processors = thread::available_parallelism().map_or(1, usize::from) as f64;
        let all_ns = last_ns.saturating_sub(first_ns) as f64 * processors;
        let own_ns = own_last.saturating_sub(own_first) as f64;
        let others_ns = busy_last.saturating_sub(busy_first) as f64 - own_ns;
        (others_ns / all_ns.max(1.0)).max(0.0)
    }
}

fn joined<T>(thread: thread::ScopedJoinHandle<'_, Result<T, RunError>>) -> Result<T, RunError> {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

#[cfg(test)]
mod tests;
