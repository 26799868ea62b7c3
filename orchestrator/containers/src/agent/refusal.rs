//! Why a request was refused, and the text of the answer.

use std::io;

use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};

use endpoint::NotServed;

use crate::agent::answer::json;
use crate::name::{BadName, Name};
use crate::token::Token;
use crate::wire::{Problem, ProblemKind};

/// Why a request was refused.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Refusal {
    #[error("there is no `{0}` here")]
    Path(String),
    #[error("{0} is not served here; use {1}")]
    Method(Method, &'static str),
    #[error("this path does not accept the query `{0}`; leave it out, or use from=N for a file")]
    Query(String),
    #[error(
        "the token is missing or wrong; send `Authorization: Bearer TOKEN` with the one that claimed this agent"
    )]
    Token,
    #[error("the request has more than one Authorization header; send one")]
    Tokens,
    #[error(
        "the request is to another host, or has {0} Host headers; send a path, and exactly one"
    )]
    Host(usize),
    #[error("{0}; ask by the agent's address, or by the name that it listens on")]
    Misdirected(NotServed),
    #[error(transparent)]
    NoHost(NotServed),
    #[error("`{0}` says that a page sent the request; an agent serves no page")]
    Page(&'static str),
    #[error("a run has at most {0} roles; end it, and begin another")]
    Roles(usize),
    #[error("this agent has not been claimed yet; claim it first")]
    Unclaimed,
    #[error(
        "this agent belongs to another orchestrator; end that one, or start the agent again with {} set",
        Token::VARIABLE
    )]
    Claimed,
    #[error(transparent)]
    Name(#[from] BadName),
    #[error("the body cannot be read: {0}")]
    Body(String),
    #[error("the body has more than {0} bytes")]
    Large(usize),
    #[error("the body did not come within {0} s")]
    Slow(u64),
    #[error("there is no run `{0}` here; begin it first")]
    Run(Name),
    #[error("there is no role `{0}` in this run")]
    Instance(Name),
    #[error("there was a role `{0}` in this run already; choose another name")]
    Taken(Name),
    #[error("`{0}` is not a role of an agent; the roles are {1}")]
    Role(String, String),
    #[error("there is no file `{0}` in this run")]
    File(Name),
    #[error("the file `{0}` has only {1} bytes")]
    Range(Name, u64),
    #[error("this agent is ending; start it again")]
    Ending,
    /// A role did not become ready.
    #[error("{words}")]
    NotReady { words: String, kind: ProblemKind },
    #[error("cannot use the run's folder: {0}; make space where --scratch points")]
    Disk(#[from] io::Error),
}

impl Refusal {
    fn status(&self) -> StatusCode {
        match self {
            Refusal::Path(_) | Refusal::Run(_) | Refusal::Instance(_) | Refusal::File(_) => {
                StatusCode::NOT_FOUND
            }
            Refusal::Method(..) => StatusCode::METHOD_NOT_ALLOWED,
            Refusal::Token | Refusal::Unclaimed => StatusCode::UNAUTHORIZED,
            Refusal::Misdirected(_) => StatusCode::MISDIRECTED_REQUEST,
            Refusal::Page(_) => StatusCode::FORBIDDEN,
            Refusal::Claimed | Refusal::Taken(_) | Refusal::Roles(_) => StatusCode::CONFLICT,
            Refusal::Query(_)
            | Refusal::Tokens
            | Refusal::Host(_)
            | Refusal::NoHost(_)
            | Refusal::Name(_)
            | Refusal::Body(_)
            | Refusal::Role(..) => StatusCode::BAD_REQUEST,
            Refusal::Large(_) => StatusCode::PAYLOAD_TOO_LARGE,
            Refusal::Slow(_) => StatusCode::REQUEST_TIMEOUT,
            Refusal::Range(..) => StatusCode::RANGE_NOT_SATISFIABLE,
            Refusal::NotReady { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            Refusal::Ending => StatusCode::SERVICE_UNAVAILABLE,
            Refusal::Disk(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }

    /// The body of the answer.
    fn problem(&self) -> Problem {
        Problem {
            problem: self.to_string(),
            kind: match self {
                Refusal::NotReady { kind, .. } => *kind,
                Refusal::Disk(_) | Refusal::Slow(_) | Refusal::Ending => ProblemKind::Failed,
                _ => ProblemKind::Usage,
            },
        }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let mut response = json(self.status(), &self.problem());
        let (name, value) = match self {
            Refusal::Method(_, allowed) => (header::ALLOW, allowed),
            Refusal::Token | Refusal::Unclaimed => (header::WWW_AUTHENTICATE, "Bearer"),
            // What follows is for somebody else too.
            Refusal::Host(_) | Refusal::NoHost(_) | Refusal::Misdirected(_) => {
                (header::CONNECTION, "close")
            }
            // Do not wait for the rest of the body.
            Refusal::Large(_) | Refusal::Slow(_) | Refusal::Body(_) => {
                (header::CONNECTION, "close")
            }
            _ => return response,
        };
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
        response
    }
}
