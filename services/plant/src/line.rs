//! Commands over a bare TCP connection: each line is a command's query, each answer a line with the text that HTTP would
//! return.
//!
//! The first line says what the others are for, as the query of `/socket` does: `mode=closed`, and perhaps a session. No
//! request of HTTP can begin so, since a method has no `=`. It is answered by an empty line. Later an empty line is a
//! sign of life, which the plant asks for by one. The last line of the plant, before it closes the connection, has the reason behind `error: `.

use std::{
    io,
    net::IpAddr,
    pin::Pin,
    task::{Context, Poll, ready},
};

use clock::{now::now_ns, patience::Patience};
use endpoint::query::MAX_BYTES;
use tokio::{
    io::{AsyncRead, AsyncWrite, AsyncWriteExt, ReadBuf},
    net::TcpStream,
    time::{Instant, timeout},
};
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

use crate::{
    conversation::{Carrier, Closing, Incoming, Opening, converse, query},
    place::Place,
    refusal::Refusal,
    shared::{LINGER, Shared, WITHIN},
};

/// How much is taken at a time of what arrives.
const ROOM: usize = 512;

/// How the first line begins.
const HELLO: &[u8] = b"mode=";

/// A connection with what has arrived on it and is not taken yet, and with what is still to be sent.
struct LineCarrier {
    stream: TcpStream,
    arrived: Vec<u8>,
    unsent: Vec<u8>,
}

/// Whether a connection that begins with these bytes has lines.
pub(crate) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(HELLO)
}

/// Serves lines from `peer` to their end; `arrived` is their beginning.
pub(crate) async fn serve(
    stream: TcpStream,
    arrived: Vec<u8>,
    peer: IpAddr,
    shared: &Shared,
    place: &Place,
) {
    let mut lines = LineCarrier {
        stream,
        arrived,
        unsent: Vec::new(),
    };
    let closing = match lines.open(peer, shared, place).await {
        Ok(Some(opening)) => converse(&mut lines, opening, shared, place).await,
        Ok(None) => None,
        Err(closing) => Some(closing),
    };
    if let Some(closing) = closing {
        Box::pin(close(lines.stream, &closing, shared, place)).await;
    }
}

impl LineCarrier {
    /// Reads the first line, and what the others are for; nothing if the other end is gone.
    async fn open(
        &mut self,
        peer: IpAddr,
        shared: &Shared,
        place: &Place,
    ) -> Result<Option<Opening>, Closing> {
        let mut patience = Patience::default();
        let until = Instant::now() + WITHIN;
        let heard = patience.before(until, |context| self.poll_heard(context));
        let heard = heard.await;
        let mut turn = shared.turns.wait(place).await;
        let handler = &*shared.handler;
        let refused = |refusal: &Refusal| {
            let (code, reason) = (refusal.close_code(), refusal.to_string());
            Closing::refused(handler, refusal.kind(), code, reason)
        };
        let text = match heard {
            Some(Incoming::Text(text)) => text,
            Some(Incoming::Wrong(code, reason)) => {
                return Err(Closing::refused(handler, Self::KIND, code, reason));
            }
            // It does not begin with an empty line.
            Some(Incoming::End | Incoming::Sign) => return Ok(None),
            None => {
                let (part, seconds) = ("line", WITHIN.as_secs());
                return Err(refused(&Refusal::Slow { part, seconds }));
            }
        };
        let opening = query(&text).and_then(|(mode, pass)| {
            let mut handler = handler.borrow_mut();
            handler.converses(mode, pass, peer, now_ns())
        });
        if opening.is_ok() {
            // So that the other end knows.
            let _ = self.start_send(Self::ping());
        }
        turn.end().await;
        opening.map(Some).map_err(|refusal| refused(&refusal))
    }

    /// Takes the first line, if it is whole.
    fn take(&mut self) -> Option<Incoming<String>> {
        let end = self.arrived.iter().position(|byte| *byte == b'\n');
        if end.unwrap_or(self.arrived.len()) > MAX_BYTES {
            return Some(Incoming::Wrong(
                CloseCode::Size,
                format!("a line that is too long; a command has at most {MAX_BYTES} bytes"),
            ));
        }
        let line = self.arrived.drain(..=end?).collect::<Vec<u8>>();
        let text = line[..line.len() - 1].to_vec();
        Some(match String::from_utf8(text) {
            Ok(text) if text.is_empty() => Incoming::Sign,
            Ok(text) => Incoming::Text(text),
            Err(_) => Incoming::Wrong(CloseCode::Invalid, "a line that is not UTF-8".to_owned()),
        })
    }

    fn poll_unsent(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        while !self.unsent.is_empty() {
            let sent = ready!(Pin::new(&mut self.stream).poll_write(context, &self.unsent))?;
            self.unsent.drain(..sent);
        }
        Poll::Ready(Ok(()))
    }
}

impl Carrier for LineCarrier {
    type Text = String;
    type Framed = String;
    const KIND: &'static str = "line";
    const PONG: &'static str = "line";

    fn answer(mut text: String) -> String {
        text.push('\n');
        text
    }

    fn ping() -> String {
        "\n".to_owned()
    }

    fn poll_heard(&mut self, context: &mut Context<'_>) -> Poll<Incoming<String>> {
        loop {
            if let Some(heard) = self.take() {
                return Poll::Ready(heard);
            }
            let mut room = [0; ROOM];
            let mut room = ReadBuf::new(&mut room);
            let read = ready!(Pin::new(&mut self.stream).poll_read(context, &mut room));
            if read.is_err() || room.filled().is_empty() {
                return Poll::Ready(Incoming::End);
            }
            self.arrived.extend_from_slice(room.filled());
        }
    }

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Option<()>> {
        self.poll_unsent(context).map(Result::ok)
    }

    fn start_send(&mut self, line: String) -> Option<()> {
        let sent = match self.stream.try_write(line.as_bytes()) {
            Ok(sent) => sent,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => 0,
            Err(_) => return None,
        };
        self.unsent.extend_from_slice(&line.as_bytes()[sent..]);
        Some(())
    }

    fn poll_flush(&mut self, context: &mut Context<'_>) -> Poll<Option<()>> {
        self.poll_unsent(context).map(Result::ok)
    }
}

/// Sends the reason, and lets the other end read it.
async fn close(mut stream: TcpStream, closing: &Closing, shared: &Shared, place: &Place) {
    let line = format!("error: {}\n", closing.reason);
    let parting = async {
        if stream.write_all(line.as_bytes()).await.is_ok() {
            shared.linger(&mut stream, place).await;
        }
    };
    // It does not matter whether the other end listens.
    let _ = timeout(LINGER, parting).await;
}
