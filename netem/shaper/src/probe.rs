//! Measures a link in both directions with ICMP echoes: when each left the controller's end,
//! reached the plant's, and was back.
//!
//! The plant's kernel answers. A second socket there stamps the requests as they arrive, and
//! all clocks are one, so each direction is measured by itself. Here are both halves in one
//! process; where the ends are two, [`Asker`] and [`Witness`] work apart. What the figures
//! should have been is the business of the [certificate](crate::certify).

use std::net::Ipv4Addr;
use std::sync::atomic::AtomicBool;
use std::thread;

use serde::{Deserialize, Serialize};

use crate::asker::Asker;
use crate::error::{Doing, Result};
use crate::namespace::Namespace;
use crate::scheduling::prefer_this_thread;
use crate::witness::Witness;

/// Just ahead of the player: a probe that is held up between reading the clock and sending
/// would measure itself. It does next to nothing, so it takes nothing from anyone.
const PRIORITY: u8 = 49;

/// The longest sleep, so that a request to stop is seen soon.
pub(crate) const LONGEST_SLEEP_NS: u64 = 50_000_000;

/// Which echoes to send, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProbePlan {
    /// Whom to ask: [`PLANT_ADDRESS`](crate::PLANT_ADDRESS), or 127.0.0.1 where there is no
    /// link.
    pub target: Ipv4Addr,
    /// When the first leaves, monotonic. An instant in the past means now.
    pub start_ns: u64,
    /// The time from one to the next.
    pub interval_ns: u64,
    /// How many.
    pub count: u32,
    /// Where it is given, each leaves at an instant of its interval that is drawn by it, so that
    /// nothing that keeps a period can pass between them. Without it they leave at its beginning.
    pub seed: Option<u64>,
    /// How long after the last one answers are waited for. More than the link's longest
    /// round trip, or late answers pass for lost ones.
    pub grace_ns: u64,
    /// Tells probes apart: one that runs at the same time, or that ran before and may still
    /// have answers under way, needs another id.
    pub id: u16,
}

impl ProbePlan {
    /// When echo `seq` leaves, in a series that begins at `start_ns`; later than the one before.
    #[must_use]
    pub fn due_ns(&self, start_ns: u64, seq: u32) -> u64 {
        let begin_ns = start_ns.saturating_add(u64::from(seq).saturating_mul(self.interval_ns));
        let within_ns = self.seed.map_or(0, |draws| {
            link::within_ns(draws, self.id, seq, self.interval_ns)
        });
        begin_ns.saturating_add(within_ns)
    }
}

/// One echo and the times of its way, all monotonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Echo {
    /// Its number, from 0.
    pub seq: u32,
    /// When it was handed to the kernel.
    pub t_send_ns: u64,
    /// When the plant's kernel received it; `None` if it did not arrive.
    pub t_reach_ns: Option<u64>,
    /// When the controller's kernel received the answer; `None` if it did not arrive.
    pub t_back_ns: Option<u64>,
}

impl Echo {
    /// The round trip time, if there was an answer.
    #[must_use]
    pub fn rtt_ns(&self) -> Option<u64> {
        self.t_back_ns
            .map(|back| back.saturating_sub(self.t_send_ns))
    }
}

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

/// Runs a probe, or half of one, on a thread of its own, and waits for it.
pub(crate) fn on_a_thread<T: Send>(
    name: &str,
    probing: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    thread::scope(|scope| {
        thread::Builder::new()
            .name(name.into())
            .spawn_scoped(scope, || {
                prefer_this_thread(PRIORITY);
                probing()
            })
            .doing("start the thread that probes")?
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Opens a [`Prober`] and runs it to its end.
///
/// # Errors
/// As [`Prober::open`] and [`Prober::run`].
pub fn probe(plan: &ProbePlan, controller: &Namespace, plant: &Namespace) -> Result<Vec<Echo>> {
    Prober::open(controller, plant)?.run(plan, &AtomicBool::new(false), |_| {})
}
