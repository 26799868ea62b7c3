//! Messages over a bare TCP connection: each command a line, each answer a line.
//!
//! The first line names the mode and perhaps the session, and an empty one comes back. Later an empty line asks for
//! another. One that begins with `error: ` is the plant's last.

use std::{
    io,
    net::SocketAddr,
    pin::Pin,
    task::{Context, Poll, ready},
    time::Duration,
};

use endpoint::{Answer, query::MAX_BYTES};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    net::TcpStream,
    time::timeout,
};

use super::{
    Address,
    conduit::{Channel, Conduit, Opener},
    error::{ExchangeError, OpeningError, SocketError, excerpt},
    http::Http,
    session::Session,
    under_way::UnderWay,
    wording::Wording,
};
use crate::config::Config;

/// How much is read at a time: some 40 answers.
const ROOM: usize = 4096;

/// Round trips to open a connection, TCP's and the first line's.
const ROUND_TRIPS: u32 = 2;

/// What is needed to open a connection.
#[derive(Clone, Debug)]
pub(crate) struct Tcp {
    address: SocketAddr,
    wording: Wording,
    /// The session in which it commands, if it has to have one.
    session: Option<Session>,
    /// How long to wait for an answer.
    timeout: Duration,
}

/// An open connection.
#[derive(Debug)]
pub(crate) struct LineChannel {
    stream: TcpStream,
    wording: Wording,
    /// What has arrived and is not taken yet, less than a line.
    arrived: Vec<u8>,
    /// Where the next line begins in it.
    at: usize,
    /// What is still to be sent.
    unsent: Vec<u8>,
}

impl Tcp {
    /// All messages over lines; `http` has the session.
    pub(crate) fn conduit(http: Http, address: &Address, config: &Config) -> Conduit<Self> {
        let settings = &config.settings;
        let timeout = Duration::from_nanos(settings.timeout_ns);
        let opener = Self {
            address: address.socket,
            wording: Wording {
                mode: settings.mode,
                check: config.check,
            },
            session: http.session().cloned(),
            timeout,
        };
        Conduit::new(http, opener, timeout)
    }

    async fn attempt(&self) -> Result<LineChannel, OpeningError> {
        let (mut hello, mut token) = (format!("mode={}", self.wording.mode), String::new());
        if let Some(session) = &self.session {
            token = session.token().await?;
            hello += &format!("&session={token}");
        }
        hello.push('\n');
        let stream = TcpStream::connect(self.address).await?;
        stream.set_nodelay(true)?;
        let mut lines = LineChannel {
            stream,
            wording: self.wording,
            arrived: Vec::new(),
            at: 0,
            unsent: hello.into_bytes(),
        };
        std::future::poll_fn(|context| lines.poll_flush(context)).await?;
        let said = std::future::poll_fn(|context| lines.poll_line(context)).await;
        let why = match said {
            Ok(line) if line.is_empty() => return Ok(lines),
            Ok(line) => lines.reason(&line),
            Err(why) => why,
        };
        if let (Some(session), SocketError::Said { .. }) = (&self.session, &why) {
            session.forget(&token).await;
        }
        Err(ExchangeError::Socket(why.into()).into())
    }
}

impl Opener for Tcp {
    type Channel = LineChannel;

    async fn open(&self) -> Result<LineChannel, SocketError> {
        loop {
            if let Ok(result) = timeout(ROUND_TRIPS * self.timeout, self.attempt()).await {
                return result.map_err(|problem| SocketError::Opening {
                    url: format!("tcp://{}", self.address),
                    problem,
                });
            }
        }
    }
}

impl LineChannel {
    /// The next line, without its end.
    fn poll_line(&mut self, context: &mut Context<'_>) -> Poll<Result<String, SocketError>> {
        loop {
            let rest = &self.arrived[self.at..];
            let end = rest.iter().position(|byte| *byte == b'\n');
            if end.unwrap_or(rest.len()) > MAX_BYTES {
                return Poll::Ready(Err(SocketError::Long));
            }
            if let Some(end) = end {
                let line = String::from_utf8_lossy(&rest[..end]).into_owned();
                self.at += end + 1;
                return Poll::Ready(Ok(line));
            }
            self.arrived.drain(..self.at);
            self.at = 0;
            let mut room = [0; ROOM];
            let mut room = ReadBuf::new(&mut room);
            let read = ready!(Pin::new(&mut self.stream).poll_read(context, &mut room));
            if let Err(error) = read {
                return Poll::Ready(Err(SocketError::broken(error.into())));
            }
            if room.filled().is_empty() {
                return Poll::Ready(Err(SocketError::HungUp));
            }
            self.arrived.extend_from_slice(room.filled());
        }
    }

    /// Sends what is still to be sent.
    fn poll_flush(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        while !self.unsent.is_empty() {
            let sent = ready!(Pin::new(&mut self.stream).poll_write(context, &self.unsent))?;
            self.unsent.drain(..sent);
        }
        Poll::Ready(Ok(()))
    }

    /// Sends as much as fits at once. Nothing may be unsent.
    fn start_send(&mut self, line: &[u8]) -> io::Result<()> {
        let sent = match self.stream.try_write(line) {
            Ok(sent) => sent,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => 0,
            Err(error) => return Err(error),
        };
        self.unsent.extend_from_slice(&line[sent..]);
        Ok(())
    }

    /// Why a line is no answer.
    fn reason(&self, line: &str) -> SocketError {
        match (line.strip_prefix("error: "), self.wording.answer(line)) {
            (Some(reason), _) => SocketError::Said {
                reason: excerpt(reason),
            },
            (None, Err(problem)) => SocketError::Invalid(problem),
            // One that nobody asked for.
            (None, Ok(_)) => SocketError::Closed,
        }
    }
}

impl Channel for LineChannel {
    fn is_free(&self) -> bool {
        self.unsent.is_empty()
    }

    fn poll_send(
        &mut self,
        context: &mut Context<'_>,
        under_way: &mut UnderWay,
    ) -> Result<(), SocketError> {
        loop {
            let Poll::Ready(flushed) = self.poll_flush(context) else {
                return Ok(());
            };
            flushed.map_err(|error| SocketError::broken(error.into()))?;
            let Some(command) = under_way.take_unsent() else {
                return Ok(());
            };
            // Each is sent by itself, like a request.
            let mut line = self.wording.command(&command);
            line.push('\n');
            self.start_send(line.as_bytes())
                .map_err(|error| SocketError::broken(error.into()))?;
        }
    }

    fn poll_answer(&mut self, context: &mut Context<'_>) -> Poll<Result<Answer, SocketError>> {
        loop {
            let line = ready!(self.poll_line(context))?;
            if line.is_empty() {
                // Whether we are there. It is sent behind what is still to be sent.
                self.unsent.push(b'\n');
                if let Poll::Ready(Err(error)) = self.poll_flush(context) {
                    return Poll::Ready(Err(SocketError::broken(error.into())));
                }
                continue;
            }
            return Poll::Ready(match self.wording.answer(&line) {
                Ok(answer) => Ok(answer),
                Err(_) => Err(self.reason(&line)),
            });
        }
    }

    async fn leave(self) {}
}
