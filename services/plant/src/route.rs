//! What each request gets.
//!
//! [`Desk::answer`] is a function from the head of a request to a response: it
//! needs no socket, and a request that it refuses leaves the input as it was.

use std::fmt;

use endpoint::{ArrivalRow, Command, Inbox, InvalidMessage, Mode, Observation, query::MAX_BYTES};
use hyper::{
    Method, Response, StatusCode, Version,
    header::{self, HeaderMap, HeaderValue},
    http::request::Parts,
};
use journal::Recorder;
use serde::Serialize;

use crate::{
    latest::{Publisher, Reader},
    openapi,
    ticker::{input_words, output},
};

/// The paths there are.
pub(crate) const PATHS: [&str; 5] = ["/closed", "/open", "/state", "/health", "/openapi.json"];

const FORM: &str = "application/x-www-form-urlencoded";
const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// Where requests are dealt with: the plant's state as the HTTP thread owns it.
pub(crate) struct Desk {
    pub(crate) inbox: Inbox,
    pub(crate) input: Publisher<3>,
    pub(crate) output: Reader<2>,
    pub(crate) rows: Recorder<ArrivalRow>,
    pub(crate) refused: u64,
}

/// Why a request was refused.
#[derive(Debug, thiserror::Error)]
enum Refusal {
    #[error("{0}")]
    Message(#[from] InvalidMessage),
    #[error("there is no `{path}`; there are {}", PATHS.join(", "))]
    Path { path: String },
    #[error("method {0} is not served; use GET")]
    Method(Method),
    #[error("the request has {0} Host headers; send exactly one")]
    Host(usize),
    #[error("the request target is not a path; this is a plant, not a proxy")]
    Target,
    #[error("the request has a body; a command is a query and has none")]
    Body,
    #[error(
        "the plant's output is {y}: the loop has left the finite numbers; start the plant again"
    )]
    Diverged { y: f64 },
}

impl Refusal {
    fn status(&self) -> StatusCode {
        match self {
            Self::Message(InvalidMessage::TooLong { .. }) => StatusCode::URI_TOO_LONG,
            Self::Message(_) | Self::Host(_) | Self::Target => StatusCode::BAD_REQUEST,
            Self::Path { .. } => StatusCode::NOT_FOUND,
            Self::Method(_) => StatusCode::METHOD_NOT_ALLOWED,
            Self::Body => StatusCode::PAYLOAD_TOO_LARGE,
            Self::Diverged { .. } => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl Desk {
    /// The response to a request whose head arrived at `now_ns`.
    pub(crate) fn answer(&mut self, head: &Parts, has_body: bool, now_ns: u64) -> Response<String> {
        self.try_answer(head, has_body, now_ns)
            .unwrap_or_else(|refusal| {
                self.refused += 1;
                refuse(&refusal)
            })
    }

    fn try_answer(
        &mut self,
        head: &Parts,
        has_body: bool,
        now_ns: u64,
    ) -> Result<Response<String>, Refusal> {
        let query = check(head, has_body)?;
        match head.uri.path() {
            "/closed" => self.command(Mode::Closed, query, &head.headers, now_ns),
            "/open" => self.command(Mode::Open, query, &head.headers, now_ns),
            "/state" => self.observe(&head.headers, now_ns),
            "/health" => Ok(respond(TEXT, "ok\n".to_owned())),
            "/openapi.json" => Ok(respond(JSON, openapi::DOCUMENT.clone())),
            path => Err(Refusal::Path {
                path: path.chars().take(40).collect(),
            }),
        }
    }

    fn command(
        &mut self,
        mode: Mode,
        query: &str,
        headers: &HeaderMap,
        now_ns: u64,
    ) -> Result<Response<String>, Refusal> {
        let command: Command = query.parse()?;
        let output = output(self.output.read());
        let (row, answer) = self.inbox.command(mode, &command, output, now_ns);
        self.input.publish(input_words(self.inbox.input()));
        self.rows.record(row);
        if mode == Mode::Closed && !output.y.is_finite() {
            return Err(Refusal::Diverged { y: output.y });
        }
        Ok(message(&answer, headers))
    }

    fn observe(&self, headers: &HeaderMap, now_ns: u64) -> Result<Response<String>, Refusal> {
        let output = output(self.output.read());
        if !output.y.is_finite() {
            return Err(Refusal::Diverged { y: output.y });
        }
        let observation = Observation {
            t_ns: now_ns,
            tick: output.tick,
            y: output.y,
            u: self.inbox.input().u,
        };
        Ok(message(&observation, headers))
    }
}

/// Refuses what is not a plain request of one host; the query of what is.
fn check(head: &Parts, has_body: bool) -> Result<&str, Refusal> {
    // `CONNECT host:port` and `GET http://host/path` are for proxies.
    if head.uri.authority().is_some() {
        return Err(Refusal::Target);
    }
    let hosts = head.headers.get_all(header::HOST).iter().count();
    // HTTP/1.0 came before the header (RFC 9112, 3.2).
    if hosts > 1 || (hosts == 0 && head.version != Version::HTTP_10) {
        return Err(Refusal::Host(hosts));
    }
    let query = head.uri.query().unwrap_or_default();
    let bytes = head.uri.path().len().max(query.len());
    if bytes > MAX_BYTES {
        return Err(InvalidMessage::TooLong { bytes }.into());
    }
    if PATHS.contains(&head.uri.path()) && head.method != Method::GET {
        // Not even HEAD: a GET here moves the plant, and HEAD would do so too.
        return Err(Refusal::Method(head.method.clone()));
    }
    if has_body {
        return Err(Refusal::Body);
    }
    Ok(query)
}

/// A message in the form that the client accepts: a query unless it says JSON.
fn message<M: fmt::Display + Serialize>(message: &M, headers: &HeaderMap) -> Response<String> {
    let json = headers
        .get_all(header::ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .any(|range| {
            range
                .split(';')
                .next()
                .is_some_and(|kind| kind.trim() == JSON)
        });
    if json {
        let text = serde_json::to_string(message).expect("a message is numbers under fixed names");
        respond(JSON, text)
    } else {
        respond(FORM, message.to_string())
    }
}

fn respond(kind: &'static str, body: String) -> Response<String> {
    let mut response = Response::new(body);
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    // A GET that moves a plant must reach it, and each answer is of its moment.
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

fn refuse(refusal: &Refusal) -> Response<String> {
    let mut response = respond(TEXT, format!("{refusal}\n"));
    *response.status_mut() = refusal.status();
    if let Refusal::Method(_) = refusal {
        response
            .headers_mut()
            .insert(header::ALLOW, HeaderValue::from_static("GET"));
    }
    if let Refusal::Body | Refusal::Target = refusal {
        // What follows on this connection may not be a request.
        response
            .headers_mut()
            .insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}
