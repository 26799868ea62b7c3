//! The interface that leads to an address, from the kernel's routing table.

use std::fs;
use std::io;
use std::net::Ipv4Addr;

use crate::error::{Doing, Result};

/// The interface of this thread's namespace through which packets to `peer` leave.
///
/// # Errors
/// [`Error::Failed`](crate::Error::Failed) if no route leads there.
pub fn device_towards(peer: Ipv4Addr) -> Result<String> {
    let action = || format!("find the interface towards {peer}");
    let table = fs::read_to_string("/proc/thread-self/net/route").doing_with(action)?;
    lookup(&table, peer)
        .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no route leads there"))
        .doing_with(action)
}

/// The interface of the longest matching prefix in a table in the form of `/proc/net/route`: a line
/// of titles `Iface Destination Gateway Flags RefCnt Use Metric Mask ..`, then the numbers in hex in
/// this machine's byte order.
fn lookup(table: &str, peer: Ipv4Addr) -> Option<String> {
    let peer = u32::from_ne_bytes(peer.octets());
    table
        .lines()
        .skip(1)
        .filter_map(|line| {
            let mut words = line.split_ascii_whitespace();
            let interface = words.next()?;
            let destination = u32::from_str_radix(words.next()?, 16).ok()?;
            let mask = u32::from_str_radix(words.nth(5)?, 16).ok()?;
            (peer & mask == destination).then_some((mask.count_ones(), interface))
        })
        .max_by_key(|(bits, _)| *bits)
        .map(|(_, interface)| interface.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As written by a little-endian machine.
    #[cfg(target_endian = "little")]
    #[test]
    fn the_longest_prefix_decides() {
        let table = "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n\
            eth0\t00000000\t010011AC\t0003\t0\t0\t0\t00000000\t0\t0\t0\n\
            eth0\t000011AC\t00000000\t0001\t0\t0\t0\t0000FFFF\t0\t0\t0\n\
            eth1\t000012AC\t00000000\t0001\t0\t0\t0\t0000FFFF\t0\t0\t0\n";
        let towards = |peer: [u8; 4]| lookup(table, Ipv4Addr::from(peer));
        assert_eq!(towards([172, 18, 0, 2]).as_deref(), Some("eth1"));
        assert_eq!(towards([172, 17, 0, 2]).as_deref(), Some("eth0"));
        assert_eq!(towards([8, 8, 8, 8]).as_deref(), Some("eth0"));
        assert_eq!(lookup("", Ipv4Addr::LOCALHOST), None);
    }
}
