//! One connection: reads requests, sends answers, and gives up on a peer that does neither.
//!
//! It speaks HTTP/1.1 by itself, on top of `head` and `body`. A general server keeps two buffers of 8 KiB for each
//! connection, serves what is pipelined without a pause, waits for ever for a peer that does not read, and hides
//! how a length was written. Here a connection that has sent nothing has no buffer, and no step takes longer
//! than [`WITHIN`].

use std::{
    cell::{Cell, RefCell},
    io::{self, ErrorKind},
    rc::Rc,
    time::{Duration, SystemTime},
};

use hyper::{Method, Response, StatusCode, Version, body::Bytes, header};
use pace::now_ns;
use rustix::net::sockopt::set_socket_recv_buffer_size;
use tokio::{
    io::AsyncWriteExt,
    net::TcpStream,
    task,
    time::{Instant, timeout, timeout_at},
};

use crate::{
    body::Body,
    handler::Handler,
    head::{self, Framing, Head},
    place::Place,
    refusal::Refusal,
    route::Reply,
    socket,
    turn::{Turn, Turns},
    upload::{self, Upload},
};

/// How long each step may take: waiting for a request, its head, its body, sending the answer. Clients must close
/// idle connections earlier, or a request could be sent just as the plant closes its connection.
///
/// Where others of the same peer move the plant, one may be idle for twice as long: a controller keeps those that
/// it needed when its link stood still, and the request on one may be under way for that long again.
pub(crate) const WITHIN: Duration = Duration::from_secs(5);

/// How long the other end has to read why the connection is closed, and how much of what it still sends is
/// discarded meanwhile: closing earlier would lose the reason.
pub(crate) const LINGER: Duration = Duration::from_secs(1);
const LINGER_BYTES: usize = 256 * 1024;

/// How much of it is discarded at a time.
const DISCARD_BYTES: usize = 32 * 1024;

/// How much room is made at a time for what arrives.
const ROOM: usize = 1024;

/// The most bytes of bodies that are being read, over all connections.
const BODIES_BYTES: usize = 8 * 1024 * 1024;

/// What all connections share.
pub(crate) struct Shared {
    pub(crate) handler: Rc<RefCell<Handler>>,
    pub(crate) turns: Turns,
    /// The bytes of bodies that are being read.
    pub(crate) bodies: Cell<usize>,
}

impl Shared {
    pub(crate) fn new(handler: Rc<RefCell<Handler>>) -> Self {
        Self {
            handler,
            turns: Turns::new(),
            bodies: Cell::new(0),
        }
    }
}

/// A connection with what has arrived on it and is not taken yet.
struct Connection {
    stream: TcpStream,
    bytes: Vec<u8>,
}

/// Serves a connection to its end.
pub(crate) async fn serve(stream: TcpStream, shared: &Rc<Shared>, place: &Place) {
    // Answers are one small segment each: waiting for more data would add the other end's delayed
    // acknowledgement, 40 ms. If this call fails, the connection is already broken, and serving it
    // will show that.
    let _ = stream.set_nodelay(true);
    let mut connection = Connection {
        stream,
        bytes: Vec::new(),
    };
    // If a connection ends badly, only its client is affected, and the client's rows show it.
    match connection.converse(shared, place).await {
        Ok(Some(opening)) => {
            let Connection { stream, bytes } = connection;
            return Box::pin(socket::serve(stream, bytes, opening, shared, place)).await;
        }
        Ok(None) => {}
        Err(error) => tracing::debug!(%error, "connection ended"),
    }
    // In turn, for it takes time to throw away what was not read.
    let mut turn = shared.turns.wait(place).await;
    drop(connection);
    turn.end().await;
}

impl Connection {
    /// Answers requests until the last one; returns the opening of a socket, if it becomes one.
    async fn converse(
        &mut self,
        shared: &Rc<Shared>,
        place: &Place,
    ) -> io::Result<Option<socket::Opening>> {
        // For the lease.
        let peer = self.stream.peer_addr()?.ip();
        loop {
            let (mut head, mut turn) = match self.head(shared, place).await? {
                Asked::Request(head, turn) => (head, turn),
                Asked::Nothing => return Ok(None),
                Asked::Wrong(refusal) => {
                    shared.handler.borrow_mut().refuse(refusal.kind());
                    let refused = written(&refusal.response(true), Version::HTTP_11, false, false);
                    let mut turn = shared.turns.wait(place).await;
                    self.part(&refused, &mut turn, shared, place).await;
                    return Ok(None);
                }
            };
            let now_ns = now_ns();
            head.parts.extensions.insert(peer);
            let has_body = head.framing.length != head::Length::Bytes(0);
            let reply = shared
                .handler
                .borrow_mut()
                .answer(&head.parts, has_body, now_ns);
            let is_head = head.parts.method == Method::HEAD;
            let is_command = matches!(head.parts.uri.path(), "/closed" | "/open");
            let version = head.parts.version;
            drop(head.parts);
            let (response, is_unread) = match reply {
                Reply::Done(response) => (response, has_body),
                Reply::Upload(upload) => {
                    turn.end().await;
                    let done = Box::pin(self.upload(upload, head.framing, shared)).await?;
                    turn = shared.turns.wait(place).await;
                    done
                }
                Reply::Socket(response, opening) => {
                    let text = written(&response, version, true, false);
                    self.send(&text, &mut turn).await?;
                    place.on_answer();
                    return Ok(Some(opening));
                }
            };
            if is_command && response.status() == StatusCode::OK {
                place.on_command(now_ns);
            }
            let closes = response.headers().get(header::CONNECTION);
            let keeps =
                head.framing.keeps && !is_unread && closes.is_none_or(|word| word != "close");
            let text = written(&response, version, keeps, is_head);
            drop(response);
            if !keeps {
                self.part(&text, &mut turn, shared, place).await;
                return Ok(None);
            }
            self.send(&text, &mut turn).await?;
            place.on_answer();
        }
    }

