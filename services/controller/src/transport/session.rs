//! The session in which a controller commands a plant whose lease is `token`.
//!
//! It is claimed before the first command, and again after the plant has ended it: it does when it has heard
//! nothing for 15 s, as after a long outage.

use std::{rc::Rc, time::Duration};

use endpoint::http::StatusCode;
use tokio::{sync::Mutex, time::timeout};

use super::{
    ExchangeError,
    error::excerpt,
    http::{ANY, Pool, Request},
};

/// How a controller that is no page introduces itself: its rows stay with it.
const CLAIM: &str = r#"{"client":"webloop native","rows":false}"#;

/// A session, claimed when it is needed. Cheap to clone.
#[derive(Clone, Debug)]
pub(super) struct Session {
    pool: Pool,
    timeout: Duration,
    token: Rc<Mutex<Option<String>>>,
}

impl Session {
    pub(super) fn new(pool: Pool, timeout_ns: u64) -> Self {
        Self {
            pool,
            timeout: Duration::from_nanos(timeout_ns),
            token: Rc::default(),
        }
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
            let _ = self.post("/session/end", "{}", Some(&token)).await;
        }
    }

    async fn claim(&self) -> Result<String, ExchangeError> {
        let text = self.post("/session", CLAIM, None).await?;
        serde_json::from_str::<serde_json::Value>(&text)
            .ok()
            .and_then(|grant| Some(grant.get("session")?.as_str()?.to_owned()))
            .ok_or_else(|| ExchangeError::NoSession {
                text: excerpt(&text),
            })
    }

    async fn post(
        &self,
        path: &str,
        body: &'static str,
        token: Option<&str>,
    ) -> Result<String, ExchangeError> {
        let request = Request {
            target: path.to_owned(),
            token,
            body: Some(body),
            accept: ANY,
        };
        let (status, text) = self.pool.ask(&request).await?;
        if status.is_success() {
            return Ok(text);
        }
        Err(ExchangeError::refused(status, &text))
    }
}

/// Whether a plant says by this status that it does not accept a token.
pub(super) fn is_lost(status: StatusCode) -> bool {
    status == StatusCode::CONFLICT
}
