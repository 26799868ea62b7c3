//! Where the parts of a run live: all that a back-end is.
//!
//! The order of a run is the same everywhere, and is in `course`. A site starts parts and sends
//! echoes; it knows nothing of cells, times or verdicts.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use agent::Seen;
use certificate::Echo;
use shaper::ProbePlan;

use crate::RunError;
use crate::role::RoleSettings;

/// Port of the plant; the link's addresses are a run's alone, so any would do.
pub(crate) const PLANT_PORT: u16 = 8080;

/// Where a run happens.
pub(crate) trait Site: Sync {
    /// From now to the link's epoch: time to start the parts, of which the client takes
    /// `start_time` on this machine, and to measure the empty link.
    fn lead_ns(&self, start_time: Duration) -> u64;

    /// Starts a role of webloop, and returns when it can be used. The link goes first: without it the
    /// plant may have no address.
    ///
    /// # Errors
    /// What keeps it from being used; nothing is left running then.
    fn start<'a>(&'a self, role: RoleSettings) -> Result<Box<dyn Running + 'a>, RunError>;

    /// The plant's address on the link, once that has been started.
    fn plant_address(&self) -> Ipv4Addr;

    /// Sends a series of echoes from the controller's end, and waits for what the link lets
    /// come back.
    ///
    /// # Errors
    /// When they cannot be sent; not when they are lost.
    fn echoes(&self, plan: &ProbePlan, stop: &AtomicBool) -> Result<Vec<Echo>, RunError>;

    /// The clock of all that a run records: `CLOCK_MONOTONIC`, unless the site is made up.
    fn now_ns(&self) -> u64 {
        shaper::now_ns()
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

/// A part that has been started. Dropping it ends it: of a run that is given up, too, the rows
/// are kept.
pub(crate) trait Running {
    /// Whether it has ended, and if so whether well.
    ///
    /// # Errors
    /// How it ended, if not well.
    fn ended(&mut self) -> Result<bool, RunError>;

    /// What it has looked like from outside since it was started.
    ///
    /// # Errors
    /// When who started it does not say.
    fn seen(&self) -> Result<Seen, RunError>;

    /// Whether it runs beneath this process.
    fn is_beneath(&self) -> bool;

    /// Asks it to end, and does not wait.
    fn terminate(&mut self);

    /// Asks it to end, and waits until its rows are on disk.
    ///
    /// # Errors
    /// How it ended, if not well.
    fn stop(self: Box<Self>) -> Result<(), RunError>;
}

/// Several as one: it has ended when one has.
impl<R: Running> Running for Vec<R> {
    fn ended(&mut self) -> Result<bool, RunError> {
        for part in self {
            if part.ended()? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Of the one that was stopped most.
    fn seen(&self) -> Result<Seen, RunError> {
        let all: Vec<Seen> = self.iter().map(R::seen).collect::<Result<_, _>>()?;
        let most = all.into_iter().max_by_key(|seen| seen.stops_ns.len());
        Ok(most.unwrap_or_default())
    }

    fn is_beneath(&self) -> bool {
        self.iter().all(R::is_beneath)
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
