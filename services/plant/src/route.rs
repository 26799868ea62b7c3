//! What each request gets.
//!
//! [`Handler::answer`] maps the head of a request to its continuation: a response, a body to read
//! (`upload`, or a command in JSON) or a WebSocket (`socket`). It needs no network, and a request that it rejects leaves
//! the input unchanged.

use std::{fmt::Write, net::IpAddr};

use endpoint::http::{
    framing::Protocol,
    lines::{Lines, text},
    request::{Authority, Head},
};
use endpoint::{
    Answer, ArrivalOutcome, Hosts, InvalidMessage, Mode, NotServed, Output, Request, checksum,
    json, query::MAX_BYTES,
};
use hyper::{Method, Response, StatusCode, body::Bytes};
use serde::Serialize;

use crate::{
    answer::{AnswerForm, JSON, Short, TEXT, as_json, respond},
    conversation::{self, Opening},
    handler::Handler,
    handshake::{self, InvalidHandshake},
    openapi::{self, PATHS},
    origin, page,
    refusal::Refusal,
    session::Sender,
    token::Pass,
    upload::Upload,
};

/// The header that carries a session's token.
const SESSION: &str = "webloop-session";

/// How a request continues after its head.
pub(crate) enum Reply {
    /// With this message only.
    Short(Short),
    /// With this response only.
    Done(Box<Response<Bytes>>),
    /// With a body to read.
    Upload(Upload),
    /// With a body to read that is a command.
    Posted(Posted),
    /// With this response, then messages.
    Socket(Box<Response<Bytes>>, Box<Opening>),
}

/// A command that comes in a body.
pub(crate) struct Posted {
    mode: Mode,
    sender: Sender,
    form: AnswerForm,
}

impl Handler {
    /// The continuation of a request whose head arrived from `address` at `now_ns`.
    pub(crate) fn answer(&mut self, head: &Head<'_>, address: IpAddr, now_ns: u64) -> Reply {
        self.try_answer(head, address, now_ns)
            .unwrap_or_else(|refusal| {
                self.refuse(refusal.kind());
                Reply::Done(Box::new(if head.has_body() {
                    refusal.last_response()
                } else {
                    refusal.response()
                }))
            })
    }

    fn try_answer(
        &mut self,
        head: &Head<'_>,
        address: IpAddr,
        now_ns: u64,
    ) -> Result<Reply, Refusal> {
        let query = check(head, &self.hosts)?;
        let (method, path, lines) = (head.method, head.target.path, head.lines);
        let sender = || Sender {
            pass: pass(lines),
            address: address.to_canonical(),
        };
        if method == "POST" {
            if matches!(path, "/closed" | "/open") {
                return posted(path, query, lines, sender()).map(Reply::Posted);
            }
            if let Some(upload) = self.upload(path, query, lines, now_ns)? {
                return Ok(Reply::Upload(upload));
            }
        }
        // HEAD is not permitted either: a GET here moves the plant, and HEAD would do the same.
        if PATHS.contains(&path) && !allowed(path).split(", ").any(|word| word == method) {
            return Err(wrong_method(method, path));
        }
        if !PATHS.contains(&path) {
            return page(head);
        }
        if head.has_body() {
            return Err(Refusal::Body);
        }
        let response = match path {
            "/closed" | "/open" => {
                let told = self.command(mode(path), query, &sender(), now_ns)?;
                return Ok(Reply::Short(Short::new(&told, told.text(), lines)));
            }
            "/reset" => self.reset(query, &sender(), now_ns)?,
            "/state" => {
                none(query)?;
                return Ok(Reply::Short(self.observe(lines, now_ns)?));
            }
            "/health" => {
                none(query)?;
                self.health()
            }
            "/openapi.json" => {
                none(query)?;
                let describe = || openapi::describe(Some(self.signals)).to_string().into();
                respond(JSON, self.description.get_or_init(describe).clone())
            }
            "/session" => {
                none(query)?;
                as_json(&self.control.status(now_ns))
            }
            // An Upgrade in HTTP/1.0 is to be ignored (RFC 9110, 7.8).
            "/socket" if head.protocol == Protocol::Http10 => {
                return Err(InvalidHandshake { field: "HTTP/1.0" }.into());
            }
            "/socket" => return self.socket(query, lines, address, now_ns),
            // `PATHS` has no others.
            _ => return page(head),
        };
        Ok(Reply::Done(Box::new(response)))
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
        let answer = self.take(mode, &text.parse()?, sender, now_ns)?;
        Ok(Told { answer, is_signed })
    }

