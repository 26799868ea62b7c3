//! What crosses a tunnel and what does not, who may make one, and what is left of it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddrV4, TcpListener, TcpStream, UdpSocket};
use std::process::{Command, ExitCode, Stdio};
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use link::{Epoch, LinkTime, Way};
use rustix::net::{self, AddressFamily, SendFlags, SocketType, ipproto};
use rustix::thread::{CapabilitySet, capabilities, set_capabilities};
use shaper::{
    Authority, CONTROLLER_ADDRESS, Error, FRAME_MAX, Namespace, PLANT_ADDRESS, TunPort, UdpPort,
    WayConfig, become_root, play_way,
};

use crate::attempt::{held, holds};
use crate::cell::{MS, SECOND, builtin, constant};
use crate::lifetime::ROLE_FLAG;
use crate::traffic::{one_stall, within};
use crate::tunnel::{SEED, Tunnel, possible};

pub(crate) fn each_link_holds_over_a_tunnel_too() {
    if !possible() {
        return;
    }
    for (name, profile, interval_ns, count) in [
        ("constant 5 ms", constant("5ms"), MS, 3000),
        ("buccoo", builtin("buccoo"), 5 * MS, 600),
        ("diego-lan", builtin("diego-lan"), 5 * MS, 600),
        ("diego-vpn", builtin("diego-vpn"), 5 * MS, 600),
        ("couva", builtin("couva"), 10 * MS, 1000),
    ] {
        holds(name, || {
            let tunnel = Tunnel::start(&profile, SECOND).unwrap();
            held(&tunnel.prove(name, interval_ns, count)?)
        });
    }
}

