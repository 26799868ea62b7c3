//! What netem and tc do that a player must know of: each of these is a mistake that was made
//! before, by somebody, with netem.

use std::net::UdpSocket;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use clock::now::now_ns;
use link::Way;
use shaper::{
    CONTROLLER_ADDRESS, Error, Namespace, PLANT_ADDRESS, PLANT_INTERFACE, TcPlayer,
    prefill_neighbour, tc_available,
};

use crate::cell::{MS, SECOND, constant, parse};
use crate::lifetime::{NOBODY, ROLE_FLAG};
use crate::tc::{TcCell, bridged, command, config, netem, start};

/// For the two programs to start on a slow machine.
const START_NS: u64 = 2 * SECOND;

/// Steps of delay and loss, on both ways alike.
fn trace(order: &str, steps: &[(u64, &str, &str)]) -> link::Profile {
    let steps: String = steps
        .iter()
        .map(|(t_ms, delay, loss)| {
            format!(
                "[[both.trace.steps]]\nt = \"{t_ms}ms\"\ndelay = \"{delay}\"\nloss = \"{loss}\"\n"
            )
        })
        .collect();
    parse(&format!(
        "name = \"trace\"\nabout = \"a\"\n[both]\norder = \"{order}\"\ntrace.repeat = \"never\"\n{steps}"
    ))
}

/// One packet of a flow: its number, when it was sent and when it came.
struct Packet {
    number: u32,
    sent_ns: u64,
    came_ns: u64,
}

/// Sends numbered packets of `bytes` from one end to the other at link time 0 and every
/// `gap_us` after it, and gives them as they come, until all are there or none comes any more.
fn flow(cell: &TcCell, way: Way, count: u32, gap_us: u64, bytes: usize) -> Vec<Packet> {
    let open = |namespace: &Namespace, address, port| {
        namespace
            .run(|| Ok(UdpSocket::bind((address, port)).unwrap()))
            .unwrap()
    };
    let ends = [
        (&cell.controller, CONTROLLER_ADDRESS),
        (&cell.plant, PLANT_ADDRESS),
    ];
    let (from, to) = match way {
        Way::Up => (ends[0], ends[1]),
        Way::Down => (ends[1], ends[0]),
    };
    let (sender, receiver) = (open(from.0, from.1, 0), open(to.0, to.1, 4002));
    rustix::net::sockopt::set_socket_recv_buffer_size_force(&receiver, 16 << 20).ok();
    /// Longer than any delay here.
    const QUIET: Duration = Duration::from_secs(6);
    receiver.set_read_timeout(Some(QUIET)).unwrap();
    cell.sleep_until(0);
    let start_ns = now_ns();
    thread::scope(|scope| {
        scope.spawn(move || {
            // 28 bytes of IP and UDP headers.
            let mut packet = vec![0; bytes - 28];
            for number in 0..count {
                let due_ns = start_ns + u64::from(number) * gap_us * 1_000;
                thread::sleep(Duration::from_nanos(due_ns.saturating_sub(now_ns())));
                packet[..4].copy_from_slice(&number.to_be_bytes());
                packet[4..12].copy_from_slice(&now_ns().to_be_bytes());
                sender.send_to(&packet, (to.1, 4002)).unwrap();
            }
        });
        let mut packet = [0; 2048];
        std::iter::from_fn(|| {
            receiver.recv(&mut packet).ok()?;
            Some(Packet {
                number: u32::from_be_bytes(packet[..4].try_into().unwrap()),
                sent_ns: u64::from_be_bytes(packet[4..12].try_into().unwrap()),
                came_ns: now_ns(),
            })
        })
        .take(count as usize)
        .collect()
    })
}

fn in_order(packets: &[Packet]) -> bool {
    packets.is_sorted_by_key(|packet| packet.number)
}

/// netem sorts by time of departure: without a rate a packet overtakes others when the delay
/// falls, and does so where the profile lets it.
pub(crate) fn tc_keeps_order_when_the_delay_falls_unless_it_is_free() {
    let steps = [(0, "60ms", "0%"), (100, "1ms", "0%")];
    for (order, kept) in [("kept", true), ("free", false)] {
        let Some(cell) = TcCell::start(&trace(order, &steps), START_NS) else {
            return;
        };
        let packets = flow(&cell, Way::Up, 300, 1_000, 100);
        cell.finish();
        assert_eq!(packets.len(), 300, "{order}");
        assert_eq!(in_order(&packets), kept, "{order}");
    }
}

