//! What a fault of the link does to the bytes of a packet: a bit flipped, a segment made a reset, a port
//! changed.
//!
//! Pure, and without a table of connections: each packet is rewritten by itself. A packet that is not
//! what it should be, cut off or already damaged, is left as it is, so that nothing broken becomes valid.

use link::{Twist, Way};

/// What is added to the controller's port while ports are changed, bit by bit, so that it undoes itself: far
/// from the port in the order in which Linux gives ports out, which are from 32768 to 60999.
const PORT_BIT: u16 = 0x2000;

const IP_HEADER: usize = 20;
const TCP_HEADER: usize = 20;
const TCP: u8 = 6;

const SYN: u8 = 0x02;
const RST: u8 = 0x04;
const ACK: u8 = 0x10;

/// Changes an IPv4 packet as a fault asks. Returns its new length, and what of the twist was done to it:
/// resets and ports concern TCP only.
pub(crate) fn apply(packet: &mut [u8], way: Way, twist: Twist) -> (usize, Twist) {
    let mut done = Twist {
        twice: twist.twice,
        ..Twist::NONE
    };
    let mut bytes = packet.len();
    if twist.rebind {
        done.rebind = rebind(packet, way);
    }
    if twist.reset
        && let Some(short) = reset(packet)
    {
        bytes = short;
        done.reset = true;
    }
    // Last, since a damaged packet is not rewritten.
    if let Some(bit) = twist.flip
        && flip(&mut packet[..bytes], bit)
    {
        done.flip = Some(bit);
    }
    (bytes, done)
}

/// Where the parts of an IPv4 packet are.
#[derive(Debug, Clone, Copy)]
struct Parts {
    /// Length of the IP header.
    header: usize,
    /// Length of the packet by its header, which a frame may exceed.
    total: usize,
}

fn word(bytes: &[u8], at: usize) -> u16 {
    u16::from_be_bytes([bytes[at], bytes[at + 1]])
}

fn put(bytes: &mut [u8], at: usize, word: u16) {
    bytes[at..at + 2].copy_from_slice(&word.to_be_bytes());
}

/// The parts of a packet that is whole.
fn parts(packet: &[u8]) -> Option<Parts> {
    let first = *packet.first()?;
    let header = usize::from(first & 0x0f) * 4;
    if first >> 4 != 4 || header < IP_HEADER || header > packet.len() {
        return None;
    }
    let total = usize::from(word(packet, 2));
    (header..=packet.len())
        .contains(&total)
        .then_some(Parts { header, total })
}

/// The parts of a packet that is a whole and undamaged segment of TCP.
fn segment(packet: &[u8]) -> Option<Parts> {
    let parts = parts(packet)?;
    let Parts { header, total } = parts;
    let is_fragment = word(packet, 6) & 0x3fff != 0;
    if packet[9] != TCP || is_fragment || total < header + TCP_HEADER {
        return None;
    }
    let data = header + usize::from(packet[header + 12] >> 4) * 4;
    let is_whole = (header + TCP_HEADER..=total).contains(&data);
    let is_sound = sum(&packet[..header], 0) == 0xffff && tcp_sum(packet, parts) == 0xffff;
    (is_whole && is_sound).then_some(parts)
}

/// The ones' complement sum of 16-bit words (RFC 1071), added to another.
fn sum(bytes: &[u8], before: u16) -> u16 {
    let words = bytes.chunks(2).map(|word| {
        let low = word.get(1).copied().unwrap_or(0);
        u32::from(u16::from_be_bytes([word[0], low]))
    });
    let mut sum: u32 = words.sum::<u32>() + u32::from(before);
    while sum > 0xffff {
        sum = (sum & 0xffff) + (sum >> 16);
    }
    sum as u16
}

/// The sum over a segment with its checksum and the header that TCP adds in thought (RFC 9293, 3.1).
fn tcp_sum(packet: &[u8], Parts { header, total }: Parts) -> u16 {
    let length = (total - header) as u16;
    let addresses = sum(&packet[12..20], 0);
    let thought = sum(&length.to_be_bytes(), sum(&[0, TCP], addresses));
    sum(&packet[header..total], thought)
}

/// Flips a bit behind the IP header. Any checksum of 16-bit words finds it.
fn flip(packet: &mut [u8], bit: u32) -> bool {
    let Some(Parts { header, total }) = parts(packet) else {
        return false;
    };
    let payload = &mut packet[header..total];
    let bits = payload.len() * 8;
    if bits == 0 {
        return false;
    }
    let bit = bit as usize % bits;
    payload[bit / 8] ^= 1 << (bit % 8);
    true
}