/// As over interfaces: no more packets than the transfer needs, so checksums are whole. A
/// segment carries 1 420 bytes, the tunnel's MTU less headers with a time stamp: 8 MiB are
/// 5 908 of them.
pub(crate) fn a_tcp_transfer_crosses_a_tunnel_intact() {
    const BYTES: usize = 8 << 20;
    if !possible() {
        return;
    }
    let tunnel = Tunnel::start(&constant("1ms"), 0).unwrap();
    let listener = within(&tunnel.plant, || TcpListener::bind((PLANT_ADDRESS, 4000)));
    let sent: Vec<u8> = (0..BYTES).map(|index| (index * 31 % 251) as u8).collect();
    let mut stream = within(&tunnel.controller, || {
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
    // What the two kernels say to each other at the end is through by then.
    thread::sleep(Duration::from_millis(100));
    let (up, down, _) = tunnel.finish();
    println!("  up {:?}\n  down {:?}", up.shaped, down.shaped);
    assert!(
        (5_908..6_300).contains(&up.shaped.packets),
        "hardly any packet is sent twice"
    );
}

/// 3 000 packets that a stall has held up leave at once, cross the tunnel and reach the end:
/// each player has room for them, and neither overtakes itself.
pub(crate) fn a_burst_behind_a_stall_crosses_a_tunnel_whole_and_in_order() {
    const PACKETS: u32 = 3_000;
    if !possible() {
        return;
    }
    let tunnel = Tunnel::start(&one_stall(), SECOND / 2).unwrap();
    let plant = within(&tunnel.plant, || UdpSocket::bind((PLANT_ADDRESS, 4001)));
    let controller = within(&tunnel.controller, || {
        UdpSocket::bind((CONTROLLER_ADDRESS, 0))
    });
    rustix::net::sockopt::set_socket_recv_buffer_size_force(&plant, 16 << 20).ok();
    plant
        .set_read_timeout(Some(Duration::from_secs(5)))
        .unwrap();
    thread::sleep(Duration::from_millis(750));
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
    let (up, down, _) = tunnel.finish();
    println!("  up {:?}\n  carried {:?}", up.shaped, down.carried);
    assert_eq!(up.shaped.delivered, u64::from(PACKETS));
    assert_eq!(down.carried.packets, u64::from(PACKETS));
    assert!(received.is_sorted(), "the packets leave in order");
    // What the receiving socket has no room for is not the players' loss.
    assert!(received.len() >= 100, "{} arrived", received.len());
}

/// A packet that would be answered if it got in, from the peer's machine but not its port.
pub(crate) fn a_stranger_s_datagram_is_not_let_in() {
    const STRAYS: u64 = 50;
    if !possible() {
        return;
    }
    let tunnel = Tunnel::start(&constant("1ms"), 0).unwrap();
    let listener = within(&tunnel.plant, || UdpSocket::bind((PLANT_ADDRESS, 4001)));
    listener
        .set_read_timeout(Some(Duration::from_millis(300)))
        .unwrap();
    let stranger = within(&tunnel.controller, || UdpSocket::bind("0.0.0.0:0"));
    for _ in 0..STRAYS {
        stranger
            .send_to(&datagram_to_the_plant(), tunnel.at_plant)
            .unwrap();
    }
    let error = listener.recv(&mut [0; 64]).expect_err("nothing comes");
    assert_eq!(error.kind(), std::io::ErrorKind::WouldBlock);
    // The same bytes from the controller's end are let in: it is the sender that matters.
    let end = within(&tunnel.controller, || {
        UdpSocket::bind((CONTROLLER_ADDRESS, 0))
    });
    end.send_to(b"hello", (PLANT_ADDRESS, 4001)).unwrap();
    assert_eq!(listener.recv(&mut [0; 64]).unwrap(), 5);
    let (up, down, _) = tunnel.finish();
    assert_eq!(down.carried.foreign, STRAYS);
    assert_eq!((up.shaped.packets, down.carried.packets), (1, 1));
}

/// `hello` for UDP port 4001 of the plant, as an IPv4 packet whose checksums are right: that
/// of UDP may be left out.
fn datagram_to_the_plant() -> Vec<u8> {
    let mut packet = vec![
        0x45, 0, 0, 33, 0, 0, 0x40, 0, 64, 17, 0, 0, 10, 77, 0, 1, 10, 77, 0, 2,
    ];
    seal(&mut packet);
    packet.extend([0x10, 0, 0x0f, 0xa1, 0, 13, 0, 0]);
    packet.extend(b"hello");
    packet
}

/// Puts the right checksum into a header of 20 bytes.
fn seal(packet: &mut [u8]) {
    packet[10..12].fill(0);
    let sum: u32 = packet[..20]
        .chunks(2)
        .map(|word| u32::from(word[0]) << 8 | u32::from(word[1]))
        .sum();
    let checksum = !((sum & 0xffff) + (sum >> 16)) as u16;
    packet[10..12].copy_from_slice(&checksum.to_be_bytes());
}

/// What no player sends, from the right address: rubbish, packets that are cut, that lie about their length, that are
/// parts of none, and such as are too long. Beside it, all that the controller's end sends arrives, in order.
pub(crate) fn malformed_packets_are_counted_and_disturb_nothing() {
    const MALFORMED: u64 = 10_000;
    const GOOD: u32 = 1_000;
    if !possible() {
        return;
    }
    let tunnel = Tunnel::start(&constant("1ms"), 0).unwrap();
    let listener = within(&tunnel.plant, || UdpSocket::bind((PLANT_ADDRESS, 4001)));
    listener
        .set_read_timeout(Some(Duration::from_secs(2)))
        .unwrap();
    let end = within(&tunnel.controller, || {
        UdpSocket::bind((CONTROLLER_ADDRESS, 0))
    });
    // The player has the address, so its datagrams are made by hand.
    let forger = within(&tunnel.controller, || {
        Ok(net::socket(
            AddressFamily::INET,
            SocketType::RAW,
            Some(ipproto::RAW),
        )?)
    });
    let (from, to) = (tunnel.at_controller, tunnel.at_plant);
    let packets: Vec<Vec<u8>> = (0..MALFORMED).map(malformed).collect();
    let is_ipv4 = |packet: &&Vec<u8>| packet.first().is_some_and(|first| first >> 4 == 4);
    let foreign = MALFORMED - packets.iter().filter(is_ipv4).count() as u64;
    let long = packets.iter().filter(|packet| packet.len() > FRAME_MAX);
    let too_long = long.filter(is_ipv4).count() as u64;
    thread::scope(|scope| {
        scope.spawn(|| {
            for (number, packet) in packets.iter().enumerate() {
                for datagram in datagrams(packet, from, to, number as u16) {
                    net::sendto(&forger, &datagram, SendFlags::empty(), &to).unwrap();
                }
                if number % 10 == 9 {
                    thread::sleep(Duration::from_millis(1));
                }
            }
        });
        scope.spawn(|| {
            for number in 0..GOOD {
                end.send_to(&number.to_be_bytes(), (PLANT_ADDRESS, 4001))
                    .unwrap();
                thread::sleep(Duration::from_millis(1));
            }
        });
        for number in 0..GOOD {
            let mut bytes = [0; 64];
            assert_eq!(listener.recv(&mut bytes).unwrap(), 4);
            assert_eq!(bytes[..4], number.to_be_bytes());
        }
    });
    let (up, down, _) = tunnel.finish_without(too_long);
    let carried = down.carried;
    println!(
        "  {MALFORMED} malformed packets: {foreign} no IPv4, {too_long} too long, the others left to the kernel; \
         beside them {GOOD} of {GOOD} in order; late us: {:.0} on average, 99 % {:.0}",
        carried.lateness.mean_us, carried.lateness.p99_us
    );
    assert_eq!((up.shaped.packets, carried.foreign), (GOOD.into(), foreign));
    assert_eq!(
        carried.packets + carried.foreign + carried.dropped,
        MALFORMED + u64::from(GOOD),
        "each is counted, once"
    );
}

/// The packet of this number: one of six kinds, and random beyond that.
fn malformed(number: u64) -> Vec<u8> {
    let mut state = number * 2 + 1;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32) as usize
    };
    let mut packet = datagram_to_the_plant();
    // Some of them are whole after all, and nobody listens there.
    packet[22..24].copy_from_slice(&4002_u16.to_be_bytes());
    match number % 6 {
        // No packet, or one of any kind.
        0 => packet = (0..random() % 100).map(|_| random() as u8).collect(),
        // Cut, within its header too.
        1 => packet.truncate(1 + random() % (packet.len() - 1)),
        // Its length is another.
        2 => packet[2..4].copy_from_slice(&(random() as u16).to_be_bytes()),
        // Its header's length is another.
        3 => packet[0] = 0x40 | (random() % 16) as u8,
        // A part of a packet of which there is no other, or of the one before.
        4 => packet[6..8].copy_from_slice(&(random() as u16 & 0x3fff).to_be_bytes()),
        // More than a packet may have.
        _ => packet.resize(FRAME_MAX + 1 + random() % 1000, 0x45),
    }
    if !matches!(number % 6, 0 | 1) {
        seal(&mut packet);
    }
    packet
}

