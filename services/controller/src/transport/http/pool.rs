//! The connections of a controller: one for each message under way, kept for others.
//!
//! A message takes the idle connection that was used last. If none is idle, one is opened for it, and the message
//! takes the first that becomes free: that one, or another before. One that the plant has closed while it was idle
//! is passed over, and a request of which nothing could be sent goes by another. All else that goes wrong is the
//! message's end: it may have moved the plant. A message under way has no buffer.

use std::{
    cell::RefCell,
    collections::VecDeque,
    io,
    mem::MaybeUninit,
    net::SocketAddr,
    pin::Pin,
    rc::Rc,
    task::{Context, Poll, ready},
    time::Duration,
};

use clock::patience::Patience;
use endpoint::Connection;
use endpoint::http::{
    StatusCode, answer,
    framing::{Afterwards, Rest},
};
use tokio::{
    io::{AsyncRead, AsyncWriteExt, ReadBuf},
    net::TcpStream,
    sync::oneshot,
    task::spawn_local,
    time::{Instant, timeout_at},
};

use super::Request;
use crate::{
    config::Config,
    transport::{Address, ExchangeError},
};

/// How long a kept connection may idle. It is below the plant's limit of 5 s; otherwise a request
/// could be sent just as the plant closes the connection.
const IDLE: Duration = Duration::from_secs(4);

/// How many connections that have been idle for that long are closed when one becomes idle: closing takes time.
const CLOSED_AT_ONCE: usize = 2;

/// How much is read at a time: more than an answer has.
const ROOM: usize = 2048;

/// The most bytes of an answer's head, and of its body. A plant's answers have some hundred.
const ANSWER_BYTES: usize = 64 * 1024;

/// The connections. Cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Pool(Rc<Shared>);

#[derive(Debug)]
struct Shared {
    address: SocketAddr,
    /// Of the header `Host`.
    host: String,
    /// For a whole message, and for opening a connection.
    timeout: Duration,
    keeps: bool,
    lines: RefCell<Lines>,
}

/// A connection.
#[derive(Debug)]
struct Line {
    stream: TcpStream,
    patience: Patience,
}

/// The status and the text of an answer, and whether another request may follow.
type Heard = ((StatusCode, String), Afterwards);

/// Why a request was not sent.
enum Unsent {
    /// Nothing of it was.
    Nothing(io::Error),
    /// Some of it may have been.
    Some(io::Error),
    Late,
}

#[derive(Debug, Default)]
struct Lines {
    /// In the order in which they became idle.
    idle: VecDeque<(Line, Instant)>,
    /// Messages without a connection, in their order. Those that have given up are closed.
    waiting: VecDeque<Waiting>,
    /// How many messages have waited.
    count: u64,
}

#[derive(Debug)]
struct Waiting {
    number: u64,
    line: oneshot::Sender<Result<Line, ExchangeError>>,
}

impl Pool {
    pub(crate) fn new(address: &Address, config: &Config) -> Self {
        let settings = &config.settings;
        Self(Rc::new(Shared {
            address: address.socket,
            host: address.host(),
            timeout: Duration::from_nanos(settings.timeout_ns),
            keeps: settings.connection == Connection::Keep,
            lines: RefCell::default(),
        }))
    }

    /// Sends a request, and waits for the status and the text of its answer, for the time of a message.
    pub(crate) async fn ask(
        &self,
        request: &Request<'_>,
    ) -> Result<(StatusCode, String), ExchangeError> {
        let until = Instant::now() + self.0.timeout;
        self.0.exchange(request, until).await
    }
}

impl Shared {
    async fn exchange(
        self: &Rc<Self>,
        request: &Request<'_>,
        until: Instant,
    ) -> Result<(StatusCode, String), ExchangeError> {
        let mut line = loop {
            let (mut line, is_kept) = self.take(until).await?;
            match self.write(&mut line, request, until).await {
                Ok(()) => break line,
                Err(Unsent::Nothing(_)) if is_kept => {}
                Err(Unsent::Nothing(error) | Unsent::Some(error)) => {
                    return Err(ExchangeError::Broken(error));
                }
                Err(Unsent::Late) => return Err(ExchangeError::Timeout),
            }
        };
        let (answer, then) = line.read(until).await?;
        if then == Afterwards::Keep && self.keeps {
            self.lines.borrow_mut().free(line);
        }
        Ok(answer)
    }

    /// A connection for a message, and whether it was used before.
    async fn take(self: &Rc<Self>, until: Instant) -> Result<(Line, bool), ExchangeError> {
        let late = |_| Err(ExchangeError::Timeout);
        if !self.keeps {
            let opened = timeout_at(until, open(self.address)).await;
            return Ok((opened.unwrap_or_else(late)?, false));
        }
        let waiting = {
            let mut lines = self.lines.borrow_mut();
            if let Some(line) = lines.take() {
                return Ok((line, true));
            }
            let (number, waiting) = lines.wait();
            let own = Rc::clone(self);
            // It is opened to its end, also if the message takes another meanwhile.
            spawn_local(async move {
                let opened = timeout_at(until, open(own.address)).await;
                own.lines
                    .borrow_mut()
                    .on_opened(number, opened.unwrap_or_else(late));
            });
            waiting
        };
        match timeout_at(until, waiting).await {
            Ok(Ok(line)) => Ok((line?, false)),
            Ok(Err(_)) => Err(ExchangeError::Ended),
            Err(_) => Err(ExchangeError::Timeout),
        }
    }

