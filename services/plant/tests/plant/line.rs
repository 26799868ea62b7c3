//! Commands over a bare TCP connection.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{SocketAddr, TcpStream},
    thread,
    time::{Duration, Instant},
};

use endpoint::{Acknowledgement, State, checksum};
use plant::Ready;

use crate::support::{PATIENCE, begin, end, observe, status, with_plant};

struct Line(BufReader<TcpStream>);

impl Line {
    /// Connects and says what the lines are for.
    fn open(address: SocketAddr, hello: &str) -> Self {
        let stream = TcpStream::connect(address).expect("the plant listens");
        let timeout = stream.set_read_timeout(Some(PATIENCE));
        timeout.expect("a valid timeout");
        let mut line = Self(BufReader::new(stream));
        line.say(&format!("{hello}\n"));
        line
    }

    /// The same, and hears that it may.
    fn opened(address: SocketAddr, hello: &str) -> Self {
        let mut line = Self::open(address, hello);
        assert_eq!(line.hear(), "\n");
        line
    }

    fn say(&mut self, text: &str) {
        let said = self.0.get_mut().write_all(text.as_bytes());
        said.expect("the plant reads");
    }

    /// The next line with its end; empty when there is none.
    fn hear(&mut self) -> String {
        let mut line = String::new();
        self.0.read_line(&mut line).expect("a line");
        line
    }

    fn ask(&mut self, text: &str) -> String {
        self.say(&format!("{text}\n"));
        self.hear().trim_end().to_owned()
    }

    /// The plant's last line, behind its signs of life.
    fn last(&mut self) -> String {
        let mut rest = String::new();
        self.0.read_to_string(&mut rest).expect("text");
        rest.trim_start_matches('\n').to_owned()
    }
}

#[test]
fn both_modes_answer_as_over_http() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let mut closed = Line::opened(address, "mode=closed");
        let mut open = Line::opened(address, "mode=open");
        for seq in 0..100 {
            let query = format!("seq={seq}&t_send_ns=5&u=0.5");
            let state: State = closed.ask(&query).parse().expect("a state");
            assert_eq!((state.seq, state.u.first), (seq, 0.5));
            let query = format!("seq={seq}&t_send_ns=5&u=9");
            let answer: Acknowledgement = open.ask(&query).parse().expect("an answer");
            assert_eq!(answer.seq, seq);
        }
        // Many under way at once are answered in order, and a sign of life by nothing.
        let many = (100..200).map(|seq| format!("seq={seq}&t_send_ns=5&u=0.25\n\n"));
        closed.say(&many.collect::<String>());
        for seq in 100..200 {
            let answer = closed.hear();
            assert!(answer.starts_with(&format!("seq={seq}&")), "{answer}");
        }
        let signed = closed.ask(&checksum::signed("seq=200&t_send_ns=5&u=0.5"));
        assert!(checksum::checked(&signed, true).is_ok(), "{signed}");
        // In pieces.
        for piece in ["seq=20", "1&t_send_ns=5&", "u=1", "\n"] {
            closed.say(piece);
            thread::sleep(Duration::from_millis(5));
        }
        assert!(closed.hear().starts_with("seq=201&"));
        assert_eq!(observe(address).u, 1.0);
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.refused), (302, 0));
}

#[test]
fn a_line_that_cannot_be_read_ends_the_connection_with_the_reason() {
    let long = "0".repeat(1025);
    let endless = "0".repeat(200_000);
    // What is sent behind the first line, and what the last line says.
    let table: [(&[u8], &str); 8] = [
        (b"hello\n", "`hello` is unknown"),
        (b"seq=0&t_send_ns=5&u=NaN\n", "`u`: `NaN`"),
        (b"seq=0&t_send_ns=5&u=1\r\n", "`u`"),
        (b"mode=closed\n", "`mode` is unknown"),
        (b"seq=\xff\n", "UTF-8"),
        (b"GET / HTTP/1.1\r\n\r\n", "is unknown"),
        (long.as_bytes(), "at most 1024"),
        (endless.as_bytes(), "at most 1024"),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let count = table.len() as u64;
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        for (bytes, says) in table {
            let start = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
            let mut line = Line::opened(address, "mode=closed");
            // It may have refused and closed already.
            let _ = line.0.get_mut().write_all(bytes);
            let last = line.last();
            assert!(last.starts_with("error: "), "{start}: {last}");
            assert!(last.contains(says) && last.len() <= 131, "{start}: {last}");
            assert_eq!(observe(address).u, 0.0, "{start} changed the input");
        }
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.refused), (0, count));
}

#[test]
fn a_first_line_is_one_or_the_connection_is_http_s() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        for (hello, says) in [
            ("mode=ajar", "mode=closed"),
            ("mode=closed&u=1", "mode=closed"),
            ("mode=closed&session=0", "over or unknown"),
            ("modes=closed", "400 Bad Request"),
            ("u=1", "400 Bad Request"),
        ] {
            let last = Line::open(address, hello).last();
            assert!(last.contains(says), "{hello}: {last}");
        }
        // Behind a request, lines are none.
        let request = "GET /state HTTP/1.1\r\nHost: a\r\n\r\nmode=closed\nu=1";
        let all = Line::open(address, request).last();
        assert!(all.contains("200 OK") && all.contains("400 Bad"), "{all}");
        assert_eq!(observe(address).u, 0.0);
    })
    .expect("a run without errors");
}

#[test]
fn a_session_commands_by_its_lines_and_takes_them_with_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        let token = begin(address, "a browser");
        let last = Line::open(address, "mode=closed").last();
        assert!(last.contains("`a browser` is in control"), "{last}");
        let mut line = Line::opened(address, &format!("mode=closed&session={token}"));
        assert!(line.ask("u=0.5").starts_with("seq="));
        assert_eq!(status(address)["commands"], 1);
        assert_eq!(end(address, &token, "{}").status, 204);
        assert_eq!(line.last(), "error: the session is over\n");
        assert_eq!(observe(address).u, 0.5);
    })
    .expect("a run without errors");
}

#[test]
fn who_is_silent_is_asked_for_a_sign_of_life_and_loses_its_place_without() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        let (mut silent, mut alive) = (
            Line::opened(address, "mode=closed"),
            Line::opened(address, "mode=closed"),
        );
        let start = Instant::now();
        assert_eq!(
            (silent.hear().as_str(), alive.hear().as_str()),
            ("\n", "\n")
        );
        alive.say("\n");
        assert_eq!(silent.last(), "error: no line within 5 s\n");
        assert!(start.elapsed() > Duration::from_secs(6));
        // It has been asked again meanwhile.
        alive.say("\nu=1\n");
        let answered = (0..5).any(|_| alive.hear().starts_with("seq="));
        assert!(answered);
    })
    .expect("a run without errors");
}
