//! The player without its sockets: packets that have entered wait here for their departure.
//!
//! Pure: time is passed as an argument. Packets with equal departures leave in order of entry.

use std::collections::VecDeque;

use link::{Cause, Fate, PerWay, Timeline, Twist, Way};

use crate::player::twist;
use crate::port::frame::{Frame, Pool};
use crate::port::{Arrival, ETHERNET_HEADER};

/// Number of frames that wait for packets from the beginning: two ways at 1 kHz, with an answer to each message,
/// over a link of 50 ms. Where more packets are under way, as in a stall, there are soon more.
const POOL: usize = 256;

/// A packet that is due to leave.
#[derive(Debug)]
pub(crate) struct Departure {
    /// When it is due, monotonic.
    pub(crate) at_ns: u64,
    /// Number of packets that entered before it.
    sequence: u64,
    /// The direction in which it leaves.
    pub(crate) way: Way,
    /// Packets that a wire would carry for it.
    pub(crate) packets: u32,
    frame: Frame,
    frame_bytes: usize,
}

impl Departure {
    /// The frame to send.
    pub(crate) fn frame(&self) -> &[u8] {
        &self.frame[..self.frame_bytes]
    }

    fn key(&self) -> (u64, u64) {
        (self.at_ns, self.sequence)
    }
}

/// The packets under way on a link.
#[derive(Debug)]
pub(crate) struct Relay {
    timeline: Timeline,
    /// A way that another player shapes: its packets are due when they enter.
    carried: Option<Way>,
    /// Of each way, in the order in which they leave. Nearly always that is the order of entry.
    waiting: PerWay<VecDeque<Departure>>,
    pub(crate) pool: Pool,
    sequence: u64,
    /// The latest entry of each way: link time never runs backwards.
    entered_ns: PerWay<u64>,
}

impl Relay {
    pub(crate) fn new(timeline: Timeline) -> Self {
        Self {
            timeline,
            carried: None,
            waiting: PerWay::of(|_| VecDeque::with_capacity(POOL)),
            pool: Pool::with_frames(POOL),
            sequence: 0,
            entered_ns: PerWay::default(),
        }
    }

    /// The same relay, but it only carries the packets of this way without shaping them.
    pub(crate) fn carrying(self, way: Way) -> Self {
        Self {
            carried: Some(way),
            ..self
        }
    }

    /// Lets a packet enter the link. Returns what is done to it, or the cause if the link drops it.
    pub(crate) fn enter(
        &mut self,
        way: Way,
        arrival: &Arrival,
        frame: Frame,
    ) -> Result<Twist, Cause> {
        let entered_ns = &mut self.entered_ns[way];
        *entered_ns = arrival.stamp_ns.max(*entered_ns);
        let fate = if self.carried == Some(way) {
            Fate::Deliver {
                at: *entered_ns,
                twist: Twist::NONE,
            }
        } else {
            self.timeline.transmit(way, *entered_ns, arrival.ip_bytes)
        };
        match fate {
            Fate::Deliver { at: at_ns, twist } if twist == Twist::NONE => {
                self.push(at_ns, way, frame, arrival);
                Ok(twist)
            }
            Fate::Deliver { at: at_ns, twist } => Ok(self.twist(at_ns, way, arrival, frame, twist)),
            Fate::Drop(cause) => {
                self.pool.put(frame);
                Err(cause)
            }
        }
    }

    fn push(&mut self, at_ns: u64, way: Way, frame: Frame, arrival: &Arrival) {
        let departure = Departure {
            at_ns,
            sequence: self.sequence,
            way,
            packets: arrival.packets,
            frame,
            frame_bytes: arrival.frame_bytes,
        };
        self.sequence += 1;
        let waiting = &mut self.waiting[way];
        if waiting.back().is_some_and(|last| at_ns < last.at_ns) {
            // Packets that a fault holds back are overtaken.
            let place = waiting.partition_point(|earlier| earlier.at_ns <= at_ns);
            waiting.insert(place, departure);
        } else {
            waiting.push_back(departure);
        }
    }

