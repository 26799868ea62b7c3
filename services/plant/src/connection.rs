//! One connection: reads requests, sends answers, and gives up on a peer that does neither.
//!
//! It speaks HTTP/1.1 by itself, on top of the crate `http`. A general server keeps two buffers of 8 KiB for each
//! connection, serves what is pipelined without a pause, waits for ever for a peer that does not read, and hides
//! how a length was written. Here a connection that has sent nothing has no buffer, and no step takes longer
//! than [`WITHIN`].

use std::{
    cell::{Cell, RefCell},
    future::poll_fn,
    io::{self, ErrorKind},
    mem::MaybeUninit,
    net::IpAddr,
    ops::ControlFlow,
    pin::Pin,
    rc::Rc,
    task::{Context, Poll, ready},
    time::Duration,
};

use clock::{now::now_ns, patience::Patience};
use endpoint::http::{
    body::Body,
    framing::{Afterwards, Protocol, Rest},
    lines,
    request::{self, Framing, Malformed},
};
use endpoint::query::MAX_BYTES;
use hyper::{Response, body::Bytes, header};
use tokio::{
    io::{AsyncRead, AsyncWriteExt, ReadBuf},
    net::TcpStream,
    task,
    time::{Instant, timeout},
};

use crate::{
    answer::written,
    conversation::Opening,
    handler::Handler,
    line,
    place::Place,
    refusal::Refusal,
    route::{Posted, Reply},
    shared::{Shared, WITHIN},
    socket,
    turn::Turn,
    upload::{self, Upload},
};

/// How much is taken at a time of what arrives.
const ROOM: usize = 4096;

/// The most bytes of bodies that are being read, over all connections.
const BODIES_BYTES: usize = 8 * 1024 * 1024;

/// A connection with what has arrived on it and is not taken yet.
struct Connection {
    stream: TcpStream,
    /// The other end.
    peer: IpAddr,
    bytes: Vec<u8>,
    patience: Patience,
}

