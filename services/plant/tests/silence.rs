//! By the clock, and so in a process of its own: a thousand times a command and then nothing. The same in virtual
//! time, at every h, is among the laws of `endpoint`.

// `--nocapture` prints what docs/safe-plant.md quotes.
#![allow(clippy::print_stdout)]

use std::{net::TcpStream, sync::mpsc, thread, time::Duration};

use control::preset;
use endpoint::{ArrivalRow, PlantSettings, SampleTime, TickRow};
use plant::{Config, serve_until};
use tokio::sync::oneshot;
use tokio_tungstenite::tungstenite::{Message, client};

const H_NS: u64 = 1_000_000;
const WATCHDOG_NS: u64 = 5_000_000;
const SILENCES: u64 = 1000;

fn rows<R: serde::de::DeserializeOwned>(path: &std::path::Path) -> Vec<R> {
    let mut reader = csv::Reader::from_path(path).expect("the file");
    let rows = reader.deserialize().collect::<Result<_, _>>();
    rows.expect("rows")
}

#[test]
fn a_thousand_silences_end_in_the_safe_state_within_the_watchdog_s_time_and_two_ticks() {
    serial::timed("a thousand silences", a_thousand_silences);
}

fn a_thousand_silences() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = Config {
        listen: "127.0.0.1:0".parse().expect("an address"),
        hosts: Vec::new(),
        settings: PlantSettings {
            hold: "5ms then zero".parse().expect("a hold"),
            ..PlantSettings::new(SampleTime::try_new(H_NS).expect("1 ms"))
        },
        law: None,
        reference: None,
        out: folder.path().to_owned(),
        again: false,
    };
    let motor = preset::paper_plant().sampled(H_NS).expect("regular");
    let (ready, is_ready) = mpsc::channel();
    let (stop, stopped) = oneshot::channel::<()>();
    let plant = thread::spawn(move || {
        let stopped = async {
            let _ = stopped.await;
            Ok(())
        };
        serve_until(&config, motor.stepper(), stopped, |facts| {
            ready.send(facts).expect("the test waits");
        })
    });
    let patience = Duration::from_secs(10);
    let address = is_ready.recv_timeout(patience).expect("it starts").address;
    let stream = TcpStream::connect(address).expect("it listens");
    let url = format!("ws://{address}/socket?mode=closed");
    let (mut socket, _) = client(url, stream).expect("a socket");
    for seq in 0..SILENCES {
        let command = format!("u=1&seq={seq}");
        socket.send(Message::text(command)).expect("it reads");
        socket.read().expect("an answer");
        // Longer than the watchdog and two ticks.
        thread::sleep(Duration::from_nanos(2 * WATCHDOG_NS));
    }
    // A busy machine may be behind with its ticks.
    thread::sleep(Duration::from_millis(500));
    drop(stop);
    let report = plant.join().expect("no panic").expect("no errors");

    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join(ArrivalRow::FILE));
    let ticks: Vec<TickRow> = rows(&folder.path().join(TickRow::FILE));
    assert_eq!(arrivals.len() as u64, SILENCES);
    let nexts = arrivals.iter().skip(1).map(|row| row.t_arrive_ns);
    let (mut ended, mut within, mut worst_ns, mut from) = (0, 0, 0, ticks.iter());
    for (command, next_ns) in arrivals.iter().zip(nexts.chain([u64::MAX])) {
        // A plant whose machine stood still from the watchdog's time to the next command had no silence to end.
        let looked = ticks
            .iter()
            .any(|row| row.t_due_ns > command.t_arrive_ns + WATCHDOG_NS && row.t_tick_ns < next_ns);
        let is_safe = |row: &&TickRow| row.seq == Some(command.seq) && row.u_applied == Some(0.0);
        let mut later = from.clone();
        let safe = later.find(is_safe);
        let Some(safe) = safe else {
            assert!(!looked, "the silence after {} did not end", command.seq);
            continue;
        };
        from = later;
        ended += 1;
        assert_eq!(safe.u, 1.0, "the commanded input is told as it was");
        // What the plant decides, and what its machine made of it.
        let due_ns = safe.t_due_ns - command.t_arrive_ns;
        assert!(
            due_ns > WATCHDOG_NS && due_ns <= WATCHDOG_NS + 2 * H_NS,
            "{due_ns} ns"
        );
        let safe_ns = safe.t_tick_ns - command.t_arrive_ns;
        worst_ns = worst_ns.max(safe_ns);
        within += u64::from(safe_ns <= WATCHDOG_NS + 2 * H_NS);
    }
    assert_eq!(report.trips, ended);
    println!(
        "row 16: real ticks at 1 kHz, {ended} of {SILENCES} by the ticks' due times; {within} by the clock, the slowest after {:.2} ms",
        worst_ns as f64 * 1e-6
    );
    assert!(within * 10 > SILENCES * 9, "{within} on a busy machine");
}