/// netem's own limit of 1000 packets would lose half of these.
pub(crate) fn tc_loses_nothing_in_a_stall_at_1_khz_both_ways() {
    let stall = "name = \"stall\"\nabout = \"a\"\n[both.delay]\nbase = \"1ms\"\n\
                 [both.stall]\nevery = \"3s\"\nlength.uniform = { min = \"1800ms\", max = \"2s\" }\n";
    let Some(cell) = TcCell::start(&parse(stall), START_NS) else {
        return;
    };
    let (up, down) = thread::scope(|scope| {
        let up = scope.spawn(|| flow(&cell, Way::Up, 4_000, 1_000, 100));
        let down = scope.spawn(|| flow(&cell, Way::Down, 4_000, 1_000, 100));
        (up.join().unwrap(), down.join().unwrap())
    });
    let reports = cell.finish();
    for (packets, report) in [up, down].iter().zip(reports) {
        let longest = packets.iter().map(|p| p.came_ns - p.sent_ns).max();
        println!("  {} came, the slowest after {longest:?} ns", packets.len());
        assert!(
            longest.unwrap() > 1_200 * MS,
            "they waited for a stall's end"
        );
        assert!(in_order(packets));
        // The receiver's buffer is its own affair.
        assert!(report.traffic.delivered >= 4_000, "{:?}", report.traffic);
        assert_eq!(report.traffic.lost, 0);
    }
}

/// With an ARP on the way the first exchange takes twice its time.
pub(crate) fn tc_does_not_shape_the_first_packet_s_arp() {
    let Some(cell) = TcCell::start(&constant("50ms"), START_NS) else {
        return;
    };
    let forget = || {
        let far = [
            (&cell.controller, PLANT_ADDRESS),
            (&cell.plant, CONTROLLER_ADDRESS),
        ];
        for (end, peer) in far {
            command(end, &format!("ip neigh del {peer} dev link0"));
        }
    };
    forget();
    let first_ms = |id| cell.probe(0, MS, 1, id)[0].rtt_ns().unwrap() as f64 / 1e6;
    cell.sleep_until(MS);
    let with_arp_ms = first_ms(2);
    forget();
    for (end, peer) in [
        (&cell.controller, PLANT_ADDRESS),
        (&cell.plant, CONTROLLER_ADDRESS),
    ] {
        end.run(|| prefill_neighbour("link0", peer)).unwrap();
        assert!(command(end, "ip neigh show").contains("PERMANENT"));
    }
    let without_ms = first_ms(3);
    println!("  first round trip: {with_arp_ms:.1} ms with ARP, {without_ms:.1} ms without");
    cell.finish();
    assert!(with_arp_ms > 180.0);
    assert!((100.0..130.0).contains(&without_ms));
}

/// Needs no netem.
pub(crate) fn tc_leaves_a_foreign_qdisc_alone() {
    let [_controller, _plant, middle] = bridged();
    let add = format!("tc qdisc add dev {PLANT_INTERFACE} root handle 1: pfifo limit 7");
    command(&middle, &add);
    let show = format!("tc qdisc show dev {PLANT_INTERFACE}");
    let before = command(&middle, &show);
    let profile = constant("5ms");
    let play = || TcPlayer::start(config(&profile, Way::Up, now_ns())).map(|_| ());
    for refused in [
        middle.run(play).unwrap_err(),
        middle.run(|| tc_available(PLANT_INTERFACE)).unwrap_err(),
    ] {
        let text = refused.to_string();
        assert!(text.contains("`pfifo 1:`"), "{text}");
        assert!(text.contains("tc qdisc del dev plant root"), "{text}");
    }
    assert_eq!(command(&middle, &show), before);
}

