//! What each request gets.
//!
//! [`Handler::answer`] maps the head of a request to its continuation: a response, a body to read
//! (`upload`) or a WebSocket (`socket`). It needs no network, and a request that it rejects leaves
//! the input unchanged.

use std::{fmt, net::IpAddr};

use endpoint::{
    Answer, ArrivalOutcome, Hosts, InvalidMessage, Mode, Output, Request, checksum,
    query::MAX_BYTES,
};
use hyper::{
    Method, Response, StatusCode, Version,
    body::Bytes,
    header::{self, HeaderMap},
    http::request::Parts,
};
use serde::Serialize;

use crate::{
    answer::{JSON, TEXT, as_json, message, respond},
    handler::Handler,
    openapi::{self, PATHS},
    origin, page,
    refusal::Refusal,
    session::Sender,
    socket,
    token::Pass,
    upload::Upload,
};

/// The header that carries a session's token.
const SESSION: &str = "webloop-session";

/// How a request continues after its head.
pub(crate) enum Reply {
    /// With this response only.
    Done(Response<Bytes>),
    /// With a body to read.
    Upload(Upload),
    /// With this response, then messages.
    Socket(Response<Bytes>, socket::Opening),
}

impl Handler {
    /// The continuation of a request whose head arrived at `now_ns`.
    pub(crate) fn answer(&mut self, head: &Parts, has_body: bool, now_ns: u64) -> Reply {
        self.try_answer(head, has_body, now_ns)
            .unwrap_or_else(|refusal| {
                self.refuse(refusal.kind());
                Reply::Done(refusal.response(has_body))
            })
    }

    fn try_answer(&mut self, head: &Parts, has_body: bool, now_ns: u64) -> Result<Reply, Refusal> {
        let query = check(head, &self.hosts)?;
        let path = head.uri.path();
        if head.method == Method::POST
            && let Some(upload) = self.upload(path, query, &head.headers, now_ns)?
        {
            return Ok(Reply::Upload(upload));
        }
        let wrong_method = || Refusal::Method {
            method: head.method.clone(),
            allowed: allowed(path),
        };
        // HEAD is not permitted either: a GET here moves the plant, and HEAD would do the same.
        let method = head.method.as_str();
        if PATHS.contains(&path) && !allowed(path).split(", ").any(|word| word == method) {
            return Err(wrong_method());
        }
        if has_body {
            return Err(Refusal::Body);
        }
        let response = match path {
            "/closed" => self.exchange(Mode::Closed, query, head, now_ns)?,
            "/open" => self.exchange(Mode::Open, query, head, now_ns)?,
            "/reset" => self.reset(query, head, now_ns)?,
            "/state" => self.observe(&head.headers, now_ns)?,
            "/health" => self.health(),
            "/openapi.json" => {
                let describe = || openapi::describe(Some(self.signals)).to_string().into();
                respond(JSON, self.description.get_or_init(describe).clone())
            }
            "/session" => as_json(&self.control.status(now_ns)),
            "/socket" => return self.socket(query, head, now_ns),
            path => match page::file(path, &head.headers) {
                Some(file) if head.method == Method::GET => file,
                Some(_) => return Err(wrong_method()),
                None => {
                    return Err(Refusal::Path {
                        path: path.chars().take(40).collect(),
                    });
                }
            },
        };
        Ok(Reply::Done(response))
    }

    /// Executes a command; `text` is its query.
    pub(crate) fn command(
        &mut self,
        mode: Mode,
        text: &str,
        sender: &Sender,
        now_ns: u64,
    ) -> Result<Told, Refusal> {
        let (text, is_signed) = checksum::checked(text, self.settings.check)?;
        let request: Request = text.parse()?;
        // In open loop nothing is applied, and a number will do.
        if mode == Mode::Closed || request.u.count() > 1 {
            request.check(self.inbox.inputs())?;
        }
        if mode == Mode::Closed && self.settings.max_age_ns.is_some() && request.t_send_ns.is_none()
        {
            return Err(InvalidMessage::Missing {
                field: "t_send_ns",
                expected: "u and t_send_ns, since this plant takes no old commands; and seq"
                    .to_owned(),
            }
            .into());
        }
        if self.control.command(sender, now_ns)? {
            self.inbox.welcome();
        }
        let output = self.output();
        let (row, answer) = self.inbox.command(mode, &request, output, now_ns);
        match row.outcome {
            ArrivalOutcome::Stale => self.refuse("stale"),
            ArrivalOutcome::Aged => self.refuse("aged"),
            ArrivalOutcome::Applied | ArrivalOutcome::Acknowledged => self.control.renew(now_ns),
        }
        self.publish();
        self.rows.record(row);
        if mode == Mode::Closed {
            finite(output)?;
        }
        Ok(Told { answer, is_signed })
    }

    /// Puts the plant back to rest, with no input.
    fn reset(
        &mut self,
        query: &str,
        head: &Parts,
        now_ns: u64,
    ) -> Result<Response<Bytes>, Refusal> {
        none(query)?;
        self.control.reset(&sender(head), now_ns)?;
        if !self.can_reset {
            return Err(Refusal::Reset);
        }
        self.inbox.reset();
        self.resets += 1;
        self.publish();
        let mut response = Response::new(Bytes::new());
        *response.status_mut() = StatusCode::NO_CONTENT;
        Ok(response)
    }

    /// Whether the plant's output is a number, and what was refused.
    fn health(&self) -> Response<Bytes> {
        let diverged = finite(self.output()).err();
        let mut text = match &diverged {
            None => "ok\n".to_owned(),
            Some(refusal) => format!("{refusal}\n"),
        };
        if !self.refusals.is_empty() {
            let kinds = self.refusals.iter();
            let kinds: Vec<String> = kinds
                .map(|(kind, count)| format!("{kind} {count}"))
                .collect();
            text += &format!("refused: {}\n", kinds.join(", "));
        }
        let mut response = respond(TEXT, text);
        if diverged.is_some() {
            *response.status_mut() = StatusCode::SERVICE_UNAVAILABLE;
        }
        response
    }

