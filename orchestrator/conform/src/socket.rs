//! Messages over a WebSocket: each text is the query of a message, each answer a text.
//!
//! Reading and answering are apart, so that messages are heard also while answers are held back.

use std::cell::RefCell;
use std::rc::Rc;

use endpoint::Mode;
use endpoint::query::MAX_BYTES;
use futures_util::{SinkExt, StreamExt};
use hyper::body::Bytes;
use hyper::header::{self, HeaderMap, HeaderValue};
use hyper::upgrade::OnUpgrade;
use hyper::{Response, StatusCode};
use hyper_util::rt::TokioIo;
use pace::now_ns;
use tokio::sync::mpsc;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};

use crate::exchange::{Exchange, Said, wait_until};

/// The response that opens a socket, if the request asks for one.
pub(crate) fn handshake(headers: &HeaderMap) -> Option<Response<Bytes>> {
    let upgrade = headers.get(header::UPGRADE)?.as_bytes();
    let version = headers.get(header::SEC_WEBSOCKET_VERSION)?;
    if !upgrade.eq_ignore_ascii_case(b"websocket") || version != "13" {
        return None;
    }
    let key = headers.get(header::SEC_WEBSOCKET_KEY)?;
    let accept = HeaderValue::try_from(derive_accept_key(key.as_bytes())).ok()?;
    let mut response = Response::new(Bytes::new());
    *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
    let answer = response.headers_mut();
    answer.insert(header::CONNECTION, HeaderValue::from_static("upgrade"));
    answer.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
    answer.insert(header::SEC_WEBSOCKET_ACCEPT, accept);
    Some(response)
}

/// Serves a socket until either end closes it.
pub(crate) async fn serve(
    upgrade: OnUpgrade,
    mode: Mode,
    connection: u64,
    exchange: Rc<RefCell<Exchange>>,
) {
    let Ok(upgraded) = upgrade.await else {
        return;
    };
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_BYTES))
        .max_frame_size(Some(MAX_BYTES));
    let stream = TokioIo::new(upgraded);
    let socket = WebSocketStream::from_raw_socket(stream, Role::Server, Some(config)).await;
    let (mut answers, mut messages) = socket.split();
    let (sender, mut queue) = mpsc::unbounded_channel::<Said>();
    let read = async {
        while let Some(Ok(message)) = messages.next().await {
            let said = match message {
                Message::Text(text) => {
                    exchange
                        .borrow_mut()
                        .message(mode, &text, connection, now_ns())
                }
                Message::Binary(_) => {
                    let words = "a binary message; a command is text";
                    exchange.borrow_mut().heard.refuse(words);
                    return;
                }
                _ => continue,
            };
            if sender.send(said).is_err() {
                return;
            }
        }
    };
    let write = async {
        while let Some(said) = queue.recv().await {
            wait_until(said.at_ns).await;
            let message = match said.answer {
                Ok(answer) => Message::text(answer.to_string()),
                Err(_) => Message::Close(Some(CloseFrame {
                    code: CloseCode::Policy,
                    reason: "refused".into(),
                })),
            };
            let is_end = said.is_last || matches!(message, Message::Close(_));
            if answers.send(message).await.is_err() || is_end {
                return;
            }
        }
    };
    tokio::select! {
        () = read => {}
        () = write => {}
    }
}
