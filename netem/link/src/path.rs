//! One direction of a link as it is played.
//!
//! A packet passes, in this order, the bottleneck (rate and queue), loss, the gate (it waits while
//! the link is stalled), and the wire (delay and order). Faults have a part in loss and wire, and may
//! twist the packet at the end. All but the bottleneck are functions of time and seed alone, evaluated at the instant when the packet leaves the bottleneck. In this module and
//! in its parts every instant in `_ns` is a link time.

use crate::bottleneck::Bottleneck;
use crate::draws::Draws;
use crate::fault::{Faults, Twist};
use crate::load::Load;
use crate::loss::LossProcess;
use crate::piece::{Stay, Stretch};
use crate::profile::{Delay, Loss, Order, PathLaw, Rate};
use crate::spells::{Spell, Spells};
use crate::time::LinkTime;
use crate::way::Way;
use crate::wire::Wire;

/// How far a query may lie behind the newest one and still be answered exactly.
const KEEP_NS: u64 = 10_000_000_000;

/// How often what lies farther back is forgotten.
const FORGET_EVERY_NS: u64 = 1_000_000_000;

/// What happens to a packet, in the caller's time: [`LinkTime`] or monotonic ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate<At> {
    /// It leaves the link.
    Deliver {
        /// When it leaves.
        at: At,
        /// What faults do to it.
        twist: Twist,
    },
    /// It is lost.
    Drop(Cause),
}

impl<At> Fate<At> {
    /// When the packet arrives as it was sent; `None` if it is lost or damaged.
    #[must_use]
    pub fn arrives(self) -> Option<At> {
        match self {
            Self::Deliver { at, twist } if twist.flip.is_none() => Some(at),
            Self::Deliver { .. } | Self::Drop(_) => None,
        }
    }
}

/// Why a packet is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The link loses packets at that instant.
    Loss,
    /// The queue in front of the rate limit is full.
    Overflow,
}

/// A path's state at an instant, regardless of traffic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// One-way delay of a packet that enters now, in ns.
    pub delay_ns: u64,
    /// Whether a packet that enters now is lost, or damaged so that its receiver discards it.
    pub lost: bool,
    /// Rate limit in bit/s, if there is one.
    pub rate_bps: Option<u64>,
}

/// What a packet that enters at an instant meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Passage {
    /// Its delay, in ns, including the time in the queue and for sending, as far as they are known.
    pub delay_ns: u64,
    /// Whether it is lost or damaged, or finds the queue full.
    pub lost: bool,
    /// Whether there is a queue of unknown length, which may delay the packet more, or drop it.
    pub queued: bool,
}

/// One direction of a link as it is played: a seeded function of link time, and the queue of the rate
/// limit, if there is one.
#[derive(Debug, Clone)]
pub struct Path {
    law: PathLaw,
    queue: Option<Bottleneck>,
    loss: LossProcess,
    gate: Option<Spells>,
    wire: Wire,
    faults: Faults,
    newest_ns: u64,
    /// When something is forgotten next.
    forgets_ns: u64,
}

impl Path {
    pub(crate) fn new(law: &PathLaw, way: Way, seed: u64) -> Self {
        Self::begun(law.begun(seed), way, seed)
    }

    /// A path whose trace, if it has one, begins where it begins.
    pub(crate) fn begun(law: PathLaw, way: Way, seed: u64) -> Self {
        let names: [&[u8; 8]; 4] = match way {
            Way::Up => [b"up.level", b"up.stall", b"up.loss.", b"up.spell"],
            Way::Down => [b"dn.level", b"dn.stall", b"dn.loss.", b"dn.spell"],
        };
        let [level, stall, loss, spell] = names.map(|name| Draws::new(seed, name));
        Self {
            queue: law.rate.as_ref().map(|rate| Bottleneck::new(rate.limit())),
            loss: LossProcess::new(&law.loss, loss, spell),
            gate: law.stall.as_ref().map(|s| {
                let gap_ns = s.every_ns as f64 - s.length.mean_ns();
                Spells::new(gap_ns, s.length.clone(), stall)
            }),
            wire: Wire::new(
                &law.delay,
                law.order,
                level,
                Faults::of_delay(&law.faults, way, seed),
            ),
            faults: Faults::new(&law.faults, way, seed),
            law,
            newest_ns: 0,
            forgets_ns: 0,
        }
    }

