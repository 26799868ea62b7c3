//! One socket: how it is opened, what it sends and receives, and how it is left.

use std::{
    net::SocketAddr,
    pin::Pin,
    task::{Context, Poll, ready},
    time::Duration,
};

use endpoint::{Answer, Command, InvalidMessage, Mode, checksum, query};
use futures_util::{Sink, SinkExt, Stream, StreamExt};
use tokio::{net::TcpStream, time::timeout};
use tokio_tungstenite::{
    WebSocketStream, client_async_with_config,
    tungstenite::{
        Error, Message,
        protocol::{CloseFrame, WebSocketConfig, frame::coding::CloseCode},
    },
};

use super::under_way::UnderWay;
use crate::transport::{
    error::{ExchangeError, OpeningError, SocketError, excerpt},
    session::{self, Session},
};

/// Size of a read: an answer has about 100 bytes, so this is some 40 answers at once.
const READ_BYTES: usize = 4096;

/// Round trips to open a socket, TCP's and the WebSocket's. If an attempt had only a message's
/// timeout, it would never succeed on a link whose round trip takes more than half of that, although
/// messages would be answered there.
const ROUND_TRIPS: u32 = 2;

/// The data needed to open a socket.
#[derive(Clone, Debug)]
pub(super) struct Opener {
    pub(super) url: String,
    pub(super) address: SocketAddr,
    pub(super) mode: Mode,
    /// The session in which it commands, if it has to have one.
    pub(super) session: Option<Session>,
    /// Whether commands have a checksum, and answers need one.
    pub(super) check: bool,
    /// How long to wait for an answer.
    pub(super) timeout: Duration,
}

/// An open socket.
#[derive(Debug)]
pub(super) struct Socket {
    stream: WebSocketStream<TcpStream>,
    mode: Mode,
    check: bool,
    /// Whether something waits until the other end reads.
    is_full: bool,
}

impl Opener {
    /// Opens a socket, or returns why it cannot. An attempt without any answer is repeated: messages that
    /// wait for it end by their own timeouts.
    pub(super) async fn open(&self) -> Result<Socket, SocketError> {
        loop {
            if let Ok(result) = timeout(ROUND_TRIPS * self.timeout, self.attempt()).await {
                let stream = result.map_err(|problem| SocketError::Opening {
                    url: self.url.clone(),
                    problem,
                })?;
                return Ok(Socket {
                    stream,
                    mode: self.mode,
                    check: self.check,
                    is_full: false,
                });
            }
        }
    }

    async fn attempt(&self) -> Result<WebSocketStream<TcpStream>, OpeningError> {
        let (mut url, mut token) = (self.url.clone(), String::new());
        if let Some(session) = &self.session {
            token = session.token().await?;
            url += &format!("&session={token}");
        }
        let stream = TcpStream::connect(self.address).await?;
        stream.set_nodelay(true)?;
        let config = WebSocketConfig::default()
            .read_buffer_size(READ_BYTES)
            .write_buffer_size(0)
            .max_message_size(Some(query::MAX_BYTES))
            .max_frame_size(Some(query::MAX_BYTES));
        match client_async_with_config(&*url, stream, Some(config)).await {
            Ok((socket, _)) => Ok(socket),
            Err(Error::Http(response)) => {
                let status = response.status();
                if let Some(session) = &self.session
                    && session::is_lost(status)
                {
                    session.forget(&token).await;
                }
                let text = response.into_body().unwrap_or_default();
                Err(ExchangeError::refused(status, &String::from_utf8_lossy(&text)).into())
            }
            Err(error) => Err(OpeningError::Handshake(Box::new(error))),
        }
    }
}

impl Socket {
    /// Whether the next command goes out at once.
    pub(super) fn is_free(&self) -> bool {
        !self.is_full
    }

    /// Sends commands until there is none that waits, or no room; the reason if it is broken.
    pub(super) fn poll_send(
        &mut self,
        context: &mut Context<'_>,
        under_way: &mut UnderWay,
    ) -> Result<(), SocketError> {
        loop {
            if self.is_full {
                match Pin::new(&mut self.stream).poll_flush(context) {
                    Poll::Pending => return Ok(()),
                    Poll::Ready(flushed) => flushed.map_err(SocketError::broken)?,
                }
                self.is_full = false;
            }
            let Some(command) = under_way.take_unsent() else {
                return Ok(());
            };
            // Each is sent by itself, like a request.
            let message = Message::text(self.text(&command));
            Pin::new(&mut self.stream)
                .start_send(message)
                .map_err(SocketError::broken)?;
            self.is_full = true;
        }
    }

    fn text(&self, command: &Command) -> String {
        let text = command.to_string();
        if self.check {
            checksum::signed(&text)
        } else {
            text
        }
    }

    /// The next answer; the reason if the plant closes the connection or an answer is invalid.
    pub(super) fn poll_answer(
        &mut self,
        context: &mut Context<'_>,
    ) -> Poll<Result<Answer, SocketError>> {
        loop {
            let message = ready!(Pin::new(&mut self.stream).poll_next(context));
            let why = match message {
                Some(Ok(Message::Text(text))) => match self.answer(&text) {
                    Ok(answer) => return Poll::Ready(Ok(answer)),
                    Err(error) => SocketError::Invalid(error),
                },
                Some(Ok(Message::Binary(_))) => SocketError::Binary,
                Some(Ok(Message::Close(None))) => SocketError::Closed,
                Some(Ok(Message::Close(Some(CloseFrame { code, reason })))) => {
                    SocketError::ClosedFor {
                        code: code.into(),
                        reason: excerpt(&reason),
                    }
                }
                Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_))) => continue,
                Some(Err(error)) => SocketError::broken(error),
                None => SocketError::HungUp,
            };
            return Poll::Ready(Err(why));
        }
    }

    fn answer(&self, text: &str) -> Result<Answer, InvalidMessage> {
        let (text, _) = checksum::checked(text, self.check)?;
        Ok(match self.mode {
            Mode::Closed => Answer::State(text.parse()?),
            Mode::Open => Answer::Acknowledgement(text.parse()?),
        })
    }

    /// Closes the socket by the protocol: each side sends a close frame, then the plant closes the
    /// connection. If the plant began, this is the answer.
    pub(super) async fn leave(mut self) {
        let farewell = CloseFrame {
            code: CloseCode::Normal,
            reason: "".into(),
        };
        let sent = self.stream.send(Message::Close(Some(farewell))).await;
        if sent.is_ok() {
            while let Some(Ok(_)) = self.stream.next().await {}
        }
    }
}
