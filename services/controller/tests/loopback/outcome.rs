//! Whatever a plant says to a command over HTTP: how its message ends, and in which words.

use std::{
    io::{BufRead, BufReader, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    thread,
    time::Duration,
};

use controller::Config;
use endpoint::{ControllerSettings, MessageOutcome, MessageRow, Mode, Preset};

use crate::{MS, config, drive, h, rows};

/// Deadlines of a run: their numbers have one digit.
const DEADLINES: u64 = 5;

/// What a plant says to a command, piece by piece. `N` is the number of the command.
#[derive(Clone, Debug)]
struct Said {
    pieces: Vec<Vec<u8>>,
    then: Then,
}

/// What a plant does then.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Then {
    Stays,
    HangsUp,
    /// It hangs up before it has read the command, which the kernel tells the other end at once.
    Resets,
}

/// What becomes of the messages: all of them answered, none in time, or all failed in these words.
#[derive(Clone, Debug, PartialEq)]
enum Ends {
    Answered,
    Late,
    Failed(String),
    /// What no run should have: some so and some otherwise.
    Mixed([bool; 3], Option<String>),
}

fn said(text: &str, then: Then) -> Said {
    Said {
        pieces: vec![text.as_bytes().to_vec()],
        then,
    }
}

fn failed(why: &str) -> Ends {
    Ends::Failed(why.to_owned())
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
    let mut start = [0; 9];
    if said.then == Then::Resets && stream.peek(&mut start).is_ok() && &start == b"GET /open" {
        return;
    }
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
            if said.then == Then::Resets {
                return;
            }
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
        if said.then == Then::HangsUp {
            let _ = stream.shutdown(Shutdown::Both);
            return;
        }
    }
}

/// How messages ended, of those that a busy machine let go.
fn ends(said: &Said) -> Ends {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = ControllerSettings {
        timeout_ns: 150 * MS,
        ..Preset::Blocking.settings(Mode::Open, h(10))
    };
    let config = Config {
        connections: 1,
        ..config(folder.path(), plant(said.clone()), settings, 10 * DEADLINES)
    };
    let report = drive(&config).expect("a run to its end");
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    let any = |outcome| messages.iter().any(|row| row.outcome == outcome);
    let outcomes = [
        any(MessageOutcome::Answered),
        any(MessageOutcome::Timeout),
        any(MessageOutcome::Failed),
    ];
    match (outcomes, report.first_failure) {
        ([true, false, false], None) => Ends::Answered,
        ([false, true, false], None) => Ends::Late,
        ([false, false, true], Some(why)) => Ends::Failed(why),
        (_, why) => Ends::Mixed(outcomes, why),
    }
}

const OK: &str = "HTTP/1.1 200 OK\r\n";
const BODY: &str = "seq=N&t_arrive_ns=1";

/// What a plant may say that is a good answer, or none in time.
fn good() -> Vec<(Said, Ends)> {
    use Then::{HangsUp, Stays};
    let good = format!("{OK}Content-Length: 19\r\n\r\n{BODY}");
    let chunked = format!(
        "{OK}Transfer-Encoding: chunked\r\n\r\n5;a=b\r\nseq=N\r\ne\r\n&t_arrive_ns=1\r\n0\r\nA: b\r\n\r\n"
    );
    let answered = [
        said(&good, Stays),
        // It does not say so before.
        said(&good, HangsUp),
        said(
            &good.replace("Content", "Connection: close\r\nContent"),
            HangsUp,
        ),
        said(&format!("{good}and more"), Stays),
        said(&format!("HTTP/1.1 103 Wait\r\nA: b\r\n\r\n{good}"), Stays),
        said(&format!("HTTP/1.1 100 Continue\r\n\r\n{good}"), Stays),
        said(&chunked, Stays),
        Said {
            pieces: chunked.as_bytes().chunks(40).map(<[u8]>::to_vec).collect(),
            then: Stays,
        },
        Said {
            pieces: good.as_bytes().chunks(9).map(<[u8]>::to_vec).collect(),
            then: Stays,
        },
        said(&format!("{OK}\r\n{BODY}"), HangsUp),
        said(
            &format!("HTTP/1.0 200 OK\r\nContent-Length: 19\r\n\r\n{BODY}"),
            Stays,
        ),
    ];
    let late = [
        said(&format!("{OK}\r\n{BODY}"), Stays),
        said("", Stays),
        said("HTTP/1.1 200", Stays),
        said(&format!("{OK}Content-Length: 30\r\n\r\n{BODY}"), Stays),
        said(&chunked[..chunked.len() - 4], Stays),
    ];
    let answered = answered.map(|said| (said, Ends::Answered));
    let late = late.map(|said| (said, Ends::Late));
    answered.into_iter().chain(late).collect()
}

