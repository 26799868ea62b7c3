//! A real plant on a socket of this machine, asked by a client that writes what it likes.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use tokio_tungstenite::tungstenite::{Message, client};

use super::*;
use crate::trial::S;

/// How long an answer may take on the busiest machine.
const PATIENCE: Duration = Duration::from_secs(30);

fn trial(name: &str) -> Trial {
    let trials = Trial::all("100ms".parse().expect("a sample time"));
    let mut named = trials.into_iter().filter(|trial| trial.name == name);
    named.next().expect(name)
}

/// A plant whose trial starts in `in_ns`.
fn open(name: &str, in_ns: u64) -> Plant {
    Plant::open(&trial(name), now_ns() + in_ns).expect("a plant")
}

/// A connection to the plant, as soon as it listens.
fn connect(plant: &Plant) -> TcpStream {
    let until = Instant::now() + PATIENCE;
    let stream = loop {
        match TcpStream::connect(plant.address) {
            Ok(stream) => break stream,
            Err(problem) => assert!(Instant::now() < until, "{problem}"),
        }
        thread::sleep(Duration::from_millis(5));
    };
    stream.set_read_timeout(Some(PATIENCE)).expect("a time-out");
    stream
}

/// The next response on this connection; empty if the plant has closed it.
fn get(stream: &mut TcpStream, target: &str) -> String {
    say(
        stream,
        &format!("GET {target} HTTP/1.1\r\nHost: plant\r\n\r\n"),
    )
}

/// The same for a request in these words.
fn say(stream: &mut TcpStream, request: &str) -> String {
    if stream.write_all(request.as_bytes()).is_err() {
        return String::new();
    }
    let (mut text, mut part) = (String::new(), [0; 4096]);
    while !is_whole(&text) {
        match stream.read(&mut part) {
            Ok(length @ 1..) => text += &String::from_utf8_lossy(&part[..length]),
            _ => break,
        }
    }
    text
}

/// Whether this is a head with all of its body.
fn is_whole(text: &str) -> bool {
    text.split_once("\r\n\r\n").is_some_and(|(head, body)| {
        let length = head
            .lines()
            .find_map(|line| line.strip_prefix("content-length: "));
        length.is_some_and(|length| length.parse::<usize>() == Ok(body.len()))
    })
}

#[test]
fn messages_are_answered_and_recorded_with_what_they_said() {
    let plant = open("steady", 0);
    let mut stream = connect(&plant);
    let answer = get(&mut stream, "/closed?u=0.35");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    assert!(answer.contains("seq=0&tick="), "{answer}");
    assert!(answer.ends_with("&u=0.35"), "{answer}");
    let answer = get(&mut stream, "/open?seq=7&t_send_ns=1&u=1");
    assert!(answer.contains("seq=7&t_arrive_ns="), "{answer}");
    assert!(get(&mut stream, "/state").contains("t_ns="));
    for wrong in [
        "/closed?u=nan",
        "/closed",
        "/close?u=1",
        "/socket?mode=closed",
    ] {
        let answer = get(&mut stream, wrong);
        assert!(answer.starts_with("HTTP/1.1 4"), "{wrong}: {answer}");
    }
    let heard = plant.close().expect("it listened");
    let seqs: Vec<_> = heard.arrivals.iter().map(|one| one.request.seq).collect();
    assert_eq!((seqs, heard.connections), (vec![None, Some(7)], 1));
    assert_eq!(heard.refused, 4);
    let first = heard.first_refused.expect("the first");
    assert!(first.contains("`u=nan`"), "{first}");
}

#[test]
fn a_request_is_taken_or_refused_as_the_plant_does() {
    let plant = open("steady", 0);
    for (request, status) in [
        (
            "GET /state HTTP/1.1\r\nHost: plant\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
            200,
        ),
        ("GET /state HTTP/1.0\r\n\r\n", 200),
        ("GET /state HTTP/1.1\r\n\r\n", 400),
        ("GET /state HTTP/1.1\nHost: plant\n\n", 400),
        (
            "GET http://plant/state HTTP/1.1\r\nHost: plant\r\n\r\n",
            400,
        ),
        (
            "GET /state HTTP/1.1\r\nHost: plant\r\nContent-Length: 3\r\n\r\nu=1",
            413,
        ),
        ("HEAD /state HTTP/1.1\r\nHost: plant\r\n\r\n", 405),
    ] {
        let mut stream = connect(&plant);
        let answer = say(&mut stream, request);
        let start = format!(" {status} ");
        assert!(answer.contains(&start), "{request:?}: {answer}");
    }
    assert_eq!(plant.close().expect("it listened").refused, 5);
}

#[test]
fn a_plant_that_listens_late_refuses_connections_until_then() {
    let late = open("late-start", 60 * S);
    assert!(TcpStream::connect(late.address).is_err());
    assert!(get(&mut connect(&open("late-start", 0)), "/state").contains("y=0.0"));
}

#[test]
fn a_connection_is_closed_after_its_last_answer_without_notice() {
    // With h = 100 ms 20 messages are due, and 5 go from one closing to the next.
    let plant = open("dropped", 0);
    let mut stream = connect(&plant);
    for seq in 0..5 {
        let answer = get(&mut stream, "/closed?u=1");
        assert!(answer.contains(&format!("seq={seq}&")), "{answer}");
        assert!(!answer.contains("connection: close"), "{answer}");
    }
    assert_eq!(get(&mut stream, "/closed?u=1"), "");
    assert!(get(&mut connect(&plant), "/closed?u=1").contains("seq=5&"));
    assert_eq!(plant.close().expect("it listened").closed_ns.len(), 1);
}

#[test]
fn a_socket_carries_messages_and_is_closed_by_one_that_is_refused() {
    let plant = open("steady", 0);
    let url = "ws://plant/socket?mode=closed";
    let (mut socket, _) = client(url, connect(&plant)).expect("a handshake");
    let mut ask = |text: &str| {
        socket.send(Message::text(text)).expect("an open socket");
        socket.read().expect("an answer")
    };
    let answer = ask("seq=3&u=0.35").to_string();
    assert!(answer.starts_with("seq=3&tick="), "{answer}");
    assert!(matches!(ask("u=fast"), Message::Close(Some(_))));
    let heard = plant.close().expect("it listened");
    assert_eq!((heard.messages(), heard.refused), (1, 1));
}