    fn exchange(
        &mut self,
        mode: Mode,
        query: &str,
        head: &Parts,
        now_ns: u64,
    ) -> Result<Response<Bytes>, Refusal> {
        let told = self.command(mode, query, &sender(head), now_ns)?;
        Ok(message(&told, &head.headers))
    }

    fn observe(&mut self, headers: &HeaderMap, now_ns: u64) -> Result<Response<Bytes>, Refusal> {
        // A page that waits for its start keeps its session by this. Clients without a session may read too.
        let _ = self.control.hear(&pass(headers), now_ns);
        let output = finite(self.output())?;
        Ok(message(
            &output.observed(self.inbox.input(), now_ns),
            headers,
        ))
    }

    fn socket(&mut self, query: &str, head: &Parts, now_ns: u64) -> Result<Reply, Refusal> {
        let (mode, pass) = socket::query(query)?;
        let response = socket::handshake(head)?;
        let session = self.control.open(&pass, now_ns)?;
        let over = self.over.subscribe();
        let opening = socket::Opening {
            mode,
            sender: Sender {
                pass,
                address: address(head),
            },
            session,
            over,
        };
        Ok(Reply::Socket(response, opening))
    }

    /// The upload of a POST, if its path has one, checked before its body is read.
    fn upload(
        &mut self,
        path: &str,
        query: &str,
        headers: &HeaderMap,
        now_ns: u64,
    ) -> Result<Option<Upload>, Refusal> {
        let upload = match path {
            "/session" => {
                none(query)?;
                Upload::Claim
            }
            "/session/rows" => {
                let chunk = chunk(query)?;
                let pass = pass(headers);
                self.control.hear(&pass, now_ns)?;
                Upload::Rows { chunk, pass }
            }
            "/session/end" => {
                none(query)?;
                let pass = pass(headers);
                if !self.control.has_ended(&pass) {
                    self.control.hear(&pass, now_ns)?;
                }
                Upload::End { pass }
            }
            _ => return Ok(None),
        };
        let expected = upload.kind();
        if !is_kind(headers, expected) {
            return Err(Refusal::Kind { expected });
        }
        Ok(Some(upload))
    }
}

/// Rejects all but plain requests to one host, its own, that do not come from a foreign page; returns the query.
fn check<'a>(head: &'a Parts, hosts: &Hosts) -> Result<&'a str, Refusal> {
    // `CONNECT host:port` and `GET http://host/path` are for proxies.
    if head.uri.authority().is_some() {
        return Err(Refusal::Target);
    }
    let given = head.headers.get_all(header::HOST);
    let count = given.iter().count();
    // HTTP/1.0 is older than this header (RFC 9112, 3.2).
    if count > 1 || (count == 0 && head.version != Version::HTTP_10) {
        return Err(Refusal::Host(count));
    }
    for host in given {
        hosts.check(host.as_bytes())?;
    }
    origin::check(&head.headers)?;
    let query = head.uri.query().unwrap_or_default();
    let bytes = head.uri.path().len().max(query.len());
    if bytes > MAX_BYTES {
        return Err(InvalidMessage::TooLong { bytes }.into());
    }
    Ok(query)
}

fn allowed(path: &str) -> &'static str {
    match path {
        "/session" => "GET, POST",
        "/session/rows" | "/session/end" | "/reset" => "POST",
        _ => "GET",
    }
}

fn none(query: &str) -> Result<(), Refusal> {
    let expected = "empty";
    query
        .is_empty()
        .then_some(())
        .ok_or(Refusal::Query { expected })
}

fn chunk(query: &str) -> Result<u64, Refusal> {
    let expected = "`chunk=N` with N counting from 0";
    query
        .strip_prefix("chunk=")
        .filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()))
        .and_then(|digits| digits.parse().ok())
        .ok_or(Refusal::Query { expected })
}

/// What a command gets.
#[derive(Serialize)]
#[serde(transparent)]
pub(crate) struct Told {
    answer: Answer,
    /// Whether the answer ends with a checksum, as the command did.
    #[serde(skip)]
    is_signed: bool,
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let answer = self.answer.to_string();
        f.write_str(&if self.is_signed {
            checksum::signed(&answer)
        } else {
            answer
        })
    }
}

/// Refuses an output that is no number.
fn finite(output: Output) -> Result<Output, Refusal> {
    if output.y.is_finite() {
        Ok(output)
    } else {
        Err(Refusal::Diverged { y: output.y })
    }
}

fn sender(head: &Parts) -> Sender {
    Sender {
        pass: pass(&head.headers),
        address: address(head),
    }
}

/// The other end of the connection, which `server` tells.
fn address(head: &Parts) -> IpAddr {
    let told = head.extensions.get::<IpAddr>();
    told.map_or(IpAddr::from([0, 0, 0, 0]), IpAddr::to_canonical)
}

fn pass(headers: &HeaderMap) -> Pass {
    let mut values = headers.get_all(SESSION).iter();
    match (values.next(), values.next()) {
        (None, _) => Pass::Nothing,
        (Some(value), None) => value.as_bytes().into(),
        (Some(_), Some(_)) => Pass::Unreadable,
    }
}

/// Whether the body has this type, regardless of parameters.
fn is_kind(headers: &HeaderMap, expected: &str) -> bool {
    headers
        .get(header::CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.split(';').next())
        .is_some_and(|kind| kind.trim().eq_ignore_ascii_case(expected))
}
