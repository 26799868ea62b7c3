//! The plant as seen by the launcher: whether it is ready, and who controls it.
//!
//! The requests use the same link as the loop. A link may stall for seconds and lose packets, so a
//! request without an answer is simply repeated.

use std::{error::Error, net::SocketAddr, time::Duration};

use reqwest::{Client, StatusCode, redirect, retry};
use serde::Deserialize;

/// A link may stall for five seconds without being broken.
const ANSWER_WITHIN: Duration = Duration::from_secs(8);

/// Pause between requests to a plant that does not answer yet.
const WARM_UP_PAUSE: Duration = Duration::from_millis(50);

/// State of the control session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum State {
    /// No page holds the session.
    Free,
    /// A page holds the session.
    Held,
    /// No page holds the session any more: the last one reported its end.
    Ended,
}

/// The plant's status of its session, `GET /session`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub(crate) struct Status {
    pub(crate) state: State,
    #[serde(default)]
    pub(crate) client: String,
    #[serde(default)]
    pub(crate) commands: u64,
    #[serde(default)]
    pub(crate) rows: u64,
    /// Time since the plant last heard from the page.
    #[serde(default)]
    pub(crate) idle_ms: u64,
    /// The page's own outcome, if the plant repeats it.
    #[serde(default)]
    pub(crate) outcome: Option<String>,
    /// The reason for that outcome.
    #[serde(default)]
    pub(crate) reason: Option<String>,
}

/// Why the plant gave no answer, or not the one asked for.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Unanswered {
    #[error("no attempt ended")]
    Pending,
    #[error("{}", sentence(.0))]
    Request(reqwest::Error),
    #[error("{path}: {status}")]
    Refused {
        path: &'static str,
        status: StatusCode,
    },
    #[error("/session: {0}")]
    Status(serde_json::Error),
}

impl From<reqwest::Error> for Unanswered {
    fn from(error: reqwest::Error) -> Self {
        Self::Request(error.without_url())
    }
}

/// A client for the plant's status.
#[derive(Clone, Debug)]
pub(crate) struct Plant {
    client: Client,
    address: SocketAddr,
}

impl Plant {
    pub(crate) fn at(address: SocketAddr) -> reqwest::Result<Self> {
        let client = Client::builder()
            .no_proxy()
            .http1_only()
            .retry(retry::never())
            .redirect(redirect::Policy::none())
            .referer(false)
            .tcp_nodelay(true)
            .timeout(ANSWER_WITHIN)
            .build()?;
        Ok(Self { client, address })
    }

    /// Waits until the plant is ready; otherwise returns the result of the last attempt.
    pub(crate) async fn is_well_within(&self, within: Duration) -> Result<(), Unanswered> {
        let mut why = Unanswered::Pending;
        let well = async {
            while let Err(error) = self.get("/health").await {
                why = error;
                tokio::time::sleep(WARM_UP_PAUSE).await;
            }
        };
        tokio::time::timeout(within, well).await.map_err(|_| why)
    }

    /// The state of the control session.
    pub(crate) async fn status(&self) -> Result<Status, Unanswered> {
        let text = self.get("/session").await?;
        serde_json::from_str(&text).map_err(Unanswered::Status)
    }

    async fn get(&self, path: &'static str) -> Result<String, Unanswered> {
        let url = format!("http://{}{path}", self.address);
        let response = self.client.get(url).send().await?;
        let status = response.status();
        let text = response.text().await?;
        if status.is_success() {
            Ok(text)
        } else {
            Err(Unanswered::Refused { path, status })
        }
    }
}

/// The outermost error only says that a request failed; its sources say why.
fn sentence(error: &reqwest::Error) -> String {
    let mut why = error.to_string();
    let mut source = error.source();
    while let Some(inner) = source {
        why = format!("{why}: {inner}");
        source = inner.source();
    }
    why
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plant_may_say_more_or_less_of_a_session() {
        let status: Status = serde_json::from_str(
            r#"{"state":"ended","client":"c","commands":7,"rows":6,"idle_ms":5,"more":1}"#,
        )
        .expect("a status");
        assert_eq!((status.state, status.commands), (State::Ended, 7));
        let status: Status = serde_json::from_str(r#"{"state":"free"}"#).expect("a status");
        assert_eq!(status.state, State::Free);
        assert!(serde_json::from_str::<Status>(r#"{"state":"lost"}"#).is_err());
    }
}
