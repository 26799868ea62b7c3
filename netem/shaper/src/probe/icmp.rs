//! ICMP echo messages as bytes: what `ping` sends and what comes back (RFC 792).

/// Type of an echo request.
pub(crate) const REQUEST: u8 = 8;
/// Type of an echo reply.
pub(crate) const REPLY: u8 = 0;

const HEADER: usize = 8;
const SHORTEST_IP_HEADER: usize = 20;

/// Bytes of a message, including its header.
const MESSAGE_BYTES: usize = link::certificate::PACKET_BYTES as usize - SHORTEST_IP_HEADER;

/// What the payload is filled with. Some kernels answer a request of zeros alone with a checksum of 0, which is
/// wrong: its first echo would be lost.
const FILLER: u8 = b'w';

/// Identifies an echo and its probe. The payload carries the full number; the header has room for
/// only 16 bits of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EchoId {
    /// Distinguishes probes that run at the same time.
    pub(crate) probe: u16,
    /// Counts the echoes of a probe from 0.
    pub(crate) seq: u32,
}

/// The request with this id.
pub(crate) fn request(id: EchoId) -> [u8; MESSAGE_BYTES] {
    let mut message = [FILLER; MESSAGE_BYTES];
    message[..HEADER].fill(0);
    message[0] = REQUEST;
    message[4..6].copy_from_slice(&id.probe.to_be_bytes());
    message[6..8].copy_from_slice(&(id.seq as u16).to_be_bytes());
    message[HEADER..HEADER + 4].copy_from_slice(&id.seq.to_be_bytes());
    let checksum = checksum(&message);
    message[2..4].copy_from_slice(&checksum.to_be_bytes());
    message
}

/// The id of the echo in an IPv4 packet from a raw socket, if it is one of ours: of this type,
/// complete, and with the same number in payload and header.
pub(crate) fn parse(packet: &[u8], icmp_type: u8) -> Option<EchoId> {
    let header_bytes = usize::from(packet.first()? & 0x0f) * 4;
    if header_bytes < SHORTEST_IP_HEADER {
        return None;
    }
    let message = packet.get(header_bytes..)?;
    if message.len() != MESSAGE_BYTES || message[0] != icmp_type || checksum(message) != 0 {
        return None;
    }
    let probe = u16::from_be_bytes(message[4..6].try_into().ok()?);
    let seq = u32::from_be_bytes(message[HEADER..HEADER + 4].try_into().ok()?);
    let low = u16::from_be_bytes(message[6..8].try_into().ok()?);
    (seq as u16 == low).then_some(EchoId { probe, seq })
}

/// The Internet checksum (RFC 1071): the complement of the ones' complement sum of 16-bit words. It
/// is 0 over a message that contains its checksum.
fn checksum(message: &[u8]) -> u16 {
    let mut sum: u32 = message
        .chunks(2)
        .map(|word| u32::from(word[0]) << 8 | u32::from(*word.get(1).unwrap_or(&0)))
        .sum();
    while sum > 0xffff {
        sum = (sum & 0xffff) + (sum >> 16);
    }
    !(sum as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn packet(message: &[u8], options: usize) -> Vec<u8> {
        let mut packet = vec![0; SHORTEST_IP_HEADER + 4 * options];
        packet[0] = 0x45 + options as u8;
        packet.extend_from_slice(message);
        packet
    }

    #[test]
    fn the_checksum_of_rfc_1071s_example_is_as_printed_there() {
        // Section 3: the words 0001 f203 f4f5 f6f7 add up to ddf2.
        let words = [0x00, 0x01, 0xf2, 0x03, 0xf4, 0xf5, 0xf6, 0xf7];
        assert_eq!(checksum(&words), !0xddf2);
    }

    proptest! {
        #[test]
        fn a_request_is_read_back_whatever_ip_options_precede_it(
            probe in any::<u16>(), seq in any::<u32>(), options in 0_usize..=10,
        ) {
            let id = EchoId { probe, seq };
            let packet = packet(&request(id), options);
            prop_assert_eq!(parse(&packet, REQUEST), Some(id));
            prop_assert_eq!(parse(&packet, REPLY), None);
        }

        /// One flipped bit changes the ones' complement sum, so every such message is rejected.
        #[test]
        fn a_damaged_message_is_refused(seq in any::<u32>(), bit in 0..MESSAGE_BYTES * 8) {
            let mut message = request(EchoId { probe: 7, seq });
            message[bit / 8] ^= 1 << (bit % 8);
            prop_assert_eq!(parse(&packet(&message, 0), REQUEST), None);
        }

        #[test]
        fn no_bytes_make_the_parser_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse(&bytes, REQUEST);
        }
    }
}
