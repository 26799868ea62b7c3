//! Why a request is rejected, and how that is reported: over HTTP as a status and a text, over a
//! WebSocket as a close frame, on a line as a last one.

use endpoint::http::{body::InvalidBody, request::Malformed};
use endpoint::{InvalidMessage, NotServed, Signals};
use hyper::{
    Method, Response, StatusCode,
    body::Bytes,
    header::{self, HeaderName, HeaderValue},
};
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

use crate::{
    answer::{TEXT, respond},
    filer::FilingError,
    handshake::InvalidHandshake,
    openapi::PATHS,
    origin::Foreign,
    session::{Denied, InvalidClient},
};

/// Why a request was rejected.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Refusal {
    #[error(transparent)]
    Message(#[from] InvalidMessage),
    #[error("there is no `{path}`; there are {}", PATHS.join(", "))]
    Path { path: String },
    #[error("method {method} is not served; use {allowed}")]
    Method {
        method: Method,
        allowed: &'static str,
    },
    #[error("the request has {0} Host headers; send exactly one")]
    Host(usize),
    #[error(transparent)]
    Head(#[from] Malformed),
    #[error(
        "{0}; ask by the plant's address or `localhost`, or start it with `--host` and this name"
    )]
    Misdirected(NotServed),
    #[error(transparent)]
    NoHost(NotServed),
    #[error("the request target is not a path; this is a plant, not a proxy")]
    Target,
    #[error(transparent)]
    Foreign(#[from] Foreign),
    #[error("the request has a body; a command is a query and has none, or a POST of JSON")]
    Body,
    #[error("the query is not {expected}")]
    Query { expected: &'static str },
    #[error("the body is not {expected}; say so in Content-Type if it is")]
    Kind { expected: &'static str },
    #[error("the body has more than {limit} bytes; send less at a time")]
    Long { limit: usize },
    #[error("the {part} did not come within {seconds} s; send it again")]
    Slow { part: &'static str, seconds: u64 },
    #[error("too many bodies are on their way; send it again later")]
    Bodies,
    #[error("the body ended early; send it again")]
    Broken,
    #[error("the body does not say who claims the plant: {0}; send {{\"client\":\"a name\"}}")]
    Claim(#[from] serde_json::Error),
    #[error(transparent)]
    Client(#[from] InvalidClient),
    #[error(transparent)]
    Denied(#[from] Denied),
    #[error(transparent)]
    FilingError(#[from] FilingError),
    #[error("cannot make a session token: {0}; claim again")]
    Randomness(#[from] std::io::Error),
    #[error("a datagram that is not UTF-8, or whose answer would be long")]
    Datagram,
    #[error(transparent)]
    Handshake(#[from] InvalidHandshake),
    #[error(
        "the plant's output is {y}: the loop has diverged; POST /reset puts the plant back to rest, if it is no \
         program of one's own, and else start it again"
    )]
    Diverged { y: Signals },
    #[error("this plant is a program, which cannot be put back to rest; start it again")]
    Reset,
}

impl From<NotServed> for Refusal {
    fn from(problem: NotServed) -> Self {
        match problem {
            NotServed::Foreign(_) => Self::Misdirected(problem),
            NotServed::Malformed => Self::NoHost(problem),
        }
    }
}

impl From<InvalidBody> for Refusal {
    fn from(problem: InvalidBody) -> Self {
        match problem {
            InvalidBody::Long { limit } => Self::Long { limit },
            InvalidBody::Broken => Self::Broken,
        }
    }
}

impl Refusal {
    fn status(&self) -> StatusCode {
        match self {
            Self::Message(InvalidMessage::TooLong { .. }) => StatusCode::URI_TOO_LONG,
            Self::Message(_)
            | Self::Host(_)
            | Self::Target
            | Self::Head(Malformed::Syntax(_))
            | Self::NoHost(_)
            | Self::Query { .. }
            | Self::Broken
            | Self::Datagram
            | Self::Claim(_)
            | Self::Client(_)
            | Self::FilingError(FilingError::Row(_) | FilingError::Report(_)) => {
                StatusCode::BAD_REQUEST
            }
            Self::Misdirected(_) => StatusCode::MISDIRECTED_REQUEST,
            Self::Head(Malformed::Long) => StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE,
            Self::Bodies => StatusCode::SERVICE_UNAVAILABLE,
            Self::Foreign(_) => StatusCode::FORBIDDEN,
            Self::Path { .. } => StatusCode::NOT_FOUND,
            Self::Method { .. } => StatusCode::METHOD_NOT_ALLOWED,
            Self::Slow { .. } => StatusCode::REQUEST_TIMEOUT,
            Self::Denied(_) | Self::FilingError(FilingError::Turn(_) | FilingError::Closed) => {
                StatusCode::CONFLICT
            }
            Self::Body | Self::Long { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            Self::Kind { .. } => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Handshake(_) => StatusCode::UPGRADE_REQUIRED,
            Self::Reset => StatusCode::NOT_IMPLEMENTED,
            Self::Diverged { .. }
            | Self::Randomness(_)
            | Self::FilingError(
                FilingError::Create(_) | FilingError::Write { .. } | FilingError::Gone,
            ) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }

    /// Its kind in the plant's report.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Message(InvalidMessage::Checksum { .. } | InvalidMessage::NoChecksum) => {
                "checksum"
            }
            Self::Message(_) | Self::Query { .. } => "query",
            Self::Path { .. } => "path",
            Self::Method { .. } => "method",
            Self::Host(_) | Self::Target | Self::Misdirected(_) | Self::NoHost(_) => "host",
            Self::Head(_) => "head",
            Self::Foreign(_) => "origin",
            Self::Body | Self::Kind { .. } | Self::Long { .. } | Self::Bodies | Self::Broken => {
                "body"
            }
            Self::Slow { part, .. } => part,
            Self::Denied(denied) => denied.kind(),
            Self::Claim(_) | Self::Client(_) | Self::FilingError(_) | Self::Randomness(_) => {
                "session"
            }
            Self::Datagram => "datagram",
            Self::Handshake(_) => "websocket",
            Self::Diverged { .. } => "diverged",
            Self::Reset => "reset",
        }
    }

    /// The refusal as a response to a request that has no body, or whose body has been read.
    pub(crate) fn response(&self) -> Response<Bytes> {
        let mut response = respond(TEXT, format!("{self}\n"));
        *response.status_mut() = self.status();
        let mut tell = |name: HeaderName, value: &'static str| {
            let headers = response.headers_mut();
            headers.insert(name, HeaderValue::from_static(value));
        };
        match self {
            Self::Method { allowed, .. } => tell(header::ALLOW, allowed),
            Self::Handshake(_) => {
                tell(header::CONNECTION, "upgrade");
                tell(header::UPGRADE, "websocket");
                tell(header::SEC_WEBSOCKET_VERSION, "13");
            }
            _ => {}
        }
        let is_astray = matches!(self, Self::Host(_) | Self::NoHost(_) | Self::Misdirected(_));
        let is_torn = matches!(self, Self::Target | Self::Long { .. } | Self::Slow { .. });
        if is_astray || is_torn {
            close(&mut response);
        }
        response
    }

    /// The refusal as a response to a request with a body that has not been read.
    pub(crate) fn last_response(&self) -> Response<Bytes> {
        let mut response = self.response();
        close(&mut response);
        response
    }

    /// The code of the close frame for a rejected message.
    pub(crate) fn close_code(&self) -> CloseCode {
        match self {
            Self::Diverged { .. } => CloseCode::Error,
            _ => CloseCode::Policy,
        }
    }
}

/// Lets the connection end: what follows on it may not be a request, or is for somebody else too.
fn close(response: &mut Response<Bytes>) {
    let headers = response.headers_mut();
    headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
}
