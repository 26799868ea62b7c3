//! Which pauses of a machine a run met. A closed loop is under way at every instant. Of an open one nothing is shown
//! but its messages, so what fell between two of them changed nothing.

use endpoint::{MessageRow, Mode};
use link::certificate::Pause;

/// How much later than a pause its work may be stamped, ns: that of all who waited is done at once.
const AFTER_NS: u64 = 2_000_000;

/// The instants at which a pause matters.
#[derive(Debug)]
pub(crate) enum Met {
    /// All of them.
    Any,
    /// These, monotonic, in order.
    At(Vec<u64>),
}

impl Met {
    /// Of a run with these messages. Where a stamp is missing, every instant may have been one.
    pub(crate) fn of(mode: Mode, messages: &[MessageRow]) -> Met {
        let is_stamped = |row: &MessageRow| row.t_send_ns.is_some() || row.t_arrive_ns.is_none();
        if mode == Mode::Closed || !messages.iter().all(is_stamped) {
            return Met::Any;
        }
        let stamps = |row: &MessageRow| {
            let met = [row.t_send_ns, row.t_arrive_ns, row.t_receive_ns];
            met.into_iter().flatten().chain([row.t_due_ns])
        };
        let mut at: Vec<u64> = messages.iter().flat_map(stamps).collect();
        at.sort_unstable();
        Met::At(at)
    }

    /// Those of the pauses.
    pub(crate) fn those(&self, pauses: &[Pause]) -> Vec<Pause> {
        let met = pauses.iter().filter(|pause| self.has(pause));
        met.copied().collect()
    }

    /// Whether something was due, or came, while a pause lasted.
    fn has(&self, pause: &Pause) -> bool {
        let Met::At(at) = self else { return true };
        let from_ns = pause.t_ns.saturating_sub(pause.ns);
        let first = at.partition_point(|t_ns| *t_ns < from_ns);
        at.get(first)
            .is_some_and(|t_ns| *t_ns <= pause.t_ns.saturating_add(AFTER_NS))
    }
}

#[cfg(test)]
mod tests {
    use endpoint::MessageOutcome;
    use proptest::prelude::*;

    use super::*;

    fn row(t_due_ns: u64, took_ns: [u64; 3]) -> MessageRow {
        let [send_ns, arrive_ns, receive_ns] = took_ns;
        MessageRow {
            seq: 0,
            t_due_ns,
            t_send_ns: Some(t_due_ns + send_ns),
            t_arrive_ns: Some(t_due_ns + send_ns + arrive_ns),
            t_receive_ns: Some(t_due_ns + send_ns + arrive_ns + receive_ns),
            u: None,
            e: None,
            r: 1.0,
            y: None,
            tick: None,
            outcome: MessageOutcome::Answered,
            y_seq: None,
        }
    }

    proptest! {
        /// The definition: some stamp lies in the pause, or just after it.
        #[test]
        fn a_pause_of_an_open_loop_counts_if_a_stamp_lies_in_it(
            dues in prop::collection::vec((0u64..1_000_000_000, prop::array::uniform3(0u64..50_000_000)), 0..20),
            t_ns in 0u64..1_200_000_000,
            ns in 0u64..80_000_000,
        ) {
            let rows: Vec<MessageRow> = dues.iter().map(|(due, took)| row(*due, *took)).collect();
            let pause = Pause { t_ns, ns };
            let within = t_ns.saturating_sub(ns)..=t_ns + AFTER_NS;
            let lies_in = rows.iter().any(|row| {
                let stamps = [row.t_send_ns, row.t_arrive_ns, row.t_receive_ns, Some(row.t_due_ns)];
                stamps.into_iter().flatten().any(|stamp| within.contains(&stamp))
            });
            prop_assert_eq!(Met::of(Mode::Open, &rows).has(&pause), lies_in);
            prop_assert!(Met::of(Mode::Closed, &rows).has(&pause));
        }
    }

    #[test]
    fn a_program_without_stamps_may_have_met_every_pause() {
        let unstamped = MessageRow {
            t_send_ns: None,
            ..row(0, [1, 1, 1])
        };
        let long_after = Pause {
            t_ns: 900_000_000,
            ns: 20_000_000,
        };
        assert!(Met::of(Mode::Open, &[unstamped]).has(&long_after));
        assert!(!Met::of(Mode::Open, &[row(0, [1, 1, 1])]).has(&long_after));
    }
}
