//! The echoes of a probe and their instants.

use std::net::Ipv4Addr;

use serde::{Deserialize, Serialize};

/// The echoes to send and their instants.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbePlan {
    /// The address to probe: [`PLANT_ADDRESS`](crate::PLANT_ADDRESS), or 127.0.0.1 without a link.
    pub target: Ipv4Addr,
    /// When the first echo is sent, monotonic. An instant in the past means now.
    pub start_ns: u64,
    /// Interval between echoes.
    pub interval_ns: u64,
    /// With a seed each echo is sent at an instant of its interval drawn from the seed, so that no periodic
    /// disturbance can always fall between echoes. Without a seed it is sent at the beginning.
    pub seed: Option<u64>,
    /// How long to wait for each echo while it is missing, from `start_ns`; so many echoes are sent.
    pub until_ns: Vec<u64>,
    /// Distinguishes probes: a probe needs another id if one runs at the same time, or ran before and
    /// may still have answers under way.
    pub id: u16,
}

impl ProbePlan {
    /// Number of echoes.
    #[must_use]
    pub fn count(&self) -> u32 {
        u32::try_from(self.until_ns.len()).unwrap_or(u32::MAX)
    }

    /// Until when to listen in a series that begins at `start_ns` and whose echoes are all sent; `is_missing` says of
    /// each number whether its answer is. `None` if none is.
    pub(crate) fn end_ns(&self, start_ns: u64, is_missing: impl Fn(u32) -> bool) -> Option<u64> {
        let until = self.until_ns.iter().zip(0..);
        let missing = until.filter(|(_, seq)| is_missing(*seq));
        let longest_ns = missing.map(|(until_ns, _)| *until_ns).max()?;
        Some(start_ns.saturating_add(longest_ns))
    }

    /// When echo `seq` is sent, in a series that begins at `start_ns`; later than the one before.
    #[must_use]
    pub fn due_ns(&self, start_ns: u64, seq: u32) -> u64 {
        let begin_ns = start_ns.saturating_add(u64::from(seq).saturating_mul(self.interval_ns));
        let within_ns = self.seed.map_or(0, |draws| {
            link::within_ns(draws, self.id, seq, self.interval_ns)
        });
        begin_ns.saturating_add(within_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// It listens as long as any echo that is missing may take, and no longer; to none if all are there.
        #[test]
        fn a_probe_waits_for_the_echoes_that_are_missing_and_for_no_other(
            echoes in prop::collection::vec((0_u64..1_000, any::<bool>()), 0..50),
            start_ns in 0_u64..1_000,
        ) {
            let plan = ProbePlan {
                target: Ipv4Addr::LOCALHOST,
                start_ns,
                interval_ns: 10,
                seed: None,
                until_ns: echoes.iter().map(|(until_ns, _)| *until_ns).collect(),
                id: 0,
            };
            prop_assert_eq!(plan.count() as usize, echoes.len());
            let end_ns = plan.end_ns(start_ns, |seq| echoes[seq as usize].1);
            for (until_ns, _) in echoes.iter().filter(|(_, is_missing)| *is_missing) {
                prop_assert!(end_ns.is_some_and(|end_ns| end_ns >= start_ns + until_ns));
            }
            let is_end = |(until_ns, is_missing): &(u64, bool)| {
                *is_missing && end_ns == Some(start_ns + until_ns)
            };
            prop_assert!(end_ns.is_none() || echoes.iter().any(is_end));
        }

        #[test]
        fn each_echo_is_sent_within_its_own_interval(
            seed in prop::option::of(any::<u64>()), id in any::<u16>(), interval_ns in 1_u64..1_000_000,
        ) {
            let plan = ProbePlan {
                target: Ipv4Addr::LOCALHOST,
                start_ns: 5,
                interval_ns,
                seed,
                until_ns: vec![0; 100],
                id,
            };
            for seq in 0..plan.count() {
                let begin_ns = 5 + u64::from(seq) * interval_ns;
                let due_ns = plan.due_ns(5, seq);
                prop_assert!((begin_ns..begin_ns + interval_ns).contains(&due_ns));
            }
        }
    }
}