/// An UDP datagram as IPv4 packets, in two parts where it is too long for one.
fn datagrams(bytes: &[u8], from: SocketAddrV4, to: SocketAddrV4, id: u16) -> Vec<Vec<u8>> {
    const PART: usize = 1480;
    let length = (8 + bytes.len()) as u16;
    let mut udp = Vec::new();
    for field in [from.port(), to.port(), length, 0] {
        udp.extend(field.to_be_bytes());
    }
    udp.extend(bytes);
    let parts = udp.chunks(PART).enumerate();
    let packet = |(part, bytes): (usize, &[u8])| {
        let is_last = (part + 1) * PART >= udp.len();
        let place = (part * PART / 8) as u16 | if is_last { 0 } else { 0x2000 };
        let mut packet = vec![0x45, 0];
        packet.extend((20 + bytes.len() as u16).to_be_bytes());
        packet.extend(id.max(1).to_be_bytes());
        packet.extend(place.to_be_bytes());
        packet.extend([64, 17, 0, 0]);
        packet.extend(from.ip().octets());
        packet.extend(to.ip().octets());
        packet.extend(bytes);
        packet
    };
    parts.map(packet).collect()
}

/// A thread's capabilities are its own, so this one's can go without the others'.
pub(crate) fn without_the_capability_the_error_names_it() {
    if !possible() {
        return;
    }
    let end = Namespace::new().unwrap();
    let error = end
        .run(|| {
            let mut sets = capabilities(None).unwrap();
            sets.effective.remove(CapabilitySet::NET_ADMIN);
            set_capabilities(None, sets).unwrap();
            TunPort::open(Way::Up)
        })
        .expect_err("the kernel refuses");
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("--cap-add NET_ADMIN"), "{error}");
    println!("  {error}");
}

