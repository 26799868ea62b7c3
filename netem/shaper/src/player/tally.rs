//! What the player counts: a running tally per way, the source of the rows of each second and of the
//! report at the end.

use link::certificate::{Histogram, LinkRow, WayReport};
use link::{Cause, Twist, Way};

use crate::port::PortCounters;

/// What has happened on one way so far.
#[derive(Debug)]
pub(crate) struct Tally {
    way: Way,
    counts: Counts,
    /// The counts at the last row.
    counted: Counts,
    late: Histogram,
    /// Greatest lateness of the departures since the last row.
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
    duplicated: u64,
    corrupted: u64,
    reset: u64,
    rebound: u64,
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

    /// Packets have entered at once, mostly one, and the link has decided their fate.
    pub(crate) fn entered(&mut self, packets: u32, ip_bytes: u32, entry: Result<Twist, Cause>) {
        let packets = u64::from(packets);
        self.counts.packets += packets;
        self.counts.bytes += u64::from(ip_bytes);
        match entry {
            Ok(Twist::NONE) => {}
            Ok(twist) => {
                self.counts.duplicated += u64::from(twist.twice);
                self.counts.corrupted += u64::from(twist.flip.is_some());
                self.counts.reset += u64::from(twist.reset);
                self.counts.rebound += u64::from(twist.rebind);
            }
            Err(Cause::Loss) => self.counts.lost += packets,
            Err(Cause::Overflow) => self.counts.overflow += packets,
        }
    }

    /// Packets were due at once, mostly one, and were sent, or sending them failed.
    pub(crate) fn left(&mut self, packets: u32, late_ns: u64, sent: bool) {
        let packets = u64::from(packets);
        if !sent {
            self.counts.unsent += packets;
            return;
        }
        self.counts.delivered += packets;
        self.counts.late_ns += late_ns * packets;
        self.late_max_ns = self.late_max_ns.max(late_ns);
        self.late.add(late_ns, packets);
    }

    /// Updates the port's counts since it was opened.
    pub(crate) fn update(&mut self, port: PortCounters) {
        self.counts.port = port;
    }

    /// The row of everything since the last row.
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

    /// The total, with `unplayed` packets left under way.
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
            duplicated: self.counts.duplicated,
            corrupted: self.counts.corrupted,
            reset: self.counts.reset,
            rebound: self.counts.rebound,
            lateness: self.late.summary(),
        }
    }
}
