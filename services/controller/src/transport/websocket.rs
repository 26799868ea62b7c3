//! Messages over a WebSocket: each a text, all in one socket.
//!
//! [`WebSocket`] opens a [`socket`] when there is none for a command, and leaves it when it breaks: all messages that
//! wait then fail with the reason, and the next command opens another. [`under_way`] has the messages, which end by
//! their own time-outs. Answers may come in any order.

mod socket;
mod under_way;

use std::{
    collections::VecDeque,
    future::poll_fn,
    rc::Rc,
    task::{Context, Poll, Waker, ready},
    time::Duration,
};

use clock::now::now_ns;
use endpoint::{Command, Mode, Observation};
use futures_util::future::LocalBoxFuture;
use tokio::time::timeout;

use self::{
    socket::{Opener, Socket},
    under_way::UnderWay,
};
use super::{Address, Ended, ExchangeError, Transport, error::SocketError, http::Http};
use crate::config::{Config, DriveError};

/// How long to wait for the plant to close the socket. No rows depend on it.
const LEAVE: Duration = Duration::from_millis(100);

/// One socket for all messages.
pub(crate) struct WebSocket {
    /// Reads the plant's state as in HTTP, and has the session.
    http: Http,
    opener: Opener,
    line: Line,
    under_way: UnderWay,
    /// Messages that have ended and are not told yet.
    ended: VecDeque<Ended>,
    timeout: Duration,
}

/// The current socket.
enum Line {
    None,
    Opening(LocalBoxFuture<'static, Result<Socket, SocketError>>),
    Open(Box<Socket>),
}

impl WebSocket {
    pub(crate) fn try_new(
        http: Http,
        address: &Address,
        config: &Config,
    ) -> Result<Self, DriveError> {
        let settings = &config.settings;
        let timeout = Duration::from_nanos(settings.timeout_ns);
        let mut url = address.at(match settings.mode {
            Mode::Closed => "/socket?mode=closed",
            Mode::Open => "/socket?mode=open",
        })?;
        url.set_scheme("ws")
            .map_err(|()| address.refused(&"it has no WebSocket"))?;
        Ok(Self {
            opener: Opener {
                session: http.session().cloned(),
                check: config.check,
                url: url.to_string(),
                address: address.socket,
                mode: settings.mode,
                timeout,
            },
            http,
            line: Line::None,
            under_way: UnderWay::new(timeout),
            ended: VecDeque::new(),
            timeout,
        })
    }

    /// Does what can be done with the socket now.
    fn advance(&mut self, context: &mut Context<'_>) {
        let why = loop {
            match &mut self.line {
                Line::None if self.under_way.has_unsent() => self.line = self.opening(),
                Line::None => return,
                Line::Opening(opening) => match opening.as_mut().poll(context) {
                    Poll::Pending => return,
                    Poll::Ready(Ok(socket)) => self.line = Line::Open(Box::new(socket)),
                    Poll::Ready(Err(why)) => break why,
                },
                // Reads first: when the plant closes the connection, sending a command fails too, but
                // without the reason.
                Line::Open(socket) => match socket.poll_answer(context) {
                    Poll::Ready(Ok(answer)) => {
                        if self.under_way.answered(answer.seq()) {
                            self.ended.push_back(Ended {
                                seq: answer.seq(),
                                t_ns: now_ns(),
                                result: Ok(answer),
                            });
                        }
                    }
                    Poll::Ready(Err(why)) => break why,
                    Poll::Pending => match socket.poll_send(context, &mut self.under_way) {
                        Ok(()) => return,
                        Err(why) => break why,
                    },
                },
            }
        };
        // From here on commands open another socket.
        if let Line::Open(socket) = std::mem::replace(&mut self.line, Line::None) {
            tokio::spawn(timeout(self.timeout, socket.leave()));
        }
        let (t_ns, why) = (now_ns(), Rc::new(why));
        for seq in self.under_way.give_up() {
            let result = Err(ExchangeError::Socket(Rc::clone(&why)));
            self.ended.push_back(Ended { seq, t_ns, result });
        }
    }

    fn opening(&self) -> Line {
        let opener = self.opener.clone();
        Line::Opening(Box::pin(async move { opener.open().await }))
    }
}

impl Transport for WebSocket {
    async fn observe(&mut self) -> Result<Observation, ExchangeError> {
        self.http.observe().await
    }

    async fn open(&mut self, _: u16) {
        self.line = self.opening();
        let limit = self.timeout;
        let opened = poll_fn(|context| {
            self.advance(context);
            match self.line {
                Line::Opening(_) => Poll::Pending,
                _ => Poll::Ready(()),
            }
        });
        // It goes on with a command.
        let _ = timeout(limit, opened).await;
    }

    fn send(&mut self, command: Command) {
        self.under_way.add(command);
        // As much as can be done at once; whoever polls for ends is woken for the rest.
        let mut context = Context::from_waker(Waker::noop());
        match &mut self.line {
            Line::Open(socket) if socket.is_free() => {
                // A failure will be found again, after what the plant said has been read.
                let _ = socket.poll_send(&mut context, &mut self.under_way);
            }
            _ => self.advance(&mut context),
        }
    }

    fn poll_ended(&mut self, context: &mut Context<'_>) -> Poll<Ended> {
        loop {
            if let Some(ended) = self.ended.pop_front() {
                return Poll::Ready(ended);
            }
            self.advance(context);
            if self.ended.is_empty() {
                let seq = ready!(self.under_way.poll_timeout(context));
                return Poll::Ready(Ended {
                    seq,
                    t_ns: now_ns(),
                    result: Err(ExchangeError::Timeout),
                });
            }
        }
    }

    async fn close(self) {
        if let Line::Open(socket) = self.line {
            let _ = timeout(LEAVE, socket.leave()).await;
        }
        self.http.close().await;
    }
}