pub(crate) fn a_second_player_beside_an_end_is_refused() {
    if !possible() {
        return;
    }
    let end = Namespace::new().unwrap();
    let first = end.run(|| TunPort::open(Way::Up)).unwrap();
    let error = end
        .run(|| TunPort::open(Way::Up))
        .expect_err("one is there");
    assert!(matches!(error, Error::Failed { .. }), "{error}");
    assert!(error.to_string().contains("another player"), "{error}");
    drop(first);
    end.run(|| TunPort::open(Way::Up)).expect("it has gone");
}

/// Plays until killed, in the namespace that it is started in.
pub(crate) fn hold() -> ExitCode {
    let config = WayConfig {
        packets: None,
        profile: constant("5ms"),
        seed: SEED,
        epoch: Epoch::at_ns(0),
        opens: LinkTime::ZERO,
        end: TunPort::open(Way::Up).unwrap(),
        tunnel: UdpPort::open(
            "0.0.0.0:7077".parse().unwrap(),
            "127.0.0.1:9".parse().unwrap(),
        )
        .unwrap(),
    };
    println!("playing");
    std::io::stdout().flush().unwrap();
    play_way(config, &AtomicBool::new(false), |_| {}).unwrap();
    ExitCode::FAILURE
}

/// The namespace outlives the player here, as a container's end outlives what runs beside it.
pub(crate) fn nothing_is_left_of_a_killed_player_beside_an_end() {
    if !possible() {
        return;
    }
    let end = Namespace::new().unwrap();
    let mut child = within(&end, || {
        Command::new(std::env::current_exe()?)
            .args([ROLE_FLAG, "hold-tunnel"])
            .stdout(Stdio::piped())
            .spawn()
    });
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert_eq!(line, "playing\n");
    assert_eq!(
        interfaces(&end),
        ["link0", "lo"],
        "it is there while it plays"
    );
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = Instant::now();
    while interfaces(&end) != ["lo"] {
        assert!(
            killed.elapsed() < Duration::from_secs(5),
            "the device outlives its process"
        );
        thread::sleep(Duration::from_millis(1));
    }
    println!("  gone after {} ms", killed.elapsed().as_millis());
}

fn interfaces(namespace: &Namespace) -> Vec<String> {
    let table = within(namespace, || {
        std::fs::read_to_string("/proc/thread-self/net/dev")
    });
    let mut names: Vec<String> = table
        .lines()
        .filter_map(|line| line.split_once(':'))
        .map(|(name, _)| name.trim().into())
        .collect();
    names.sort_unstable();
    names
}

/// What a user without root has: the capabilities only inside of a user namespace. A root
/// that gave its own up, because elsewhere the file of the device may be root's alone.
pub(crate) fn play_without_capabilities() -> ExitCode {
    let mut sets = capabilities(None).unwrap();
    // Without this one the kernel lets nobody make its root the root of a user namespace.
    sets.effective = CapabilitySet::SETFCAP;
    sets.permitted = CapabilitySet::SETFCAP;
    sets.inheritable = CapabilitySet::empty();
    set_capabilities(None, sets).unwrap();
    match become_root() {
        Ok(authority) => assert_eq!(authority, Authority::UserNamespace),
        Err(error @ Error::Unsupported { .. }) => {
            println!("  SKIPPED: {error}");
            return ExitCode::SUCCESS;
        }
        Err(error) => panic!("{error}"),
    }
    if !possible() {
        return ExitCode::SUCCESS;
    }
    holds("a tunnel in a user namespace", || {
        let tunnel = Tunnel::start(&constant("5ms"), SECOND).unwrap();
        held(&tunnel.prove("in a user namespace", 5 * MS, 200)?)
    });
    ExitCode::SUCCESS
}

pub(crate) fn a_tunnel_can_be_played_in_a_user_namespace() {
    let status = Command::new(std::env::current_exe().unwrap())
        .args([ROLE_FLAG, "tunnel-without-capabilities"])
        .status()
        .unwrap();
    assert!(status.success());
}
