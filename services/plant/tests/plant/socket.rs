//! Commands over a WebSocket.

use std::{
    net::{SocketAddr, TcpStream},
    time::Duration,
};

use endpoint::{Acknowledgement, ArrivalOutcome, ArrivalRow, State};
use plant::Ready;
use tokio_tungstenite::tungstenite::{
    Bytes, Error, HandshakeError, Message, WebSocket, client,
    protocol::frame::{
        Frame,
        coding::{Data, OpCode},
    },
};

use crate::support::{PATIENCE, begin, claim, end, observe, rows, send, status, until, with_plant};

pub(crate) type Socket = WebSocket<TcpStream>;

/// Opens a socket; the status if that is refused.
pub(crate) fn open(address: SocketAddr, query: &str) -> Result<Socket, u16> {
    let stream = TcpStream::connect(address).expect("the plant listens");
    stream
        .set_read_timeout(Some(PATIENCE))
        .expect("a valid timeout");
    match client(format!("ws://{address}/socket?{query}"), stream) {
        Ok((socket, _)) => Ok(socket),
        Err(HandshakeError::Failure(Error::Http(response))) => Err(response.status().as_u16()),
        Err(error) => panic!("{error}"),
    }
}

fn ask(socket: &mut Socket, text: &str) -> String {
    socket.send(Message::text(text)).expect("the plant reads");
    match socket.read().expect("an answer") {
        Message::Text(text) => text.to_string(),
        other => panic!("{other:?}"),
    }
}

/// How the plant closes: the code and the reason.
pub(crate) fn closing(socket: &mut Socket) -> (u16, String) {
    loop {
        match socket.read().expect("a last word") {
            // Whether we are there; the answer is sent by the next read.
            Message::Ping(_) => {}
            Message::Close(Some(frame)) => return (frame.code.into(), frame.reason.to_string()),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn both_modes_answer_as_over_http() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let mut closed = open(address, "mode=closed").expect("a socket");
        let mut open = open(address, "mode=open").expect("a socket");
        for seq in 0..100 {
            let query = format!("seq={seq}&t_send_ns=5&u=0.5");
            let state: State = ask(&mut closed, &query).parse().expect("a state");
            assert_eq!((state.seq, state.u.first), (seq, 0.5));
            let query = format!("seq={seq}&t_send_ns=5&u=9");
            let answer: Acknowledgement = ask(&mut open, &query).parse().expect("an answer");
            assert_eq!(answer.seq, seq);
        }
        // Many under way at once are answered in order.
        for seq in 100..200 {
            let text = format!("seq={seq}&t_send_ns=5&u=0.5");
            closed.write(Message::text(text)).expect("room");
        }
        closed.flush().expect("the plant reads");
        for seq in 100..200 {
            let answer = closed.read().expect("an answer").to_string();
            assert!(answer.starts_with(&format!("seq={seq}&")), "{answer}");
        }
        closed
            .send(Message::Ping("?".into()))
            .expect("the plant reads");
        let pong = closed.read().expect("a pong");
        assert_eq!(pong, Message::Pong("?".into()));
        closed.close(None).expect("the plant reads");
        assert!(matches!(closed.read(), Ok(Message::Close(_))));
        assert!(matches!(closed.read(), Err(Error::ConnectionClosed)));
        // The other one is gone without a word, before the run is over, and that is
        // no refusal.
        drop(open);
        std::thread::sleep(Duration::from_millis(50));
    })
    .expect("a run without errors");
    assert_eq!(
        (report.arrivals, report.connections, report.refused),
        (300, 2, 0)
    );
    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join("arrivals.csv"));
    for row in &arrivals {
        let expected = match row.outcome {
            ArrivalOutcome::Applied => 0.5,
            ArrivalOutcome::Acknowledged => 9.0,
            ArrivalOutcome::Stale | ArrivalOutcome::Aged => panic!("{row:?}"),
        };
        assert_eq!(row.u, expected);
    }
    for pair in arrivals.windows(2) {
        assert!(
            pair[0].t_arrive_ns <= pair[1].t_arrive_ns,
            "stamped as they are read"
        );
    }
}

