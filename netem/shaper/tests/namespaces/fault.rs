//! Faults of a link on real packets: what two kernels make of each, and that echoes still prove the link.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use link::Profile;
use link::certificate::PlayerReport;
use shaper::PLANT_ADDRESS;

use crate::attempt::{held, holds};
use crate::cell::{Cell, MS, SECOND, parse};
use crate::traffic::within;

const SEED: u64 = 11;

/// A link of 2 ms each way with one fault.
fn faulty(fault: &str) -> Profile {
    parse(&format!(
        "name = \"faulty\"\nabout = \"a\"\nboth.delay.base = \"2ms\"\n[[fault]]\n{fault}\n"
    ))
}

/// Echoes agree with the model of a link with each fault, and one that has the fault is not taken for one
/// without it, if it concerns echoes. Resets and ports concern TCP only.
pub(crate) fn echoes_prove_a_link_with_each_fault() {
    let when = "at = \"300ms\"\nfor = \"400ms\"\nevery = \"900ms\"";
    for (effect, concerns_echoes) in [
        ("down = true", true),
        ("delay = \"30ms\"", true),
        ("loss = \"40%\"", true),
        ("duplicate = \"40%\"", false),
        ("reorder = \"40%\"\nby = \"30ms\"", true),
        ("corrupt = \"40%\"", true),
    ] {
        let profile = faulty(&format!("{when}\n{effect}"));
        holds(effect, || {
            let cell = Cell::start(&profile, SEED, SECOND).unwrap();
            let proof = cell.prove(effect, 3 * MS, 600)?;
            let bare = link::certificate::certify(
                &proof.echoes,
                &crate::cell::constant("2ms"),
                SEED,
                link::Epoch::at_ns(proof.epoch_ns),
                proof.baseline,
            );
            assert_eq!(held(&bare).is_err(), concerns_echoes, "{effect}: {bare:?}");
            held(&proof.certificate)
        });
    }
}

/// A plant that sends back what comes, on every connection.
fn echo_server(cell: &Cell) -> SocketAddr {
    let address = SocketAddr::from((PLANT_ADDRESS, 4000));
    let listener = within(&cell.plant, || TcpListener::bind(address));
    thread::spawn(move || {
        for stream in listener.incoming() {
            thread::spawn(move || {
                let Ok(mut stream) = stream else { return };
                let _ = stream.set_nodelay(true);
                let mut bytes = [0; 4096];
                while let Ok(count @ 1..) = stream.read(&mut bytes) {
                    if stream.write_all(&bytes[..count]).is_err() {
                        return;
                    }
                }
            });
        }
    });
    address
}

fn connect(cell: &Cell, address: SocketAddr) -> TcpStream {
    let stream = within(&cell.controller, || {
        TcpStream::connect_timeout(&address, Duration::from_secs(5))
    });
    stream.set_nodelay(true).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(5)))
        .unwrap();
    stream
}

/// Sends a message of `bytes` and waits until it is back, whole. Returns how long that took.
fn exchange(stream: &mut TcpStream, number: u8, bytes: usize) -> std::io::Result<Duration> {
    let sent: Vec<u8> = (0..bytes)
        .map(|place| (place as u8).wrapping_mul(31) ^ number)
        .collect();
    let clock = Instant::now();
    stream.write_all(&sent)?;
    let mut back = vec![0; bytes];
    stream.read_exact(&mut back)?;
    assert!(back == sent, "the bytes come back as they were sent");
    Ok(clock.elapsed())
}

/// Messages on one connection while a fault is in force all the time.
fn exchanges(fault: &str, count: u8) -> (Vec<Duration>, PlayerReport) {
    let cell = Cell::start(&faulty(fault), SEED, 0).unwrap();
    let address = echo_server(&cell);
    let mut stream = connect(&cell, address);
    let took = (0..count).map(|number| exchange(&mut stream, number, 900).unwrap());
    let took = took.collect();
    drop(stream);
    thread::sleep(Duration::from_millis(50));
    (took, cell.finish())
}

/// TCP throws a duplicate away, and nothing is sent again.
pub(crate) fn duplicates_come_out_twice_and_do_tcp_no_harm() {
    let (took, report) = exchanges("at = \"0s\"\nfor = \"60s\"\nduplicate = \"100%\"", 50);
    println!("  up {:?}", report.up);
    assert_eq!(report.up.duplicated, report.up.packets);
    assert_eq!(report.down.duplicated, report.down.packets);
    assert_eq!(
        report.up.delivered + report.up.unplayed,
        2 * report.up.packets
    );
    let longest = took.iter().max().unwrap();
    assert!(
        *longest < Duration::from_millis(150),
        "nothing is resent: {longest:?}"
    );
}

