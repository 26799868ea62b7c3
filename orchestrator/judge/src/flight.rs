//! How long a message waits to enter the link when messages share a stream: TCP sends no more segments than its
//! congestion window holds until the earlier ones are acknowledged. The window is no smaller than at its start (RFC
//! 6928) unless something was lost, and how far it has grown since is not recorded: a message may have waited, and
//! need not.

use link::{Timeline, Way};

use crate::milliseconds::ns;
use crate::terms::Terms;

/// Segments under way without an acknowledgement at the start: RFC 6928, and Linux's own.
const WINDOW: usize = 10;

/// Longest time until what arrived is acknowledged, if no answer carries that back, ms: Linux's `TCP_DELACK_MIN`.
const ACKNOWLEDGED_WITHIN_MS: f64 = 40.0;

/// IP length of an acknowledgement, bytes.
const ACKNOWLEDGEMENT_BYTES: u32 = 52;

/// The messages of one way that may be under way.
pub(crate) struct Flight {
    back: Way,
    link: Timeline,
    /// When the last of them arrived, at the place of each; 0 for one that never did.
    arrived_ns: [u64; WINDOW],
    sent: usize,
}

impl Flight {
    pub(crate) fn new(way: Way, terms: &Terms) -> Flight {
        Flight {
            back: way.back(),
            link: terms.timeline.clone(),
            arrived_ns: [0; WINDOW],
            sent: 0,
        }
    }

    /// Until when the next message may wait at the longest, ns; 0 if the window had room for it when it was stamped.
    /// The one before the window's is acknowledged by then, so fewer are under way than the window holds.
    pub(crate) fn waits_until_ns(
        &mut self,
        enters_ns: u64,
        leaves_ns: Option<u64>,
        terms: &Terms,
    ) -> u64 {
        let place = self.sent % WINDOW;
        self.sent += 1;
        let before_ns = std::mem::replace(&mut self.arrived_ns[place], leaves_ns.unwrap_or(0));
        if before_ns == 0 {
            return 0;
        }
        let within_ns = ns(ACKNOWLEDGED_WITHIN_MS);
        let (link, bytes) = (&mut self.link, ACKNOWLEDGEMENT_BYTES);
        let back = terms.window(link, self.back, before_ns, within_ns, bytes);
        match back.latest_ns > enters_ns {
            true => back.latest_ns,
            false => 0,
        }
    }
}