/// Serves a connection from `peer` to its end.
pub(crate) async fn serve(stream: TcpStream, peer: IpAddr, shared: &Rc<Shared>, place: &Place) {
    // Answers are one small segment each: waiting for more data would add the other end's delayed
    // acknowledgement, 40 ms. If this call fails, the connection is already broken, and serving it
    // will show that.
    let _ = stream.set_nodelay(true);
    let mut connection = Connection {
        stream,
        peer,
        bytes: Vec::new(),
        patience: Patience::default(),
    };
    // If a connection ends badly, only its client is affected, and the client's rows show it.
    match connection.converse(shared, place).await {
        Ok(Some(Becomes::Socket(opening))) => {
            let Connection { stream, bytes, .. } = connection;
            return Box::pin(socket::serve(stream, bytes, opening, shared, place)).await;
        }
        Ok(Some(Becomes::Lines)) => {
            let Connection { stream, bytes, .. } = connection;
            return Box::pin(line::serve(stream, bytes, peer, shared, place)).await;
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
    /// Answers requests until the last one; returns what the connection becomes, if that is another than HTTP's.
    async fn converse(
        &mut self,
        shared: &Rc<Shared>,
        place: &Place,
    ) -> io::Result<Option<Becomes>> {
        let mut is_first = true;
        loop {
            let (asked, turn) = match self.head(shared, place).await? {
                Next::Request(asked, turn) => (asked, turn),
                Next::Nothing => return Ok(None),
                // Only at its beginning: what follows a request is for who sent that.
                Next::Wrong(_) if is_first && line::begins(&self.bytes) => {
                    return Ok(Some(Becomes::Lines));
                }
                Next::Wrong(refusal) => {
                    self.refuse(&refusal, shared, place).await;
                    return Ok(None);
                }
            };
            is_first = false;
            if let ControlFlow::Break(becomes) = self.answer(asked, turn, shared, place).await? {
                return Ok(becomes);
            }
        }
    }

    /// Answers a request in its turn; whether it was the last, and what the connection becomes then.
    async fn answer(
        &mut self,
        asked: Served,
        mut turn: Turn<'_>,
        shared: &Rc<Shared>,
        place: &Place,
    ) -> io::Result<ControlFlow<Option<Becomes>>> {
        let Served {
            reply,
            framing,
            protocol,
            is_head,
            has_body,
            commanded_ns,
        } = asked;
        let (response, is_unread) = match reply {
            Reply::Short(short) => {
                if let Some(now_ns) = commanded_ns {
                    place.on_command(now_ns);
                }
                let (text, then) = (short.written(protocol, framing.then), framing.then);
                return self.reply(&text, then, &mut turn, shared, place).await;
            }
            Reply::Done(response) => (*response, has_body),
            Reply::Posted(posted) => {
                turn.end().await;
                let posted = self.posted(posted, framing, protocol, shared, place);
                let (text, then, mut turn) = Box::pin(posted).await?;
                return self.reply(&text, then, &mut turn, shared, place).await;
            }
            Reply::Upload(upload) => {
                turn.end().await;
                let done = Box::pin(self.upload(upload, framing, shared)).await?;
                turn = shared.turns.wait(place).await;
                done
            }
            Reply::Socket(response, opening) => {
                let text = written(&response, protocol, Afterwards::Keep);
                self.send(&text, &mut turn).await?;
                place.on_answer();
                return Ok(ControlFlow::Break(Some(Becomes::Socket(*opening))));
            }
        };
        let closes = response.headers().get(header::CONNECTION);
        let is_last = is_unread || closes.is_some_and(|word| word == "close");
        let then = if is_last {
            Afterwards::Close
        } else {
            framing.then
        };
        let mut text = written(&response, protocol, then);
        if is_head {
            text.truncate(text.len() - response.body().len());
        }
        drop(response);
        self.reply(&text, then, &mut turn, shared, place).await
    }

    /// Sends an answer; whether it was the last.
    async fn reply(
        &mut self,
        text: &[u8],
        then: Afterwards,
        turn: &mut Turn<'_>,
        shared: &Shared,
        place: &Place,
    ) -> io::Result<ControlFlow<Option<Becomes>>> {
        if then == Afterwards::Close {
            self.part(text, turn, shared, place).await;
            return Ok(ControlFlow::Break(None));
        }
        self.send(text, turn).await?;
        place.on_answer();
        Ok(ControlFlow::Continue(()))
    }

    /// Refuses what is no request, and with it the connection.
    async fn refuse(&mut self, refusal: &Refusal, shared: &Shared, place: &Place) {
        shared.handler.borrow_mut().refuse(refusal.kind());
        let response = refusal.last_response();
        let text = written(&response, Protocol::Http11, Afterwards::Close);
        let mut turn = shared.turns.wait(place).await;
        self.part(&text, &mut turn, shared, place).await;
    }

    /// The next request, in its turn, when its head is whole.
    async fn head<'a>(&mut self, shared: &'a Shared, place: &Place) -> io::Result<Next<'a>> {
        let mut until = Instant::now() + WITHIN;
        let idle_until = until + WITHIN;
        let mut is_begun = false;
        loop {
            if !self.bytes.is_empty() {
                let mut turn = shared.turns.wait(place).await;
                match self.take(&shared.handler, Rest::MayCome) {
                    Ok(Some(asked)) => return Ok(Next::Request(asked, turn)),
                    Ok(None) => turn.end().await,
                    Err(malformed) => return Ok(Next::Wrong(malformed.into())),
                }
                if !is_begun {
                    is_begun = true;
                    until = Instant::now() + WITHIN;
                }
            }
            match self.more_before(until).await {
                Some(Ok(true)) => {}
                Some(Ok(false)) => return Ok(Next::Nothing),
                Some(Err(error)) => return Err(error),
                None if !is_begun && until < idle_until && is_beside_control(place) => {
                    until = idle_until;
                }
                None if is_begun => {
                    let turn = shared.turns.wait(place).await;
                    if let Ok(Some(asked)) = self.take(&shared.handler, Rest::IsMissing) {
                        return Ok(Next::Request(asked, turn));
                    }
                    drop(turn);
                    let refusal = Refusal::Slow {
                        part: "head",
                        seconds: WITHIN.as_secs(),
                    };
                    return Ok(Next::Wrong(refusal));
                }
                None => return Ok(Next::Nothing),
            }
        }
    }

    /// Takes the next head, if it is whole, and what its request gets.
    fn take(
        &mut self,
        handler: &RefCell<Handler>,
        rest: Rest,
    ) -> Result<Option<Served>, Malformed> {
        let mut room = lines::room();
        let Some(head) = request::read(&self.bytes, &mut room)? else {
            return Ok(None);
        };
        let behind = &self.bytes[head.bytes..];
        let Some(head) = head.settled(behind, rest) else {
            return Ok(None);
        };
        let now_ns = now_ns();
        let mut handler = handler.borrow_mut();
        let asked = Served {
            reply: handler.answer(&head, self.peer, now_ns),
            commanded_ns: matches!(head.target.path, "/closed" | "/open").then_some(now_ns),
            framing: head.framing,
            has_body: head.has_body(),
            protocol: head.protocol,
            is_head: head.method == "HEAD",
        };
        let bytes = head.bytes;
        self.bytes.drain(..bytes);
        Ok(Some(asked))
    }

    /// Reads the body of an upload and executes it; also whether some of the body is unread.
    async fn upload(
        &mut self,
        upload: Upload,
        framing: Framing,
        shared: &Rc<Shared>,
    ) -> io::Result<(Response<Bytes>, bool)> {
        match self.read_body(framing, upload.limit(), shared).await? {
            Ok(bytes) => {
                // In a task of its own, so that it is completed even if its connection breaks.
                let handler = Rc::clone(&shared.handler);
                let done = task::spawn_local(upload::run(upload, bytes.into(), handler));
                let response = done.await.map_err(io::Error::other)?;
                Ok((response, false))
            }
            Err(refusal) => {
                shared.handler.borrow_mut().refuse(refusal.kind());
                Ok((refusal.last_response(), true))
            }
        }
    }

    /// Reads the body of a command and executes it; what is answered, what becomes of the connection then, and the turn
    /// in which that was done.
    async fn posted<'a>(
        &mut self,
        posted: Posted,
        framing: Framing,
        protocol: Protocol,
        shared: &'a Shared,
        place: &Place,
    ) -> io::Result<(Vec<u8>, Afterwards, Turn<'a>)> {
        let read = self.read_body(framing, MAX_BYTES, shared).await?;
        let turn = shared.turns.wait(place).await;
        let (now_ns, is_read) = (now_ns(), read.is_ok());
        let mut handler = shared.handler.borrow_mut();
        let done = read.and_then(|body| handler.posted(&posted, &body, now_ns));
        let (text, then) = match done {
            Ok(short) => {
                place.on_command(now_ns);
                (short.written(protocol, framing.then), framing.then)
            }
            Err(refusal) => {
                handler.refuse(refusal.kind());
                let (response, then) = if is_read {
                    (refusal.response(), framing.then)
                } else {
                    (refusal.last_response(), Afterwards::Close)
                };
                (written(&response, protocol, then), then)
            }
        };
        Ok((text, then, turn))
    }

    /// Reads a body of at most `limit` bytes, or why it cannot be read.
    async fn read_body(
        &mut self,
        framing: Framing,
        limit: usize,
        shared: &Shared,
    ) -> io::Result<Result<Vec<u8>, Refusal>> {
        if framing.waits && self.bytes.is_empty() {
            let word = b"HTTP/1.1 100 Continue\r\n\r\n";
            within(self.stream.write_all(word)).await?;
        }
        let mut held = Held(&shared.bodies, 0);
        Ok(match Body::new(framing.length, limit) {
            Ok(body) => {
                let read = timeout(WITHIN, self.body(body, &mut held)).await;
                read.unwrap_or(Err(Refusal::Slow {
                    part: "body",
                    seconds: WITHIN.as_secs(),
                }))
            }
            Err(problem) => Err(problem.into()),
        })
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
        self.rest();
        poll_fn(|context| poll_more(&mut self.stream, &mut self.bytes, context)).await
    }

    /// The same, but not beyond `until`.
    async fn more_before(&mut self, until: Instant) -> Option<io::Result<bool>> {
        self.rest();
        let more =
            |context: &mut Context<'_>| poll_more(&mut self.stream, &mut self.bytes, context);
        self.patience.before(until, more).await
    }

    /// It may be long until there is more.
    fn rest(&mut self) {
        if self.bytes.is_empty() {
            self.bytes = Vec::new();
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
            Box::pin(shared.linger(&mut self.stream, place)).await;
        }
    }
}

