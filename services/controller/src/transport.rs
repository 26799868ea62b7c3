//! How a command goes out and its answer comes back.
//!
//! [`Transport`] is the seam: the loop knows nothing of HTTP. [`Http`] is the
//! one there is, a request a message, by reqwest.

use std::{error::Error, future::Future, net::ToSocketAddrs, time::Duration};

use endpoint::{Answer, Command, Connection, ControllerSettings, Mode, Observation};
use reqwest::{Client, Url, redirect, retry};

use crate::DriveError;

/// How long a kept connection may idle. It is below the plant's limit of 10 s:
/// else a request could meet the close of its connection.
const POOL_IDLE: Duration = Duration::from_secs(5);

/// How much of a refusal is repeated.
const EXCERPT_CHARS: usize = 200;

/// Why a message has no valid answer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ExchangeError {
    /// No answer in time.
    #[error("no answer in time")]
    Timeout,
    /// The connection broke, or the answer is none.
    #[error("{0}")]
    Failed(String),
}

/// A way to the plant and back. Cheap to clone: each message takes its own.
pub(crate) trait Transport: Clone + Send + 'static {
    /// Sends a command and waits for its answer.
    fn exchange(
        self,
        command: Command,
    ) -> impl Future<Output = Result<Answer, ExchangeError>> + Send + 'static;

    /// Looks at the plant.
    fn observe(self) -> impl Future<Output = Result<Observation, ExchangeError>> + Send + 'static;
}

/// One GET a message.
#[derive(Clone, Debug)]
pub(crate) struct Http {
    client: Client,
    mode: Mode,
    command: Url,
    state: Url,
}

impl Http {
    pub(crate) fn try_new(plant: &str, settings: &ControllerSettings) -> Result<Self, DriveError> {
        let bad = |why: &dyn ToString| DriveError::Address {
            plant: plant.to_owned(),
            why: why.to_string(),
        };
        let base = Url::parse(plant).map_err(|error| bad(&error))?;
        let (Some(host), Some(port)) = (base.host_str(), base.port_or_known_default()) else {
            return Err(bad(&"it has no host"));
        };
        if base.scheme() != "http" {
            return Err(bad(&"the scheme is not http"));
        }
        if base.path() != "/" || base.query().is_some() || base.fragment().is_some() {
            return Err(bad(&"it is more than a host and a port"));
        }
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
        if base.domain().is_some() {
            // A name is looked up here, once, and not within the loop.
            let mut addresses = (host, port)
                .to_socket_addrs()
                .map_err(|error| bad(&error))?;
            let address = addresses
                .next()
                .ok_or_else(|| bad(&"its name has no address"))?;
            builder = builder.resolve(host, address);
        }
        let client = builder.build().map_err(|error| bad(&error))?;
        let at = |path: &str| base.join(path).map_err(|error| bad(&error));
        let command = match settings.mode {
            Mode::Closed => at("/closed"),
            Mode::Open => at("/open"),
        }?;
        Ok(Self {
            client,
            mode: settings.mode,
            command,
            state: at("/state")?,
        })
    }

    async fn get(&self, url: Url) -> Result<String, ExchangeError> {
        let response = self.client.get(url).send().await.map_err(failed)?;
        let status = response.status();
        // Read to its end, else the connection cannot be used again.
        let text = response.text().await.map_err(failed)?;
        if status.is_success() {
            Ok(text)
        } else {
            let text: String = text.trim_end().chars().take(EXCERPT_CHARS).collect();
            Err(ExchangeError::Failed(format!("{status}: {text}")))
        }
    }
}

impl Transport for Http {
    async fn exchange(self, command: Command) -> Result<Answer, ExchangeError> {
        let mut url = self.command.clone();
        url.set_query(Some(&command.to_string()));
        let text = self.get(url).await?;
        Answer::parse(self.mode, &text, &command)
            .map_err(|error| ExchangeError::Failed(error.to_string()))
    }

    async fn observe(self) -> Result<Observation, ExchangeError> {
        let text = self.get(self.state.clone()).await?;
        text.parse()
            .map_err(|error| ExchangeError::Failed(format!("{error}")))
    }
}

fn failed(error: reqwest::Error) -> ExchangeError {
    if error.is_timeout() {
        return ExchangeError::Timeout;
    }
    // The outermost error only says that a request failed; why is further in.
    let error = error.without_url();
    let mut why = error.to_string();
    let mut source = error.source();
    while let Some(inner) = source {
        why = format!("{why}: {inner}");
        source = inner.source();
    }
    ExchangeError::Failed(why)
}
