//! Measures a link in both directions with ICMP echoes: when each left the controller's end, reached
//! the plant's end, and came back.
//!
//! The plant's kernel answers. A second socket there stamps the requests as they arrive. Both use one
//! clock, so each direction is measured separately. [`Prober`] has both halves in one process;
//! [`Asker`] and [`Witness`] work separately. The [certificate](link::certificate::certify) knows what the
//! times should be.

pub(crate) mod asker;
pub(crate) mod hearer;
pub(crate) mod icmp;
pub(crate) mod plan;
pub(crate) mod thread;
pub(crate) mod witness;

use std::sync::atomic::AtomicBool;

use link::certificate::Echo;

use crate::error::Result;
use crate::network::namespace::Namespace;
use crate::probe::asker::Asker;
use crate::probe::plan::ProbePlan;
use crate::probe::thread::on_a_thread;
use crate::probe::witness::Witness;

/// Both halves of a probe.
///
/// Their sockets stay in the namespaces in which they were opened, so any thread can run the probe.
#[derive(Debug)]
pub struct Prober {
    asker: Asker,
    witness: Witness,
}

impl Prober {
    /// Opens the sockets; without a link both namespaces are the same.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) if this process may not open raw sockets.
    pub fn open(controller: &Namespace, plant: &Namespace) -> Result<Self> {
        Ok(Self {
            asker: controller.run(Asker::open)?,
            witness: plant.run(Witness::open)?,
        })
    }

    /// Sends the echoes of `plan` at absolute instants, independently of slow answers, until all are
    /// done or `stop` is set. Calls `on_answer` with each echo when its answer comes; returns all
    /// echoes in order of sending.
    ///
    /// Runs on a thread of its own, for which it requests real-time scheduling, and waits for that thread.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) if a socket fails.
    pub fn run(
        &mut self,
        plan: &ProbePlan,
        stop: &AtomicBool,
        on_answer: impl FnMut(&Echo) + Send,
    ) -> Result<Vec<Echo>> {
        let Self { asker, witness } = self;
        on_a_thread("probe", || {
            asker.exchange(plan, Some(witness), stop, on_answer)
        })
    }
}

/// Opens a [`Prober`] and runs it to its end.
///
/// # Errors
/// Those of [`Prober::open`] and [`Prober::run`].
pub fn probe(plan: &ProbePlan, controller: &Namespace, plant: &Namespace) -> Result<Vec<Echo>> {
    Prober::open(controller, plant)?.run(plan, &AtomicBool::new(false), |_| {})
}
