//! Checks the numbering of the rows in a whole file: each number occurs once, and none is missing.
//!
//! Someone who removes rows from a file and updates its checksum still leaves a gap in the numbers. Where an end was
//! killed as the experiment asked, and started again, there is a gap anyway.

use std::collections::BTreeSet;

use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use plan::{Phase, ProbeRow};
use thiserror::Error;

/// Why the rows of a file are not whole.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Disorder {
    /// Another number was next.
    #[error("{name} is {found}, and {due} is next: rows are missing or out of order")]
    Number {
        /// The column.
        name: &'static str,
        /// What it has.
        found: u64,
        /// What was next.
        due: u64,
    },
    /// A tick was due at another time.
    #[error("t_due_ns is {found}, and {due} is h = {h} ns after the tick before")]
    Due {
        /// When it was due, ns.
        found: u64,
        /// When it should have been, ns.
        due: u64,
        /// The sample time, ns.
        h: u64,
    },
    /// A number came before.
    #[error("seq {0} appears twice")]
    Twice(u64),
    /// A number never came.
    #[error("seq {seq} is missing, and the rows go up to {last}")]
    Missing {
        /// The number.
        seq: u64,
        /// The greatest that came.
        last: u64,
    },
    /// Echoes of a phase come after those of a later one.
    #[error("its phase has ended before")]
    Phase,
    /// Another number of rows was written.
    #[error("it has {found} rows, and {origin} says {written}")]
    Count {
        /// How many the file has.
        found: u64,
        /// Who counted them.
        origin: &'static str,
        /// How many were written.
        written: u64,
    },
}

/// Whether rows may be missing between others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gaps {
    /// None may.
    None,
    /// Some may, as where an end was killed and started again.
    Allowed,
}

/// `ticks.csv`: k counts from 0, and each tick is due h after the one before.
#[derive(Debug)]
pub struct TickOrder {
    h_ns: u64,
    gaps: Gaps,
    next: Option<TickDue>,
}

#[derive(Debug, Clone, Copy)]
struct TickDue {
    k: u64,
    t_due_ns: u64,
}

impl TickOrder {
    /// Of a file whose ticks are due every `h_ns`, where rows may be missing as `gaps` says.
    #[must_use]
    pub fn new(h_ns: u64, gaps: Gaps) -> Self {
        Self {
            h_ns,
            gaps,
            next: None,
        }
    }

    /// Takes the next row.
    ///
    /// # Errors
    /// [`Disorder`] if another row is next.
    pub fn check(&mut self, row: &TickRow) -> Result<(), Disorder> {
        let mut due = self.next.unwrap_or(TickDue {
            k: 0,
            t_due_ns: row.t_due_ns,
        });
        if self.gaps == Gaps::Allowed && row.k > due.k {
            let later_ns = (row.k - due.k).saturating_mul(self.h_ns);
            due = TickDue {
                k: row.k,
                t_due_ns: due.t_due_ns.saturating_add(later_ns),
            };
        }
        follows("k", row.k, due.k)?;
        if row.t_due_ns != due.t_due_ns {
            return Err(Disorder::Due {
                found: row.t_due_ns,
                due: due.t_due_ns,
                h: self.h_ns,
            });
        }
        self.next = Some(TickDue {
            k: due.k + 1,
            t_due_ns: due.t_due_ns.saturating_add(self.h_ns),
        });
        Ok(())
    }
}

/// `second.csv`: k counts from 0.
#[derive(Debug)]
pub struct SecondOrder {
    next: u64,
    gaps: Gaps,
}

impl SecondOrder {
    /// Of a file, where rows may be missing as `gaps` says.
    #[must_use]
    pub fn new(gaps: Gaps) -> Self {
        Self { next: 0, gaps }
    }

    /// Takes the next row.
    ///
    /// # Errors
    /// [`Disorder`] if another row is next.
    pub fn check(&mut self, row: &SecondRow) -> Result<(), Disorder> {
        if !(self.gaps == Gaps::Allowed && row.k > self.next) {
            follows("k", row.k, self.next)?;
        }
        self.next = row.k + 1;
        Ok(())
    }
}

/// `arrivals.csv`: n counts from 0.
#[derive(Debug, Default)]
pub struct ArrivalOrder {
    next: u64,
}

impl ArrivalOrder {
    /// Takes the next row.
    ///
    /// # Errors
    /// [`Disorder`] if another row is next.
    pub fn check(&mut self, row: &ArrivalRow) -> Result<(), Disorder> {
        follows("n", row.n, self.next)?;
        self.next += 1;
        Ok(())
    }
}

/// `messages.csv`: each seq up to the greatest occurs once, in the order in which messages ended.
#[derive(Debug, Default)]
pub struct MessageOrder {
    /// Every seq below this one has occurred.
    next: u64,
    /// Seqs beyond `next` that have occurred: messages that ended before an earlier one.
    beyond: BTreeSet<u64>,
}

impl MessageOrder {
    /// Takes the next row.
    ///
    /// # Errors
    /// [`Disorder`] if another row is next.
    pub fn check(&mut self, row: &MessageRow) -> Result<(), Disorder> {
        if row.seq == self.next && self.beyond.is_empty() {
            // As nearly all are.
            self.next += 1;
            return Ok(());
        }
        if row.seq < self.next || !self.beyond.insert(row.seq) {
            return Err(Disorder::Twice(row.seq));
        }
        while self.beyond.remove(&self.next) {
            self.next += 1;
        }
        Ok(())
    }

