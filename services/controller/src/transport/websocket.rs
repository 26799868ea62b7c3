//! Messages over a WebSocket, each a text: how a socket is opened, what it sends and receives, and how it is left.

use std::{
    net::SocketAddr,
    pin::Pin,
    task::{Context, Poll, ready},
    time::Duration,
};

use endpoint::{Answer, Mode, query};
use futures_util::{Sink, SinkExt, Stream, StreamExt};
use tokio::{net::TcpStream, time::timeout};
use tokio_tungstenite::{
    WebSocketStream, client_async_with_config,
    tungstenite::{
        Error, Message,
        protocol::{CloseFrame, WebSocketConfig, frame::coding::CloseCode},
    },
};

use super::{
    Address,
    conduit::{Channel, Conduit, Opener},
    error::{ExchangeError, OpeningError, SocketError, excerpt},
    http::Http,
    session::{self, Session},
    under_way::UnderWay,
    wording::Wording,
};
use crate::config::{Config, DriveError};

/// Size of a read: an answer has about 100 bytes, so this is some 40 answers at once.
const READ_BYTES: usize = 4096;

/// Round trips to open a socket, TCP's and the WebSocket's. If an attempt had only a message's
/// timeout, it would never succeed on a link whose round trip takes more than half of that, although
/// messages would be answered there.
const ROUND_TRIPS: u32 = 2;

/// The data needed to open a socket.
#[derive(Clone, Debug)]
pub(crate) struct WebSocket {
    url: String,
    address: SocketAddr,
    wording: Wording,
    /// The session in which it commands, if it has to have one.
    session: Option<Session>,
    /// How long to wait for an answer.
    timeout: Duration,
}

/// An open socket.
#[derive(Debug)]
pub(crate) struct Socket {
    stream: WebSocketStream<TcpStream>,
    wording: Wording,
    /// Whether something waits until the other end reads.
    is_full: bool,
}

impl WebSocket {
    /// All messages over a WebSocket; `http` has the session.
    pub(crate) fn conduit(
        http: Http,
        address: &Address,
        config: &Config,
    ) -> Result<Conduit<Self>, DriveError> {
        let settings = &config.settings;
        let timeout = Duration::from_nanos(settings.timeout_ns);
        let mut url = address.at(match settings.mode {
            Mode::Closed => "/socket?mode=closed",
            Mode::Open => "/socket?mode=open",
        })?;
        url.set_scheme("ws")
            .map_err(|()| address.refused(&"it has no WebSocket"))?;
        let opener = Self {
            url: url.to_string(),
            address: address.socket,
            wording: Wording {
                mode: settings.mode,
                check: config.check,
            },
            session: http.session().cloned(),
            timeout,
        };
        Ok(Conduit::new(http, opener, timeout))
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

impl Opener for WebSocket {
    type Channel = Socket;

    async fn open(&self) -> Result<Socket, SocketError> {
        loop {
            if let Ok(result) = timeout(ROUND_TRIPS * self.timeout, self.attempt()).await {
                let stream = result.map_err(|problem| SocketError::Opening {
                    url: self.url.clone(),
                    problem,
                })?;
                return Ok(Socket {
                    stream,
                    wording: self.wording,
                    is_full: false,
                });
            }
        }
    }
}

impl Channel for Socket {
    fn is_free(&self) -> bool {
        !self.is_full
    }

    fn poll_send(
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
            let message = Message::text(self.wording.command(&command));
            Pin::new(&mut self.stream)
                .start_send(message)
                .map_err(SocketError::broken)?;
            self.is_full = true;
        }
    }

    fn poll_answer(&mut self, context: &mut Context<'_>) -> Poll<Result<Answer, SocketError>> {
        loop {
            let message = ready!(Pin::new(&mut self.stream).poll_next(context));
            let why = match message {
                Some(Ok(Message::Text(text))) => match self.wording.answer(&text) {
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

    /// Closes the socket by the protocol: each side sends a close frame, then the plant closes the
    /// connection. If the plant began, this is the answer.
    async fn leave(mut self) {
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