    /// Sends a request.
    async fn write(
        &self,
        line: &mut Line,
        request: &Request<'_>,
        until: Instant,
    ) -> Result<(), Unsent> {
        let text = request.text(&self.host);
        let sent = match line.stream.try_write(text.as_bytes()) {
            Ok(sent) => sent,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => 0,
            Err(error) => return Err(Unsent::Nothing(error)),
        };
        if sent == text.len() {
            return Ok(());
        }
        let rest = line.stream.write_all(&text.as_bytes()[sent..]);
        match timeout_at(until, rest).await {
            Ok(sent) => sent.map_err(Unsent::Some),
            Err(_) => Err(Unsent::Late),
        }
    }
}

impl Lines {
    /// The connection that was used last, of those that are idle and can be used.
    fn take(&mut self) -> Option<Line> {
        while let Some((line, since)) = self.idle.pop_back() {
            if since.elapsed() > IDLE {
                // Those before it have idled for longer.
                self.idle.push_back((line, since));
                self.close_old();
                return None;
            }
            // Not even a system call, unless something has come: that it is closed, or what nobody asked for.
            let came = line.stream.try_read(&mut [0]);
            if came.is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock) {
                return Some(line);
            }
        }
        None
    }

    /// The place of a message without a connection.
    fn wait(&mut self) -> (u64, oneshot::Receiver<Result<Line, ExchangeError>>) {
        while self
            .waiting
            .front()
            .is_some_and(|first| first.line.is_closed())
        {
            self.waiting.pop_front();
        }
        let (line, waiting) = oneshot::channel();
        let number = self.count;
        self.count += 1;
        self.waiting.push_back(Waiting { number, line });
        (number, waiting)
    }

    /// The connection was opened that was to be for this message, or it was not.
    fn on_opened(&mut self, number: u64, opened: Result<Line, ExchangeError>) {
        let place = self
            .waiting
            .binary_search_by_key(&number, |waiting| waiting.number);
        let own = place.ok().and_then(|place| self.waiting.remove(place));
        let back = match own {
            Some(own) => own.line.send(opened).err(),
            None => Some(opened),
        };
        if let Some(Ok(line)) = back {
            self.free(line);
        }
    }

    /// A connection can take another message.
    fn free(&mut self, mut line: Line) {
        while let Some(first) = self.waiting.pop_front() {
            match first.line.send(Ok(line)) {
                Ok(()) => return,
                // It has given up.
                Err(Ok(back)) => line = back,
                Err(Err(_)) => return,
            }
        }
        self.close_old();
        self.idle.push_back((line, Instant::now()));
    }

    fn close_old(&mut self) {
        for _ in 0..CLOSED_AT_ONCE {
            if self
                .idle
                .front()
                .is_some_and(|(_, since)| since.elapsed() > IDLE)
            {
                self.idle.pop_front();
            }
        }
    }
}

async fn open(address: SocketAddr) -> Result<Line, ExchangeError> {
    let stream = TcpStream::connect(address).await;
    let stream = stream.map_err(ExchangeError::Connecting)?;
    stream
        .set_nodelay(true)
        .map_err(ExchangeError::Connecting)?;
    Ok(Line {
        stream,
        patience: Patience::default(),
    })
}

impl Line {
    /// Waits for the answer; also whether another request may follow.
    async fn read(&mut self, until: Instant) -> Result<Heard, ExchangeError> {
        let Self { stream, patience } = self;
        // What came before the last part of an answer.
        let mut held = Vec::new();
        let came = patience.before(until, |context| poll_answer(stream, &mut held, context));
        came.await.unwrap_or(Err(ExchangeError::Timeout))
    }
}

/// The answer of a plant, and whether another request may follow.
fn poll_answer(
    stream: &mut TcpStream,
    held: &mut Vec<u8>,
    context: &mut Context<'_>,
) -> Poll<Result<Heard, ExchangeError>> {
    loop {
        let mut room = [MaybeUninit::uninit(); ROOM];
        let mut room = ReadBuf::uninit(&mut room);
        let came = ready!(Pin::new(&mut *stream).poll_read(context, &mut room));
        came.map_err(ExchangeError::Broken)?;
        let rest = if room.filled().is_empty() {
            Rest::IsMissing
        } else {
            Rest::MayCome
        };
        let bytes = if held.is_empty() {
            room.filled()
        } else {
            held.extend_from_slice(room.filled());
            &*held
        };
        if let Some(answer) = answer::read(bytes, rest, ANSWER_BYTES)? {
            let text = match std::str::from_utf8(&answer.body) {
                Ok(text) => text.to_owned(),
                Err(_) => String::from_utf8_lossy(&answer.body).into_owned(),
            };
            return Poll::Ready(Ok(((answer.status, text), answer.then)));
        }
        if held.is_empty() {
            *held = room.filled().to_vec();
        }
    }
}
