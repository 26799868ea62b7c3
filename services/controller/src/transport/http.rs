//! Messages over HTTP: one GET each, or one POST of JSON.
//!
//! What a request says and what its answer means is here; a [`Pool`] of connections carries it, as a `request` is
//! written.

mod pool;
mod request;

pub(crate) use self::pool::Pool;
pub(super) use self::request::{ANY, Request};

use std::{
    collections::VecDeque,
    fmt::Write,
    task::{Context, Poll, Waker},
};

use clock::now::now_ns;
use endpoint::{Answer, Command, Mode, Observation, checksum, json};
use futures_util::{
    StreamExt,
    future::{LocalBoxFuture, join_all},
    stream::FuturesUnordered,
};

use super::{
    Ended, ExchangeError, Transport,
    session::{self, Session},
};
use crate::config::Config;

/// Room for the target of most commands, so that a text that grows is not moved.
const TARGET_BYTES: usize = 128;

/// The form that a command in JSON asks its answer in.
const JSON: &str = "application/json";

/// What all requests have in common. Cheap to clone.
#[derive(Clone, Debug)]
struct Asker {
    pool: Pool,
    mode: Mode,
    /// The session in which it commands, if it has to have one.
    session: Option<Session>,
    check: bool,
    form: CommandForm,
}

/// The form of a message.
#[derive(Clone, Copy, Debug)]
enum CommandForm {
    Query,
    Json,
}

/// One request per message.
pub(crate) struct Http {
    asker: Asker,
    under_way: FuturesUnordered<LocalBoxFuture<'static, Ended>>,
    /// What ended while a command was sent.
    ended: VecDeque<Ended>,
}

impl Http {
    pub(crate) fn new(pool: Pool, config: &Config) -> Self {
        let settings = &config.settings;
        let session = config
            .claim
            .then(|| Session::new(pool.clone(), settings.timeout_ns));
        Self {
            asker: Asker {
                pool,
                mode: settings.mode,
                session,
                check: config.check,
                form: match settings.transport {
                    endpoint::Transport::Json => CommandForm::Json,
                    _ => CommandForm::Query,
                },
            },
            under_way: FuturesUnordered::new(),
            ended: VecDeque::new(),
        }
    }

    /// The session in which it commands, if it has to have one.
    pub(super) fn session(&self) -> Option<&Session> {
        self.asker.session.as_ref()
    }
}

impl Asker {
    /// Asks for `target`, or posts JSON to it and asks for JSON.
    async fn ask(&self, target: String, json: Option<&str>) -> Result<String, ExchangeError> {
        let token = match &self.session {
            None => None,
            Some(session) => Some((session, session.token().await?)),
        };
        let request = Request {
            target,
            token: token.as_ref().map(|(_, token)| &**token),
            body: json,
            accept: if json.is_some() { JSON } else { ANY },
        };
        let (status, text) = self.pool.ask(&request).await?;
        if status.is_success() {
            return Ok(text);
        }
        if let Some((session, token)) = token
            && session::is_lost(status)
        {
            session.forget(&token).await;
        }
        Err(ExchangeError::refused(status, &text))
    }

    async fn observe(&self) -> Result<Observation, ExchangeError> {
        let text = self.ask("/state".to_owned(), None).await?;
        Ok(text.parse()?)
    }

    async fn exchange(&self, command: &Command) -> Result<Answer, ExchangeError> {
        let path = match self.mode {
            Mode::Closed => "/closed",
            Mode::Open => "/open",
        };
        if let CommandForm::Json = self.form {
            let body = json::command(command);
            let text = self.ask(path.to_owned(), Some(&body)).await?;
            return Ok(json::answer(self.mode, &text, command)?);
        }
        let target = if self.check {
            format!("{path}?{}", checksum::signed(&command.to_string()))
        } else {
            let mut target = String::with_capacity(TARGET_BYTES);
            // Writing to a String does not fail.
            let _ = write!(target, "{path}?{command}");
            target
        };
        let text = self.ask(target, None).await?;
        let (text, _) = checksum::checked(&text, self.check)?;
        Ok(Answer::parse(self.mode, text, command)?)
    }
}

impl Transport for Http {
    async fn observe(&mut self) -> Result<Observation, ExchangeError> {
        self.asker.observe().await
    }

    async fn open(&mut self, connections: u16) {
        // The only way to open a connection is to use it.
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
