//! The half of a probe at the controller: it sends echoes, each at its instant, and receives the
//! answers. It does not know when they reached the plant; the [witness](crate::Witness) there does.

use std::io;
use std::net::SocketAddrV4;
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicBool, Ordering};

use clock::now::{now_ns, timespec};
use link::certificate::Echo;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::SendFlags;

use crate::error::{Doing, Result};
use crate::probe::hearer::Hearer;
use crate::probe::icmp::{self, EchoId};
use crate::probe::plan::ProbePlan;
use crate::probe::thread::{LONGEST_SLEEP_NS, on_a_thread};
use crate::probe::witness::Witness;

/// A socket that sends requests and receives the answers.
///
/// It stays in the namespace in which it was opened, so any thread can run it.
#[derive(Debug)]
pub struct Asker {
    hearer: Hearer,
}

impl Asker {
    /// Opens the socket in the namespace of the calling thread.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) if this process may not open raw
    /// sockets.
    pub fn open() -> Result<Self> {
        Hearer::open(icmp::REPLY).map(|hearer| Self { hearer })
    }

    /// Sends the echoes of `plan` at absolute instants, independently of slow answers, until all are
    /// done or `stop` is set. Calls `on_answer` with each echo when its answer comes; returns all
    /// echoes in order of sending. The times at which they reached the plant are missing;
    /// [`merge`](link::certificate::merge) adds them.
    ///
    /// Runs on a thread of its own, for which it requests real-time scheduling, and waits for that thread.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) if the socket fails.
    pub fn run(
        &mut self,
        plan: &ProbePlan,
        stop: &AtomicBool,
        on_answer: impl FnMut(&Echo) + Send,
    ) -> Result<Vec<Echo>> {
        on_a_thread("probe", || self.exchange(plan, None, stop, on_answer))
    }

    /// The same on this thread, with the witness if it is in this process.
    pub(crate) fn exchange(
        &mut self,
        plan: &ProbePlan,
        mut witness: Option<&mut Witness>,
        stop: &AtomicBool,
        mut on_answer: impl FnMut(&Echo),
    ) -> Result<Vec<Echo>> {
        /// Room for a probe of usual length; for a longer one it grows.
        const CAPACITY: u32 = 1 << 16;
        let start_ns = plan.start_ns.max(now_ns());
        let due_ns = |seq: u32| plan.due_ns(start_ns, seq);
        let target = SocketAddrV4::new(plan.target, 0);
        let count = plan.count();
        let mut echoes: Vec<Echo> = Vec::with_capacity(count.min(CAPACITY) as usize);
        while !stop.load(Ordering::Relaxed) {
            let sent = echoes.len() as u32;
            if sent < count && now_ns() >= due_ns(sent) {
                echoes.push(self.send(plan.id, sent, &target)?);
            }
            if let Some(witness) = &mut witness {
                witness.drain(|sighting| {
                    if sighting.id == plan.id
                        && let Some(echo) = echoes.get_mut(sighting.seq as usize)
                    {
                        echo.t_reach_ns.get_or_insert(sighting.t_reach_ns);
                    }
                })?;
            }
            self.hearer.drain(|id, stamp_ns| {
                if id.probe == plan.id
                    && let Some(echo) = echoes.get_mut(id.seq as usize)
                    && echo.t_back_ns.is_none()
                {
                    echo.t_back_ns = Some(stamp_ns);
                    on_answer(echo);
                }
            })?;
            let sent = echoes.len() as u32;
            let is_missing = |seq: u32| echoes[seq as usize].t_back_ns.is_none();
            let wake_ns = match sent < count {
                true => due_ns(sent),
                false => match plan.end_ns(start_ns, is_missing) {
                    Some(end_ns) if end_ns > now_ns() => end_ns,
                    _ => break,
                },
            };
            let now = now_ns();
            let sleep_ns = wake_ns.saturating_sub(now).min(LONGEST_SLEEP_NS);
            self.wait(witness.as_deref(), sleep_ns)?;
        }
        Ok(echoes)
    }

    fn send(&self, probe: u16, seq: u32, target: &SocketAddrV4) -> Result<Echo> {
        let message = icmp::request(EchoId { probe, seq });
        // Read last before the system call, since the time of earlier steps does not belong to the link.
        let t_send_ns = now_ns();
        rustix::net::sendto(&self.hearer, &message, SendFlags::empty(), target)
            .doing_with(|| format!("send echo {seq}"))?;
        Ok(Echo {
            seq,
            t_send_ns,
            t_reach_ns: None,
            t_back_ns: None,
        })
    }

    fn wait(&self, witness: Option<&Witness>, sleep_ns: u64) -> Result<()> {
        if sleep_ns == 0 {
            return Ok(());
        }
        let own = self.hearer.as_fd();
        // Without a witness the same socket is polled twice, which does no harm.
        let mut sockets = [own, witness.map_or(own, AsFd::as_fd)]
            .map(|socket| PollFd::from_borrowed_fd(socket, PollFlags::IN));
        match poll(&mut sockets, Some(&timespec(sleep_ns))) {
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(io::Error::from(error)).doing("wait for echoes"),
        }
    }
}
