//! Messages over HTTP, and what every controller does whatever carries them.

use std::{
    io::{Read, Write},
    net::{SocketAddr, TcpListener},
    sync::mpsc,
    thread,
    time::Duration,
};

use controller::{Config, DriveError, drive_until};
use endpoint::{Connection, ControllerSettings, MessageOutcome, MessageRow, Mode, Preset, TickRow};

use crate::{MS, check, config, drive, h, rows, with_plant};

pub(crate) fn the_paper_s_loop_settles_at_its_reference_at_333_hz_and_1_khz() {
    for ms in [3, 1] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = Preset::PaperPython.settings(Mode::Closed, h(ms));
        let (report, plant) = with_plant(folder.path(), h(ms), |address| {
            drive(&config(folder.path(), address, settings, 2400)).expect("a run without errors")
        });
        let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
        check(&report, &messages, 2400 / ms);
        assert_eq!(report.first_failure, None);
        assert_eq!(plant.arrivals, report.counts.sent);
        // Without a network the loop settles to 2 % well within half a second;
        // over the last second only a stall of the machine can move it.
        let ticks: Vec<TickRow> = rows(&folder.path().join("ticks.csv"));
        let tail: Vec<f64> = ticks
            .iter()
            .filter(|row| (report.stop_ns - 1000 * MS..report.stop_ns).contains(&row.t_due_ns))
            .map(|row| row.y)
            .collect();
        let mean = tail.iter().sum::<f64>() / tail.len() as f64;
        assert!(
            (mean - 1.0).abs() < 0.02,
            "h = {ms} ms: mean of the last second {mean}"
        );
    }
}

pub(crate) fn a_new_connection_for_each_message_is_a_new_connection_for_each_message() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paper = Preset::PaperPython.settings(Mode::Open, h(10));
    let settings = ControllerSettings {
        connection: Connection::New,
        ..paper
    };
    let (report, plant) = with_plant(&folder.path().join("new"), h(10), |address| {
        drive(&config(&folder.path().join("new"), address, settings, 300)).expect("no errors")
    });
    // The warm-up is one request and two beside each other.
    assert_eq!(plant.connections, report.counts.sent + 3);

    let (report, plant) = with_plant(&folder.path().join("keep"), h(10), |address| {
        drive(&config(&folder.path().join("keep"), address, paper, 300)).expect("no errors")
    });
    assert!(report.counts.sent > 10);
    assert!(plant.connections < report.counts.sent, "{plant:?}");
}

pub(crate) fn a_plant_that_goes_away_costs_its_messages_and_not_the_run() {
    // It answers the warm-up and five commands, then hangs up for good.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound");
    let plant = thread::spawn(move || {
        let mut commands = 0;
        while commands < 5 {
            let (mut stream, _) = listener.accept().expect("a connection");
            let mut request = vec![0; 4096];
            let read = stream.read(&mut request).expect("a request");
            let head = String::from_utf8_lossy(&request[..read]).into_owned();
            let body = if head.starts_with("GET /state ") {
                "t_ns=1&tick=1&y=0.0&u=0.0".to_owned()
            } else {
                commands += 1;
                let seq = head.split(['=', '&']).nth(1).unwrap_or_default().to_owned();
                format!("seq={seq}&t_arrive_ns=1")
            };
            let length = body.len();
            write!(
                stream,
                "HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: {length}\r\n\r\n{body}"
            )
            .expect("the controller reads");
        }
    });
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = Preset::Blocking.settings(Mode::Open, h(10));
    let report = drive(&config(folder.path(), address, settings, 300)).expect("a run to its end");
    plant.join().expect("no panic");
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, 30);
    assert_eq!(report.counts.answered, 5);
    assert!(report.counts.failed > 0);
    let last = messages.last().expect("rows");
    assert!(
        matches!(
            last.outcome,
            MessageOutcome::Failed | MessageOutcome::Missed
        ),
        "{last:?}"
    );
    let why = report.first_failure.expect("failures");
    // Mostly nobody listens; one that connects just before is reset.
    let is_said = why.starts_with("cannot connect to the plant: Connection refused")
        || why.starts_with("the connection to the plant broke: ");
    assert!(is_said, "{why}");
}

pub(crate) fn a_silent_plant_is_timeouts_and_a_full_client_misses() {
    // It answers /state and is silent on commands: 20 deadlines of 10 ms, two
    // outstanding, a timeout of 50 ms.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound");
    let (stop, stopped) = mpsc::channel::<()>();
    let plant = thread::spawn(move || {
        let mut silent = Vec::new();
        listener.set_nonblocking(true).expect("a socket");
        while let Err(mpsc::TryRecvError::Empty) = stopped.try_recv() {
            let Ok((mut stream, _)) = listener.accept() else {
                thread::sleep(Duration::from_millis(1));
                continue;
            };
            stream.set_nonblocking(false).expect("a socket");
            let mut request = [0; 512];
            let read = stream.read(&mut request).unwrap_or_default();
            if request[..read].starts_with(b"GET /state ") {
                let answer = "HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: 25\r\n\r\nt_ns=1&tick=1&y=0.0&u=0.0";
                stream
                    .write_all(answer.as_bytes())
                    .expect("the controller reads");
            } else {
                silent.push(stream);
            }
        }
    });
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = ControllerSettings {
        outstanding: "2".parse().expect("a valid word"),
        timeout_ns: 50 * MS,
        ..Preset::PaperPython.settings(Mode::Open, h(10))
    };
    let report = drive(&config(folder.path(), address, settings, 200)).expect("a run to its end");
    drop(stop);
    plant.join().expect("no panic");
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, 20);
    assert_eq!(report.counts.timeout, report.counts.sent);
    // Two under way for 50 ms or a little more each: 2 of about 5 deadlines.
    assert!(
        (4..=10).contains(&report.counts.sent),
        "{:?}",
        report.counts
    );
}

pub(crate) fn what_cannot_be_reached_or_is_no_address_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = Preset::Blocking.settings(Mode::Open, h(10));
    let address: SocketAddr = "127.0.0.1:1".parse().expect("an address");
    for plant in [
        "",
        "10.77.0.2:8080",
        "https://127.0.0.1:1",
        "http://127.0.0.1:1/closed",
        "ftp://a/",
    ] {
        let bad = Config {
            plant: plant.to_owned(),
            ..config(folder.path(), address, settings, 1)
        };
        let error = drive(&bad).expect_err("it is no address");
        assert!(matches!(error, DriveError::Address { .. }), "{error}");
        assert!(
            error.to_string().contains("http://10.77.0.2:8080"),
            "{error}"
        );
    }
    assert!(!folder.path().join("messages.csv").exists());
}

pub(crate) fn a_controller_that_is_told_to_end_keeps_its_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = Preset::PaperPython.settings(Mode::Closed, h(10));
    let (report, _) = with_plant(folder.path(), h(10), |address| {
        let config = config(folder.path(), address, settings, 60_000);
        let stop = async {
            tokio::time::sleep(Duration::from_millis(600)).await;
            Ok(())
        };
        thread::scope(|scope| {
            let run = scope.spawn(|| drive_until(&config, stop));
            run.join().expect("no panic").expect("a run without errors")
        })
    });
    assert!(report.interrupted);
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, report.counts.due);
    assert!(report.counts.due > 0);
}