    /// Lets a packet leave as a fault changes it, and with it its duplicate. Returns what was done.
    #[cold]
    fn twist(
        &mut self,
        at_ns: u64,
        way: Way,
        arrival: &Arrival,
        mut frame: Frame,
        twist: Twist,
    ) -> Twist {
        let Arrival {
            frame_bytes, ip_at, ..
        } = *arrival;
        let (bytes, done) = twist::apply(&mut frame[ip_at..frame_bytes], way, twist);
        if done.flip.is_some() {
            // A checksum that was left for later would make the damage good.
            frame[..ip_at.saturating_sub(ETHERNET_HEADER)].fill(0);
        }
        let twisted = Arrival {
            frame_bytes: ip_at + bytes,
            ..*arrival
        };
        if done.twice {
            let mut twin = self.pool.take(frame_bytes);
            twin[..frame_bytes].copy_from_slice(&frame[..frame_bytes]);
            self.push(at_ns, way, twin, &twisted);
        }
        self.push(at_ns, way, frame, &twisted);
        done
    }

    /// When the latest packet of a way entered.
    pub(crate) fn entered_ns(&self, way: Way) -> u64 {
        self.entered_ns[way]
    }

    /// Whether another player shapes this way.
    pub(crate) fn is_carried(&self, way: Way) -> bool {
        self.carried == Some(way)
    }

    /// The packet that leaves next.
    fn next(&self) -> Option<&Departure> {
        let fronts = Way::BOTH.map(|way| self.waiting[way].front());
        fronts.into_iter().flatten().min_by_key(|next| next.key())
    }

    /// When the next packet is due.
    pub(crate) fn next_ns(&self) -> Option<u64> {
        self.next().map(|next| next.at_ns)
    }

    /// The next packet, if it is due by `now_ns`. Return it with [`finish`](Self::finish).
    pub(crate) fn pop_due(&mut self, now_ns: u64) -> Option<Departure> {
        let way = self.next().filter(|next| next.at_ns <= now_ns)?.way;
        self.waiting[way].pop_front()
    }

    /// Takes back a packet that has left.
    pub(crate) fn finish(&mut self, departure: Departure) {
        self.pool.put(departure.frame);
    }

