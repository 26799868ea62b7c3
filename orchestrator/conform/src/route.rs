//! What each HTTP request gets: the paths that the contract names, with the plant's own strictness.
//!
//! There are no sessions, pages or uploads, which are for controllers in a browser.

use endpoint::Mode;
use endpoint::http::framing::{Afterwards, Protocol};
use endpoint::http::request::{Authority, Head};
use hyper::body::Bytes;
use hyper::{Response, StatusCode};
use plant::answer::{TEXT, message, respond, written};
use plant::handshake;

use crate::exchange::{Exchange, Refusal};

/// What a request gets.
#[derive(Debug)]
pub(crate) struct Reply {
    /// The answer as it is sent.
    pub(crate) text: Vec<u8>,
    /// When it is, ns.
    pub(crate) at_ns: u64,
    pub(crate) then: Then,
}

/// What becomes of a connection after an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Then {
    /// Another request may follow.
    Request,
    /// It is closed.
    End,
    /// It becomes a WebSocket.
    Socket(Mode),
}

/// What a request asks for.
enum Wanted {
    Message(Mode),
    State,
    Socket(Mode),
    Health,
}

/// The reply to a request whose head arrived at `now_ns`.
pub(crate) fn reply(
    exchange: &mut Exchange,
    head: &Head<'_>,
    connection: u64,
    now_ns: u64,
) -> Reply {
    let (mut at_ns, mut then) = (exchange.released_ns(now_ns), Then::Request);
    let response = match asked(head) {
        Ok(Wanted::Message(mode)) => {
            let said = exchange.message(mode, head.target.query, connection, now_ns);
            at_ns = said.at_ns;
            if said.is_last {
                then = Then::End;
            }
            match &said.answer {
                Ok(answer) => message(answer, head.lines),
                Err(refusal) => refused(refusal),
            }
        }
        Ok(Wanted::State) => message(&exchange.observe(now_ns), head.lines),
        Ok(Wanted::Health) => respond(TEXT, "ok\n"),
        Ok(Wanted::Socket(mode)) => match handshake::response(head.lines) {
            Ok(response) => {
                then = Then::Socket(mode);
                response
            }
            Err(problem) => {
                let words = problem.to_string();
                exchange.heard.refuse(&words);
                refused(&Refusal::new(StatusCode::UPGRADE_REQUIRED, words))
            }
        },
        Err(refusal) => {
            exchange.heard.refuse(&refusal.words);
            refused(&refusal)
        }
    };
    // A body is not read, and what follows a HEAD's answer would be taken for the next.
    let is_torn = head.has_body() || head.method == "HEAD";
    let told = if is_torn {
        Afterwards::Close
    } else {
        head.framing.then
    };
    if told == Afterwards::Close && then == Then::Request {
        then = Then::End;
    }
    Reply {
        text: written(&response, head.protocol, told),
        at_ns,
        then,
    }
}

fn asked(head: &Head<'_>) -> Result<Wanted, Refusal> {
    let refuse = |status, words: &str| Err(Refusal::new(status, words));
    if head.target.authority != Authority::Absent {
        return refuse(
            StatusCode::BAD_REQUEST,
            "the request target is not a path; this is a plant, not a proxy",
        );
    }
    let hosts = head.lines.all("host").count();
    if hosts > 1 || (hosts == 0 && head.protocol == Protocol::Http11) {
        return refuse(
            StatusCode::BAD_REQUEST,
            "the request has not exactly one Host header",
        );
    }
    if head.method != "GET" {
        let words = format!("method {} is not served; use GET", head.method);
        return refuse(StatusCode::METHOD_NOT_ALLOWED, &words);
    }
    if head.has_body() {
        return refuse(
            StatusCode::PAYLOAD_TOO_LARGE,
            "the request has a body; a command is a query and has none",
        );
    }
    match head.target.path {
        "/closed" => Ok(Wanted::Message(Mode::Closed)),
        "/open" => Ok(Wanted::Message(Mode::Open)),
        "/state" => Ok(Wanted::State),
        "/health" => Ok(Wanted::Health),
        "/socket" => match head.target.query {
            "mode=closed" => Ok(Wanted::Socket(Mode::Closed)),
            "mode=open" => Ok(Wanted::Socket(Mode::Open)),
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

pub(crate) fn refused(refusal: &Refusal) -> Response<Bytes> {
    let mut response = respond(TEXT, format!("{}\n", refusal.words));
    *response.status_mut() = refusal.status;
    response
}
