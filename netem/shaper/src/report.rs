//! What the player counts: a running tally per way, the rows made of it each second, and the
//! report at the end. What two players that shape a way each report together is in
//! [`played`](crate::played).

use link::{Cause, Way};
use serde::{Deserialize, Serialize};

use crate::lateness::{Histogram, Lateness};
use crate::port::PortCounters;
use crate::scheduling::Scheduling;

/// One way of the link over one second: a row of `link.csv`. The counts are of that second
/// alone, so that a column can be summed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LinkRow {
    /// The end of the second, monotonic.
    pub t_ns: u64,
    /// Which way.
    pub way: Way,
    /// IPv4 packets that entered.
    pub packets: u64,
    /// Their length, IP headers included.
    pub bytes: u64,
    /// Packets that left at the other end.
    pub delivered: u64,
    /// Packets that the link lost.
    pub lost: u64,
    /// Packets that found the link's queue full.
    pub overflow: u64,
    /// Frames that were no IPv4, or a stranger's, and are not forwarded.
    pub foreign: u64,
    /// Packets that the player itself lost, which it must not.
    pub dropped: u64,
    /// Mean lateness of the departures, us; 0 if there were none.
    pub late_mean_us: f64,
    /// Greatest lateness of a departure, us.
    pub late_max_us: f64,
}

/// One way of the link over the whole play.
///
/// `packets = delivered + lost + overflow + unplayed` and those of `dropped` that were lost
/// in sending.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct WayReport {
    /// IPv4 packets that entered.
    pub packets: u64,
    /// Their length, IP headers included.
    pub bytes: u64,
    /// Packets that left at the other end.
    pub delivered: u64,
    /// Packets that the link lost.
    pub lost: u64,
    /// Packets that found the link's queue full.
    pub overflow: u64,
    /// Packets that were still under way at the end.
    pub unplayed: u64,
    /// Frames that were no IPv4, or a stranger's, and are not forwarded.
    pub foreign: u64,
    /// Packets that the player itself lost: its socket was full, or sending failed. Anything
    /// but 0 makes a run invalid.
    pub dropped: u64,
    /// How late the departures were.
    pub lateness: Lateness,
}

/// A time that the player was kept from its processor, or stopped, though it had something to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Pause {
    /// When it ended, monotonic.
    pub t_ns: u64,
    /// How long it was.
    pub ns: u64,
}

/// What the player did.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct PlayerReport {
    /// What the kernel granted the player's thread.
    pub scheduling: Scheduling,
    /// The monotonic instant of link time 0.
    pub epoch_ns: u64,
    /// When it began to play, monotonic.
    pub started_ns: u64,
    /// When it ended, monotonic.
    pub ended_ns: u64,
    /// When it was held up for 5 ms or more; the first hundred.
    #[serde(default)]
    pub pauses: Vec<Pause>,
    /// From controller to plant.
    pub up: WayReport,
    /// From plant to controller.
    pub down: WayReport,
}

impl PlayerReport {
    /// Packets that the player itself lost. Anything but 0 makes a run invalid.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.up.dropped + self.down.dropped
    }
}

/// What has happened on one way so far.
#[derive(Debug)]
pub(crate) struct Tally {
    way: Way,
    counts: Counts,
    /// The counts at the last row.
    counted: Counts,
    late: Histogram,
    /// Of the departures since the last row.
    late_max_ns: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    packets: u64,
    bytes: u64,
    delivered: u64,
    lost: u64,
    overflow: u64,
    unsent: u64,
    late_ns: u64,
    port: PortCounters,
}

impl Counts {
    fn dropped(&self) -> u64 {
        self.port.dropped + self.unsent
    }
}

impl Tally {
    pub(crate) fn new(way: Way) -> Self {
        Self {
            way,
            counts: Counts::default(),
            counted: Counts::default(),
            late: Histogram::new(),
            late_max_ns: 0,
        }
    }

    /// A packet came in, and the link has spoken.
    pub(crate) fn entered(&mut self, ip_bytes: u32, dropped: Option<Cause>) {
        self.counts.packets += 1;
        self.counts.bytes += u64::from(ip_bytes);
        match dropped {
            None => {}
            Some(Cause::Loss) => self.counts.lost += 1,
            Some(Cause::Overflow) => self.counts.overflow += 1,
        }
    }

    /// A packet was due and has been sent, or the attempt failed.
    pub(crate) fn left(&mut self, late_ns: u64, sent: bool) {
        if !sent {
            self.counts.unsent += 1;
            return;
        }
        self.counts.delivered += 1;
        self.counts.late_ns += late_ns;
        self.late_max_ns = self.late_max_ns.max(late_ns);
        self.late.add(late_ns);
    }

    /// Takes over what the port has counted since it was opened.
    pub(crate) fn update(&mut self, port: PortCounters) {
        self.counts.port = port;
    }

    /// What happened since the last row.
    pub(crate) fn row(&mut self, t_ns: u64) -> LinkRow {
        let (now, before) = (self.counts, self.counted);
        let delivered = now.delivered - before.delivered;
        let row = LinkRow {
            t_ns,
            way: self.way,
            packets: now.packets - before.packets,
            bytes: now.bytes - before.bytes,
            delivered,
            lost: now.lost - before.lost,
            overflow: now.overflow - before.overflow,
            foreign: now.port.foreign - before.port.foreign,
            dropped: now.dropped() - before.dropped(),
            late_mean_us: (now.late_ns - before.late_ns) as f64 / delivered.max(1) as f64 * 1e-3,
            late_max_us: self.late_max_ns as f64 * 1e-3,
        };
        self.counted = now;
        self.late_max_ns = 0;
        row
    }

    /// The sum of it all, with so many packets left unplayed.
    pub(crate) fn report(&self, unplayed: u64) -> WayReport {
        WayReport {
            packets: self.counts.packets,
            bytes: self.counts.bytes,
            delivered: self.counts.delivered,
            lost: self.counts.lost,
            overflow: self.counts.overflow,
            unplayed,
            foreign: self.counts.port.foreign,
            dropped: self.counts.dropped(),
            lateness: self.late.summary(),
        }
    }
}