    /// Executes a command that is the body of a POST.
    pub(crate) fn posted(
        &mut self,
        posted: &Posted,
        body: &[u8],
        now_ns: u64,
    ) -> Result<Short, Refusal> {
        if self.settings.check {
            // An object has none.
            return Err(InvalidMessage::NoChecksum.into());
        }
        let request = json::request(body)?;
        let told = Told {
            answer: self.take(posted.mode, &request, &posted.sender, now_ns)?,
            is_signed: false,
        };
        Ok(Short::in_form(&told, told.text(), posted.form))
    }

    fn take(
        &mut self,
        mode: Mode,
        request: &Request,
        sender: &Sender,
        now_ns: u64,
    ) -> Result<Answer, Refusal> {
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
        self.inbox.hear(sender.address, self.control.since_ns());
        let output = self.output();
        let (row, answer) = self.inbox.command(mode, request, output, now_ns);
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
        Ok(answer)
    }

    /// Puts the plant back to rest, with no input.
    fn reset(
        &mut self,
        query: &str,
        sender: &Sender,
        now_ns: u64,
    ) -> Result<Response<Bytes>, Refusal> {
        none(query)?;
        self.control.reset(sender, now_ns)?;
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

    fn observe(&mut self, lines: Lines<'_>, now_ns: u64) -> Result<Short, Refusal> {
        // A page that waits for its start keeps its session by this. Clients without a session may read too.
        let _ = self.control.hear(&pass(lines), now_ns);
        let output = finite(self.output())?;
        let observation = output.observed(self.inbox.input(), now_ns);
        Ok(Short::new(&observation, observation.to_string(), lines))
    }

    fn socket(
        &mut self,
        query: &str,
        lines: Lines<'_>,
        address: IpAddr,
        now_ns: u64,
    ) -> Result<Reply, Refusal> {
        let (mode, pass) = conversation::query(query)?;
        let response = handshake::response(lines)?;
        let opening = self.converses(mode, pass, address, now_ns)?;
        Ok(Reply::Socket(Box::new(response), Box::new(opening)))
    }

    /// Lets a connection carry the commands of a loop.
    pub(crate) fn converses(
        &mut self,
        mode: Mode,
        pass: Pass,
        address: IpAddr,
        now_ns: u64,
    ) -> Result<Opening, Refusal> {
        let session = self.control.open(&pass, now_ns)?;
        Ok(Opening {
            mode,
            sender: Sender {
                pass,
                address: address.to_canonical(),
            },
            session,
            over: self.over.subscribe(),
        })
    }

    /// The upload of a POST, if its path has one, checked before its body is read.
    fn upload(
        &mut self,
        path: &str,
        query: &str,
        lines: Lines<'_>,
        now_ns: u64,
    ) -> Result<Option<Upload>, Refusal> {
        let upload = match path {
            "/session" => {
                none(query)?;
                Upload::Claim
            }
            "/session/rows" => {
                let chunk = chunk(query)?;
                let pass = pass(lines);
                self.control.hear(&pass, now_ns)?;
                Upload::Rows { chunk, pass }
            }
            "/session/end" => {
                none(query)?;
                let pass = pass(lines);
                if !self.control.has_ended(&pass) {
                    self.control.hear(&pass, now_ns)?;
                }
                Upload::End { pass }
            }
            _ => return Ok(None),
        };
        let expected = upload.kind();
        if !is_kind(lines, expected) {
            return Err(Refusal::Kind { expected });
        }
        Ok(Some(upload))
    }
}

/// Rejects all but plain requests to one host, its own, that do not come from a foreign page; returns the query.
fn check<'a>(head: &Head<'a>, hosts: &Hosts) -> Result<&'a str, Refusal> {
    let target = head.target;
    let count = head.lines.all("host").count();
    // HTTP/1.0 is older than this header (RFC 9112, 3.2). It may look, as a health check does; where a request
    // changes something, its host is to be known.
    let may_lack = head.protocol == Protocol::Http10 && !changes(head.method, target.path);
    if count > 1 || (count == 0 && !may_lack) {
        return Err(Refusal::Host(count));
    }
    let named = head.lines.first("host");
    let host = match target.authority {
        Authority::Absent => named,
        Authority::Proxys => return Err(Refusal::Target),
        Authority::Http(host) => {
            if hosts.check(host.as_bytes()).is_err() {
                return Err(Refusal::Target);
            }
            // It counts in place of `Host`, which must be a host all the same (RFC 9112, 3.2 and 3.2.2).
            if let Some(Err(problem @ NotServed::Malformed)) = named.map(|named| hosts.check(named))
            {
                return Err(problem.into());
            }
            Some(host.as_bytes())
        }
    };
    if let (Authority::Absent, Some(host)) = (target.authority, host) {
        hosts.check(host)?;
    }
    origin::check(head.lines, host)?;
    let query = target.query;
    let bytes = target.path.len().max(query.len());
    if bytes > MAX_BYTES {
        return Err(InvalidMessage::TooLong { bytes }.into());
    }
    Ok(query)
}

