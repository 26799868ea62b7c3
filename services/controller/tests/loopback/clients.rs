//! The controller's own client and reqwest: whatever a plant says, both make the same of it, in the same words.

use std::{
    io::{BufRead, BufReader, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    thread,
    time::Duration,
};

use controller::{Client, Config};
use endpoint::{ControllerSettings, MessageOutcome, MessageRow, Mode, Preset};
use pace::now_ns;

use crate::{MS, config, drive, h, rows};

/// Deadlines of a run: their numbers have one digit.
const DEADLINES: u64 = 5;

/// What a plant says to a command, piece by piece. `N` is the number of the command.
#[derive(Clone, Debug)]
struct Said {
    pieces: Vec<Vec<u8>>,
    /// Whether it hangs up then.
    hangs_up: bool,
}

fn said(text: &str, hangs_up: bool) -> Said {
    Said {
        pieces: vec![text.as_bytes().to_vec()],
        hangs_up,
    }
}

fn plant(said: Said) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound");
    thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let said = said.clone();
            thread::spawn(move || serve(stream, &said));
        }
    });
    address
}

fn serve(mut stream: TcpStream, said: &Said) {
    stream.set_nodelay(true).expect("a socket");
    let lines = BufReader::new(stream.try_clone().expect("a socket")).lines();
    let mut number = None;
    for line in lines.map_while(Result::ok) {
        if let Some(rest) = line.strip_prefix("GET /open?seq=") {
            number = rest.bytes().next();
        }
        if !line.is_empty() {
            continue;
        }
        let Some(number) = number.take() else {
            let body = "t_ns=1&tick=1&y=0.0&u=0.0";
            let head = "HTTP/1.1 200 OK\r\nContent-Length: 25\r\n\r\n";
            let _ = stream.write_all(format!("{head}{body}").as_bytes());
            continue;
        };
        for piece in &said.pieces {
            let mut piece = piece.clone();
            for at in 4..piece.len() {
                if &piece[at - 4..=at] == b"seq=N" {
                    piece[at] = number;
                }
            }
            let _ = stream.write_all(&piece);
            if said.pieces.len() > 1 {
                thread::sleep(Duration::from_millis(1));
            }
        }
        if said.hangs_up {
            let _ = stream.shutdown(Shutdown::Both);
            return;
        }
    }
}

/// How messages ended, of those that a busy machine let go, and why the first failed.
fn ends(client: Client, said: &Said) -> (bool, bool, bool, Option<String>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = ControllerSettings {
        timeout_ns: 150 * MS,
        ..Preset::Blocking.settings(Mode::Open, h(10))
    };
    let config = Config {
        client,
        connections: 1,
        start_ns: Some(now_ns() + 30 * MS),
        ..config(folder.path(), plant(said.clone()), settings, 10 * DEADLINES)
    };
    let report = drive(&config).expect("a run to its end");
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    let any = |outcome| messages.iter().any(|row| row.outcome == outcome);
    (
        any(MessageOutcome::Answered),
        any(MessageOutcome::Failed),
        any(MessageOutcome::Timeout),
        report.first_failure,
    )
}

pub(crate) fn both_clients_make_the_same_of_what_a_plant_says() {
    const OK: &str = "HTTP/1.1 200 OK\r\n";
    const BODY: &str = "seq=N&t_arrive_ns=1";
    let good = format!("{OK}Content-Length: 19\r\n\r\n{BODY}");
    let chunked = format!(
        "{OK}Transfer-Encoding: chunked\r\n\r\n5;a=b\r\nseq=N\r\ne\r\n&t_arrive_ns=1\r\n0\r\nA: b\r\n\r\n"
    );
    let table = [
        said(&good, false),
        // It does not say so before.
        said(&good, true),
        said(&format!("{good}and more"), false),
        said(&format!("HTTP/1.1 103 Wait\r\nA: b\r\n\r\n{good}"), false),
        said(&chunked, false),
        Said {
            pieces: chunked.as_bytes().chunks(40).map(<[u8]>::to_vec).collect(),
            hangs_up: false,
        },
        said(&format!("{OK}\r\n{BODY}"), true),
        said(&format!("{OK}\r\n{BODY}"), false),
        said(
            &format!("HTTP/1.0 200 OK\r\nContent-Length: 19\r\n\r\n{BODY}"),
            false,
        ),
        said("", true),
        said("", false),
        said("HTTP/1.1 200", true),
        said(&format!("{OK}Content-Length: 30\r\n\r\n{BODY}"), true),
        said(&format!("{OK}Content-Length: 30\r\n\r\n{BODY}"), false),
        said(&format!("{OK}Content-Length: x\r\n\r\n{BODY}"), false),
        said(&format!("{OK}a b: c\r\n\r\n"), false),
        said("HTTQ/1.1 200 OK\r\n\r\n", false),
        said("HTTP/1.1 2x0 OK\r\n\r\n", false),
        said(
            "HTTP/1.0 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
            false,
        ),
        said("HTTP/1.1 204 No Content\r\n\r\n", false),
        said(
            "HTTP/1.1 409 Conflict\r\nContent-Length: 9\r\n\r\nin use\x07\r\n",
            false,
        ),
        said("HTTP/1.1 599 Odd\r\nContent-Length: 1\r\n\r\nx", false),
        said(
            "HTTP/1.1 302 Found\r\nLocation: /state\r\nContent-Length: 0\r\n\r\n",
            false,
        ),
        said(&format!("{OK}Content-Length: 5\r\n\r\nseq=\u{fffd}"), false),
    ];
    for said in table {
        let text = String::from_utf8_lossy(&said.pieces[0]).into_owned();
        // On a busy machine a plant may hang up after the next command has been sent.
        let is_same = serial::tries().any(|_| {
            let [own, other] = [Client::Own, Client::Reqwest].map(|client| ends(client, &said));
            let is_same = own == other;
            if !is_same {
                println!("  {text:?}:\n  {own:?}\n  {other:?}");
            }
            is_same
        });
        assert!(is_same, "{text:?}");
    }
    // A bad chunk fails with both, in other words.
    let bad = said(
        &format!("{OK}Transfer-Encoding: chunked\r\n\r\nx\r\n"),
        false,
    );
    for client in [Client::Own, Client::Reqwest] {
        let (answered, failed, timeout, why) = ends(client, &bad);
        assert_eq!(
            (answered, failed, timeout),
            (false, true, false),
            "{client:?}"
        );
        let why = why.expect("failures");
        assert!(why.starts_with("error decoding response body"), "{why}");
    }
}
