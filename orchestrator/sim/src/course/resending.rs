//! The timers of packets under way. A lost packet is sent again when its timer ends; a packet that
//! was not lost but waits behind a rate limit may be sent again in vain.

use endpoint::Model;
use link::Way;

use super::Course;
use super::passage::{Event, Packet};
use crate::connection::Id;
use crate::record::Record;
use crate::retransmission::{handshake_pause_ns, pause_ns};

/// Length of an IP packet that acknowledges a duplicate and reports it (DSACK).
const DUPLICATE_BYTES: u32 = 64;

impl<R: Record, M: Model + Clone> Course<'_, R, M> {
    /// When the sender's timer ends, if it is set as the packet is sent for the `tries`-th time.
    pub(super) fn rings_again_ns(&self, id: Id, packet: Packet, tries: u16, now_ns: u64) -> u64 {
        let pause_ns = match packet {
            Packet::Syn | Packet::SynAck => handshake_pause_ns(packet == Packet::Syn, tries),
            Packet::Request | Packet::Answer => {
                let round_trip = self.connections.round_trip(id, packet == Packet::Answer);
                pause_ns(round_trip, tries)
            }
        };
        self.wheel.rings_ns(now_ns, pause_ns)
    }

    /// A packet that gets through was sent for the `tries`-th time: sets its sender's timer.
    pub(super) fn waits_to_hear(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        if let Some(turn) = self.connections.turn(id) {
            let rings_ns = self.rings_again_ns(id, packet, tries, now_ns);
            let event = Event::Unheard(id, packet, tries, turn);
            self.queue.push(rings_ns, event);
        }
    }

    /// A sender's timer has ended although its packet was not lost. Unless the sender has been answered
    /// meanwhile, it sends the packet again, and the receiver acknowledges the duplicate at once.
    pub(super) fn sends_in_vain(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        let (way, bytes) = self.shape(packet);
        if let Some(out_ns) = self.cross(way, now_ns, bytes) {
            self.queue.push(out_ns, Event::Twice(way));
        }
        self.waits_to_hear(id, packet, tries.saturating_add(1), now_ns);
    }

    /// A duplicate arrived this way, and is acknowledged with a packet of its own.
    pub(super) fn acknowledges_twice(&mut self, way: Way, now_ns: u64) {
        let _ = self.cross(way.back(), now_ns, DUPLICATE_BYTES);
    }
}
