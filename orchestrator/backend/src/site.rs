//! Where the parts of a run live: what a back-end has to provide.
//!
//! The order of a run is the same everywhere, and is in `course`. A site starts parts and sends echoes;
//! it knows nothing about cells, times or verdicts.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use link::certificate::Echo;
use process::{Seen, Stop};
use shaper::ProbePlan;

use crate::error::RunError;
use crate::role::RoleSettings;

/// Port of the plant. Any port would do, since only one run uses the link's addresses.
pub(crate) const PLANT_PORT: u16 = 8080;

/// Where a run happens.
pub(crate) trait Site: Sync {
    /// Time from now until the link opens, ns: usually enough to start the parts, of which the client takes
    /// `start_time` on this machine, and to measure the empty link.
    fn lead_ns(&self, start_time: Duration) -> u64;

    /// Starts a role of webloop, and returns when it can be used. Start the link first: without it the
    /// plant may have no address.
    ///
    /// # Errors
    /// Why it cannot be used; nothing is left running then.
    fn start<'a>(&'a self, role: RoleSettings) -> Result<Box<dyn Running + 'a>, RunError>;

    /// The plant's address on the link, once the link has been started.
    fn plant_address(&self) -> Ipv4Addr;

    /// Sends a series of echoes from the controller's end, and waits for those that the link lets come
    /// back.
    ///
    /// # Errors
    /// If they cannot be sent; a lost echo is no error.
    fn echoes(&self, plan: &ProbePlan, stop: &AtomicBool) -> Result<Vec<Echo>, RunError>;

    /// The clock of everything that a run records, ns: `CLOCK_MONOTONIC`, unless the site is made up by
    /// a test.
    fn now_ns(&self) -> u64 {
        clock::now::now_ns()
    }

    /// Waits.
    fn sleep(&self, duration: Duration) {
        std::thread::sleep(duration);
    }

    /// Where the plant listens.
    fn plant_socket(&self) -> SocketAddr {
        SocketAddr::from((self.plant_address(), PLANT_PORT))
    }
}

/// A part that has been started. Dropping it ends it; the rows are kept, even if the run is given up.
pub(crate) trait Running {
    /// Whether it has ended.
    ///
    /// # Errors
    /// How it ended, if it failed.
    fn ended(&mut self) -> Result<bool, RunError>;

    /// What was observed of it from outside since it was started.
    ///
    /// # Errors
    /// If the agent that started it does not say.
    fn seen(&self) -> Result<Seen, RunError>;

    /// Whether it descends from this process.
    fn is_beneath(&self) -> bool;

    /// Will let it stand still at these times, which are in order, monotonic; [`Seen::frozen_ns`] says when it did.
    ///
    /// # Errors
    /// If the agent that started it cannot be told.
    fn freeze(&mut self, stops: Vec<Stop>) -> Result<(), RunError>;

    /// Kills it, and returns what was observed of it.
    ///
    /// # Errors
    /// If the agent that started it cannot be told.
    fn kill(self: Box<Self>) -> Result<Seen, RunError>;

    /// Asks it to end, without waiting.
    fn terminate(&mut self);

    /// Asks it to end, and waits until its rows are on disk.
    ///
    /// # Errors
    /// How it ended, if it failed.
    fn stop(self: Box<Self>) -> Result<(), RunError>;
}

/// Several parts as one, which has ended when one of them has.
impl<R: Running> Running for Vec<R> {
    fn ended(&mut self) -> Result<bool, RunError> {
        for part in self {
            if part.ended()? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What was observed of the part that was stopped most often.
    fn seen(&self) -> Result<Seen, RunError> {
        let all: Vec<Seen> = self.iter().map(R::seen).collect::<Result<_, _>>()?;
        let most = all.into_iter().max_by_key(|seen| seen.stops_ns.len());
        Ok(most.unwrap_or_default())
    }

    fn is_beneath(&self) -> bool {
        self.iter().all(R::is_beneath)
    }

    fn freeze(&mut self, stops: Vec<Stop>) -> Result<(), RunError> {
        self.iter_mut()
            .try_for_each(|part| part.freeze(stops.clone()))
    }

    fn kill(self: Box<Self>) -> Result<Seen, RunError> {
        let seen = self.into_iter().map(|part| Box::new(part).kill());
        seen.reduce(Result::and)
            .unwrap_or_else(|| Ok(Seen::default()))
    }

    fn terminate(&mut self) {
        for part in self {
            part.terminate();
        }
    }

    fn stop(self: Box<Self>) -> Result<(), RunError> {
        self.into_iter()
            .map(|part| Box::new(part).stop())
            .fold(Ok(()), Result::and)
    }
}