    /// Fate of a packet of `bytes` (IP packet length) that enters at `t`. Must be called in order of entry.
    ///
    /// Without a rate limit this is exactly [`Path::state_at`] at `t`; with one, at the instant when
    /// the packet has been sent.
    #[inline]
    pub fn transmit(&mut self, t: LinkTime, bytes: u32) -> Fate<LinkTime> {
        let t_ns = self.kept(t.ns());
        let sent_ns = match &mut self.queue {
            None => t_ns,
            Some(queue) => {
                let law = &self.law;
                // There is no queue without a rate.
                let rate_at = |t_ns| rate_at(law, t_ns).unwrap_or(u64::MAX);
                match queue.enter(t_ns, bytes, rate_at) {
                    Some(sent_ns) => sent_ns,
                    None => return Fate::Drop(Cause::Overflow),
                }
            }
        };
        if self.lost(sent_ns) {
            return Fate::Drop(Cause::Loss);
        }
        Fate::Deliver {
            at: LinkTime::from_ns(sent_ns).after(self.delay_ns(sent_ns)),
            twist: match self.faults.is_empty() {
                true => Twist::NONE,
                false => self.faults.twist(sent_ns),
            },
        }
    }

    /// The state at an instant, regardless of traffic: what [`Path::transmit`] would do to a packet
    /// if there were no rate limit.
    ///
    /// Queries may come in any order as long as none lies more than 10 s behind the newest; an older
    /// one gets the state of 10 s before the newest.
    pub fn state_at(&mut self, t: LinkTime) -> State {
        let t_ns = self.kept(t.ns());
        State {
            delay_ns: self.delay_ns(t_ns),
            lost: self.lost(t_ns) || self.faults.corrupts(t_ns),
            rate_bps: rate_at(&self.law, t_ns),
        }
    }

    /// What a packet of `bytes` that enters at `t` meets, given the `load` of the other packets.
    /// Without the load, a path with a rate limit gives the least possible delay.
    ///
    /// Queries may come in any order, as for [`Path::state_at`].
    pub fn passage(&mut self, t: LinkTime, bytes: u32, load: Option<&Load>) -> Passage {
        let t_ns = t.ns();
        let Some(rate_bps) = rate_at(&self.law, t_ns) else {
            let State { delay_ns, lost, .. } = self.state_at(t);
            return Passage {
                delay_ns,
                lost,
                queued: false,
            };
        };
        let law = &self.law;
        let sent_ns = match load {
            None => Some(t_ns.saturating_add(Bottleneck::takes_ns(bytes, rate_bps))),
            Some(load) => load.sent_ns(t_ns, bytes, |t_ns| rate_at(law, t_ns).unwrap_or(u64::MAX)),
        };
        let state = self.state_at(sent_ns.map_or(t, LinkTime::from_ns));
        Passage {
            delay_ns: (sent_ns.unwrap_or(t_ns) - t_ns).saturating_add(state.delay_ns),
            lost: state.lost || sent_ns.is_none(),
            queued: load.is_none(),
        }
    }

    /// What a packet of `bytes` that enters at `t` meets, given the `load`, and so do those that enter after it, up
    /// to the end of the piece: as [`Path::passage`] has it. Where there is a rate limit, or faults, a piece is one
    /// instant.
    #[inline]
    pub fn piece(&mut self, t: LinkTime, bytes: u32, load: Option<&Load>) -> Stretch {
        let Some(mut delays) = self.delays_alone(t) else {
            let passage = self.passage(t, bytes, load);
            return Stretch {
                delays: Stay::at(t.ns(), passage.delay_ns),
                lost: passage.lost,
                queued: passage.queued,
            };
        };
        let lost = self.lost(t.ns());
        let stays_until_ns = self.loss.stays_until_ns(t.ns(), self.law.trace());
        delays.end_ns = delays.end_ns.min(stays_until_ns);
        Stretch {
            delays,
            lost,
            queued: false,
        }
    }

    /// The delays of [`Path::piece`], up to the end of a piece that no loss ends.
    #[inline]
    pub fn delays(&mut self, t: LinkTime, bytes: u32, load: Option<&Load>) -> Stay {
        self.delays_alone(t)
            .unwrap_or_else(|| Stay::at(t.ns(), self.passage(t, bytes, load).delay_ns))
    }

