//! Messages over HTTP: one GET each, with reqwest.

use std::{error::Error, time::Duration};

use endpoint::{Answer, Command, Connection, Mode, Observation, checksum};
use reqwest::{Client, Url, redirect, retry};

use super::{
    Address, ExchangeError, Transport, excerpt,
    session::{self, Session},
};
use crate::{Config, DriveError};

/// How long a kept connection may idle. It is below the plant's limit of 5 s; otherwise a request
/// could be sent just as the plant closes the connection.
const POOL_IDLE: Duration = Duration::from_secs(4);

/// One GET per message.
#[derive(Clone, Debug)]
pub(crate) struct Http {
    client: Client,
    mode: Mode,
    command: Url,
    state: Url,
    /// The session in which it commands, if it has to have one.
    pub(super) session: Option<Session>,
    check: bool,
}

impl Http {
    pub(crate) fn try_new(address: &Address, config: &Config) -> Result<Self, DriveError> {
        let settings = &config.settings;
        let timeout = Duration::from_nanos(settings.timeout_ns);
        let mut builder = Client::builder()
            .no_proxy()
            .http1_only()
            .retry(retry::never())
            .redirect(redirect::Policy::none())
            .referer(false)
            .tcp_nodelay(true)
            .connect_timeout(timeout)
            .timeout(timeout)
            .pool_idle_timeout(POOL_IDLE);
        if settings.connection == Connection::New {
            builder = builder.pool_max_idle_per_host(0);
        }
        if let Some(name) = address.base.domain() {
            builder = builder.resolve(name, address.socket);
        }
        let client = builder.build().map_err(|error| address.refused(&error))?;
        let command = address.at(match settings.mode {
            Mode::Closed => "/closed",
            Mode::Open => "/open",
        })?;
        let session = config
            .claim
            .then(|| Session::try_new(address, &client, timeout))
            .transpose()?;
        Ok(Self {
            client,
            session,
            check: config.check,
            mode: settings.mode,
            command,
            state: address.at("/state")?,
        })
    }

    async fn get(&self, url: Url) -> Result<String, ExchangeError> {
        let mut request = self.client.get(url);
        let token = match &self.session {
            None => None,
            Some(session) => Some((session, session.token().await?)),
        };
        if let Some((_, token)) = &token {
            request = request.header(session::HEADER, token);
        }
        let response = request.send().await.map_err(failed)?;
        let status = response.status();
        // Read to its end, or the connection cannot be used again.
        let text = response.text().await.map_err(failed)?;
        if status.is_success() {
            Ok(text)
        } else {
            if let Some((session, token)) = token
                && session::is_lost(status)
            {
                session.forget(&token).await;
            }
            let text = excerpt(&text);
            Err(ExchangeError::Failed(format!("{status}: {text}")))
        }
    }
}

impl Transport for Http {
    async fn observe(self) -> Result<Observation, ExchangeError> {
        let text = self.get(self.state.clone()).await?;
        text.parse()
            .map_err(|error| ExchangeError::Failed(format!("{error}")))
    }

    async fn open(self) {
        // The only way for a client to open a connection is to use it.
        let _ = self.observe().await;
    }

    async fn exchange(self, command: Command) -> Result<Answer, ExchangeError> {
        let mut url = self.command.clone();
        url.set_query(Some(&if self.check {
            checksum::signed(&command.to_string())
        } else {
            command.to_string()
        }));
        let text = self.get(url).await?;
        checksum::checked(&text, self.check)
            .and_then(|(text, _)| Answer::parse(self.mode, text, &command))
            .map_err(|error| ExchangeError::Failed(error.to_string()))
    }

    async fn close(self) {
        if let Some(session) = &self.session {
            session.end().await;
        }
    }
}

pub(super) fn failed(error: reqwest::Error) -> ExchangeError {
    if error.is_timeout() {
        return ExchangeError::Timeout;
    }
    // The outermost error only says that a request failed; its sources say why.
    let error = error.without_url();
    let mut why = error.to_string();
    let mut source = error.source();
    while let Some(inner) = source {
        why = format!("{why}: {inner}");
        source = inner.source();
    }
    ExchangeError::Failed(why)
}
