//! One request to an agent and its answer: time-outs, the token, and errors in words.

use std::error::Error as _;
use std::time::Duration;

use hyper::body::Bytes;
use reqwest::header::{AUTHORIZATION, CONTENT_TYPE};
use reqwest::{Client, Method, RequestBuilder, Response, Url, redirect};
use serde::Serialize;
use serde::de::DeserializeOwned;
use text::excerpt;
use tokio::runtime::Runtime;

use crate::error::Error;
use crate::token::Token;
use crate::wire::ProblemKind;
use crate::wire::{Problem, SIZE_HEADER};

/// How long to wait for a connection.
const CONNECT_WITHIN: Duration = Duration::from_secs(2);

/// How long a kept connection may be idle: less than the 5 s after which the agent closes it.
const POOL_IDLE: Duration = Duration::from_secs(4);

/// How much of an unexpected answer is quoted, in characters.
const EXCERPT_CHARS: usize = 200;

/// A client of one agent. Several threads may send requests through it.
#[derive(Debug)]
pub(crate) struct Exchange {
    agent: String,
    authority: String,
    base: Url,
    token: Option<Token>,
    client: Client,
    runtime: Runtime,
}

/// A part of a file.
pub(crate) struct Part {
    pub(crate) bytes: Bytes,
    pub(crate) size: u64,
}

impl Exchange {
    /// Prepares requests to `agent`, which is its name in errors. Nothing is sent yet.
    pub(crate) fn open(
        agent: &str,
        authority: &str,
        token: Option<Token>,
    ) -> Result<Exchange, Error> {
        let base = base(authority).ok_or_else(|| Error::Authority {
            agent: agent.to_owned(),
            authority: authority.chars().take(100).collect(),
        })?;
        let client = Client::builder()
            .no_proxy()
            .http1_only()
            .redirect(redirect::Policy::none())
            .referer(false)
            .tcp_nodelay(true)
            .connect_timeout(CONNECT_WITHIN)
            .pool_idle_timeout(POOL_IDLE)
            .build()
            .map_err(|problem| Error::Start(std::io::Error::other(problem)))?;
        Ok(Exchange {
            agent: agent.to_owned(),
            authority: authority.to_owned(),
            base,
            token,
            client,
            runtime: tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()?,
        })
    }

    pub(crate) fn authority(&self) -> &str {
        &self.authority
    }

    /// Sends a request without a body.
    pub(crate) fn ask(
        &self,
        method: Method,
        path: &[&str],
        within: Duration,
    ) -> Result<Bytes, Error> {
        self.send(self.to(method, self.url(path)), within)
            .map(|(_, bytes)| bytes)
    }

    /// Posts a value as JSON.
    pub(crate) fn tell(
        &self,
        path: &[&str],
        what: &impl Serialize,
        within: Duration,
    ) -> Result<Bytes, Error> {
        let body = serde_json::to_vec(what).expect("strings under fixed names");
        let request = self.to(Method::POST, self.url(path)).body(body);
        self.send(request.header(CONTENT_TYPE, "application/json"), within)
            .map(|(_, bytes)| bytes)
    }

    /// Asks for a file from byte `from` on.
    pub(crate) fn part(&self, path: &[&str], from: u64, within: Duration) -> Result<Part, Error> {
        let mut url = self.url(path);
        url.set_query(Some(&format!("from={from}")));
        let (size, bytes) = self.send(self.to(Method::GET, url), within)?;
        let size = size.ok_or_else(|| self.odd("the answer does not say how long the file is"))?;
        Ok(Part { bytes, size })
    }

    /// Reads an answer's JSON.
    pub(crate) fn read<T: DeserializeOwned>(&self, body: &Bytes) -> Result<T, Error> {
        serde_json::from_slice(body).map_err(|problem| {
            let text = beginning(body);
            self.odd(&format!(
                "`{text}` is not an answer of an agent ({problem})"
            ))
        })
    }

    fn to(&self, method: Method, url: Url) -> RequestBuilder {
        let request = self.client.request(method, url);
        match &self.token {
            Some(token) => request.header(AUTHORIZATION, token.header()),
            None => request,
        }
    }

    /// The segments are encoded, so that each stays one.
    fn url(&self, path: &[&str]) -> Url {
        let mut url = self.base.clone();
        if let Ok(mut segments) = url.path_segments_mut() {
            segments.clear().extend(path);
        }
        url
    }

    fn send(
        &self,
        request: RequestBuilder,
        within: Duration,
    ) -> Result<(Option<u64>, Bytes), Error> {
        let request = request.timeout(within);
        let answer = self.runtime.block_on(async {
            let response = request.send().await?;
            let (status, size) = (response.status(), size(&response));
            // Read the body to its end, or the connection cannot be used again.
            Ok((status, size, response.bytes().await?))
        });
        let (status, size, bytes) = answer.map_err(|problem| self.unanswered(problem))?;
        if status.is_success() {
            return Ok((size, bytes));
        }
        Err(match serde_json::from_slice::<Problem>(&bytes) {
            Ok(Problem { problem, kind }) => Error::Refused {
                agent: self.agent.clone(),
                problem: text::plain(&problem).into_owned(),
                kind,
            },
            Err(_) => self.odd(&format!("{status}: {}", beginning(&bytes))),
        })
    }

    fn unanswered(&self, problem: reqwest::Error) -> Error {
        // The outermost error only says that a request failed; the cause is further in.
        let timeout = problem.is_timeout();
        let problem = problem.without_url();
        let mut why = if timeout {
            "no answer in time".to_owned()
        } else {
            problem.to_string()
        };
        let mut source = problem.source().filter(|_| !timeout);
        while let Some(inner) = source {
            why = format!("{why}: {inner}");
            source = inner.source();
        }
        Error::Unanswered {
            agent: self.agent.clone(),
            authority: self.authority.clone(),
            problem: why,
        }
    }

    fn odd(&self, problem: &str) -> Error {
        Error::Refused {
            agent: self.agent.clone(),
            problem: format!("{} gives an invalid answer: {problem}", self.authority),
            kind: ProblemKind::Failed,
        }
    }
}

/// The URL of an agent; `None` unless `authority` is `host:port` and nothing more.
fn base(authority: &str) -> Option<Url> {
    let url = Url::parse(&format!("http://{authority}/")).ok()?;
    let (_, port) = authority.rsplit_once(':')?;
    let port: u16 = port.parse().ok()?;
    let plain = url.username().is_empty()
        && url.password().is_none()
        && url.path() == "/"
        && url.query().is_none()
        && url.fragment().is_none()
        && url.port_or_known_default() == Some(port)
        && port > 0;
    plain.then_some(url)
}

fn size(response: &Response) -> Option<u64> {
    response
        .headers()
        .get(SIZE_HEADER)?
        .to_str()
        .ok()?
        .parse()
        .ok()
}

fn beginning(body: &Bytes) -> String {
    excerpt(String::from_utf8_lossy(body).trim(), EXCERPT_CHARS)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn an_authority_is_a_host_and_a_port() {
        for text in [
            "plant.control:7070",
            "127.0.0.1:1",
            "[::1]:7070",
            "localhost:80",
        ] {
            assert!(base(text).is_some(), "{text}");
        }
        for text in [
            "",
            ":7070",
            "plant",
            "plant:",
            "plant:0",
            "plant:70700",
            "plant:7070/x",
            "http://plant:7070",
            "me@plant:7070",
            "plant:7070?x",
            "plant:7070#x",
            "pl ant:7070",
        ] {
            assert!(base(text).is_none(), "{text}");
        }
    }
}
