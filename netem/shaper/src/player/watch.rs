//! Detects when a player had something to do but was stopped or got no processor.
//!
//! Pure: instants are passed as arguments. A player that works without a rest is not held up, however
//! late its packets are; their lateness shows that.

use link::certificate::Pause;

/// A shorter pause may be a time slice, and shows in the lateness of the packets.
const PAUSE_NS: u64 = 5_000_000;

/// Pauses that are kept; a player that is stopped ten times a second keeps those of ten seconds.
const KEPT: usize = 100;

/// What a player knows of its own time.
#[derive(Debug)]
pub(crate) struct Watch {
    /// Until when it had reason to be idle, or when it was last seen at work.
    busy_from_ns: u64,
    /// When it was last seen at work. A packet that came earlier waited for its turn until then.
    worked_ns: u64,
    /// Whether it has just rested, so that the first packet it finds may have waited for it.
    rested: bool,
    pub(crate) pauses: Vec<Pause>,
}

impl Watch {
    pub(crate) fn new(now_ns: u64) -> Self {
        Self {
            busy_from_ns: now_ns,
            worked_ns: now_ns,
            rested: false,
            pauses: Vec::with_capacity(KEPT),
        }
    }

    /// The player rests until `t_ns`, or until a packet comes.
    pub(crate) fn rest_until(&mut self, t_ns: u64) {
        self.busy_from_ns = t_ns;
        self.rested = true;
    }

    /// The player takes a packet that the kernel received at `stamp_ns`. The first packet after a
    /// rest ended the rest.
    pub(crate) fn on_arrival(&mut self, stamp_ns: u64) {
        if self.rested {
            let waits_from_ns = stamp_ns.max(self.worked_ns);
            self.busy_from_ns = self.busy_from_ns.min(waits_from_ns);
            self.rested = false;
        }
    }

    /// The player is at work.
    pub(crate) fn beat(&mut self, now_ns: u64) {
        let ns = now_ns.saturating_sub(self.busy_from_ns);
        if ns >= PAUSE_NS && self.pauses.len() < KEPT {
            self.pauses.push(Pause { t_ns: now_ns, ns });
        }
        self.busy_from_ns = now_ns;
        self.worked_ns = now_ns;
        self.rested = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn pauses(watch: &Watch) -> Vec<(u64, u64)> {
        let ms = |pause: &Pause| (pause.t_ns / MS, pause.ns / MS);
        watch.pauses.iter().map(ms).collect()
    }

    #[test]
    fn a_rest_that_ends_in_time_is_none_and_one_that_does_not_is() {
        let mut watch = Watch::new(0);
        watch.rest_until(50 * MS);
        watch.beat(50 * MS);
        watch.rest_until(100 * MS);
        watch.beat(120 * MS);
        assert_eq!(pauses(&watch), [(120, 20)]);
    }

    #[test]
    fn a_packet_that_ends_a_rest_and_waits_tells_of_a_pause() {
        let mut watch = Watch::new(0);
        watch.rest_until(50 * MS);
        watch.on_arrival(10 * MS);
        // The second packet does not count: the first one ended the rest.
        watch.on_arrival(9 * MS);
        watch.beat(40 * MS);
        assert_eq!(pauses(&watch), [(40, 30)]);
    }

    #[test]
    fn packets_that_wait_for_their_turn_in_a_burst_are_no_pause_though_it_looks_for_more_between() {
        let mut watch = Watch::new(0);
        for t_ms in 20..30 {
            watch.beat(t_ms * MS);
            watch.rest_until(50 * MS);
            // This packet came with the burst, before packets that were taken earlier.
            watch.on_arrival(MS);
        }
        assert_eq!(pauses(&watch), [(20, 20)]);
        watch.beat(36 * MS);
        assert_eq!(pauses(&watch), [(20, 20), (36, 7)]);
    }

    #[test]
    fn one_that_works_through_a_burst_is_not_held_up() {
        let mut watch = Watch::new(0);
        for t_ms in 1..100 {
            watch.on_arrival(0);
            watch.beat(t_ms * MS);
        }
        assert!(watch.pauses.is_empty());
        watch.beat(130 * MS);
        assert_eq!(pauses(&watch), [(130, 31)]);
    }
}
