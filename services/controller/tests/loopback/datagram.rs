//! Messages by UDP, against a plant by script that loses some.

use std::{
    net::{SocketAddr, TcpListener, UdpSocket},
    thread,
};

use endpoint::{
    Acknowledgement, Command, ControllerSettings, MessageOutcome, MessageRow, Mode, Preset,
    Transport, datagram,
};

use crate::{MS, check, config, drive, h, rows};

const AT_REST: &[u8] =
    b"HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: 25\r\n\r\nt_ns=1&tick=1&y=0.0&u=0.0";

/// A plant that shows itself at rest over HTTP, and says what `answers` has for a command's number, for as long as the
/// test's process lives.
fn plant(answers: impl Fn(u64) -> Vec<String> + Send + 'static) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound");
    let socket = UdpSocket::bind(address).expect("the same port");
    thread::spawn(move || {
        for mut stream in listener.incoming().map_while(Result::ok) {
            use std::io::{Read, Write};
            let _ = stream.read(&mut [0; 2048]);
            let _ = stream.write_all(AT_REST);
        }
    });
    thread::spawn(move || {
        let mut room = [0; 2048];
        while let Ok((bytes, peer)) = socket.recv_from(&mut room) {
            let text = std::str::from_utf8(&room[..bytes]).expect("text");
            let (mode, command) = datagram::read(text).expect("a mode");
            assert_eq!(mode, Mode::Open);
            let command: Command = command.parse().expect("a command");
            for answer in answers(command.seq) {
                let _ = socket.send_to(answer.as_bytes(), peer);
            }
        }
    });
    address
}

fn acknowledged(seq: u64) -> String {
    let t_arrive_ns = seq;
    Acknowledgement { seq, t_arrive_ns }.to_string()
}

pub(crate) fn a_datagram_that_is_lost_is_a_message_without_an_answer() {
    // Of five, one is lost, one is answered by what is none, one twice, and one late.
    let address = plant(|seq| match seq % 5 {
        0 => Vec::new(),
        1 => vec!["hello".to_owned()],
        2 => vec![acknowledged(seq), acknowledged(seq)],
        3 => vec![acknowledged(1_000_000)],
        _ => vec![acknowledged(seq), acknowledged(seq - 1)],
    });
    let settings = ControllerSettings {
        transport: Transport::Udp,
        timeout_ns: 400 * MS,
        ..Preset::PaperPython.settings(Mode::Open, h(10))
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = drive(&config(folder.path(), address, settings, 400)).expect("a run to its end");
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, 40);
    assert_eq!((report.counts.failed, report.first_failure), (0, None));
    let was_sent = |seq: u64| {
        let row = messages.iter().find(|row| row.seq == seq);
        row.is_some_and(|row| row.t_send_ns.is_some())
    };
    for row in messages.iter().filter(|row| row.t_send_ns.is_some()) {
        let is_answered = match row.seq % 5 {
            0 | 1 => false,
            // By the answer to the next.
            3 => was_sent(row.seq + 1),
            _ => true,
        };
        let expected = if is_answered {
            MessageOutcome::Answered
        } else {
            MessageOutcome::Timeout
        };
        assert_eq!(row.outcome, expected, "{row:?}");
        if is_answered {
            assert_eq!(row.t_arrive_ns, Some(row.seq), "another's answer");
        }
    }
}
