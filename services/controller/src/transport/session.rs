//! The session in which a controller commands a plant whose lease is `token`.
//!
//! It is claimed before the first command, and again after the plant has ended it: it does when it has heard
//! nothing for 15 s, as after a long outage.

use std::{sync::Arc, time::Duration};

use reqwest::{Client, StatusCode, Url, header};
use tokio::{sync::Mutex, time::timeout};

use super::{Address, ExchangeError, excerpt};
use crate::DriveError;

/// The header that carries the token.
pub(super) const HEADER: &str = "webloop-session";

/// How a controller that is no page introduces itself: its rows stay with it.
const CLAIM: &str = r#"{"client":"webloop native","rows":false}"#;

/// A session, claimed when it is needed. Cheap to clone.
#[derive(Clone, Debug)]
pub(super) struct Session {
    client: Client,
    claim: Url,
    end: Url,
    timeout: Duration,
    token: Arc<Mutex<Option<String>>>,
}

impl Session {
    pub(super) fn try_new(
        address: &Address,
        client: &Client,
        timeout: Duration,
    ) -> Result<Self, DriveError> {
        Ok(Self {
            client: client.clone(),
            claim: address.at("/session")?,
            end: address.at("/session/end")?,
            timeout,
            token: Arc::default(),
        })
    }

    /// The token; of a session that is claimed now, if there is none.
    pub(super) async fn token(&self) -> Result<String, ExchangeError> {
        let claimed = async {
            let mut token = self.token.lock().await;
            if let Some(token) = &*token {
                return Ok(token.clone());
            }
            let claimed = self.claim().await?;
            Ok(token.insert(claimed).clone())
        };
        timeout(self.timeout, claimed)
            .await
            .unwrap_or(Err(ExchangeError::Timeout))
    }

    /// Takes notice that the plant does not accept this token any more.
    pub(super) async fn forget(&self, refused: &str) {
        let mut token = self.token.lock().await;
        if token.as_deref() == Some(refused) {
            *token = None;
        }
    }

    /// Gives the plant back. If that fails, its session ends by silence.
    pub(super) async fn end(&self) {
        if let Some(token) = self.token.lock().await.take() {
            let _ = self.post(&self.end, "{}".to_owned(), Some(&token)).await;
        }
    }

    async fn claim(&self) -> Result<String, ExchangeError> {
        let text = self.post(&self.claim, CLAIM.to_owned(), None).await?;
        serde_json::from_str::<serde_json::Value>(&text)
            .ok()
            .and_then(|grant| Some(grant.get("session")?.as_str()?.to_owned()))
            .ok_or_else(|| {
                let text = excerpt(&text);
                ExchangeError::Failed(format!("the claim's answer has no session: {text}"))
            })
    }

    async fn post(
        &self,
        url: &Url,
        body: String,
        token: Option<&str>,
    ) -> Result<String, ExchangeError> {
        let mut request = self.client.post(url.clone()).body(body);
        request = request.header(header::CONTENT_TYPE, "application/json");
        if let Some(token) = token {
            request = request.header(HEADER, token);
        }
        let response = request.send().await.map_err(super::http::failed)?;
        let status = response.status();
        let text = response.text().await.map_err(super::http::failed)?;
        if status.is_success() {
            return Ok(text);
        }
        let text = excerpt(&text);
        Err(ExchangeError::Failed(format!("{status}: {text}")))
    }
}

/// Whether a plant says by this status that it does not accept a token.
pub(super) fn is_lost(status: StatusCode) -> bool {
    status == StatusCode::CONFLICT
}