/// What a killed player left is known by its handle and taken away. So it is when the play
/// ends by an error: here somebody changes what is in force.
pub(crate) fn tc_notices_what_the_kernel_plays_and_restores_what_it_found() {
    let [_controller, _plant, middle] = bridged();
    if !netem(&middle) {
        return;
    }
    let middle = Arc::new(middle);
    let root =
        |words: &str| format!("tc qdisc {words} dev {PLANT_INTERFACE} root handle 77: netem");
    command(&middle, &format!("{} delay 9ms", root("add")));
    let stop = Arc::new(AtomicBool::new(false));
    let playing = start(&middle, config(&constant("5ms"), Way::Up, 0), &stop);
    thread::sleep(Duration::from_millis(100));
    let show = format!("tc qdisc show dev {PLANT_INTERFACE}");
    let playing_now = command(&middle, &show);
    assert!(
        playing_now.contains("limit 20000 delay 5ms"),
        "{playing_now}"
    );
    command(&middle, &format!("{} delay 6ms", root("change")));
    let error = playing
        .join()
        .unwrap()
        .expect_err("it plays something else");
    println!("  {error}");
    assert!(error.to_string().contains("it plays"), "{error}");
    let after = command(&middle, &show);
    assert!(after.contains("noqueue 0: root"), "{after}");
}

/// A packet that is under way keeps its departure when the setting changes.
pub(crate) fn tc_changes_keep_the_packets_that_are_under_way() {
    let steps = [(0, "400ms", "0%"), (100, "20ms", "0%")];
    let Some(cell) = TcCell::start(&trace("free", &steps), START_NS) else {
        return;
    };
    let packets = flow(&cell, Way::Down, 30, 10_000, 100);
    cell.finish();
    assert_eq!(packets.len(), 30);
    for packet in &packets {
        let due_ms = if packet.number < 9 { 400.0 } else { 20.0 };
        let ms = (packet.came_ns - packet.sent_ns) as f64 / 1e6;
        // The change comes at the tenth or the eleventh.
        let near = (9..=10).contains(&packet.number);
        assert!(
            near || (due_ms..due_ms + 15.0).contains(&ms),
            "{}: {ms}",
            packet.number
        );
    }
}

/// Seconds are seconds, also where tc counts in 32 bits of something else.
pub(crate) fn tc_plays_a_delay_of_seconds() {
    let Some(cell) = TcCell::start(&constant("4500ms"), START_NS) else {
        return;
    };
    let packets = flow(&cell, Way::Up, 10, 300_000, 100);
    cell.finish();
    assert_eq!(packets.len(), 10);
    for packet in packets {
        let ms = (packet.came_ns - packet.sent_ns) / MS;
        assert!((4_500..4_530).contains(&ms), "{ms} ms");
    }
}

pub(crate) fn tc_switches_loss_on_and_off() {
    let steps = [(0, "2ms", "0%"), (200, "2ms", "100%"), (400, "2ms", "0%")];
    let Some(cell) = TcCell::start(&trace("kept", &steps), START_NS) else {
        return;
    };
    let epoch_ns = cell.epoch_ns;
    let packets = flow(&cell, Way::Up, 600, 1_000, 100);
    let [up, _] = cell.finish();
    let in_spell = |packet: &&Packet| (203 * MS..397 * MS).contains(&(packet.sent_ns - epoch_ns));
    println!("  {} of 600 came, {} lost", packets.len(), up.traffic.lost);
    assert_eq!(packets.iter().filter(in_spell).count(), 0);
    assert!((380..=420).contains(&packets.len()), "{}", packets.len());
    assert!(packets.len() as u64 + up.traffic.lost >= 600);
}

/// 1250 bytes of IP at 1 Mbit/s are 10 ms. With netem's count, which has the Ethernet header
/// in it, the 99 gaps would be 11 ms longer.
pub(crate) fn tc_limits_the_rate_of_ip_packets() {
    let narrow = "name = \"narrow\"\nabout = \"a\"\n[both]\nrate = \"1mbit\"\nlimit = 200\n\
                  [both.delay]\nbase = \"5ms\"\n";
    let Some(cell) = TcCell::start(&parse(narrow), START_NS) else {
        return;
    };
    let packets = flow(&cell, Way::Up, 100, 1_000, 1_250);
    cell.finish();
    assert_eq!(packets.len(), 100);
    let ms = (packets[99].came_ns - packets[0].came_ns) as f64 / 1e6;
    println!("  100 packets in {ms:.1} ms");
    assert!((987.0..996.0).contains(&ms), "{ms}");
}

