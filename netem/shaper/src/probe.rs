//! Measures a link in both directions with ICMP echoes: when each left the controller's end,
//! reached the plant's, and was back.
//!
//! The plant's kernel answers. A second socket there stamps the requests as they arrive, and
//! all clocks are one, so each direction is measured by itself. Here are both halves in one
//! process; where the ends are two, [`Asker`] and [`Witness`] work apart. What the figures
//! should have been is the business of the [certificate](certificate::certify).

pub(crate) mod asker;
pub(crate) mod hearer;
pub(crate) mod icmp;
pub(crate) mod plan;
pub(crate) mod thread;
pub(crate) mod witness;

use std::sync::atomic::AtomicBool;

use certificate::Echo;

use crate::error::Result;
use crate::network::namespace::Namespace;
use crate::probe::asker::Asker;
use crate::probe::plan::ProbePlan;
use crate::probe::thread::on_a_thread;
use crate::probe::witness::Witness;

/// Both halves of a probe.
///
/// Their sockets stay in the namespaces that they were opened in, so any thread can run the
/// probe.
#[derive(Debug)]
pub struct Prober {
    asker: Asker,
    witness: Witness,
}

impl Prober {
    /// Opens the sockets; where there is no link, both namespaces are the same.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) if this process may not open raw
    /// sockets.
    pub fn open(controller: &Namespace, plant: &Namespace) -> Result<Self> {
        Ok(Self {
            asker: controller.run(Asker::open)?,
            witness: plant.run(Witness::open)?,
        })
    }

    /// Sends the echoes of `plan` at absolute instants that no slow answer moves, until all
    /// are through or `stop` is set. `on_answer` gets each echo as its answer comes; all of
    /// them are returned, in the order of sending.
    ///
    /// It does so on a thread of its own, for which it asks real-time scheduling, and waits
    /// for that.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) when a socket fails.
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
/// As [`Prober::open`] and [`Prober::run`].
pub fn probe(plan: &ProbePlan, controller: &Namespace, plant: &Namespace) -> Result<Vec<Echo>> {
    Prober::open(controller, plant)?.run(plan, &AtomicBool::new(false), |_| {})
}
