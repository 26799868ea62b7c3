//! Whether a packet that entered later than it was stamped explains what looks impossible.
//!
//! A machine that takes a processor away between the stamp of an echo and its sending lets it meet a later
//! state of the link: one with less delay, or one that loses nothing. Such an echo is no evidence against
//! the link. One that left sooner than every state between its stamp and its arrival lets it, is.

use crate::timeline::Timeline;
use crate::way::Way;

use crate::certificate::echo::{Echo, PACKET_BYTES};
use crate::certificate::prediction::{LOOK_NS, Prediction};
use crate::certificate::statistics::ms;

/// An echo counts as quicker than the link only by more than this, ns, since the edges of its states are not
/// known more exactly.
pub(crate) const QUICKER_NS: u64 = 500_000;

/// The link as it is asked about one echo after another.
pub(crate) struct Entries<'a> {
    link: &'a Timeline,
}

impl<'a> Entries<'a> {
    pub(crate) fn of(link: &'a Timeline) -> Entries<'a> {
        Entries { link }
    }

    /// Whether a packet that was stamped at `from_ns` may have left a way by `leaves_ns`, entering at any time
    /// between.
    pub(crate) fn allow(&self, way: Way, from_ns: u64, leaves_ns: u64) -> bool {
        // Rare, so that a copy costs little: a timeline forgets what lies far behind its newest query.
        let mut link = self.link.clone();
        let by_ns = leaves_ns.saturating_add(QUICKER_NS);
        let mut enters_ns = from_ns;
        while enters_ns <= leaves_ns {
            let passage = link.passage(way, enters_ns, PACKET_BYTES);
            if !passage.lost && enters_ns.saturating_add(passage.delay_ns) <= by_ns {
                return true;
            }
            enters_ns += LOOK_NS;
        }
        false
    }

    /// Whether an echo crossed a way quicker than the link lets any packet that entered after its stamp. What the
    /// empty link costs is not taken off: no packet takes less than nothing there.
    pub(crate) fn is_quicker(&self, echo: &Echo, prediction: &Prediction) -> bool {
        let (Some(reach_ns), Some(back_ns)) = (echo.t_reach_ns, echo.t_back_ns) else {
            return false;
        };
        let ways = [
            (Way::Up, &prediction.up, echo.t_send_ns, reach_ns),
            (Way::Down, &prediction.down, reach_ns, back_ns),
        ];
        ways.into_iter().any(|(way, expected, from_ns, leaves_ns)| {
            let excess_ms = expected.excess_ms(ms(leaves_ns.saturating_sub(from_ns)));
            excess_ms < -ms(QUICKER_NS) && !self.allow(way, from_ns, leaves_ns)
        })
    }
}
