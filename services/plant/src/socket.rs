//! Commands over a WebSocket: each text message is a command's query, each answer the text that HTTP
//! would return.
//!
//! One connection carries a whole loop, and a message has none of a request's headers. `route`
//! executes commands; the framing is tungstenite's. A message that cannot be read ends the connection
//! with the reason, since a client that sends one has an error.

use std::{cell::RefCell, rc::Rc, time::Duration};

use endpoint::{Mode, query::MAX_BYTES};
use futures_util::{SinkExt, StreamExt};
use hyper::{
    Response, StatusCode,
    body::Bytes,
    header::{self, HeaderMap, HeaderName, HeaderValue},
    http::request::Parts,
    upgrade::{OnUpgrade, Upgraded},
};
use hyper_util::rt::TokioIo;
use pace::now_ns;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    sync::watch,
    time::timeout,
};
use tokio_tungstenite::{
    WebSocketStream,
    tungstenite::{
        Error, Message,
        error::{CapacityError, ProtocolError},
        handshake::derive_accept_key,
        protocol::{CloseFrame, Role, WebSocketConfig, frame::coding::CloseCode},
    },
};

use crate::{handler::Handler, refusal::Refusal, session::Sender, token::Pass};

/// The longest reason that fits a close frame (RFC 6455, 5.5).
const REASON_BYTES: usize = 123;

/// How long a socket may be silent. Clients that wait for the start of a run are silent for some
/// seconds; one that is gone must not keep its place forever.
const IDLE_TIMEOUT: Duration = Duration::from_secs(60);

/// How long an answer may wait for room in the socket.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);

/// How long the other end has to read why the connection is closed. What it still sends is discarded
/// meanwhile: closing earlier would lose the reason.
const LINGER: Duration = Duration::from_secs(1);

type Socket = WebSocketStream<TokioIo<Upgraded>>;

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

/// The response that opens a socket, if the request asks for one.
pub(crate) fn handshake(head: &Parts) -> Result<Response<Bytes>, Refusal> {
    let headers = &head.headers;
    let expect = |field, given| {
        if given {
            Ok(())
        } else {
            Err(Refusal::Handshake { field })
        }
    };
    expect("Connection", has(headers, &header::CONNECTION, "upgrade"))?;
    expect("Upgrade", has(headers, &header::UPGRADE, "websocket"))?;
    let version = headers.get(header::SEC_WEBSOCKET_VERSION);
    expect("Sec-WebSocket-Version", version.is_some_and(|v| v == "13"))?;
    let key = headers
        .get(header::SEC_WEBSOCKET_KEY)
        .map(HeaderValue::as_bytes)
        .filter(|key| is_key(key))
        .ok_or(Refusal::Handshake {
            field: "Sec-WebSocket-Key",
        })?;
    let accept = HeaderValue::try_from(derive_accept_key(key)).expect("base64 is ASCII");
    let mut response = Response::new(Bytes::new());
    *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
    let answer = response.headers_mut();
    answer.insert(header::CONNECTION, HeaderValue::from_static("upgrade"));
    answer.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
    answer.insert(header::SEC_WEBSOCKET_ACCEPT, accept);
    Ok(response)
}

/// Whether a header contains `word`.
fn has(headers: &HeaderMap, name: &HeaderName, word: &str) -> bool {
    headers
        .get_all(name)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .any(|given| given.trim().eq_ignore_ascii_case(word))
}

/// Whether this is the base64 encoding of 16 bytes.
fn is_key(key: &[u8]) -> bool {
    let digit = |byte: &u8| byte.is_ascii_alphanumeric() || b"+/".contains(byte);
    key.len() == 24 && key.ends_with(b"==") && key[..22].iter().all(digit)
}

/// Serves a socket to its end.
pub(crate) async fn serve(upgrade: OnUpgrade, opening: Opening, handler: Rc<RefCell<Handler>>) {
    let stream = match upgrade.await {
        Ok(upgraded) => TokioIo::new(upgraded),
        Err(error) => {
            tracing::debug!(%error, "socket not opened");
            return;
        }
    };
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_BYTES))
        .max_frame_size(Some(MAX_BYTES));
    let mut socket = WebSocketStream::from_raw_socket(stream, Role::Server, Some(config)).await;
    if let Some(closing) = converse(&mut socket, opening, &handler).await {
        close(socket, closing).await;
    }
}

/// Answers messages until the end; returns why we end it, unless the other end did.
async fn converse(
    socket: &mut Socket,
    opening: Opening,
    handler: &RefCell<Handler>,
) -> Option<Closing> {
    let Opening {
        mode,
        sender,
        session,
        mut over,
    } = opening;
    let on_end_of = async {
        match session {
            Some(number) => drop(over.wait_for(|over| *over >= number).await),
            None => std::future::pending().await,
        }
    };
    let mut on_end_of = std::pin::pin!(on_end_of);
    loop {
        let message = tokio::select! {
            biased;
            message = timeout(IDLE_TIMEOUT, socket.next()) => message,
            () = &mut on_end_of => {
                return Some(Closing::new(CloseCode::Policy, "the session is over"));
            }
        };
        let now_ns = now_ns();
        let text = match message {
            Ok(Some(Ok(Message::Text(text)))) => text,
            Ok(Some(Ok(Message::Binary(_)))) => {
                let reason = "a binary message; a command is text";
                let code = CloseCode::Unsupported;
                return Some(Closing::refused(handler, "websocket", code, reason));
            }
            // The crate answers pings and close frames.
            Ok(Some(Ok(_))) => continue,
            Ok(Some(Err(error))) => return broken(handler, &error),
            Ok(None) => return None,
            Err(_) => {
                let reason = format!("no message in {} s", IDLE_TIMEOUT.as_secs());
                return Some(Closing::new(CloseCode::Away, reason));
            }
        };
        let answer = handler.borrow_mut().command(mode, &text, &sender, now_ns);
        let answer = match answer {
            Ok(answer) => Message::text(answer.to_string()),
            Err(refusal) => {
                let code = refusal.close_code();
                let kind = refusal.kind();
                return Some(Closing::refused(handler, kind, code, refusal.to_string()));
            }
        };
        match timeout(SEND_TIMEOUT, socket.send(answer)).await {
            Ok(Ok(())) => {}
            // The other end does not read, or it is gone.
            Ok(Err(_)) | Err(_) => return None,
        }
    }
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
async fn close(mut socket: Socket, closing: Closing) {
    let Closing { code, reason } = closing;
    let frame = CloseFrame {
        code,
        reason: reason.into(),
    };
    let parting = async {
        if socket.close(Some(frame)).await.is_ok() {
            let mut stream = socket.into_inner();
            let mut rest = [0; 4096];
            let _ = stream.shutdown().await;
            while let Ok(1..) = stream.read(&mut rest).await {}
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