    /// The delays from `t` on, where neither packets nor faults have a part in them, and it is not so long ago that it
    /// was forgotten.
    #[inline]
    fn delays_alone(&mut self, t: LinkTime) -> Option<Stay> {
        if self.law.rate.is_some() || !self.faults.is_empty() {
            return None;
        }
        let t_ns = self.kept(t.ns());
        if t_ns != t.ns() {
            return None;
        }
        let Some(gate) = &mut self.gate else {
            return Some(self.wire.delays(t_ns));
        };
        Some(match gate.stretch(t_ns) {
            // All that wait for the gate leave together.
            Ok(opens_ns) => Stay {
                level_ns: 0,
                held_until_ns: opens_ns.saturating_add(self.wire.delay_ns(opens_ns)),
                end_ns: opens_ns,
            },
            Err(closes_ns) => {
                let delays = self.wire.delays(t_ns);
                Stay {
                    end_ns: delays.end_ns.min(closes_ns),
                    ..delays
                }
            }
        })
    }

    /// The queue's history, if there is a rate limit: from the instants and lengths in bytes of the
    /// packets that entered, in order.
    #[must_use]
    pub fn load(&self, packets: impl IntoIterator<Item = (LinkTime, u32)>) -> Option<Load> {
        let rate = self.law.rate.as_ref()?;
        let rate_at = |t_ns| rate_at(&self.law, t_ns).unwrap_or(u64::MAX);
        let packets = packets.into_iter().map(|(t, bytes)| (t.ns(), bytes));
        Some(Load::new(rate.limit(), rate_at, packets))
    }

    /// The first stall that ends after `t`; `None` if the way never stalls.
    pub(crate) fn stall_after(&mut self, t: LinkTime) -> Option<Spell> {
        self.gate.as_mut()?.after(t.ns())
    }

    /// The last link time up to `t` at which faults may have broken connections of TCP that cross.
    pub fn broken(&mut self, t: LinkTime) -> Option<LinkTime> {
        self.faults.broken_ns(t.ns()).map(LinkTime::from_ns)
    }

    /// Whether a fault that loses or damages packets is in force.
    pub(crate) fn loses_by_fault(&mut self, t: LinkTime) -> bool {
        self.faults.is_lossy(t.ns())
    }

    /// Whether a packet may be lost or damaged here: by loss, by a full queue, or by a fault.
    pub(crate) fn may_lose(&self) -> bool {
        self.law.loss != Loss::Never || self.queue.is_some() || !self.faults.is_empty()
    }

    pub(crate) fn may_overtake(&self) -> bool {
        self.law.order == Order::Free
    }

    /// Forgets what lies too far back, and limits `t_ns` to the range that is kept.
    #[inline]
    fn kept(&mut self, t_ns: u64) -> u64 {
        if t_ns < self.newest_ns {
            return t_ns.max(self.newest_ns.saturating_sub(KEEP_NS));
        }
        self.newest_ns = t_ns;
        if t_ns >= self.forgets_ns {
            self.forget();
        }
        t_ns
    }

    #[cold]
    fn forget(&mut self) {
        self.forgets_ns = self.newest_ns.saturating_add(FORGET_EVERY_NS);
        let oldest_ns = self.newest_ns.saturating_sub(KEEP_NS);
        self.loss.forget_before(oldest_ns);
        if let Some(gate) = &mut self.gate {
            gate.forget_before(oldest_ns);
        }
    }

    /// The delay from the entry of the gate to the end of the wire.
    #[inline]
    fn delay_ns(&mut self, t_ns: u64) -> u64 {
        let opens_ns = self.gate.as_mut().and_then(|gate| gate.end_at(t_ns));
        let on_wire_ns = opens_ns.unwrap_or(t_ns);
        let delay_ns = (on_wire_ns - t_ns).saturating_add(self.wire.delay_ns(on_wire_ns));
        match self.faults.is_empty() {
            true => delay_ns,
            false => delay_ns.saturating_add(self.faults.held_back_ns(t_ns)),
        }
    }

    #[inline]
    fn lost(&mut self, t_ns: u64) -> bool {
        self.loss.lost(t_ns, self.law.trace()) || !self.faults.is_empty() && self.faults.lost(t_ns)
    }
}

/// The rate limit in force at an instant.
#[inline]
fn rate_at(law: &PathLaw, t_ns: u64) -> Option<u64> {
    match (&law.rate, &law.delay) {
        (None, _) => None,
        (Some(Rate::Constant { rate_bps, .. }), _) => Some(*rate_bps),
        (Some(Rate::Trace { .. }), Delay::Trace(trace)) => trace.step_at(t_ns).1.rate_bps,
        (Some(Rate::Trace { .. }), _) => None,
    }
}
