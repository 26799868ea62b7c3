//! Messages on a bare TCP connection, against a plant by script.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{SocketAddr, TcpListener, TcpStream},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use endpoint::{
    Acknowledgement, Command, ControllerSettings, MessageOutcome, MessageRow, Mode, Preset,
    Transport, report,
};

use crate::{MS, check, config, drive, h, rows};

const AT_REST: &[u8] =
    b"HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: 25\r\n\r\nt_ns=1&tick=1&y=0.0&u=0.0";

/// What a scripted plant says: to the first line of its first connection, and to each command of it; nothing is for
/// nothing. On all others it answers.
#[derive(Clone, Copy)]
struct Script {
    hello: &'static str,
    says: fn(u64) -> Option<String>,
}

fn acknowledged(seq: u64) -> String {
    let t_arrive_ns = seq;
    format!("{}\n", Acknowledgement { seq, t_arrive_ns })
}

/// A plant for as long as the test's process lives, and how many connections had lines.
fn plant(script: Script) -> (SocketAddr, Arc<AtomicUsize>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound");
    let asked = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&asked);
    thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let count = Arc::clone(&count);
            thread::spawn(move || serve(stream, script, &count));
        }
    });
    (address, asked)
}

fn serve(mut stream: TcpStream, script: Script, asked: &AtomicUsize) {
    let mut start = [0];
    if stream.peek(&mut start).is_err() || start != *b"m" {
        let _ = stream.read(&mut [0; 2048]);
        let _ = stream.write_all(AT_REST);
        return;
    }
    // A refusal before the first command is nobody's failure.
    let scripted = if script.hello == "\n" { 1 } else { 2 };
    let is_first = asked.fetch_add(1, Ordering::Relaxed) < scripted;
    let mut out = stream.try_clone().expect("a socket");
    let mut lines = BufReader::new(stream).lines().map_while(Result::ok);
    assert_eq!(lines.next().as_deref(), Some("mode=open"));
    let hello = if is_first { script.hello } else { "\n" };
    let _ = out.write_all(hello.as_bytes());
    for line in lines.filter(|line| !line.is_empty()) {
        let command: Command = line.parse().expect("a command");
        let said = if is_first {
            (script.says)(command.seq)
        } else {
            Some(acknowledged(command.seq))
        };
        let Some(said) = said else { continue };
        let _ = out.write_all(said.as_bytes());
        if said.starts_with("error: ") {
            return;
        }
    }
}

fn played(script: Script) -> (report::Native, Vec<MessageRow>, usize) {
    let (address, asked) = plant(script);
    let settings = ControllerSettings {
        transport: Transport::Tcp,
        timeout_ns: 300 * MS,
        ..Preset::PaperPython.settings(Mode::Open, h(10))
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = drive(&config(folder.path(), address, settings, 400)).expect("a run to its end");
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, 40);
    for row in &messages {
        if row.outcome == MessageOutcome::Answered {
            assert_eq!(row.t_arrive_ns, Some(row.seq), "another's answer");
        }
    }
    (report, messages, asked.load(Ordering::Relaxed))
}

pub(crate) fn the_plant_s_last_line_is_the_reason_and_the_next_command_connects_again() {
    let long = "x".repeat(5_000);
    let long: &'static str = Box::leak(long.into_boxed_str());
    for (hello, says, expected) in [
        (
            "\n",
            (|seq| (seq >= 3).then(|| "error: field `u`: `NaN` is not finite\n".to_owned()))
                as fn(u64) -> Option<String>,
            "closed the connection: field `u`: `NaN`",
        ),
        (
            "\n",
            |seq| (seq >= 3).then(|| "hello\n".to_owned()),
            "`hello` is unknown",
        ),
        (
            "error: a page is in control\n",
            |_| None,
            "a page is in control",
        ),
        (long, |_| None, "too long"),
    ] {
        let (report, _, asked) = played(Script { hello, says });
        let why = report.first_failure.expect("failures");
        assert!(why.contains(expected), "{why}");
        assert!(report.counts.failed >= 1, "{:?}", report.counts);
        assert!(report.counts.answered > 0, "{:?}", report.counts);
        assert_eq!(asked, if hello == "\n" { 2 } else { 3 }, "{why}");
    }
}

pub(crate) fn answers_in_any_order_and_empty_lines_between_them_are_taken() {
    let (report, _, asked) = played(Script {
        hello: "\n",
        says: |seq| match seq % 2 {
            0 => None,
            // Whether we are there, another's, and two.
            _ => Some(format!(
                "\n{}{}{}",
                acknowledged(1_000_000),
                acknowledged(seq),
                acknowledged(seq - 1)
            )),
        },
    });
    assert_eq!(report.first_failure, None);
    assert_eq!(asked, 1);
    // A deadline may have been missed on a busy machine, and with it an answer.
    assert!(report.counts.answered + 2 >= report.counts.sent);
}
