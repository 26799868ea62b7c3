//! Measures a link in both directions with ICMP echoes: when each left the controller's end,
//! reached the plant's, and was back.
//!
//! The plant's kernel answers. A second socket there stamps the requests as they arrive, and
//! all clocks are one, so each direction is measured by itself. What the figures should have
//! been is the business of the [certificate](crate::certify).

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{AddressFamily, SendFlags, SocketFlags, SocketType, ipproto};
use serde::{Deserialize, Serialize};

use crate::clock::{StampClock, now_ns, timespec};
use crate::error::{Doing, Error, Result};
use crate::icmp::{self, EchoId};
use crate::namespace::Namespace;
use crate::port::widen;
use crate::scheduling::prefer_this_thread;
use crate::sys;

/// Just ahead of the player: a probe that is held up between reading the clock and sending
/// would measure itself. It does next to nothing, so it takes nothing from anyone.
const PRIORITY: u8 = 49;

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
    /// How long after the last one answers are waited for. More than the link's longest
    /// round trip, or late answers pass for lost ones.
    pub grace_ns: u64,
    /// Tells probes apart: one that runs at the same time, or that ran before and may still
    /// have answers under way, needs another id.
    pub id: u16,
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

/// The sockets of a probe, one at each end.
///
/// They stay in the namespaces that they were opened in, so any thread can run the probe.
#[derive(Debug)]
pub struct Prober {
    /// Sends requests and hears replies.
    controller: Hearer,
    /// Hears requests.
    plant: Hearer,
}