/// Glued segments would be delayed and lost as one. 1 MiB is 725 segments of 1448 bytes.
pub(crate) fn tc_gets_single_packets_from_tcp() {
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};
    const BYTES: usize = 1 << 20;
    let Some(cell) = TcCell::start(&constant("2ms"), START_NS) else {
        return;
    };
    let listener = cell
        .plant
        .run(|| Ok(TcpListener::bind((PLANT_ADDRESS, 4003)).unwrap()))
        .unwrap();
    let mut stream = cell
        .controller
        .run(|| Ok(TcpStream::connect((PLANT_ADDRESS, 4003)).unwrap()))
        .unwrap();
    let (mut accepted, _) = listener.accept().unwrap();
    let received = thread::spawn(move || {
        let mut bytes = Vec::new();
        accepted.read_to_end(&mut bytes).unwrap();
        bytes.len()
    });
    cell.sleep_until(0);
    stream.write_all(&vec![7; BYTES]).unwrap();
    drop(stream);
    assert_eq!(received.join().unwrap(), BYTES);
    let [up, _] = cell.finish();
    println!("  {:?}", up.traffic);
    assert!((725..800).contains(&up.traffic.delivered));
}

/// Three machines that cannot: without tc, without the right, and without netem.
pub(crate) fn tc_says_what_is_missing_and_what_to_do() {
    let [_controller, _plant, middle] = bridged();
    let try_as = |nobody: bool, path: &str| {
        let mut try_it = Command::new(std::env::current_exe().unwrap());
        try_it.args([ROLE_FLAG, "try-tc"]).env("PATH", path);
        if nobody {
            try_it.uid(NOBODY).gid(NOBODY);
        }
        let output = middle.run(|| Ok(try_it.output())).unwrap();
        // Where this program lies, nobody may not be let in.
        output.map(|output| String::from_utf8(output.stdout).unwrap())
    };
    let path = std::env::var("PATH").unwrap();
    let missing = try_as(false, "/nowhere").unwrap();
    assert!(
        missing.contains("unsupported") && missing.contains("install iproute2"),
        "{missing}"
    );
    match try_as(true, &path) {
        Ok(said) => assert!(
            said.contains("unsupported") && said.contains("NET_ADMIN"),
            "{said}"
        ),
        Err(error) => println!("  SKIPPED, as nobody: {error}"),
    }
    let here = try_as(false, &path).unwrap();
    println!("  {}", here.trim());
    assert!(
        here.contains("available") || here.contains("modprobe sch_netem"),
        "{here}"
    );
    let error = middle.run(|| tc_available("nowhere")).unwrap_err();
    assert!(matches!(&error, Error::Failed { .. }) && error.to_string().contains("nowhere"));
}

/// Whether tc can play here, as a child that has been put into the middle.
pub(crate) fn try_tc() -> ExitCode {
    match tc_available(PLANT_INTERFACE) {
        Ok(()) => println!("available"),
        Err(error @ Error::Unsupported { .. }) => println!("unsupported: {error}"),
        Err(error) => println!("failed: {error}"),
    }
    ExitCode::SUCCESS
}

/// A play that is told to stop at once has put up and taken away.
pub(crate) fn tc_can_be_stopped_at_once() {
    let [_controller, _plant, middle] = bridged();
    if !netem(&middle) {
        return;
    }
    let profile = constant("5ms");
    let play = || {
        let player = TcPlayer::start(config(&profile, Way::Up, now_ns() + SECOND))?;
        player.play(&AtomicBool::new(true), |_| ())
    };
    let report = middle.run(play).unwrap();
    assert_eq!((report.changes, report.traffic.packets), (0, 0));
    assert!(report.tc.contains("iproute2") && !report.kernel.is_empty());
    assert!(report.first.to_string().contains("netem"));
    let text = serde_json::to_string(&report).unwrap();
    assert_eq!(
        serde_json::from_str::<link::certificate::TcReport>(&text).unwrap(),
        report
    );
}
