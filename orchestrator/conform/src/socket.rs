//! Messages over a WebSocket: each text is the query of a message, each answer a text.
//!
//! Reading and answering are apart, so that messages are heard also while answers are held back.

use std::cell::RefCell;
use std::rc::Rc;

use clock::now::now_ns;
use endpoint::Mode;
use endpoint::query::MAX_BYTES;
use futures_util::{SinkExt, StreamExt};
use tokio::net::TcpStream;
use tokio::sync::mpsc;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};

use crate::exchange::{Exchange, Said, wait_until};

/// Serves a socket until either end closes it; `arrived` is what came behind its handshake.
pub(crate) async fn serve(
    stream: TcpStream,
    arrived: Vec<u8>,
    mode: Mode,
    connection: u64,
    exchange: Rc<RefCell<Exchange>>,
) {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_BYTES))
        .max_frame_size(Some(MAX_BYTES));
    let socket =
        WebSocketStream::from_partially_read(stream, arrived, Role::Server, Some(config)).await;
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