    /// Checks that no seq up to the greatest is missing.
    ///
    /// # Errors
    /// [`Disorder::Missing`] with the first that is.
    pub fn end(&self) -> Result<(), Disorder> {
        match self.beyond.last() {
            None => Ok(()),
            Some(last) => Err(Disorder::Missing {
                seq: self.next,
                last: *last,
            }),
        }
    }
}

/// `probes.csv`: one phase after the other, and seq counts from 0 in each.
#[derive(Debug, Default)]
pub struct ProbeOrder {
    phase: Option<Phase>,
    next: u32,
    /// Number of echoes through the link, without those on the empty link.
    pub through: u64,
}

impl ProbeOrder {
    /// Takes the next row.
    ///
    /// # Errors
    /// [`Disorder`] if another row is next.
    pub fn check(&mut self, row: &ProbeRow) -> Result<(), Disorder> {
        if self.phase != Some(row.phase) {
            if self
                .phase
                .is_some_and(|phase| phase as u8 > row.phase as u8)
            {
                return Err(Disorder::Phase);
            }
            (self.phase, self.next) = (Some(row.phase), 0);
        }
        follows("seq", row.seq.into(), self.next.into())?;
        self.next += 1;
        self.through += u64::from(row.phase != Phase::Empty);
        Ok(())
    }
}

fn follows(name: &'static str, found: u64, due: u64) -> Result<(), Disorder> {
    if found == due {
        Ok(())
    } else {
        Err(Disorder::Number { name, found, due })
    }
}

#[cfg(test)]
mod tests {
    use endpoint::MessageOutcome;
    use proptest::prelude::*;

    use super::*;

    fn message(seq: u64) -> MessageRow {
        MessageRow {
            seq,
            t_due_ns: 0,
            t_send_ns: None,
            t_receive_ns: None,
            t_arrive_ns: None,
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome: MessageOutcome::Missed,
            y_seq: None,
        }
    }

    fn is_whole(seqs: &[u64]) -> bool {
        let mut order = MessageOrder::default();
        seqs.iter().all(|seq| order.check(&message(*seq)).is_ok()) && order.end().is_ok()
    }

    fn ticks(rows: &[(u64, u64)], gaps: Gaps) -> Result<(), Disorder> {
        let mut order = TickOrder::new(10, gaps);
        rows.iter().try_for_each(|(k, t_due_ns)| {
            order.check(&TickRow {
                k: *k,
                t_due_ns: *t_due_ns,
                t_tick_ns: 0,
                u: 0.0,
                y: 0.0,
                seq: None,
                u_applied: None,
            })
        })
    }

    #[test]
    fn ticks_are_h_apart_from_wherever_they_begin() {
        assert_eq!(ticks(&[(0, 7), (1, 17), (2, 27)], Gaps::None), Ok(()));
        for rows in [[(1, 7), (2, 17)], [(0, 7), (2, 27)], [(0, 7), (1, 18)]] {
            assert!(ticks(&rows, Gaps::None).is_err(), "{rows:?}");
        }
        assert_eq!(ticks(&[(0, 7), (5, 57), (6, 67)], Gaps::Allowed), Ok(()));
        for rows in [[(0, 7), (5, 58)], [(0, 7), (0, 7)]] {
            assert!(ticks(&rows, Gaps::Allowed).is_err(), "{rows:?}");
        }
    }

    #[test]
    fn echoes_count_in_each_phase() {
        let row = |(phase, seq)| ProbeRow {
            phase,
            seq,
            t_send_ns: 0,
            t_reach_ns: None,
            t_back_ns: None,
            due_up_ns: 0,
            due_down_ns: 0,
            due_lost: false,
        };
        use Phase::{After, Before, Empty};
        let check = |rows: &[(Phase, u32)]| {
            let mut order = ProbeOrder::default();
            rows.iter()
                .try_for_each(|r| order.check(&row(*r)))
                .map(|()| order.through)
        };
        assert_eq!(
            check(&[(Empty, 0), (Empty, 1), (Before, 0), (After, 0)]),
            Ok(2)
        );
        for rows in [
            [(Empty, 0), (Empty, 2)],
            [(Before, 1), (After, 0)],
            [(After, 0), (Before, 0)],
        ] {
            assert!(check(&rows).is_err(), "{rows:?}");
        }
    }

    proptest! {
        #[test]
        fn messages_are_whole_in_any_order_and_never_without_one_or_with_one_twice(
            seqs in (2u64..40).prop_flat_map(|n| Just((0..n).collect::<Vec<_>>()).prop_shuffle()),
            at in any::<prop::sample::Index>(),
        ) {
            prop_assert!(is_whole(&seqs));
            let at = at.index(seqs.len());
            let mut twice = seqs.clone();
            twice.insert(at, seqs[at]);
            prop_assert!(!is_whole(&twice));
            let mut without = seqs.clone();
            let last = without.remove(at) == seqs.len() as u64 - 1;
            // The numbers do not show that the greatest is missing; the count of rows does.
            prop_assert_eq!(is_whole(&without), last);
        }
    }
}