impl Prober {
    /// Opens the sockets; where there is no link, both namespaces are the same.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if this process may not open raw sockets.
    pub fn open(controller: &Namespace, plant: &Namespace) -> Result<Self> {
        Ok(Self {
            controller: controller.run(|| Hearer::open(icmp::REPLY))?,
            plant: plant.run(|| Hearer::open(icmp::REQUEST))?,
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
    /// [`Error::Failed`] when a socket fails.
    pub fn run(
        &mut self,
        plan: &ProbePlan,
        stop: &AtomicBool,
        on_answer: impl FnMut(&Echo) + Send,
    ) -> Result<Vec<Echo>> {
        thread::scope(|scope| {
            let probing = || {
                prefer_this_thread(PRIORITY);
                self.exchange(plan, stop, on_answer)
            };
            thread::Builder::new()
                .name("probe".into())
                .spawn_scoped(scope, probing)
                .doing("start the thread that probes")?
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }

    fn exchange(
        &mut self,
        plan: &ProbePlan,
        stop: &AtomicBool,
        mut on_answer: impl FnMut(&Echo),
    ) -> Result<Vec<Echo>> {
        /// Room for a probe of usual length; a longer one makes it grow.
        const CAPACITY: u32 = 1 << 16;
        /// The longest sleep, so that a request to stop is seen soon.
        const LONGEST_SLEEP_NS: u64 = 50_000_000;
        let start_ns = plan.start_ns.max(now_ns());
        let due_ns =
            |seq: u32| start_ns.saturating_add(u64::from(seq).saturating_mul(plan.interval_ns));
        let end_ns = due_ns(plan.count.saturating_sub(1)).saturating_add(plan.grace_ns);
        let target = SocketAddrV4::new(plan.target, 0);
        let mut echoes = Vec::with_capacity(plan.count.min(CAPACITY) as usize);
        let mut answered = 0;
        while !stop.load(Ordering::Relaxed) {
            let now = now_ns();
            let sent = echoes.len() as u32;
            let all_sent = sent == plan.count;
            if all_sent && (answered == plan.count || now >= end_ns) {
                break;
            }
            if !all_sent && now >= due_ns(sent) {
                echoes.push(self.send(plan.id, sent, &target)?);
            }
            self.plant.drain(plan.id, |seq, stamp_ns| {
                if let Some(echo) = echoes.get_mut(seq as usize) {
                    echo.t_reach_ns.get_or_insert(stamp_ns);
                }
            })?;
            self.controller.drain(plan.id, |seq, stamp_ns| {
                if let Some(echo) = echoes.get_mut(seq as usize)
                    && echo.t_back_ns.is_none()
                {
                    echo.t_back_ns = Some(stamp_ns);
                    answered += 1;
                    on_answer(echo);
                }
            })?;
            let sent = echoes.len() as u32;
            let wake_ns = if sent < plan.count {
                due_ns(sent)
            } else {
                end_ns
            };
            let sleep_ns = wake_ns.saturating_sub(now_ns()).min(LONGEST_SLEEP_NS);
            self.wait(sleep_ns)?;
        }
        Ok(echoes)
    }

    fn send(&self, probe: u16, seq: u32, target: &SocketAddrV4) -> Result<Echo> {
        let message = icmp::request(EchoId { probe, seq });
        // The last thing before the system call: what is done earlier is not the link's.
        let t_send_ns = now_ns();
        rustix::net::sendto(
            &self.controller.socket,
            &message,
            SendFlags::empty(),
            target,
        )
        .doing(format!("send echo {seq}"))?;
        Ok(Echo {
            seq,
            t_send_ns,
            t_reach_ns: None,
            t_back_ns: None,
        })
    }

    fn wait(&self, sleep_ns: u64) -> Result<()> {
        if sleep_ns == 0 {
            return Ok(());
        }
        let mut sockets = [&self.controller, &self.plant]
            .map(|hearer| PollFd::from_borrowed_fd(hearer.socket.as_fd(), PollFlags::IN));
        match poll(&mut sockets, Some(&timespec(sleep_ns))) {
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(io::Error::from(error)).doing("wait for echoes"),
        }
    }
}

/// Opens a [`Prober`] and runs it to its end.
///
/// # Errors
/// As [`Prober::open`] and [`Prober::run`].
pub fn probe(plan: &ProbePlan, controller: &Namespace, plant: &Namespace) -> Result<Vec<Echo>> {
    Prober::open(controller, plant)?.run(plan, &AtomicBool::new(false), |_| {})
}

/// A raw ICMP socket that hears one type of message, with kernel receive stamps.
#[derive(Debug)]
struct Hearer {
    socket: OwnedFd,
    icmp_type: u8,
    stamps: StampClock,
}

impl Hearer {
    fn open(icmp_type: u8) -> Result<Self> {
        let socket = rustix::net::socket_with(
            AddressFamily::INET,
            SocketType::RAW,
            SocketFlags::CLOEXEC,
            Some(ipproto::ICMP),
        )
        .map_err(|source| Error::Unsupported {
            action: "open a raw ICMP socket",
            remedy: "probing needs CAP_NET_RAW in the ends' namespaces: run webloop as root, or \
                     let it make a user namespace; in a container, --cap-add NET_RAW",
            source: source.into(),
        })?;
        widen(&socket);
        sys::hear_only_icmp(&socket, icmp_type)
            .and_then(|()| sys::stamp_received(&socket))
            .doing("prepare a raw ICMP socket")?;
        Ok(Self {
            socket,
            icmp_type,
            stamps: StampClock::new(),
        })
    }

    /// Takes all that has come and tells number and time of each echo of this probe.
    fn drain(&mut self, probe: u16, mut heard: impl FnMut(u32, u64)) -> Result<()> {
        let mut packet = [0; 256];
        while let Some(received) =
            sys::receive(&self.socket, &mut packet).doing("receive an echo")?
        {
            let bytes = &packet[..received.len.min(packet.len())];
            if let Some(id) = icmp::parse(bytes, self.icmp_type)
                && id.probe == probe
            {
                let stamp_ns = received
                    .stamp_ns
                    .map_or_else(now_ns, |stamp| self.stamps.monotonic_ns(stamp));
                heard(id.seq, stamp_ns);
            }
        }
        Ok(())
    }
}