/// A file of the page, or why there is none.
fn page(head: &Head<'_>) -> Result<Reply, Refusal> {
    let (method, path) = (head.method, head.target.path);
    let Some(file) = page::file(path, head.lines) else {
        return Err(Refusal::Path {
            path: path.chars().take(40).collect(),
        });
    };
    if method != "GET" {
        return Err(wrong_method(method, path));
    }
    if head.has_body() {
        return Err(Refusal::Body);
    }
    Ok(Reply::Done(Box::new(file)))
}

fn wrong_method(method: &str, path: &str) -> Refusal {
    Refusal::Method {
        method: Method::from_bytes(method.as_bytes()).unwrap_or_default(),
        allowed: allowed(path),
    }
}

/// Whether a request does more than look.
fn changes(method: &str, path: &str) -> bool {
    method != "GET" || matches!(path, "/closed" | "/open" | "/socket")
}

fn allowed(path: &str) -> &'static str {
    match path {
        "/closed" | "/open" => "GET, POST",
        "/session" => "GET, POST",
        "/session/rows" | "/session/end" | "/reset" => "POST",
        _ => "GET",
    }
}

/// The mode of a command that comes this way.
fn mode(path: &str) -> Mode {
    if path == "/open" {
        Mode::Open
    } else {
        Mode::Closed
    }
}

/// The command of a POST, checked before its body is read.
fn posted(path: &str, query: &str, lines: Lines<'_>, sender: Sender) -> Result<Posted, Refusal> {
    if !query.is_empty() {
        let expected = "empty, and a POST has its command in a body of JSON";
        return Err(Refusal::Query { expected });
    }
    if !is_kind(lines, JSON) {
        return Err(Refusal::Kind { expected: JSON });
    }
    Ok(Posted {
        mode: mode(path),
        sender,
        form: AnswerForm::of(lines),
    })
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

impl Told {
    /// Room for most answers, so that a text that grows is not moved.
    const BYTES: usize = 160;

    /// The answer as a query.
    pub(crate) fn text(&self) -> String {
        let mut answer = String::with_capacity(Self::BYTES);
        // Writing to a String does not fail.
        let _ = write!(answer, "{}", self.answer);
        if self.is_signed {
            checksum::signed(&answer)
        } else {
            answer
        }
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

fn pass(lines: Lines<'_>) -> Pass {
    let mut values = lines.all(SESSION);
    match (values.next(), values.next()) {
        (None, _) => Pass::Nothing,
        (Some(value), None) => value.into(),
        (Some(_), Some(_)) => Pass::Unreadable,
    }
}

/// Whether the body has this type, regardless of parameters.
fn is_kind(lines: Lines<'_>, expected: &str) -> bool {
    lines
        .first("content-type")
        .and_then(text)
        .and_then(|value| value.split(';').next())
        .is_some_and(|kind| kind.trim().eq_ignore_ascii_case(expected))
}