    /// How many packets of this way are still under way.
    pub(crate) fn under_way(&self, way: Way) -> u64 {
        let packets = |departure: &Departure| u64::from(departure.packets);
        self.waiting[way].iter().map(packets).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use link::{Epoch, Profile};
    use proptest::prelude::*;

    const EPOCH_NS: u64 = 1_000_000_000;

    /// A packet in a frame of this length.
    fn packet(frame_bytes: usize, stamp_ns: u64) -> Arrival {
        Arrival {
            frame_bytes,
            ip_at: 14,
            packets: 1,
            ip_bytes: frame_bytes as u32 - 14,
            stamp_ns,
        }
    }

    fn profile(name: &str) -> Profile {
        let source = Profile::builtin(name).expect("one of the paper's");
        Profile::parse(source, name).expect("a valid profile")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Arrivals on both ways with any gaps, over the stalling and lossy link: each packet is
        /// either dropped or leaves once, whole, at the instant that the timeline gives for its
        /// entry, and in the order of these instants.
        #[test]
        fn each_packet_leaves_when_the_timeline_says_or_is_dropped(
            seed in any::<u64>(),
            gaps in prop::collection::vec((0_u64..20_000_000, any::<bool>()), 1..400),
        ) {
            let couva = profile("couva");
            let mut relay = Relay::new(Timeline::new(&couva, seed, Epoch::at_ns(EPOCH_NS)));
            let mut stated = Timeline::new(&couva, seed, Epoch::at_ns(EPOCH_NS));
            let (mut t_ns, mut dropped, mut most, mut due) = (EPOCH_NS, 0, 0, Vec::new());
            for (number, (gap_ns, up)) in gaps.iter().enumerate() {
                t_ns += gap_ns;
                let way = if *up { Way::Up } else { Way::Down };
                let mut frame = relay.pool.take(64);
                frame[..8].copy_from_slice(&(number as u64).to_le_bytes());
                let arrival = packet(64 + number, t_ns);
                let state = stated.state_at(way, t_ns);
                match relay.enter(way, &arrival, frame) {
                    Ok(twist) => {
                        prop_assert_eq!(twist, Twist::NONE);
                        due.push((t_ns + state.delay_ns, number));
                    }
                    Err(_) => {
                        prop_assert!(state.lost);
                        dropped += 1;
                    }
                }
                most = most.max(relay.under_way(Way::Up) + relay.under_way(Way::Down));
            }
            due.sort_unstable();
            prop_assert_eq!(relay.under_way(Way::Up) + relay.under_way(Way::Down), due.len() as u64);
            for (at_ns, number) in &due {
                prop_assert_eq!(relay.next_ns(), Some(*at_ns));
                prop_assert!(relay.pop_due(at_ns - 1).is_none());
                let departure = relay.pop_due(*at_ns).expect("due now");
                prop_assert_eq!(departure.frame().len(), 64 + number);
                prop_assert_eq!(&departure.frame()[..8], &(*number as u64).to_le_bytes()[..]);
                relay.finish(departure);
            }
            prop_assert_eq!(due.len() + dropped, gaps.len());
            prop_assert_eq!(relay.next_ns(), None);
            // Every frame is back in the pool, which has grown only to what was under way at once.
            prop_assert!((POOL..=POOL.max(most as usize + 1)).contains(&relay.pool.frames()));
        }
    }

    const FAULTS: &str = "name = 'f'\nabout = ''\nboth.delay.base = '2ms'\n\
        fault = [{ at = '0s', for = '300ms', every = '500ms', duplicate = '50%' },\n\
        { at = '0s', for = '200ms', period = '300ms', corrupt = '50%' },\n\
        { at = '0s', for = '300ms', every = '400ms', reorder = '50%' },\n\
        { at = '0s', for = '100ms', every = '400ms', loss = '50%' },\n\
        { at = '0s', for = '90ms', every = '300ms', reset = true },\n\
        { at = '0s', for = '90ms', every = '300ms', rebind = true }]";

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Each packet's fate is the timeline's, packet by packet: lost, or out at its instant, twice if
        /// so, with one bit flipped if so. What is no segment of TCP is neither reset nor rebound.
        #[test]
        fn each_packet_is_twisted_as_the_timeline_says(
            seed in any::<u64>(), gaps in prop::collection::vec((0_u64..20_000_000, any::<bool>()), 1..300),
        ) {
            let faults = Profile::parse(FAULTS, "faults").expect("a valid profile");
            let epoch = Epoch::at_ns(EPOCH_NS);
            let mut relay = Relay::new(Timeline::new(&faults, seed, epoch));
            let mut decided = Timeline::new(&faults, seed, epoch);
            let mut stated = Timeline::new(&faults, seed, epoch);
            let (mut t_ns, mut due) = (EPOCH_NS, Vec::new());
            for (number, (gap_ns, is_up)) in gaps.iter().enumerate() {
                t_ns += gap_ns;
                let way = if *is_up { Way::Up } else { Way::Down };
                let mut frame = relay.pool.take(64);
                // An IPv4 packet of another protocol, behind an Ethernet header.
                frame[..14].fill(9);
                frame[14..74].fill(0);
                frame[14] = 0x45;
                frame[17] = 60;
                frame[34..42].copy_from_slice(&(number as u64).to_le_bytes());
                let arrival = packet(74, t_ns);
                let entry = relay.enter(way, &arrival, frame);
                let state = stated.state_at(way, t_ns);
                match decided.transmit(way, t_ns, 60) {
                    Fate::Drop(cause) => prop_assert_eq!(entry, Err(cause)),
                    Fate::Deliver { at, twist } => {
                        prop_assert_eq!(entry, Ok(Twist { reset: false, rebind: false, ..twist }));
                        prop_assert_eq!((at, twist.flip.is_some()), (t_ns + state.delay_ns, state.lost));
                        let times = if twist.twice { 2 } else { 1 };
                        due.extend(std::iter::repeat_n((at, due.len(), number, twist.flip), times));
                    }
                }
            }
            due.sort_by_key(|(at_ns, ..)| *at_ns);
            for (at_ns, _, number, flip) in due {
                prop_assert_eq!(relay.next_ns(), Some(at_ns));
                let departure = relay.pop_due(at_ns).expect("due now");
                let mut frame = departure.frame().to_vec();
                prop_assert_eq!(frame.len(), 74);
                if let Some(bit) = flip {
                    let bit = bit as usize % 320;
                    frame[34 + bit / 8] ^= 1 << (bit % 8);
                }
                prop_assert_eq!(&frame[34..42], &(number as u64).to_le_bytes()[..]);
                prop_assert!(frame[..14].iter().all(|byte| *byte == 9));
                relay.finish(departure);
            }
            prop_assert_eq!(relay.next_ns(), None);
        }
    }