/// What it may say that is no answer, and what is said of that.
fn bad() -> Vec<(Said, Ends)> {
    use Then::{HangsUp, Resets, Stays};
    let no_http = |why: &str| failed(&format!("the answer is not HTTP/1.1: {why}"));
    let unreadable = |why: &str| failed(&format!("the plant's answer cannot be read: {why}"));
    let cut = |part: &str| {
        failed(&format!(
            "the connection was closed within the {part} of the answer"
        ))
    };
    vec![
        (
            said("", HangsUp),
            failed("the connection was closed before an answer came"),
        ),
        (
            said("", Resets),
            failed("the connection to the plant broke: Connection reset by peer (os error 104)"),
        ),
        (said("HTTP/1.1 200", HangsUp), cut("head")),
        (
            said(&format!("{OK}Content-Length: 30\r\n\r\n{BODY}"), HangsUp),
            cut("body"),
        ),
        (
            said(
                &format!("{OK}Transfer-Encoding: chunked\r\n\r\n13\r\n{BODY}"),
                HangsUp,
            ),
            cut("body"),
        ),
        (
            said(&format!("{OK}Content-Length: x\r\n\r\n{BODY}"), Stays),
            no_http("its Content-Length is not one number"),
        ),
        (
            said(
                &format!("{OK}Content-Length: 99999999\r\n\r\n{BODY}"),
                Stays,
            ),
            failed("the answer has more than 65536 bytes"),
        ),
        (
            said(&format!("{OK}a b: c\r\n\r\n"), Stays),
            no_http("the name of a header is not a word"),
        ),
        (
            said("HTTQ/1.1 200 OK\r\n\r\n", Stays),
            no_http("its version is not HTTP/1.1 or HTTP/1.0"),
        ),
        (
            said("HTTP/1.1 2x0 OK\r\n\r\n", Stays),
            no_http("its status is not three digits"),
        ),
        (
            said(
                "HTTP/1.0 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
                Stays,
            ),
            no_http("HTTP/1.0 has no Transfer-Encoding"),
        ),
        (
            said(
                &format!("{OK}Transfer-Encoding: chunked\r\n\r\nx\r\n"),
                Stays,
            ),
            failed("the chunks of the answer cannot be read"),
        ),
        (
            said("HTTP/1.1 204 No Content\r\n\r\n", Stays),
            unreadable("field `seq` is missing: this message has the fields seq, t_arrive_ns"),
        ),
        (
            said(&format!("{OK}Content-Length: 5\r\n\r\nseq=\u{fffd}"), Stays),
            unreadable(
                "field `t_arrive_ns` is missing: this message has the fields seq, t_arrive_ns",
            ),
        ),
        (
            said(
                "HTTP/1.1 409 Conflict\r\nContent-Length: 9\r\n\r\nin use\x07\r\n",
                Stays,
            ),
            failed("the plant answered 409 Conflict: in use\\u{7}"),
        ),
        (
            said("HTTP/1.1 599 Odd\r\nContent-Length: 1\r\n\r\nx", Stays),
            failed("the plant answered 599: x"),
        ),
        (
            said(
                "HTTP/1.1 302 Found\r\nLocation: /state\r\nContent-Length: 0\r\n\r\n",
                Stays,
            ),
            failed("the plant answered 302 Found"),
        ),
    ]
}

pub(crate) fn whatever_a_plant_says_each_message_has_its_end_and_a_failure_its_words() {
    for (said, expected) in good().into_iter().chain(bad()) {
        let text = String::from_utf8_lossy(&said.pieces[0]).into_owned();
        // On a busy machine a plant may hang up after the next command has been sent.
        let is_so = serial::tries().any(|_| {
            let found = ends(&said);
            if found != expected {
                println!("  {text:?}:\n  {found:?}\n  not {expected:?}");
            }
            found == expected
        });
        assert!(is_so, "{text:?}");
    }
}