/// Whether the peer has moved the plant over another connection meanwhile.
fn is_beside_control(place: &Place) -> bool {
    let since_ns = now_ns().saturating_sub(place.peer_commanded_ns());
    place.peer_commanded_ns() > 0 && Duration::from_nanos(since_ns) < WITHIN
}

/// Takes what has arrived; whether there will be more. Room is made only for what is there.
fn poll_more(
    stream: &mut TcpStream,
    bytes: &mut Vec<u8>,
    context: &mut Context<'_>,
) -> Poll<io::Result<bool>> {
    let mut room = [MaybeUninit::uninit(); ROOM];
    let mut room = ReadBuf::uninit(&mut room);
    ready!(Pin::new(stream).poll_read(context, &mut room))?;
    bytes.extend_from_slice(room.filled());
    Poll::Ready(Ok(!room.filled().is_empty()))
}

/// What comes next on a connection.
enum Next<'a> {
    Request(Served, Turn<'a>),
    /// The other end is gone, or it has been silent for too long.
    Nothing,
    Wrong(Refusal),
}

/// What a connection becomes that carries a whole loop.
enum Becomes {
    Socket(Opening),
    Lines,
}

/// A request with what it gets.
struct Served {
    reply: Reply,
    /// When it arrived, if it is a command.
    commanded_ns: Option<u64>,
    framing: Framing,
    has_body: bool,
    protocol: Protocol,
    is_head: bool,
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

async fn within(sent: impl Future<Output = io::Result<()>>) -> io::Result<()> {
    timeout(WITHIN, sent).await.unwrap_or_else(|_| {
        Err(io::Error::new(
            ErrorKind::TimedOut,
            "the client does not read",
        ))
    })
}
