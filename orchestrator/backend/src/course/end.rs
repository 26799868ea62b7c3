//! An end of a run's loop as the course handles it: a fault may let it stand still, or kill it and start it again.
//!
//! It is told its stops when it starts, and the agent or thread that started it keeps them by itself; kills are
//! events of the course. What was asked is in the plan, and what it means for the verdict in `judge`.

use plan::{End, EndEffect, EndFault, EndFaultDone};
use process::Stop;

use crate::error::RunError;
use crate::role::RoleSettings;
use crate::site::{Running, Site};

/// The plant or the controller. Dropping it ends it.
pub(super) struct EndPart<'a> {
    pub(super) end: End,
    settings: RoleSettings,
    faults: Vec<EndFault>,
    /// The loop's start, from which the faults' times count.
    start_ns: u64,
    /// `None` while it is killed.
    running: Option<Box<dyn Running + 'a>>,
    /// What was seen of it before it was killed.
    earlier: process::Seen,
    /// When it was killed, and ready again.
    kills_ns: Vec<[u64; 2]>,
}

impl<'a> EndPart<'a> {
    /// Starts an end. Those of `faults` that hit it will happen, but for kills.
    pub(super) fn start(
        site: &'a dyn Site,
        end: End,
        settings: RoleSettings,
        faults: &[EndFault],
        start_ns: u64,
    ) -> Result<EndPart<'a>, RunError> {
        let own = faults.iter().filter(|fault| fault.end == end);
        let mut part = EndPart {
            end,
            running: Some(site.start(settings.clone())?),
            settings,
            faults: own.cloned().collect(),
            start_ns,
            earlier: process::Seen::default(),
            kills_ns: Vec::new(),
        };
        part.tell_stops(site)?;
        Ok(part)
    }

    /// Tells it the stops that are still to come.
    fn tell_stops(&mut self, site: &dyn Site) -> Result<(), RunError> {
        let now_ns = site.now_ns();
        let stops = self.faults.iter().flat_map(|one| one.stops(self.start_ns));
        let stops = stops.filter(|stop| stop.start > now_ns);
        let stops: Vec<Stop> = stops.map(|stop| [stop.start, stop.end]).collect();
        match &mut self.running {
            Some(running) if !stops.is_empty() => running.freeze(stops),
            _ => Ok(()),
        }
    }

    /// Kills it.
    pub(super) fn kill(&mut self, site: &dyn Site) -> Result<(), RunError> {
        if let Some(running) = self.running.take() {
            self.kills_ns.push([site.now_ns(), u64::MAX]);
            let seen = running.kill()?;
            self.earlier = std::mem::take(&mut self.earlier).then(seen);
        }
        Ok(())
    }

    /// Starts it again where it was killed, and returns when it is ready.
    pub(super) fn start_again(&mut self, site: &'a dyn Site) -> Result<(), RunError> {
        self.running = Some(site.start(self.settings.clone().again())?);
        if let Some([_, ready_ns]) = self.kills_ns.last_mut() {
            *ready_ns = site.now_ns();
        }
        self.tell_stops(site)
    }

    /// Whether it has ended by itself.
    pub(super) fn ended(&mut self) -> Result<bool, RunError> {
        self.running
            .as_mut()
            .map_or(Ok(false), |running| running.ended())
    }

    pub(super) fn terminate(&mut self) {
        if let Some(running) = &mut self.running {
            running.terminate();
        }
    }

    pub(super) fn stop(self) -> Result<(), RunError> {
        self.running.map_or(Ok(()), Running::stop)
    }

    pub(super) fn is_beneath(&self) -> bool {
        self.running
            .as_ref()
            .is_some_and(|running| running.is_beneath())
    }

    /// What was observed of it since its first start.
    pub(super) fn seen(&self) -> Result<process::Seen, RunError> {
        let seen = self
            .running
            .as_ref()
            .map(|running| running.seen())
            .transpose()?;
        Ok(self.earlier.clone().then(seen.unwrap_or_default()))
    }

    /// What was done to it, by what was `seen` of it, and when its machine was busy.
    ///
    /// # Errors
    /// If something that was asked for was not done.
    pub(super) fn done(
        &self,
        seen: &process::Seen,
        loads_ns: &[[u64; 2]],
    ) -> Result<Vec<EndFaultDone>, RunError> {
        let (mut kills, mut loads) = (self.kills_ns.iter(), loads_ns.iter());
        let done = self.faults.iter().map(|fault| {
            let [from_ns, to_ns] = [fault.from_ns, fault.to_ns].map(|ns| self.start_ns + ns);
            let stops: Vec<Stop> = match fault.effect {
                EndEffect::Kill => kills.next().into_iter().copied().collect(),
                EndEffect::Busy(_) => loads.next().into_iter().copied().collect(),
                EndEffect::Freeze | EndEffect::Starve(_) => {
                    let stops = seen.frozen_ns.iter().copied();
                    stops
                        .filter(|[begun_ns, _]| (from_ns..to_ns).contains(begun_ns))
                        .collect()
                }
            };
            let not_done = || {
                let s = fault.from_ns as f64 / 1e9;
                RunError::role(
                    &self.end.to_string(),
                    format!("was to be hit by a fault at {s} s, which was not done"),
                )
            };
            let (Some([begun_ns, _]), Some([_, over_ns])) = (stops.first(), stops.last()) else {
                return Err(not_done());
            };
            if *over_ns == u64::MAX {
                return Err(not_done());
            }
            Ok(EndFaultDone {
                end: fault.end,
                effect: fault.effect,
                asked_from_ns: from_ns,
                asked_to_ns: to_ns,
                from_ns: *begun_ns,
                to_ns: *over_ns,
                stood_ns: stops.iter().map(|[from_ns, to_ns]| to_ns - from_ns).sum(),
            })
        });
        done.collect()
    }
}