    /// The next request's head, in its turn.
    async fn head<'a>(&mut self, shared: &'a Shared, place: &Place) -> io::Result<Asked<'a>> {
        let mut until = Instant::now() + WITHIN;
        let idle_until = until + WITHIN;
        let mut is_begun = false;
        loop {
            if !self.bytes.is_empty() {
                if !is_begun {
                    is_begun = true;
                    until = Instant::now() + WITHIN;
                }
                let mut turn = shared.turns.wait(place).await;
                match head::read(&self.bytes) {
                    Ok(Some(head)) => {
                        self.bytes.drain(..head.bytes);
                        return Ok(Asked::Request(head, turn));
                    }
                    Ok(None) => turn.end().await,
                    Err(malformed) => return Ok(Asked::Wrong(malformed.into())),
                }
            }
            match timeout_at(until, self.more()).await {
                Ok(Ok(true)) => {}
                Ok(Ok(false)) => return Ok(Asked::Nothing),
                Ok(Err(error)) => return Err(error),
                Err(_) if !is_begun && until < idle_until && is_beside_control(place) => {
                    until = idle_until;
                }
                Err(_) if is_begun => {
                    let refusal = Refusal::Slow {
                        part: "head",
                        seconds: WITHIN.as_secs(),
                    };
                    return Ok(Asked::Wrong(refusal));
                }
                Err(_) => return Ok(Asked::Nothing),
            }
        }
    }

    /// Reads the body of an upload and executes it; also whether some of the body is unread.
    async fn upload(
        &mut self,
        upload: Upload,
        framing: Framing,
        shared: &Rc<Shared>,
    ) -> io::Result<(Response<Bytes>, bool)> {
        let limit = upload.limit();
        if framing.waits && self.bytes.is_empty() {
            let word = b"HTTP/1.1 100 Continue\r\n\r\n";
            within(self.stream.write_all(word)).await?;
        }
        let body = Body::new(framing.length, limit);
        let mut held = Held(&shared.bodies, 0);
        let read = match body {
            Ok(body) => {
                let read = timeout(WITHIN, self.body(body, &mut held)).await;
                read.unwrap_or(Err(Refusal::Slow {
                    part: "body",
                    seconds: WITHIN.as_secs(),
                }))
            }
            Err(refusal) => Err(refusal),
        };
        match read {
            Ok(bytes) => {
                // In a task of its own, so that it is completed even if its connection breaks.
                let handler = Rc::clone(&shared.handler);
                let done = task::spawn_local(upload::run(upload, bytes.into(), handler));
                let response = done.await.map_err(io::Error::other)?;
                Ok((response, false))
            }
            Err(refusal) => {
                shared.handler.borrow_mut().refuse(refusal.kind());
                Ok((refusal.response(true), true))
            }
        }
    }

    async fn body(&mut self, mut body: Body, held: &mut Held<'_>) -> Result<Vec<u8>, Refusal> {
        while !body.take(&mut self.bytes)? {
            held.set(body.held() + self.bytes.len())?;
            match self.more().await {
                Ok(true) => {}
                Ok(false) | Err(_) => return Err(Refusal::Broken),
            }
        }
        Ok(body.into_bytes())
    }

    /// Waits until more has arrived; whether there will be more.
    async fn more(&mut self) -> io::Result<bool> {
        if self.bytes.is_empty() {
            // It may be long until there is more.
            self.bytes = Vec::new();
        }
        loop {
            // Room is made only for what is there.
            self.stream.readable().await?;
            self.bytes.reserve(ROOM / 2);
            match self.stream.try_read_buf(&mut self.bytes) {
                Ok(read) => return Ok(read > 0),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Sends an answer; what does not fit into the socket, after the turn.
    async fn send(&mut self, text: &[u8], turn: &mut Turn<'_>) -> io::Result<()> {
        let sent = self.stream.try_write(text).unwrap_or(0);
        turn.on_bytes(text.len());
        turn.end().await;
        if sent == text.len() {
            return Ok(());
        }
        within(self.stream.write_all(&text[sent..])).await
    }

    /// Sends the last answer, and lets the other end read it.
    async fn part(&mut self, text: &[u8], turn: &mut Turn<'_>, shared: &Shared, place: &Place) {
        if self.send(text, turn).await.is_ok() {
            self.bytes = Vec::new();
            Box::pin(linger(&mut self.stream, &shared.turns, place)).await;
        }
    }
}

/// Whether the peer has moved the plant over another connection meanwhile.
fn is_beside_control(place: &Place) -> bool {
    let since_ns = now_ns().saturating_sub(place.peer_commanded_ns());
    place.peer_commanded_ns() > 0 && Duration::from_nanos(since_ns) < WITHIN
}

/// What a connection asks.
enum Asked<'a> {
    Request(Head, Turn<'a>),
    /// The other end is gone, or it has been silent for too long.
    Nothing,
    Wrong(Refusal),
}

/// The bytes of one body, counted among those of all.
struct Held<'a>(&'a Cell<usize>, usize);

impl Held<'_> {
    fn set(&mut self, bytes: usize) -> Result<(), Refusal> {
        let all = self.0.get() - self.1 + bytes;
        self.0.set(all);
        self.1 = bytes;
        if all > BODIES_BYTES {
            return Err(Refusal::Bodies);
        }
        Ok(())
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.0.set(self.0.get() - self.1);
    }
}

