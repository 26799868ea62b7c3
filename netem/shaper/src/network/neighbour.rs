//! The other end's Ethernet address, found before anything is shaped and then kept permanently.
//!
//! Otherwise ARP would cross the link like any packet: the first exchange would take twice its time,
//! and so would later ones whenever the kernel asks again.

use std::fs;
use std::io;
use std::net::{Ipv4Addr, UdpSocket};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::{Doing, Error, Result};
use crate::network::netlink::{Mac, Netlink};

/// Two machines on one network answer within a millisecond. The kernel itself gives up after three
/// requests, one second apart.
const PATIENCE: Duration = Duration::from_secs(4);
/// Time between two reads of the kernel's table.
const PAUSE: Duration = Duration::from_millis(20);

/// Finds the Ethernet address of `peer`, a neighbour on `device` in the calling thread's namespace,
/// and makes the kernel keep it.
///
/// # Errors
/// [`Error::Failed`] if the peer does not answer within 4 s, is not a neighbour on that device, or
/// the kernel refuses.
pub fn prefill_neighbour(device: &str, peer: Ipv4Addr) -> Result<()> {
    /// Nothing listens on `discard`, and nothing needs to: the packet makes the kernel ask for the address.
    const DISCARD: u16 = 9;
    let action = || format!("find `{peer}` on `{device}`");
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).doing_with(action)?;
    let asked = Instant::now();
    loop {
        socket.send_to(&[0], (peer, DISCARD)).doing_with(action)?;
        let table = fs::read_to_string("/proc/thread-self/net/arp").doing_with(action)?;
        if let Some(mac) = find(&table, device, peer) {
            let mut netlink = Netlink::open()?;
            let index = netlink.index_of(device)?;
            return netlink.replace_neighbour(index, peer, mac);
        }
        if asked.elapsed() > PATIENCE {
            let source = io::Error::new(
                io::ErrorKind::TimedOut,
                "no answer came; is the other end up, and on the same network?",
            );
            return Err(Error::Failed {
                action: action(),
                source,
            });
        }
        thread::sleep(PAUSE);
    }
}

/// The address in the kernel's ARP table, if its entry is complete.
fn find(table: &str, device: &str, peer: Ipv4Addr) -> Option<Mac> {
    /// `ATF_COM` of `linux/if_arp.h`: the address is known.
    const COMPLETE: u32 = 0x2;
    table.lines().skip(1).find_map(|line| {
        let mut words = line.split_whitespace();
        let address: Ipv4Addr = words.next()?.parse().ok()?;
        let flags = u32::from_str_radix(words.nth(1)?.strip_prefix("0x")?, 16).ok()?;
        let (mac, on) = (words.next()?, words.nth(1)?);
        if address != peer || on != device || flags & COMPLETE == 0 {
            return None;
        }
        let bytes: Option<Vec<u8>> = mac
            .split(':')
            .map(|byte| u8::from_str_radix(byte, 16).ok())
            .collect();
        bytes?.try_into().ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "\
IP address       HW type     Flags       HW address            Mask     Device
10.0.0.2         0x1         0x2         02:42:0a:00:00:02     *        eth1
10.0.0.3         0x1         0x0         00:00:00:00:00:00     *        eth1
10.0.0.4         0x1         0x6         02:42:0a:00:00:04     *        eth0
";

    #[test]
    fn only_a_complete_entry_on_the_device_counts() {
        let at = |last| Ipv4Addr::new(10, 0, 0, last);
        assert_eq!(find(TABLE, "eth1", at(2)), Some([2, 0x42, 10, 0, 0, 2]));
        assert_eq!(find(TABLE, "eth1", at(3)), None);
        assert_eq!(find(TABLE, "eth1", at(4)), None);
        assert_eq!(find(TABLE, "eth0", at(4)), Some([2, 0x42, 10, 0, 0, 4]));
        assert_eq!(find("", "eth0", at(4)), None);
    }
}
