//! Commands over a WebSocket: each text message is a command's query, each answer the text that HTTP
//! would return.
//!
//! One connection carries a whole loop, and a message has none of a request's headers. `route`
//! executes commands; the framing is tungstenite's. A message that cannot be read ends the connection
//! with the reason, since a client that sends one has an error.

use std::{cell::RefCell, time::Duration};

use clock::{now::now_ns, patience::Patience};
use endpoint::{Mode, query::MAX_BYTES};
use futures_util::{SinkExt, StreamExt};
use hyper::body::Bytes;
use tokio::{
    net::TcpStream,
    sync::watch,
    time::{Instant, timeout},
};
use tokio_tungstenite::{
    WebSocketStream,
    tungstenite::{
        Error, Message,
        error::{CapacityError, ProtocolError},
        protocol::{CloseFrame, Role, WebSocketConfig, frame::coding::CloseCode},
    },
};

use crate::{
    handler::Handler,
    place::Place,
    refusal::Refusal,
    session::Sender,
    shared::{LINGER, Shared, WITHIN},
    token::Pass,
    turn::Turn,
};

/// The longest reason that fits a close frame (RFC 6455, 5.5).
const REASON_BYTES: usize = 123;

/// After this silence the other end is asked whether it is there: clients that wait for the start of a run
/// are silent for some seconds.
const SILENCE: Duration = Duration::from_secs(2);

/// How long it may take to answer that, by a pong or any message. One that is gone must not keep its place.
const PONG_WITHIN: Duration = WITHIN;

/// How much is read at a time, and how many pongs and answers may wait for an end that does not read.
const READ_BYTES: usize = 512;
const UNSENT_BYTES: usize = 8 * 1024;

type Socket = WebSocketStream<TcpStream>;

/// The purpose of a socket.
#[derive(Debug)]
pub(crate) struct Opening {
    pub(crate) mode: Mode,
    pub(crate) sender: Sender,
    /// The number of its session, if it belongs to one.
    pub(crate) session: Option<u64>,
    /// The latest session that has ended.
    pub(crate) over: watch::Receiver<u64>,
}

/// Why we close a socket.
struct Closing {
    code: CloseCode,
    reason: String,
}

/// Reads `mode=closed|open[&session=..]`.
pub(crate) fn query(query: &str) -> Result<(Mode, Pass), Refusal> {
    let expected = "`mode=closed` or `mode=open`, and perhaps `session=` with 32 hex digits";
    let refuse = || Refusal::Query { expected };
    let (mut mode, mut pass) = (None, None);
    for (key, value) in form_urlencoded::parse(query.as_bytes()) {
        let again = match &*key {
            "mode" => mode.replace(value.parse().map_err(|_| refuse())?).is_some(),
            "session" => pass.replace(Pass::from(value.as_bytes())).is_some(),
            _ => true,
        };
        if again {
            return Err(refuse());
        }
    }
    Ok((mode.ok_or_else(refuse)?, pass.unwrap_or(Pass::Nothing)))
}

/// Serves a socket to its end.
///
/// `arrived` is what came behind its handshake.
pub(crate) async fn serve(
    stream: TcpStream,
    arrived: Vec<u8>,
    opening: Opening,
    shared: &Shared,
    place: &Place,
) {
    let config = WebSocketConfig::default()
        .read_buffer_size(READ_BYTES)
        .write_buffer_size(0)
        .max_write_buffer_size(UNSENT_BYTES)
        .max_message_size(Some(MAX_BYTES))
        .max_frame_size(Some(MAX_BYTES));
    let mut socket =
        WebSocketStream::from_partially_read(stream, arrived, Role::Server, Some(config)).await;
    if let Some(closing) = converse(&mut socket, opening, shared, place).await {
        Box::pin(close(socket, closing, shared, place)).await;
    }
}

/// Answers messages until the end; returns why we end it, unless the other end did.
async fn converse(
    socket: &mut Socket,
    opening: Opening,
    shared: &Shared,
    place: &Place,
) -> Option<Closing> {
    let handler = &*shared.handler;
    let Opening {
        mode,
        sender,
        session,
        over,
    } = opening;
    let mut on_end_of = std::pin::pin!(wait_for_end(session, over));
    let (mut heard, mut is_asked) = (Instant::now(), false);
    let mut patience = Patience::default();
    loop {
        let until = heard
            + if is_asked {
                SILENCE + PONG_WITHIN
            } else {
                SILENCE
            };
        let message = tokio::select! {
            biased;
            message = patience.before(until, |context| socket.poll_next_unpin(context)) => message,
            () = &mut on_end_of => {
                return Some(Closing::new(CloseCode::Policy, "the session is over"));
            }
        };
        if message.is_some() {
            (heard, is_asked) = (Instant::now(), false);
        }
        let mut turn = shared.turns.wait(place).await;
        let message = match message {
            Some(Some(Ok(message))) => message,
            Some(Some(Err(error))) => return broken(handler, &error),
            Some(None) => return None,
            None if !is_asked => {
                is_asked = true;
                let ping = Message::Ping(Bytes::new());
                send(socket, ping, &mut turn, &mut patience).await?;
                continue;
            }
            None => {
                let reason = format!("no pong within {} s", PONG_WITHIN.as_secs());
                return Some(Closing::new(CloseCode::Away, reason));
            }
        };
        match answer(message, mode, &sender, handler, place) {
            Ok(Some(answer)) => send(socket, answer, &mut turn, &mut patience).await?,
            Ok(None) => turn.end().await,
            Err(closing) => return Some(closing),
        }
    }
}

