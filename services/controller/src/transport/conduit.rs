//! Messages over one connection for all of them, whatever frames them.
//!
//! A [`Conduit`] opens a [`Channel`] when there is none for a command, and leaves it when it breaks: all messages that
//! wait then fail with the reason, and the next command opens another. They end by their own time-outs, and answers may
//! come in any order. `websocket` and `line` are such channels.

use std::{
    collections::VecDeque,
    future::poll_fn,
    rc::Rc,
    task::{Context, Poll, Waker, ready},
    time::Duration,
};

use clock::now::now_ns;
use endpoint::{Answer, Command, Observation};
use futures_util::future::LocalBoxFuture;
use tokio::{task::spawn_local, time::timeout};

use super::{Ended, ExchangeError, Transport, error::SocketError, http::Http, under_way::UnderWay};

/// How long to wait for the plant to close the connection. No rows depend on it.
const LEAVE: Duration = Duration::from_millis(100);

/// An open connection.
pub(crate) trait Channel {
    /// Whether the next command goes out at once.
    fn is_free(&self) -> bool;

    /// Sends commands until there is none that waits, or no room; the reason if it is broken.
    fn poll_send(
        &mut self,
        context: &mut Context<'_>,
        under_way: &mut UnderWay,
    ) -> Result<(), SocketError>;

    /// The next answer; the reason if the plant closes the connection or an answer is invalid.
    fn poll_answer(&mut self, context: &mut Context<'_>) -> Poll<Result<Answer, SocketError>>;

    /// Takes leave of the plant, as the protocol has it.
    async fn leave(self);
}

/// What is needed to open a connection.
pub(crate) trait Opener: Clone {
    type Channel: Channel;

    /// Opens one, or returns why it cannot. An attempt without any answer is repeated: messages that wait for it end by
    /// their own timeouts.
    async fn open(&self) -> Result<Self::Channel, SocketError>;
}

/// One connection for all messages.
pub(crate) struct Conduit<O: Opener> {
    /// Reads the plant's state as in HTTP, and has the session.
    http: Http,
    opener: O,
    line: Line<O::Channel>,
    under_way: UnderWay,
    /// Messages that have ended and are not told yet.
    ended: VecDeque<Ended>,
    timeout: Duration,
}

/// The current connection.
enum Line<C> {
    None,
    Opening(LocalBoxFuture<'static, Result<C, SocketError>>),
    Open(Box<C>),
}

impl<O: Opener<Channel: 'static> + 'static> Conduit<O> {
    pub(super) fn new(http: Http, opener: O, timeout: Duration) -> Self {
        Self {
            http,
            opener,
            line: Line::None,
            under_way: UnderWay::new(timeout),
            ended: VecDeque::new(),
            timeout,
        }
    }

    /// Does what can be done with the connection now.
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
        // From here on commands open another.
        if let Line::Open(socket) = std::mem::replace(&mut self.line, Line::None) {
            spawn_local(timeout(self.timeout, socket.leave()));
        }
        let (t_ns, why) = (now_ns(), Rc::new(why));
        for seq in self.under_way.give_up() {
            let result = Err(ExchangeError::Socket(Rc::clone(&why)));
            self.ended.push_back(Ended { seq, t_ns, result });
        }
    }

    fn opening(&self) -> Line<O::Channel> {
        let opener = self.opener.clone();
        Line::Opening(Box::pin(async move { opener.open().await }))
    }
}

impl<O: Opener<Channel: 'static> + 'static> Transport for Conduit<O> {
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
