//! What each HTTP request gets: the paths that the contract names, with the plant's own strictness.
//!
//! There are no sessions, pages or uploads, which are for controllers in a browser.

use endpoint::Mode;
use hyper::body::Bytes;
use hyper::header;
use hyper::http::request::Parts;
use hyper::{Method, Response, StatusCode, Version};
use plant::answer::{TEXT, message, respond};

use crate::exchange::{Exchange, Refusal};
use crate::socket;

/// What a request gets.
#[derive(Debug)]
pub(crate) struct Reply {
    pub(crate) response: Response<Bytes>,
    /// When it gets it, ns.
    pub(crate) at_ns: u64,
    /// Whether its connection is closed then.
    pub(crate) is_last: bool,
    /// The mode of the WebSocket that the connection becomes.
    pub(crate) socket: Option<Mode>,
}

/// What a request asks for.
enum Asked {
    Message(Mode),
    State,
    Socket(Mode),
    Health,
}

/// The reply to a request whose head arrived at `now_ns`.
pub(crate) fn reply(
    exchange: &mut Exchange,
    head: &Parts,
    has_body: bool,
    connection: u64,
    now_ns: u64,
) -> Reply {
    let at_ns = exchange.released_ns(now_ns);
    let plain = |response| Reply {
        response,
        at_ns,
        is_last: false,
        socket: None,
    };
    match asked(head, has_body) {
        Ok(Asked::Message(mode)) => {
            let query = head.uri.query().unwrap_or_default();
            let said = exchange.message(mode, query, connection, now_ns);
            let response = match &said.answer {
                Ok(answer) => message(answer, &head.headers),
                Err(refusal) => refused(refusal),
            };
            Reply {
                response,
                at_ns: said.at_ns,
                is_last: said.is_last,
                socket: None,
            }
        }
        Ok(Asked::State) => plain(message(&exchange.observe(now_ns), &head.headers)),
        Ok(Asked::Health) => plain(respond(TEXT, "ok\n")),
        Ok(Asked::Socket(mode)) => match socket::handshake(&head.headers) {
            Some(response) => Reply {
                socket: Some(mode),
                ..plain(response)
            },
            None => {
                let words = "/socket takes the handshake of RFC 6455, version 13";
                exchange.heard.refuse(words);
                plain(refused(&Refusal::new(StatusCode::UPGRADE_REQUIRED, words)))
            }
        },
        Err(refusal) => {
            exchange.heard.refuse(&refusal.words);
            plain(refused(&refusal))
        }
    }
}

fn asked(head: &Parts, has_body: bool) -> Result<Asked, Refusal> {
    let refuse = |status, words: &str| Err(Refusal::new(status, words));
    if head.uri.authority().is_some() {
        return refuse(
            StatusCode::BAD_REQUEST,
            "the request target is not a path; this is a plant, not a proxy",
        );
    }
    let hosts = head.headers.get_all(header::HOST).iter().count();
    if hosts > 1 || (hosts == 0 && head.version != Version::HTTP_10) {
        return refuse(
            StatusCode::BAD_REQUEST,
            "the request has not exactly one Host header",
        );
    }
    if head.method != Method::GET {
        let words = format!("method {} is not served; use GET", head.method);
        return refuse(StatusCode::METHOD_NOT_ALLOWED, &words);
    }
    if has_body {
        return refuse(
            StatusCode::PAYLOAD_TOO_LARGE,
            "the request has a body; a command is a query and has none",
        );
    }
    match head.uri.path() {
        "/closed" => Ok(Asked::Message(Mode::Closed)),
        "/open" => Ok(Asked::Message(Mode::Open)),
        "/state" => Ok(Asked::State),
        "/health" => Ok(Asked::Health),
        "/socket" => match head.uri.query() {
            Some("mode=closed") => Ok(Asked::Socket(Mode::Closed)),
            Some("mode=open") => Ok(Asked::Socket(Mode::Open)),
            _ => refuse(
                StatusCode::BAD_REQUEST,
                "the query of /socket is not mode=closed or mode=open",
            ),
        },
        path => {
            let words =
                format!("there is no `{path:.40}`; there are /closed, /open, /state, /socket");
            refuse(StatusCode::NOT_FOUND, &words)
        }
    }
}

fn refused(refusal: &Refusal) -> Response<Bytes> {
    let mut response = respond(TEXT, format!("{}\n", refusal.words));
    *response.status_mut() = refusal.status;
    response
}
