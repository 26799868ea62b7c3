//! What a player beside an end did that shapes one way, and what two of them did together.

use crate::time::Epoch;
use crate::way::Way;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::lateness::Lateness;
use crate::certificate::report::{Pause, PlayerReport, WayReport};
use crate::certificate::scheduling::Scheduling;

/// What a player did that shapes one way, beside one of the ends.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WayPlayed {
    /// The way that it shapes.
    pub way: Way,
    /// What the kernel granted its thread.
    pub scheduling: Scheduling,
    /// The monotonic instant of link time 0.
    #[serde(rename = "epoch_ns")]
    pub epoch: Epoch,
    /// When it began to play, monotonic.
    pub started_ns: u64,
    /// When it ended, monotonic.
    pub ended_ns: u64,
    /// When it was held up for 5 ms or more; the first hundred.
    #[serde(default)]
    pub pauses: Vec<Pause>,
    /// What it did on that way.
    pub shaped: WayReport,
    /// What came the other way, from the player beside the other end.
    pub carried: Carried,
}

/// Packets that came shaped and were handed on at once.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Carried {
    /// IPv4 packets that came. What the other end's player delivered and did not come here
    /// was lost between the two.
    pub packets: u64,
    /// Their length, IP headers included.
    pub bytes: u64,
    /// Datagrams that held no IPv4 or that a stranger sent, and are not handed on.
    pub foreign: u64,
    /// Packets that were lost here. Anything but 0 makes a run invalid.
    pub dropped: u64,
    /// How long after the kernel had received them they were handed on.
    pub lateness: Lateness,
}

impl From<WayReport> for Carried {
    fn from(report: WayReport) -> Self {
        Self {
            packets: report.packets,
            bytes: report.bytes,
            foreign: report.foreign,
            dropped: report.dropped,
            lateness: report.lateness,
        }
    }
}

impl WayPlayed {
    /// Packets that this player delivered and the one beside the other end did not get: lost by the
    /// network between them, or sent after the other had stopped.
    #[must_use]
    pub fn astray(&self, other: &Self) -> u64 {
        self.shaped.delivered.saturating_sub(other.carried.packets)
    }
}

impl PlayerReport {
    /// The report of the link that two players make together, in either order; `None` if they are not
    /// the two ways of one link with one epoch.
    ///
    /// A packet that a player lost while carrying it counts as lost on its way. Packets that the
    /// network between the players lost are not included: see [`WayPlayed::astray`].
    #[must_use]
    pub fn of_ways(one: &WayPlayed, other: &WayPlayed) -> Option<Self> {
        let (up, down) = match (one.way, other.way) {
            (Way::Up, Way::Down) => (one, other),
            (Way::Down, Way::Up) => (other, one),
            _ => return None,
        };
        let way = |shaping: &WayPlayed, carrying: &WayPlayed| WayReport {
            dropped: shaping.shaped.dropped + carrying.carried.dropped,
            ..shaping.shaped
        };
        (up.epoch == down.epoch).then(|| Self {
            scheduling: match (up.scheduling, down.scheduling) {
                (Scheduling::Fifo, Scheduling::Fifo) => Scheduling::Fifo,
                _ => Scheduling::Other,
            },
            epoch: up.epoch,
            // The link exists while both play.
            started_ns: up.started_ns.max(down.started_ns),
            ended_ns: up.ended_ns.min(down.ended_ns),
            pauses: [&up.pauses[..], &down.pauses[..]].concat(),
            up: way(up, down),
            down: way(down, up),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A report on `packets` packets, all delivered except `dropped`, which the port lost before.
    fn report(packets: u64, dropped: u64) -> WayReport {
        WayReport {
            packets,
            bytes: packets * 84,
            delivered: packets,
            dropped,
            ..WayReport::default()
        }
    }

    fn played(way: Way, started_ns: u64, scheduling: Scheduling) -> WayPlayed {
        let (sent, came) = match way {
            Way::Up => (10, 20),
            Way::Down => (20, 9),
        };
        WayPlayed {
            way,
            scheduling,
            epoch: Epoch::at_ns(7),
            started_ns,
            ended_ns: started_ns + 100,
            pauses: Vec::new(),
            shaped: report(sent, 2),
            carried: report(came, 3).into(),
        }
    }

    #[test]
    fn two_players_make_one_link_in_whatever_order() {
        let up = played(Way::Up, 1_000, Scheduling::Fifo);
        let down = played(Way::Down, 1_010, Scheduling::Other);
        let link = PlayerReport::of_ways(&up, &down).expect("a link");
        assert_eq!(PlayerReport::of_ways(&down, &up), Some(link.clone()));
        assert_eq!((link.started_ns, link.ended_ns), (1_010, 1_100));
        assert_eq!(link.scheduling, Scheduling::Other);
        assert_eq!((link.up.packets, link.down.packets), (10, 20));
        assert_eq!((link.up.dropped, link.down.dropped), (5, 5));
        assert_eq!((up.astray(&down), down.astray(&up)), (1, 0));
    }

    #[test]
    fn what_is_not_two_ways_of_one_link_makes_none() {
        let up = played(Way::Up, 1_000, Scheduling::Fifo);
        let down = played(Way::Down, 1_000, Scheduling::Fifo);
        assert_eq!(PlayerReport::of_ways(&up, &up), None);
        let of_another = WayPlayed {
            epoch: Epoch::at_ns(8),
            ..down.clone()
        };
        assert_eq!(PlayerReport::of_ways(&up, &of_another), None);
    }

    #[test]
    fn it_is_read_back_from_json_as_it_was() {
        let up = played(Way::Up, 1_000, Scheduling::Fifo);
        let text = serde_json::to_string(&up).expect("numbers and names");
        assert_eq!(
            serde_json::from_str::<WayPlayed>(&text).expect("the same"),
            up
        );
    }
}
