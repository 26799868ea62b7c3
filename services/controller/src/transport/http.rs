//! Messages over HTTP: one GET each.
//!
//! [`Client`] is what sends a request: the connections of this crate's own, a [`Pool`], or [`Reqwest`], to compare
//! with. What a request says and what its answer means is the same for both.

mod answer;
mod pool;
mod reqwest;

pub(crate) use self::{pool::Pool, reqwest::Reqwest};

use std::{
    collections::VecDeque,
    fmt::Write,
    task::{Context, Poll, Waker},
};

use ::reqwest::StatusCode;
use endpoint::{Answer, Command, Mode, Observation, checksum};
use futures_util::{
    StreamExt,
    future::{BoxFuture, join_all},
    stream::FuturesUnordered,
};
use pace::now_ns;

use super::{
    Ended, ExchangeError, Transport, excerpt,
    session::{self, Session},
};
use crate::Config;

/// Room for the target of most commands, so that a text that grows is not moved.
const TARGET_BYTES: usize = 128;

/// A request to the plant.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    /// Its path, and its query if it has one.
    pub(super) target: String,
    /// The session to which it belongs.
    pub(super) token: Option<&'a str>,
    /// JSON to post; without it, the request is a GET.
    pub(super) body: Option<&'static str>,
}

/// Sends requests over connections that it keeps. Cheap to clone.
pub(crate) trait Client: Clone + Send + Sync + 'static {
    /// Sends a request, and waits for the status and the text of its answer, for the time of a message.
    fn ask(
        &self,
        request: Request<'_>,
    ) -> impl Future<Output = Result<(StatusCode, String), ExchangeError>> + Send;
}

/// What all requests have in common. Cheap to clone.
#[derive(Clone, Debug)]
struct Asker<C> {
    client: C,
    mode: Mode,
    /// The session in which it commands, if it has to have one.
    session: Option<Session<C>>,
    check: bool,
}

/// One GET per message.
pub(crate) struct Http<C> {
    asker: Asker<C>,
    under_way: FuturesUnordered<BoxFuture<'static, Ended>>,
    /// What ended while a command was sent.
    ended: VecDeque<Ended>,
}

impl<C: Client> Http<C> {
    pub(crate) fn new(client: C, config: &Config) -> Self {
        let settings = &config.settings;
        let session = config
            .claim
            .then(|| Session::new(client.clone(), settings.timeout_ns));
        Self {
            asker: Asker {
                client,
                mode: settings.mode,
                session,
                check: config.check,
            },
            under_way: FuturesUnordered::new(),
            ended: VecDeque::new(),
        }
    }

    /// The session in which it commands, if it has to have one.
    pub(super) fn session(&self) -> Option<&Session<C>> {
        self.asker.session.as_ref()
    }
}

impl<C: Client> Asker<C> {
    async fn get(&self, target: String) -> Result<String, ExchangeError> {
        let token = match &self.session {
            None => None,
            Some(session) => Some((session, session.token().await?)),
        };
        let request = Request {
            target,
            token: token.as_ref().map(|(_, token)| &**token),
            body: None,
        };
        let (status, text) = self.client.ask(request).await?;
        if status.is_success() {
            return Ok(text);
        }
        if let Some((session, token)) = token
            && session::is_lost(status)
        {
            session.forget(&token).await;
        }
        Err(refused(status, &text))
    }

    async fn observe(&self) -> Result<Observation, ExchangeError> {
        let text = self.get("/state".to_owned()).await?;
        text.parse()
            .map_err(|error| ExchangeError::Failed(format!("{error}")))
    }

    async fn exchange(&self, command: &Command) -> Result<Answer, ExchangeError> {
        let path = match self.mode {
            Mode::Closed => "/closed",
            Mode::Open => "/open",
        };
        let target = if self.check {
            format!("{path}?{}", checksum::signed(&command.to_string()))
        } else {
            let mut target = String::with_capacity(TARGET_BYTES);
            // Writing to a String does not fail.
            let _ = write!(target, "{path}?{command}");
            target
        };
        let text = self.get(target).await?;
        checksum::checked(&text, self.check)
            .and_then(|(text, _)| Answer::parse(self.mode, text, command))
            .map_err(|error| ExchangeError::Failed(error.to_string()))
    }
}

impl<C: Client> Transport for Http<C> {
    async fn observe(&mut self) -> Result<Observation, ExchangeError> {
        self.asker.observe().await
    }

    async fn open(&mut self, connections: u16) {
        // The only way for a client to open a connection is to use it.
        join_all((0..connections).map(|_| self.asker.observe())).await;
    }

    fn send(&mut self, command: Command) {
        let asker = self.asker.clone();
        self.under_way.push(Box::pin(async move {
            let result = asker.exchange(&command).await;
            Ended {
                seq: command.seq,
                t_ns: now_ns(),
                result,
            }
        }));
        // Polled at once, and so sent; whoever polls for ends is woken for the rest.
        let mut context = Context::from_waker(Waker::noop());
        while let Poll::Ready(Some(ended)) = self.under_way.poll_next_unpin(&mut context) {
            self.ended.push_back(ended);
        }
    }

    fn poll_ended(&mut self, context: &mut Context<'_>) -> Poll<Ended> {
        if let Some(ended) = self.ended.pop_front() {
            return Poll::Ready(ended);
        }
        match self.under_way.poll_next_unpin(context) {
            Poll::Ready(Some(ended)) => Poll::Ready(ended),
            Poll::Ready(None) | Poll::Pending => Poll::Pending,
        }
    }

    async fn close(mut self) {
        self.under_way.clear();
        if let Some(session) = &self.asker.session {
            session.end().await;
        }
    }
}

/// What a plant says to a request that it does not take.
pub(super) fn refused(status: StatusCode, text: &str) -> ExchangeError {
    ExchangeError::Failed(format!("{status}: {}", excerpt(text)))
}