/// Waits for the end of a socket's session; for ever, if it belongs to none.
async fn wait_for_end(session: Option<u64>, mut over: watch::Receiver<u64>) {
    match session {
        Some(number) => drop(over.wait_for(|over| *over >= number).await),
        None => std::future::pending().await,
    }
}

/// Executes a message that is a command, and gives its answer; or why we close the socket.
fn answer(
    message: Message,
    mode: Mode,
    sender: &Sender,
    handler: &RefCell<Handler>,
    place: &Place,
) -> Result<Option<Message>, Closing> {
    let now_ns = now_ns();
    let text = match message {
        Message::Text(text) => text,
        Message::Binary(_) => {
            let reason = "a binary message; a command is text";
            let code = CloseCode::Unsupported;
            return Err(Closing::refused(handler, "websocket", code, reason));
        }
        // The crate answers pings and close frames.
        _ => return Ok(None),
    };
    let told = handler.borrow_mut().command(mode, &text, sender, now_ns);
    let told = told.map_err(|refusal| {
        let code = refusal.close_code();
        Closing::refused(handler, refusal.kind(), code, refusal.to_string())
    })?;
    place.on_command(now_ns);
    place.on_answer();
    Ok(Some(Message::text(told.text())))
}

/// Sends a message: into the socket at once, and what does not fit after the turn. `None` if the other end does
/// not read, or is gone.
async fn send(
    socket: &mut Socket,
    message: Message,
    turn: &mut Turn<'_>,
    patience: &mut Patience,
) -> Option<()> {
    let until = Instant::now() + WITHIN;
    let is_free = patience.before(until, |context| socket.poll_ready_unpin(context));
    is_free.await?.ok()?;
    socket.start_send_unpin(message).ok()?;
    turn.end().await;
    let is_sent = patience.before(until, |context| socket.poll_flush_unpin(context));
    is_sent.await?.ok()
}

/// How to close the socket of an end whose messages cannot be read.
fn broken(handler: &RefCell<Handler>, error: &Error) -> Option<Closing> {
    let (code, reason) = match error {
        Error::Capacity(CapacityError::MessageTooLong { size, .. }) => (
            CloseCode::Size,
            format!("a message of {size} bytes; a command has at most {MAX_BYTES}"),
        ),
        // The other end is gone without a close frame; that is not an invalid message.
        Error::Protocol(ProtocolError::ResetWithoutClosingHandshake) => return None,
        Error::Utf8(_) => (CloseCode::Invalid, "a text that is not UTF-8".to_owned()),
        Error::Protocol(problem) => (CloseCode::Protocol, problem.to_string()),
        _ => return None,
    };
    Some(Closing::refused(handler, "websocket", code, reason))
}

impl Closing {
    fn new(code: CloseCode, reason: impl Into<String>) -> Self {
        let mut reason = reason.into();
        let end = (0..=REASON_BYTES).rfind(|end| reason.is_char_boundary(*end));
        reason.truncate(end.unwrap_or_default());
        Self { code, reason }
    }

    /// A closing that is counted as a refusal of this kind.
    fn refused(
        handler: &RefCell<Handler>,
        kind: &'static str,
        code: CloseCode,
        reason: impl Into<String>,
    ) -> Self {
        handler.borrow_mut().refuse(kind);
        Self::new(code, reason)
    }
}

/// Sends the reason, and lets the other end read it.
async fn close(mut socket: Socket, closing: Closing, shared: &Shared, place: &Place) {
    let Closing { code, reason } = closing;
    let frame = CloseFrame {
        code,
        reason: reason.into(),
    };
    let parting = async {
        if socket.close(Some(frame)).await.is_ok() {
            shared.linger(&mut socket.into_inner(), place).await;
        }
    };
    // It does not matter whether the other end listens.
    let _ = timeout(LINGER, parting).await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_query_has_a_mode_and_perhaps_a_session() {
        let session = "0123456789abcdef0123456789abcdef";
        let read = |text: &str| query(text).ok();
        assert!(matches!(
            read("mode=open"),
            Some((Mode::Open, Pass::Nothing))
        ));
        let text = format!("session={session}&mode=closed");
        assert!(matches!(read(&text), Some((Mode::Closed, Pass::Token(_)))));
        let text = "mode=closed&session=";
        assert!(matches!(read(text), Some((Mode::Closed, Pass::Unreadable))));
        for wrong in [
            "",
            "mode=",
            "mode=ajar",
            "mode=open&mode=open",
            "mode=open&u=1",
        ] {
            assert!(read(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn a_reason_is_cut_between_letters() {
        let closing = Closing::new(CloseCode::Policy, "é".repeat(100));
        assert_eq!(closing.reason, "é".repeat(61));
    }
}