/// Makes a segment a reset, with its own sequence number: the one that its receiver expects next, if none
/// before it was lost, and no other resets a connection (RFC 5961). Returns its length.
fn reset(packet: &mut [u8]) -> Option<usize> {
    let Parts { header, .. } = segment(packet)?;
    let flags = packet[header + 13];
    if flags & (SYN | RST) != 0 {
        return None;
    }
    let total = header + TCP_HEADER;
    put(packet, 2, total as u16);
    put(packet, 10, 0);
    put(packet, 10, !sum(&packet[..header], 0));
    packet[header + 12] = (TCP_HEADER as u8 / 4) << 4;
    packet[header + 13] = RST | flags & ACK;
    // The window, the checksum, and the pointer to what is urgent.
    packet[header + 14..total].fill(0);
    let checksum = !tcp_sum(packet, Parts { header, total });
    put(packet, header + 16, checksum);
    Some(total)
}

/// Changes the controller's port: of the sender up, of the receiver down. Done twice, nothing is changed.
fn rebind(packet: &mut [u8], way: Way) -> bool {
    let Some(Parts { header, .. }) = segment(packet) else {
        return false;
    };
    let at = match way {
        Way::Up => header,
        Way::Down => header + 2,
    };
    let before = word(packet, at);
    let after = before ^ PORT_BIT;
    if after == 0 {
        return false;
    }
    put(packet, at, after);
    // RFC 1624: HC' = ~(~HC + ~m + m').
    let known = !word(packet, header + 16);
    let moved = sum(&after.to_be_bytes(), sum(&(!before).to_be_bytes(), known));
    put(packet, header + 16, !moved);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A segment with options in both headers, its checksums computed word by word.
    fn packet(ip_options: usize, tcp_options: usize, flags: u8, payload: &[u8]) -> Vec<u8> {
        let (header, data) = (IP_HEADER + 4 * ip_options, TCP_HEADER + 4 * tcp_options);
        let mut packet = vec![1; header + data];
        packet.extend_from_slice(payload);
        let total = packet.len() as u16;
        packet[0] = 0x40 + (header / 4) as u8;
        packet[2..4].copy_from_slice(&total.to_be_bytes());
        packet[6..8].copy_from_slice(&[0x40, 0]);
        packet[9] = 6;
        packet[10..12].fill(0);
        packet[12..20].copy_from_slice(&[10, 77, 0, 1, 10, 77, 0, 2]);
        packet[header..header + 4].copy_from_slice(&[0x9c, 0x41, 0x0f, 0xa0]);
        packet[header + 12] = ((data / 4) << 4) as u8;
        packet[header + 13] = flags;
        packet[header + 16..header + 18].fill(0);
        let own = checksum(&packet[..header]);
        packet[10..12].copy_from_slice(&own.to_be_bytes());
        let own = checksum(&thought(&packet, header));
        packet[header + 16..header + 18].copy_from_slice(&own.to_be_bytes());
        packet
    }

    /// A segment behind the header that TCP adds in thought.
    fn thought(packet: &[u8], header: usize) -> Vec<u8> {
        let length = (packet.len() - header) as u16;
        let mut bytes = packet[12..20].to_vec();
        bytes.extend([0, 6]);
        bytes.extend(length.to_be_bytes());
        bytes.extend(&packet[header..]);
        bytes
    }

    /// As RFC 1071 describes it, in a number that cannot overflow and is folded at the end.
    fn checksum(bytes: &[u8]) -> u16 {
        let mut padded = bytes.to_vec();
        padded.resize(bytes.len().next_multiple_of(2), 0);
        let mut sum = 0_u64;
        for at in (0..padded.len()).step_by(2) {
            sum += u64::from(padded[at]) * 256 + u64::from(padded[at + 1]);
        }
        while sum > 0xffff {
            sum = sum / 0x1_0000 + sum % 0x1_0000;
        }
        !(sum as u16)
    }

    fn is_sound(packet: &[u8]) -> bool {
        let header = usize::from(packet[0] & 0x0f) * 4;
        checksum(&packet[..header]) == 0 && checksum(&thought(packet, header)) == 0
    }

    fn everything() -> Twist {
        Twist {
            twice: true,
            flip: Some(77),
            reset: true,
            rebind: true,
        }
    }

    prop_compose! {
        fn packets()(
            ip_options in 0..11_usize, tcp_options in 0..11_usize, flags in prop::sample::select(vec![ACK, ACK | 0x08, ACK | 0x01]),
            payload in prop::collection::vec(any::<u8>(), 0..300),
        ) -> Vec<u8> {
            packet(ip_options, tcp_options, flags, &payload)
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic_and_none_become_a_valid_segment(
            mut bytes in prop::collection::vec(any::<u8>(), 0..120), head in any::<bool>(), up in any::<bool>(),
        ) {
            if let (true, Some(first)) = (head, bytes.first_mut()) {
                *first = 0x45;
            }
            let before = bytes.clone();
            let way = if up { Way::Up } else { Way::Down };
            let (length, done) = apply(&mut bytes, way, Twist { flip: None, ..everything() });
            if segment(&before).is_none() {
                prop_assert_eq!((length, &bytes), (before.len(), &before));
                prop_assert!(!done.reset && !done.rebind);
            }
            let _ = apply(&mut bytes, way, everything());
        }

        #[test]
        fn a_packet_that_is_cut_off_or_damaged_is_left_as_it_is(
            whole in packets(), cut in any::<prop::sample::Index>(), bit in any::<u32>(),
        ) {
            let mut short = whole[..cut.index(whole.len())].to_vec();
            let before = short.clone();
            apply(&mut short, Way::Up, everything());
            prop_assert_eq!(short, before);
            let mut damaged = whole.clone();
            prop_assert!(flip(&mut damaged, bit));
            let before = damaged.clone();
            apply(&mut damaged, Way::Down, Twist { flip: None, ..everything() });
            prop_assert_eq!(damaged, before);
        }

        /// Any one bit behind the IP header, and no other.
        #[test]
        fn a_flipped_bit_is_one_bit_that_the_checksum_finds(whole in packets(), bit in any::<u32>()) {
            let mut packet = whole.clone();
            let (length, done) = apply(&mut packet, Way::Up, Twist { flip: Some(bit), ..Twist::NONE });
            prop_assert_eq!((length, done.flip), (whole.len(), Some(bit)));
            let changed: u32 = packet.iter().zip(&whole).map(|(one, other)| (one ^ other).count_ones()).sum();
            prop_assert_eq!(changed, 1);
            let header = usize::from(whole[0] & 0x0f) * 4;
            prop_assert_eq!(&packet[..header], &whole[..header]);
            prop_assert!(is_sound(&whole) && !is_sound(&packet));
        }

        #[test]
        fn a_reset_is_a_valid_segment_of_the_same_connection_without_a_payload(whole in packets()) {
            let mut packet = whole.clone();
            let (length, done) = apply(&mut packet, Way::Down, Twist { reset: true, ..Twist::NONE });
            prop_assert!(done.reset);
            packet.truncate(length);
            prop_assert!(is_sound(&packet));
            let header = usize::from(whole[0] & 0x0f) * 4;
            prop_assert_eq!(length, header + TCP_HEADER);
            prop_assert_eq!(usize::from(word(&packet, 2)), length);
            // Ports, sequence numbers, addresses and IP options.
            prop_assert_eq!(&packet[header..header + 12], &whole[header..header + 12]);
            prop_assert_eq!(&packet[12..header], &whole[12..header]);
            prop_assert_eq!(packet[header + 13], RST | ACK);
            // A reset stays one.
            let before = packet.clone();
            prop_assert!(reset(&mut packet).is_none());
            prop_assert_eq!(packet, before);
        }

        #[test]
        fn the_controller_s_port_changes_and_changes_back(whole in packets(), up in any::<bool>()) {
            let (way, at) = if up { (Way::Up, 0) } else { (Way::Down, 2) };
            let mut packet = whole.clone();
            let twist = Twist { rebind: true, ..Twist::NONE };
            prop_assert!(apply(&mut packet, way, twist).1.rebind);
            prop_assert!(is_sound(&packet));
            let header = usize::from(whole[0] & 0x0f) * 4;
            prop_assert_eq!(word(&packet, header + at), word(&whole, header + at) ^ PORT_BIT);
            prop_assert_eq!(word(&packet, header + 2 - at), word(&whole, header + 2 - at));
            apply(&mut packet, way, twist);
            prop_assert_eq!(&packet[header..header + 16], &whole[header..header + 16]);
            prop_assert!(is_sound(&packet));
        }

        #[test]
        fn all_at_once_are_a_damaged_reset_from_another_port(whole in packets()) {
            let mut packet = whole;
            let (length, done) = apply(&mut packet, Way::Up, everything());
            prop_assert_eq!(done, everything());
            prop_assert!(!is_sound(&packet[..length]));
        }
    }

    #[test]
    fn what_opens_a_connection_is_not_reset_and_what_is_not_tcp_is_not_rewritten() {
        for flags in [SYN, SYN | ACK] {
            let mut opening = packet(0, 5, flags, &[]);
            let before = opening.clone();
            assert_eq!(reset(&mut opening), None);
            assert_eq!(opening, before);
        }
        let mut echo = packet(0, 0, ACK, &[3; 30]);
        echo[9] = 1;
        echo[10..12].fill(0);
        let own = checksum(&echo[..IP_HEADER]);
        echo[10..12].copy_from_slice(&own.to_be_bytes());
        let before = echo.clone();
        let twist = Twist {
            flip: None,
            ..everything()
        };
        let (length, done) = apply(&mut echo, Way::Up, twist);
        assert_eq!((length, &echo), (before.len(), &before));
        assert!(done.twice && !done.reset && !done.rebind);
        // But its bits can be flipped.
        assert!(apply(&mut echo, Way::Up, everything()).1.flip.is_some());
    }
}
