//! Echoes: as each half of a probe knows them, and both together. The shaper sends and receives them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Length of an echo's IP packet, which a link counts: 20 bytes of IPv4 header, 8 of ICMP header, and
/// the 56 that `ping` sends by default.
pub const PACKET_BYTES: u32 = 84;

/// One echo and its times, all monotonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
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

/// A request that reached the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sighting {
    /// The id of its probe.
    pub id: u16,
    /// The number of the echo in that probe.
    pub seq: u32,
    /// When the plant's kernel received it, monotonic.
    pub t_reach_ns: u64,
}

/// Adds to the asker's echoes of probe `id` the times at which the witness saw them: the first
/// sighting of each echo, in whatever order the sightings come.
#[must_use]
pub fn merge(echoes: &[Echo], id: u16, sightings: &[Sighting]) -> Vec<Echo> {
    let mut reached: BTreeMap<u32, u64> = BTreeMap::new();
    for sighting in sightings.iter().filter(|sighting| sighting.id == id) {
        reached
            .entry(sighting.seq)
            .and_modify(|first_ns| *first_ns = sighting.t_reach_ns.min(*first_ns))
            .or_insert(sighting.t_reach_ns);
    }
    echoes
        .iter()
        .map(|echo| Echo {
            t_reach_ns: reached.get(&echo.seq).copied(),
            ..*echo
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ID: u16 = 7;

    fn echo(seq: u32) -> Echo {
        Echo {
            seq,
            t_send_ns: u64::from(seq) * 1000,
            t_reach_ns: None,
            t_back_ns: Some(u64::from(seq) * 1000 + 400),
        }
    }

    proptest! {
        /// Each echo has any number of sightings, in any order, mixed with those of another probe and
        /// of numbers that were never sent. The earliest counts, an echo without one did not arrive,
        /// and the asker's data remain.
        #[test]
        fn the_first_sighting_counts_in_whatever_order_they_come(
            delays_ns in prop::collection::vec(prop::collection::vec(1_u64..1000, 0..3), 0..50),
            order in any::<prop::sample::Index>(),
        ) {
            let echoes: Vec<Echo> = (0..delays_ns.len() as u32).map(echo).collect();
            let mut sightings = vec![Sighting { id: ID, seq: 1 << 20, t_reach_ns: 5 }];
            for (echo, delays_ns) in echoes.iter().zip(&delays_ns) {
                sightings.push(Sighting { id: ID + 1, seq: echo.seq, t_reach_ns: 1 });
                sightings.extend(delays_ns.iter().map(|delay_ns| Sighting {
                    id: ID,
                    seq: echo.seq,
                    t_reach_ns: echo.t_send_ns + delay_ns,
                }));
            }
            let middle = order.index(sightings.len());
            sightings.rotate_left(middle);
            sightings[..middle].reverse();
            let merged = merge(&echoes, ID, &sightings);
            prop_assert_eq!(merged.len(), echoes.len());
            for ((echo, merged), delays_ns) in echoes.iter().zip(&merged).zip(&delays_ns) {
                let first_ns = delays_ns.iter().min().map(|delay_ns| echo.t_send_ns + delay_ns);
                prop_assert_eq!(*merged, Echo { t_reach_ns: first_ns, ..*echo });
            }
        }
    }
}
