//! Commands over a WebSocket: each text message is a command's query, each answer the text that HTTP
//! would return.
//!
//! A message has none of a request's headers. What is said is in `conversation`; the framing is tungstenite's.

use std::task::{Context, Poll, ready};

use endpoint::query::MAX_BYTES;
use futures_util::{SinkExt, StreamExt};
use hyper::body::Bytes;
use tokio::{net::TcpStream, time::timeout};
use tokio_tungstenite::{
    WebSocketStream,
    tungstenite::{
        Error, Message, Utf8Bytes,
        error::{CapacityError, ProtocolError},
        protocol::{CloseFrame, Role, WebSocketConfig, frame::coding::CloseCode},
    },
};

use crate::{
    conversation::{Carrier, Closing, Incoming, Opening, converse},
    place::Place,
    shared::{LINGER, Shared},
};

/// How much is read at a time, and how many pongs and answers may wait for an end that does not read.
const READ_BYTES: usize = 512;
const UNSENT_BYTES: usize = 8 * 1024;

type Socket = WebSocketStream<TcpStream>;

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

impl Carrier for Socket {
    type Text = Utf8Bytes;
    type Framed = Message;
    const KIND: &'static str = "websocket";
    const PONG: &'static str = "pong";

    fn answer(text: String) -> Message {
        Message::text(text)
    }

    fn ping() -> Message {
        Message::Ping(Bytes::new())
    }

    fn poll_heard(&mut self, context: &mut Context<'_>) -> Poll<Incoming<Utf8Bytes>> {
        Poll::Ready(match ready!(self.poll_next_unpin(context)) {
            Some(Ok(Message::Text(text))) => Incoming::Text(text),
            Some(Ok(Message::Binary(_))) => Incoming::Wrong(
                CloseCode::Unsupported,
                "a binary message; a command is text".to_owned(),
            ),
            // The crate answers pings and close frames.
            Some(Ok(_)) => Incoming::Sign,
            Some(Err(error)) => broken(&error),
            None => Incoming::End,
        })
    }

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Option<()>> {
        self.poll_ready_unpin(context).map(Result::ok)
    }

    fn start_send(&mut self, message: Message) -> Option<()> {
        self.start_send_unpin(message).ok()
    }

    fn poll_flush(&mut self, context: &mut Context<'_>) -> Poll<Option<()>> {
        self.poll_flush_unpin(context).map(Result::ok)
    }
}

/// What is heard of an end whose messages cannot be read.
fn broken(error: &Error) -> Incoming<Utf8Bytes> {
    match error {
        Error::Capacity(CapacityError::MessageTooLong { size, .. }) => Incoming::Wrong(
            CloseCode::Size,
            format!("a message of {size} bytes; a command has at most {MAX_BYTES}"),
        ),
        // The other end is gone without a close frame; that is not an invalid message.
        Error::Protocol(ProtocolError::ResetWithoutClosingHandshake) => Incoming::End,
        Error::Utf8(_) => {
            Incoming::Wrong(CloseCode::Invalid, "a text that is not UTF-8".to_owned())
        }
        Error::Protocol(problem) => Incoming::Wrong(CloseCode::Protocol, problem.to_string()),
        _ => Incoming::End,
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
