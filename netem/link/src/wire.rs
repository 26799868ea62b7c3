//! The wire's delay at each instant: a level that is held and redrawn, or the steps of a trace, and what
//! faults add to it; and the order in which packets leave.
//!
//! If the order is kept, the delay is first-in first-out as a function of time alone: a packet leaves no
//! earlier than one that *could* have entered before it. With the level D(t) it is `D*(t) = max over s <= t
//! of (s + D(s)) - t`, the virtual waiting time, which falls by at most one second per second.

use crate::draws::Draws;
use crate::fault::{Effect, Seeded};
use crate::piece::Stay;
use crate::profile::{Delay, Level, Order};

/// A piece of time with a constant level.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start_ns: u64,
    /// When the next piece begins.
    end_ns: u64,
    level_ns: u64,
}

/// A piece that was computed, and the effect of the earlier pieces on it.
#[derive(Debug, Clone, Copy)]
struct Known {
    start_ns: u64,
    /// When the next piece begins.
    end_ns: u64,
    level_ns: u64,
    /// No packet of this piece leaves before this: a packet of an earlier piece leaves then.
    held_until_ns: u64,
}

/// The wire of one direction.
#[derive(Debug, Clone)]
pub(crate) struct Wire {
    delay: Delay,
    order: Order,
    draws: Draws,
    /// Faults that add to the delay.
    faults: Vec<Seeded>,
    reach_ns: u64,
    /// The piece of the newest query, since the next is mostly about the same; empty before the first.
    known: Known,
    /// The one before it: who asks about a span of time for each packet goes ahead, and back for the next.
    before: Known,
}

/// A piece of no time.
const NOWHEN: Known = Known {
    start_ns: 0,
    end_ns: 0,
    level_ns: 0,
    held_until_ns: 0,
};

impl Wire {
    pub(crate) fn new(delay: &Delay, order: Order, draws: Draws, faults: Vec<Seeded>) -> Self {
        let added_ns = faults.iter().map(added_ns).fold(0, u64::saturating_add);
        Self {
            delay: delay.clone(),
            order,
            draws,
            faults,
            reach_ns: delay.reach_ns().saturating_add(added_ns),
            known: NOWHEN,
            before: NOWHEN,
        }
    }

    /// How long a packet that enters the wire at `t_ns` stays on it.
    #[inline]
    pub(crate) fn delay_ns(&mut self, t_ns: u64) -> u64 {
        self.delays(t_ns).delay_ns(t_ns)
    }

    /// The same of all packets that enter it in the piece at `t_ns`.
    #[inline]
    pub(crate) fn delays(&mut self, t_ns: u64) -> Stay {
        if !(self.known.start_ns..self.known.end_ns).contains(&t_ns) {
            let there = self.learn(t_ns);
            self.before = std::mem::replace(&mut self.known, there);
        }
        Stay {
            level_ns: self.known.level_ns,
            held_until_ns: self.known.held_until_ns,
            end_ns: self.known.end_ns,
        }
    }

    /// The piece at `t_ns`, and until when earlier pieces hold its packets back.
    #[inline(never)]
    fn learn(&mut self, t_ns: u64) -> Known {
        if (self.before.start_ns..self.before.end_ns).contains(&t_ns) {
            return self.before;
        }
        let piece = self.piece_at(t_ns);
        let before = self.known;
        let held_until_ns = match self.order {
            Order::Free => 0,
            // What held back the piece before may hold back this one, and the last packet of that one does.
            Order::Kept if before.end_ns == piece.start_ns && before.end_ns > 0 => {
                let last_ns = before.end_ns - 1;
                let last_leaves_ns = last_ns.saturating_add(before.level_ns);
                before.held_until_ns.max(last_leaves_ns)
            }
            Order::Kept => self.held_until_ns(piece),
        };
        Known {
            start_ns: piece.start_ns,
            end_ns: piece.end_ns,
            level_ns: piece.level_ns,
            held_until_ns,
        }
    }

    /// Until when earlier pieces hold back the packets of this one, found without knowing any of them.
    fn held_until_ns(&mut self, piece: Piece) -> u64 {
        // When the first packet of the piece leaves if it is not held back; none leaves earlier.
        let first_ns = piece.start_ns.saturating_add(piece.level_ns);
        let (mut held_until_ns, mut start_ns) = (0, piece.start_ns);
        // An earlier piece matters by its last instant; a piece that ended longer ago than the
        // greatest level cannot hold a packet any more.
        while let Some(last_ns) = start_ns.checked_sub(1) {
            if last_ns.saturating_add(self.reach_ns) <= first_ns.max(held_until_ns) {
                break;
            }
            let earlier = self.piece_at(last_ns);
            held_until_ns = held_until_ns.max(last_ns.saturating_add(earlier.level_ns));
            start_ns = earlier.start_ns;
        }
        held_until_ns
    }

    fn piece_at(&mut self, t_ns: u64) -> Piece {
        let mut piece = self.level_at(t_ns);
        for fault in &mut self.faults {
            let span = fault.span_at(t_ns);
            piece.start_ns = piece.start_ns.max(span.start_ns);
            piece.end_ns = piece.end_ns.min(span.end_ns);
            if span.is_spell {
                piece.level_ns = piece.level_ns.saturating_add(added_ns(fault));
            }
        }
        piece
    }

    /// The piece without faults.
    fn level_at(&mut self, t_ns: u64) -> Piece {
        match &self.delay {
            Delay::Constant { delay_ns } => Piece {
                start_ns: 0,
                end_ns: u64::MAX,
                level_ns: *delay_ns,
            },
            Delay::Held(level) => held_piece(level, &mut self.draws, t_ns),
            Delay::Trace(trace) => {
                let (span_ns, step) = trace.step_at(t_ns);
                Piece {
                    start_ns: span_ns.start,
                    end_ns: span_ns.end,
                    level_ns: step.delay_ns,
                }
            }
        }
    }
}

/// What a fault adds to the delay while it is in force.
fn added_ns(fault: &Seeded) -> u64 {
    match fault.effect() {
        Effect::Delay { delay_ns } => delay_ns,
        _ => 0,
    }
}

/// Piece 0 begins at link time 0, piece k >= 1 at a random instant of the k-th hold, so that no
/// periodic sampling is synchronous with the redraws.
fn held_piece(level: &Level, draws: &mut Draws, t_ns: u64) -> Piece {
    let mut start_of = |piece: u64| match piece.checked_sub(1) {
        None => 0,
        Some(holds) => {
            let within_ns = (draws.at(2 * piece) * level.hold_ns as f64) as u64;
            (holds * level.hold_ns).saturating_add(within_ns)
        }
    };
    let mut piece = t_ns / level.hold_ns + 1;
    let mut start_ns = start_of(piece);
    let end_ns = if start_ns > t_ns {
        let end_ns = start_ns;
        piece -= 1;
        start_ns = start_of(piece);
        end_ns
    } else {
        start_of(piece + 1)
    };
    Piece {
        start_ns,
        end_ns,
        level_ns: level.delay_ns(draws.at(2 * piece + 1)),
    }
}
