//! What a sending kernel has left for later: the checksum, and cutting a segment of up to 64 KiB into packets.
//!
//! `struct virtio_net_hdr` of `linux/virtio_net.h` says so, before each frame of a packet socket with
//! `PACKET_VNET_HDR`. It is passed on as it came, so that the receiving kernel knows what the sending one did.
//! Pure.

/// Length of that header.
pub(crate) const OFFLOAD_HEADER: usize = 10;

/// Where it says by which protocol a segment is cut, if it is, and into how many bytes each.
const CUT_BY: usize = 1;
const CUT_BYTES: usize = 4;

const TCP: u8 = 6;
const UDP_HEADER: usize = 8;

/// The packets that a wire carries for a packet that is to be cut, and their bytes with a header each. `header` is
/// the packet's offload header; a packet that is not to be cut is one.
pub(crate) fn on_a_wire(header: &[u8], packet: &[u8]) -> (u32, u32) {
    // Both fit: a frame has less than 70 000 bytes, and each of its bytes has two headers of 60 at most.
    let whole = (1, packet.len() as u32);
    let (Some(0x01..), Some(&[low, high])) = (
        header.get(CUT_BY).copied(),
        header.get(CUT_BYTES..CUT_BYTES + 2),
    ) else {
        return whole;
    };
    let cut = usize::from(u16::from_ne_bytes([low, high]));
    let Some(headers) = headers(packet).filter(|_| cut > 0) else {
        return whole;
    };
    let packets = packet.len().saturating_sub(headers).div_ceil(cut).max(1);
    let bytes = packet.len() + (packets - 1) * headers;
    (packets as u32, bytes as u32)
}

/// The length of an IPv4 packet's headers, up to what it carries for a program.
fn headers(packet: &[u8]) -> Option<usize> {
    let ip = usize::from(packet.first()? & 0x0f) * 4;
    let own = match *packet.get(9)? {
        TCP => usize::from(packet.get(ip + 12)? >> 4) * 4,
        _ => UDP_HEADER,
    };
    Some(ip + own)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The header of a segment of TCP over IPv4 that is cut into so many bytes each.
    fn cut(bytes: u16) -> [u8; OFFLOAD_HEADER] {
        let mut header = [0; OFFLOAD_HEADER];
        header[CUT_BY] = 1;
        header[CUT_BYTES..CUT_BYTES + 2].copy_from_slice(&bytes.to_ne_bytes());
        header
    }

    /// A packet of TCP with options in both headers.
    fn packet(ip_options: usize, tcp_options: usize, payload: usize) -> Vec<u8> {
        let (ip, tcp) = (20 + 4 * ip_options, 20 + 4 * tcp_options);
        let mut packet = vec![0; ip + tcp + payload];
        packet[0] = 0x40 | (ip / 4) as u8;
        packet[9] = TCP;
        packet[ip + 12] = ((tcp / 4) << 4) as u8;
        packet
    }

    proptest! {
        /// As if the packets were made one by one.
        #[test]
        fn it_counts_the_packets_that_are_cut(
            ip_options in 0..11_usize, tcp_options in 0..11_usize, payload in 0..65_000_usize, size in 1..9_000_usize,
        ) {
            let whole = packet(ip_options, tcp_options, payload);
            let headers = whole.len() - payload;
            let (mut packets, mut bytes, mut left) = (0, 0, payload);
            while left > 0 || packets == 0 {
                let part = left.min(size);
                left -= part;
                packets += 1;
                bytes += (headers + part) as u32;
            }
            prop_assert_eq!(on_a_wire(&cut(size as u16), &whole), (packets, bytes));
        }

        #[test]
        fn no_bytes_make_it_panic_and_none_count_as_nothing(
            header in prop::collection::vec(any::<u8>(), 0..12), packet in prop::collection::vec(any::<u8>(), 0..200),
        ) {
            let (packets, bytes) = on_a_wire(&header, &packet);
            prop_assert!(packets >= 1 && bytes >= packet.len() as u32);
        }
    }

    #[test]
    fn a_packet_that_is_not_to_be_cut_is_one() {
        let whole = packet(0, 3, 1448);
        assert_eq!(on_a_wire(&[0; OFFLOAD_HEADER], &whole), (1, 1500));
        assert_eq!(on_a_wire(&cut(0), &whole), (1, 1500));
        assert_eq!(on_a_wire(&[], &whole), (1, 1500));
        assert_eq!(
            on_a_wire(&cut(1448), &packet(0, 3, 2 * 1448)),
            (2, 2 * 1500)
        );
    }
}