#[test]
fn a_message_that_cannot_be_read_ends_the_socket_with_the_reason() {
    let text = |bytes: &'static [u8]| {
        let frame = Frame::message(Bytes::from_static(bytes), OpCode::Data(Data::Text), true);
        Message::Frame(frame)
    };
    let odd = Frame::message("seq=1", OpCode::Data(Data::Continue), true);
    let long_key = format!("seq=0&t_send_ns=5&u=1&{}=1", "é".repeat(60));
    // What is sent, the code, and what the reason says.
    let table = [
        (Message::text(""), 1008, "`u` is missing"),
        (Message::text("hello"), 1008, "`hello` is unknown"),
        (Message::text("seq=0&t_send_ns=5&u=NaN"), 1008, "`u`: `NaN`"),
        (Message::text(long_key), 1008, "is unknown"),
        (Message::text("0".repeat(1024)), 1008, "is unknown"),
        (Message::text("0".repeat(1025)), 1009, "at most 1024"),
        (Message::text("0".repeat(200_000)), 1009, "at most 1024"),
        (
            Message::binary(b"seq=0&t_send_ns=5&u=1".as_slice()),
            1003,
            "binary",
        ),
        (text(b"seq=\xff"), 1007, "UTF-8"),
        (Message::Frame(odd), 1002, ""),
    ];
    let count = table.len() as u64;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        for (message, code, says) in table {
            let start: String = format!("{message:?}").chars().take(60).collect();
            let mut socket = open(address, "mode=closed").expect("a socket");
            socket.send(message).expect("the plant reads");
            let (got, reason) = closing(&mut socket);
            assert_eq!(got, code, "{start}: {reason}");
            assert!(
                reason.contains(says) && reason.len() <= 123,
                "{start}: {reason}"
            );
            assert_eq!(observe(address).u, 0.0, "{start} changed the input");
        }
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.refused), (0, count));
}

#[test]
fn what_is_no_handshake_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        let whole = [
            ("Connection", "keep-alive, Upgrade"),
            ("Upgrade", "websocket"),
            ("Sec-WebSocket-Version", "13"),
            ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ];
        let request = "GET /socket?mode=closed";
        for (index, (missing, _)) in whole.iter().enumerate().skip(1) {
            let mut headers = whole.to_vec();
            headers.remove(index);
            let refused = send(address, request, &headers, "");
            assert_eq!(refused.status, 426, "{missing}: {refused:?}");
            assert!(refused.body.contains(missing), "{missing}: {refused:?}");
            assert!(refused.head.contains("upgrade: websocket"), "{refused:?}");
        }
        assert_eq!(send(address, request, &[], "").status, 426);
        for query in ["", "?mode=ajar", "?mode=closed&u=1"] {
            let refused = send(address, &format!("GET /socket{query}"), &whole, "");
            assert_eq!(refused.status, 400, "{query}: {refused:?}");
        }
    })
    .expect("a run without errors");
}

#[test]
fn a_session_commands_over_its_sockets_and_takes_them_with_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let mut plain = open(address, "mode=closed").expect("a socket, which is no command");
        let token = begin(address, "a browser");
        assert_eq!(open(address, "mode=closed").expect_err("it is held"), 409);
        let other = "mode=closed&session=0123456789abcdef0123456789abcdef";
        assert_eq!(open(address, other).expect_err("not this one"), 409);

        let query = format!("mode=closed&session={token}");
        let mut socket = open(address, &query).expect("a socket");
        let state: State = ask(&mut socket, "seq=0&t_send_ns=5&u=0.5")
            .parse()
            .expect("a state");
        assert_eq!(state.u, 0.5);
        assert_eq!(status(address)["commands"], 1);
        plain
            .send(Message::text("seq=0&t_send_ns=5&u=9"))
            .expect("the plant reads");
        let (code, reason) = closing(&mut plain);
        assert_eq!(code, 1008);
        assert!(reason.contains("`a browser` is in control"), "{reason}");

        assert_eq!(end(address, &token, "{}").status, 204);
        let (code, reason) = closing(&mut socket);
        assert_eq!((code, reason.as_str()), (1008, "the session is over"));
        assert_eq!(open(address, &query).expect_err("it is over"), 409);
        assert_eq!(observe(address).u, 0.5);

        // Without a session again, which keeps the next page out for a while.
        let mut plain = open(address, "mode=closed").expect("a socket");
        ask(&mut plain, "seq=0&t_send_ns=5&u=0.25");
        assert_eq!(observe(address).u, 0.25);
        until("the claim is granted", || {
            claim(address, "another").status == 200
        });
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.sessions), (2, 2));
}