/// Ends what we send, and reads what the other end still sends.
pub(crate) async fn linger(stream: &mut TcpStream, turns: &Turns, place: &Place) {
    let rest = async {
        stream.shutdown().await?;
        // The kernel need not keep what is discarded.
        set_socket_recv_buffer_size(&*stream, DISCARD_BYTES)?;
        let mut left = LINGER_BYTES;
        while left > 0 {
            stream.readable().await?;
            let mut turn = turns.wait(place).await;
            let read = stream.try_read_buf(&mut Vec::with_capacity(DISCARD_BYTES));
            turn.on_bytes(read.as_ref().map_or(0, |read| *read));
            turn.end().await;
            match read {
                Ok(0) => break,
                Ok(read) => left = left.saturating_sub(read),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
        io::Result::Ok(())
    };
    // It does not matter whether the other end listens.
    let _ = timeout(LINGER, rest).await;
}

async fn within(sent: impl Future<Output = io::Result<()>>) -> io::Result<()> {
    timeout(WITHIN, sent).await.unwrap_or_else(|_| {
        Err(io::Error::new(
            ErrorKind::TimedOut,
            "the client does not read",
        ))
    })
}

/// An answer as it is sent.
fn written(response: &Response<Bytes>, version: Version, keeps: bool, is_head: bool) -> Vec<u8> {
    let (status, body) = (response.status(), response.body());
    let mut text = Vec::with_capacity(256 + body.len());
    let is_new = version == Version::HTTP_11;
    let minor = u8::from(is_new);
    let reason = status.canonical_reason().unwrap_or_default();
    let mut line = |name: &str, value: &[u8]| {
        text.extend_from_slice(name.as_bytes());
        text.extend_from_slice(value);
        text.extend_from_slice(b"\r\n");
    };
    line(
        &format!("HTTP/1.{minor} {} ", status.as_str()),
        reason.as_bytes(),
    );
    for (name, value) in response.headers() {
        line(&format!("{name}: "), value.as_bytes());
    }
    let has_length = !status.is_informational() && status != StatusCode::NO_CONTENT;
    if has_length {
        line("content-length: ", body.len().to_string().as_bytes());
    }
    let says = response.headers().contains_key(header::CONNECTION);
    match (keeps, is_new) {
        (false, true) if !says => line("connection: ", b"close"),
        (true, false) => line("connection: ", b"keep-alive"),
        _ => {}
    }
    line("date: ", date().as_bytes());
    text.extend_from_slice(b"\r\n");
    if !is_head {
        text.extend_from_slice(body);
    }
    text
}

/// The time of day, written once a second.
fn date() -> Rc<str> {
    thread_local! {
        static DATE: RefCell<(u64, Rc<str>)> = RefCell::new((u64::MAX, "".into()));
    }
    let now = SystemTime::now();
    let s = now
        .duration_since(SystemTime::UNIX_EPOCH)
        .map_or(0, |since| since.as_secs());
    DATE.with_borrow_mut(|(of_s, text)| {
        if *of_s != s {
            (*of_s, *text) = (s, httpdate::fmt_http_date(now).into());
        }
        Rc::clone(text)
    })
}
