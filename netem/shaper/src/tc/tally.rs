//! What the tc player counts, the source of its rows and its report.
//!
//! netem counts the packets, the player its changes. netem has one count for losses by the setting
//! and for lack of room; this file infers which of the two it was.

use link::Way;
use link::certificate::{Histogram, TcRow, WayReport};

use crate::tc::qdisc::Counters;

/// netem counts these bytes besides the IP packet.
const ETHERNET_HEADER_BYTES: u64 = 14;

/// The counts so far.
pub(crate) struct TcTally {
    way: Way,
    /// Whether there is a rate limit, so that a full queue belongs to the link.
    limited: bool,
    limit: u64,
    counters: Counters,
    overflow: u64,
    changes: u64,
    /// Number of changes at the last row, and the lateness of the changes since then.
    counted: u64,
    late_ns: u64,
    late_max_ns: u64,
    late: Histogram,
}

impl TcTally {
    pub(crate) fn new(way: Way) -> Self {
        Self {
            way,
            limited: false,
            limit: 0,
            counters: Counters::default(),
            overflow: 0,
            changes: 0,
            counted: 0,
            late_ns: 0,
            late_max_ns: 0,
            late: Histogram::new(),
        }
    }

    /// Sets the number of packets for which netem has room from now on, and whether there is a rate limit.
    pub(crate) fn room(&mut self, limit: u32, limited: bool) {
        self.limit = u64::from(limit);
        self.limited |= limited;
    }

    /// A change was made.
    pub(crate) fn changed(&mut self, late_ns: u64) {
        self.changes += 1;
        self.late_ns += late_ns;
        self.late_max_ns = self.late_max_ns.max(late_ns);
        self.late.add(late_ns, 1);
    }

    /// The row up to the instant at which netem had these counters.
    pub(crate) fn row(&mut self, t_ns: u64, now: Counters) -> TcRow {
        let before = self.counters;
        let delivered = now.packets.saturating_sub(before.packets);
        let drops = now.drops.saturating_sub(before.drops);
        // netem can only have been full if all packets that were there or came since were in it at once.
        let most = before.qlen + (delivered + drops + now.qlen).saturating_sub(before.qlen);
        let overflow = if most >= self.limit { drops } else { 0 };
        let changes = self.changes - self.counted;
        let bytes = now.bytes.saturating_sub(before.bytes);
        let row = TcRow {
            t_ns,
            way: self.way,
            delivered,
            bytes: bytes.saturating_sub(delivered * ETHERNET_HEADER_BYTES),
            lost: drops - overflow,
            overflow: if self.limited { overflow } else { 0 },
            dropped: if self.limited { 0 } else { overflow },
            queued: now.qlen,
            changes,
            late_mean_us: self.late_ns as f64 / changes.max(1) as f64 * 1e-3,
            late_max_us: self.late_max_ns as f64 * 1e-3,
        };
        self.counters = now;
        self.overflow += overflow;
        self.counted = self.changes;
        (self.late_ns, self.late_max_ns) = (0, 0);
        row
    }

    pub(crate) fn changes(&self) -> u64 {
        self.changes
    }

    /// The sum of all rows.
    pub(crate) fn report(&self) -> WayReport {
        let Counters {
            packets,
            bytes,
            drops,
            qlen,
        } = self.counters;
        WayReport {
            packets: packets + drops + qlen,
            bytes: bytes.saturating_sub(packets * ETHERNET_HEADER_BYTES),
            delivered: packets,
            lost: drops - self.overflow,
            overflow: if self.limited { self.overflow } else { 0 },
            unplayed: qlen,
            foreign: 0,
            dropped: if self.limited { 0 } else { self.overflow },
            lateness: self.late.summary(),
            ..WayReport::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counters(packets: u64, drops: u64, qlen: u64) -> Counters {
        Counters {
            packets,
            bytes: packets * 98,
            drops,
            qlen,
        }
    }

    #[test]
    fn a_drop_is_a_loss_where_there_was_room_all_the_time() {
        let mut tally = TcTally::new(Way::Up);
        tally.room(100, false);
        tally.changed(3_000);
        tally.changed(5_000);
        let row = tally.row(1, counters(50, 9, 10));
        assert_eq!((row.delivered, row.lost, row.dropped), (50, 9, 0));
        assert_eq!((row.bytes, row.queued, row.changes), (50 * 84, 10, 2));
        assert_eq!((row.late_mean_us, row.late_max_us), (4.0, 5.0));
        // 10 were there and 100 came (40 left, 11 were dropped, 59 wait): more than the room for 100.
        let row = tally.row(2, counters(90, 20, 59));
        assert_eq!((row.lost, row.dropped, row.overflow), (0, 11, 0));
        assert_eq!((row.changes, row.late_max_us), (0, 0.0));
        let report = tally.report();
        assert_eq!(report.packets, 90 + 20 + 59);
        assert_eq!((report.lost, report.dropped, report.unplayed), (9, 11, 59));
    }

    #[test]
    fn behind_a_rate_limit_a_full_queue_is_the_link_s_own() {
        let mut tally = TcTally::new(Way::Down);
        tally.room(100, true);
        let row = tally.row(1, counters(50, 50, 0));
        assert_eq!((row.lost, row.dropped, row.overflow), (0, 0, 50));
    }
}
