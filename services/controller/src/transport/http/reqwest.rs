//! Requests with reqwest, a general client: what a program has that does not write its own.

use std::{error::Error, time::Duration};

use ::reqwest::{self as library, StatusCode, Url, header, redirect, retry};
use endpoint::Connection;

use super::{Client, Request, pool::IDLE};
use crate::{
    Config, DriveError,
    transport::{Address, ExchangeError, session},
};

/// reqwest, set to do nothing of its own accord.
#[derive(Clone, Debug)]
pub(crate) struct Reqwest {
    client: library::Client,
    base: Url,
}

impl Reqwest {
    pub(crate) fn try_new(address: &Address, config: &Config) -> Result<Self, DriveError> {
        let settings = &config.settings;
        let timeout = Duration::from_nanos(settings.timeout_ns);
        let mut builder = library::Client::builder()
            .no_proxy()
            .http1_only()
            .retry(retry::never())
            .redirect(redirect::Policy::none())
            .referer(false)
            .tcp_nodelay(true)
            .connect_timeout(timeout)
            .timeout(timeout)
            .pool_idle_timeout(IDLE);
        if settings.connection == Connection::New {
            builder = builder.pool_max_idle_per_host(0);
        }
        if let Some(name) = address.base.domain() {
            builder = builder.resolve(name, address.socket);
        }
        let client = builder.build().map_err(|error| address.refused(&error))?;
        let base = address.base.clone();
        Ok(Self { client, base })
    }
}

impl Client for Reqwest {
    async fn ask(&self, asked: Request<'_>) -> Result<(StatusCode, String), ExchangeError> {
        let url = self.base.join(&asked.target);
        let url = url.map_err(|error| ExchangeError::Failed(error.to_string()))?;
        let mut request = match asked.body {
            None => self.client.get(url),
            Some(body) => self
                .client
                .post(url)
                .body(body)
                .header(header::CONTENT_TYPE, "application/json"),
        };
        if let Some(token) = asked.token {
            request = request.header(session::HEADER, token);
        }
        let response = request.send().await.map_err(failed)?;
        let status = response.status();
        // Read to its end, or the connection cannot be used again.
        let text = response.text().await.map_err(failed)?;
        Ok((status, text))
    }
}

fn failed(error: library::Error) -> ExchangeError {
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