    #[test]
    fn a_damaged_packet_has_no_checksum_that_was_left_for_later() {
        let text = "name = 'f'\nabout = ''\nboth.delay.base = '2ms'\n\
            fault = [{ at = '0s', for = '1s', corrupt = '100%' }]";
        let faults = Profile::parse(text, "faults").expect("a valid profile");
        let mut relay = Relay::new(Timeline::new(&faults, 1, Epoch::at_ns(0)));
        let mut frame = relay.pool.take(84);
        frame[..24].fill(9);
        frame[24..84].fill(0);
        frame[24] = 0x45;
        frame[27] = 60;
        let arrival = Arrival {
            ip_at: 24,
            ..packet(84, 5)
        };
        let entry = relay.enter(Way::Up, &arrival, frame);
        assert!(entry.expect("it is let out").flip.is_some());
        let departure = relay.pop_due(u64::MAX).expect("it leaves");
        assert_eq!(departure.frame()[..10], [0; 10]);
        assert_eq!(departure.frame()[10..24], [9; 14]);
    }

    #[test]
    fn before_the_epoch_the_empty_link_plays() {
        let mut relay = Relay::new(Timeline::new(
            &profile("diego-vpn"),
            1,
            Epoch::at_ns(EPOCH_NS),
        ));
        let frame = relay.pool.take(64);
        let arrival = packet(64, EPOCH_NS - 1);
        assert_eq!(relay.enter(Way::Up, &arrival, frame), Ok(Twist::NONE));
        // The empty link: 2 ms.
        assert_eq!(relay.next_ns(), Some(EPOCH_NS - 1 + 2_000_000));
    }

    #[test]
    fn a_carried_way_is_due_at_once_and_the_other_way_is_shaped_as_ever() {
        let constant = "name = \"c\"\nabout = \"c\"\n[both.delay]\nbase = \"5ms\"\n";
        let constant = Profile::parse(constant, "a test").expect("a valid profile");
        let mut relay =
            Relay::new(Timeline::new(&constant, 1, Epoch::default())).carrying(Way::Down);
        for (way, due_ns) in [(Way::Down, 9_000), (Way::Up, 5_009_000)] {
            let frame = relay.pool.take(64);
            let arrival = packet(64, 9_000);
            assert_eq!(relay.enter(way, &arrival, frame), Ok(Twist::NONE));
            assert_eq!(relay.next_ns(), Some(due_ns));
            let departure = relay.pop_due(due_ns).expect("due now");
            assert_eq!(departure.way, way);
            relay.finish(departure);
        }
    }

    #[test]
    fn a_stamp_before_the_last_one_enters_with_the_last_one() {
        let mut relay = Relay::new(Timeline::new(&Profile::empty(), 1, Epoch::default()));
        for stamp_ns in [9_000, 5_000] {
            let frame = relay.pool.take(64);
            let arrival = packet(64, stamp_ns);
            assert_eq!(relay.enter(Way::Up, &arrival, frame), Ok(Twist::NONE));
        }
        assert!(relay.pop_due(2_009_000).is_some() && relay.pop_due(2_009_000).is_some());
    }
}
