//! Other packets than probes.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::thread;
use std::time::Duration;

use link::Profile;
use link::certificate::PlayerReport;
use rustix::net::{self, AddressFamily, RecvFlags, SocketType};
use shaper::{CONTROLLER_ADDRESS, Namespace, PLANT_ADDRESS};

use crate::cell::{Cell, SECOND, constant, parse};

/// TCP takes its time over a packet whose checksum is wrong: it is sent again after 200 ms.
/// So whether checksums are whole shows in the player's count: no more packets than the
/// transfer needs. 8 MiB are 5 794 segments of 1 448 bytes, and at most as many
/// acknowledgements again.
pub(crate) fn a_tcp_transfer_arrives_intact_and_no_packet_is_lost_by_the_player() {
    // A link that does not treat packets alike: it loses some, some day.
    let never = "at = \"80000s\"\nfor = \"1s\"\nloss = \"1%\"";
    let text = "name = \"a\"\nabout = \"a\"\nboth.delay.base = \"1ms\"\n[[fault]]\n";
    let (report, longest) = transfer(&parse(&format!("{text}{never}")));
    assert!(longest <= ON_A_WIRE, "single packets: {longest}");
    assert!(
        (5_794..6_200).contains(&report.up.packets),
        "hardly any packet is sent twice"
    );
}

/// The segments of a kernel cross as it made them, and are counted as the packets that a wire carries.
pub(crate) fn segments_cross_whole_where_a_link_treats_packets_alike() {
    let (report, longest) = transfer(&constant("1ms"));
    assert!(longest > ON_A_WIRE, "segments: {longest}");
    assert!(
        (5_794..6_200).contains(&report.up.packets),
        "as many packets as ever"
    );
    // What is sent again is in it, to as much as each packet holds.
    let bytes = report.up.bytes - report.up.packets * 40;
    assert!(
        (BYTES as u64..=report.up.packets * 1_460).contains(&bytes),
        "each with its headers: {bytes}"
    );
}

/// A queue counts packets, and a rate is that of each.
pub(crate) fn single_packets_cross_a_link_with_a_rate() {
    let text = "name = \"a\"\nabout = \"a\"\nboth.delay.base = \"1ms\"\nboth.rate = \"1gbit\"\n";
    let (report, longest) = transfer(&parse(text));
    assert!(longest <= ON_A_WIRE, "single packets: {longest}");
    assert!(report.up.packets >= 5_794);
}

/// What a transfer brings.
const BYTES: usize = 8 << 20;
/// The longest frame that a wire carries.
const ON_A_WIRE: usize = 1500 + 14;

/// Sends [`BYTES`] over a link; they must arrive as they were sent. Returns also the longest frame that the plant
/// saw.
fn transfer(profile: &Profile) -> (PlayerReport, usize) {
    let cell = Cell::start(profile, 1, 0).unwrap();
    let frames = within(&cell.plant, || {
        net::socket(AddressFamily::PACKET, SocketType::RAW, Some(net::eth::ALL)).map_err(Into::into)
    });
    // Without root it holds only the first frames.
    net::sockopt::set_socket_recv_buffer_size_force(&frames, 64 << 20).ok();
    let listener = within(&cell.plant, || TcpListener::bind((PLANT_ADDRESS, 4000)));
    let sent: Vec<u8> = (0..BYTES).map(|index| (index * 31 % 251) as u8).collect();
    let mut stream = within(&cell.controller, || {
        TcpStream::connect_timeout(&(PLANT_ADDRESS, 4000).into(), Duration::from_secs(5))
    });
    let (mut accepted, _) = listener.accept().unwrap();
    let received = thread::spawn(move || {
        let mut bytes = Vec::with_capacity(BYTES);
        accepted.read_to_end(&mut bytes).unwrap();
        bytes
    });
    stream.write_all(&sent).unwrap();
    drop(stream);
    assert!(
        received.join().unwrap() == sent,
        "the bytes arrive as they were sent"
    );
    let flags = RecvFlags::DONTWAIT | RecvFlags::TRUNC;
    let lengths = std::iter::from_fn(|| net::recv(&frames, &mut [0; 64], flags).ok());
    let longest = lengths.map(|(_, length)| length).max().unwrap();
    let report = cell.finish();
    println!(
        "  longest {longest}, up {:?}\n  down {:?}",
        report.up, report.down
    );
    (report, longest)
}

/// A link that stalls from link time 0.2 s to 2 s. Before and after, its delay is 1 ms. What
/// is sent meanwhile waits behind the packet of 0.2 s: the level need not say so.
pub(crate) fn one_stall() -> Profile {
    parse(
        "name = \"stall\"\nabout = \"one stall\"\nboth.trace.repeat = \"never\"\n[[both.trace.steps]]\nt = \"0s\"\ndelay = \"1ms\"\n[[both.trace.steps]]\nt = \"200ms\"\ndelay = \"1800ms\"\n[[both.trace.steps]]\nt = \"210ms\"\ndelay = \"1ms\"\n",
    )
}

/// 3 000 packets wait for the end of a stall and then leave all at once, in order: what a
/// radio's stall does to a loop at 1 kHz.
pub(crate) fn a_burst_behind_a_stall_leaves_whole_and_in_order() {
    const PACKETS: u32 = 3_000;
    let stall = one_stall();
    let cell = Cell::start(&stall, 1, SECOND / 2).unwrap();
    let plant = within(&cell.plant, || UdpSocket::bind((PLANT_ADDRESS, 4001)));
    let controller = within(&cell.controller, || {
        UdpSocket::bind((CONTROLLER_ADDRESS, 0))
    });
    net::sockopt::set_socket_recv_buffer_size_force(&plant, 16 << 20).ok();
    plant
        .set_read_timeout(Some(Duration::from_secs(5)))
        .unwrap();
    cell.sleep_until(SECOND / 4);
    for sequence in 0..PACKETS {
        controller
            .send_to(&sequence.to_be_bytes(), (PLANT_ADDRESS, 4001))
            .unwrap();
        if sequence % 10 == 9 {
            thread::sleep(Duration::from_millis(1));
        }
    }
    let mut bytes = [0; 4];
    let received: Vec<u32> = (0..PACKETS)
        .map_while(|_| {
            plant
                .recv(&mut bytes)
                .ok()
                .map(|_| u32::from_be_bytes(bytes))
        })
        .collect();
    let report = cell.finish();
    println!("  up {:?}", report.up);
    // What the receiving socket has no room for is not the player's loss: without root its
    // buffer is small.
    assert_eq!(report.up.delivered, u64::from(PACKETS));
    assert!(received.is_sorted(), "the packets leave in order");
    assert!(received.len() >= 100, "{} arrived", received.len());
}

/// Opens something in a namespace.
pub(crate) fn within<T: Send>(
    namespace: &Namespace,
    open: impl FnOnce() -> std::io::Result<T> + Send,
) -> T {
    namespace.run(|| Ok(open().unwrap())).unwrap()
}