/// If a kernel took a checksum for checked, wrong bytes would come back, and nothing would be resent.
pub(crate) fn a_flipped_bit_never_reaches_a_program_and_is_sent_again() {
    let (took, report) = exchanges("at = \"0s\"\nfor = \"60s\"\ncorrupt = \"8%\"", 60);
    println!("  up {:?}\n  down {:?}", report.up, report.down);
    let corrupted = report.up.corrupted + report.down.corrupted;
    assert!(corrupted > 0, "the seed has such slots");
    let resent = took
        .iter()
        .filter(|took| **took > Duration::from_millis(190))
        .count();
    println!("  {corrupted} damaged, {resent} messages waited for a resend");
    assert!(resent > 0, "what is damaged is sent again");
}

pub(crate) fn packets_that_are_held_back_are_overtaken_and_tcp_puts_them_in_order() {
    let fault = "at = \"0s\"\nfor = \"60s\"\nreorder = \"40%\"\nby = \"6ms\"";
    let cell = Cell::start(&faulty(fault), SEED, 0).unwrap();
    let address = echo_server(&cell);
    let mut stream = connect(&cell, address);
    // Many segments each, so that some overtake others.
    for number in 0..20 {
        exchange(&mut stream, number, 60_000).unwrap();
    }
    drop(stream);
    let report = cell.finish();
    println!("  up {:?}", report.up);
    assert_eq!(report.up.lost, 0);
}

/// Whether the connection is gone when it is used.
fn is_broken(result: &std::io::Result<Duration>) -> bool {
    let kinds = [ErrorKind::ConnectionReset, ErrorKind::BrokenPipe];
    let is_it = |error: &std::io::Error| kinds.contains(&error.kind());
    result.as_ref().is_err_and(is_it)
}

/// Of the answers only, so that the controller sees the reset at once; then of the requests, where the
/// plant does, and tells the controller of it when that sends again.
pub(crate) fn a_reset_ends_the_connection_under_way_and_another_can_be_opened() {
    for way in ["down", "up"] {
        let fault = format!("way = \"{way}\"\nat = \"500ms\"\nfor = \"500ms\"\nreset = true");
        let cell = Cell::start(&faulty(&fault), SEED, 0).unwrap();
        let address = echo_server(&cell);
        let mut stream = connect(&cell, address);
        exchange(&mut stream, 1, 900).unwrap();
        cell.sleep_until(550 * MS);
        // Where the plant's end is gone, a packet after the fault is the first that tells.
        let broken = exchange(&mut stream, 2, 900);
        assert!(is_broken(&broken), "{way}: {broken:?}");
        cell.sleep_until(1_050 * MS);
        let mut other = connect(&cell, address);
        exchange(&mut other, 3, 900).unwrap();
        drop((stream, other));
        let report = cell.finish();
        println!("  {way}: up {:?}\n  down {:?}", report.up, report.down);
        let [this, back] = match way {
            "up" => [report.up, report.down],
            _ => [report.down, report.up],
        };
        assert!(this.reset > 0 && back.reset == 0, "{way}");
    }
}

/// The old connection meets an end that does not know it, a new one works during the fault and ends with it.
pub(crate) fn a_changed_port_ends_old_connections_and_lets_new_ones_work() {
    let fault = "at = \"500ms\"\nfor = \"1500ms\"\nrebind = true";
    let cell = Cell::start(&faulty(fault), SEED, 0).unwrap();
    let address = echo_server(&cell);
    let mut old = connect(&cell, address);
    exchange(&mut old, 1, 900).unwrap();
    cell.sleep_until(550 * MS);
    let broken = exchange(&mut old, 2, 900);
    assert!(is_broken(&broken), "{broken:?}");
    let mut new = connect(&cell, address);
    for number in 0..20 {
        exchange(&mut new, number, 900).unwrap();
    }
    cell.sleep_until(2_050 * MS);
    let broken = exchange(&mut new, 3, 900);
    assert!(is_broken(&broken), "{broken:?}");
    exchange(&mut connect(&cell, address), 4, 900).unwrap();
    let report = cell.finish();
    println!("  up {:?}\n  down {:?}", report.up, report.down);
    assert!(report.up.rebound > 20 && report.down.rebound > 20);
}

pub(crate) fn a_link_that_is_down_carries_nothing_until_it_is_up_again() {
    let fault = "at = \"300ms\"\nfor = \"500ms\"\ndown = true";
    let cell = Cell::start(&faulty(fault), SEED, 0).unwrap();
    let address = echo_server(&cell);
    let mut stream = connect(&cell, address);
    exchange(&mut stream, 1, 900).unwrap();
    cell.sleep_until(320 * MS);
    let took = exchange(&mut stream, 2, 900).unwrap();
    let report = cell.finish();
    println!("  it took {took:?}, up {:?}", report.up);
    assert!(took > Duration::from_millis(450), "{took:?}");
    assert!(report.up.lost > 0);
}
