//! One socket from its opening to its end: what it sends, what it receives, and the errors for
//! waiting messages when it is over.

use std::{
    net::SocketAddr,
    sync::{Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use endpoint::{Answer, Command, InvalidMessage, Mode, checksum, query};
use futures_util::{
    SinkExt, StreamExt,
    stream::{SplitSink, SplitStream},
};
use tokio::{
    net::TcpStream,
    sync::{mpsc, oneshot},
    time::timeout,
};
use tokio_tungstenite::{
    WebSocketStream, client_async_with_config,
    tungstenite::{
        Error, Message,
        protocol::{CloseFrame, WebSocketConfig, frame::coding::CloseCode},
    },
};

use super::under_way::{UnderWay, Waiting};
use crate::transport::{
    ExchangeError, excerpt,
    session::{self, Session},
};

/// Size of a read: an answer has about 100 bytes, so this is some 40 answers at once.
const READ_BYTES: usize = 4096;

/// Round trips to open a socket, TCP's and the WebSocket's. If an attempt had only a message's
/// timeout, it would never succeed on a link whose round trip takes more than half of that, although
/// messages would be answered there.
const ROUND_TRIPS: u32 = 2;

/// The half that sends messages.
type Outgoing = SplitSink<WebSocketStream<TcpStream>, Message>;

/// The half that receives messages.
type Incoming = SplitStream<WebSocketStream<TcpStream>>;

/// An order to a socket.
#[derive(Debug)]
pub(super) enum Order {
    /// Opens the socket, and reports when it is open.
    Open(oneshot::Sender<()>),
    /// Sends a command, with the receiver that waits for its answer.
    Send(Command, Waiting),
}

/// The data needed to open a socket.
#[derive(Clone, Debug)]
pub(super) struct Socket {
    pub(super) url: String,
    pub(super) address: SocketAddr,
    pub(super) mode: Mode,
    /// The session in which it commands, if it has to have one.
    pub(super) session: Option<Session>,
    /// Whether commands have a checksum, and answers need one.
    pub(super) check: bool,
    /// How long to wait for an answer.
    pub(super) timeout: Duration,
}

impl Socket {
    /// Opens the socket and executes orders until the connection ends, or until there can be no more
    /// orders. Messages that wait then get the reason.
    pub(super) async fn serve(self, mut orders: mpsc::Receiver<Order>) {
        let under_way = Mutex::new(UnderWay::default());
        let mut socket = self.connect().await;
        let why = match &mut socket {
            Err(why) => why.clone(),
            Ok((sink, stream)) => tokio::select! {
                // Reads first: when the plant closes the connection, sending a command fails too, but
                // without the reason.
                biased;
                why = read(self.mode, self.check, stream, &under_way) => why,
                why = write(self.check, sink, &mut orders, &under_way) => why,
            },
        };
        // From here on commands open another socket.
        orders.close();
        lock(&under_way).failed(&why);
        while let Ok(order) = orders.try_recv() {
            if let Order::Send(_, waiting) = order {
                let error = ExchangeError::Failed(why.clone());
                let _ = waiting.answer.send(Err(error));
            }
        }
        if let Ok((sink, stream)) = socket {
            let _ = timeout(self.timeout, leave(sink, stream)).await;
        }
    }

    /// Connects, or returns why it cannot. An attempt without any answer is repeated: messages that
    /// wait for it end by their own timeouts.
    async fn connect(&self) -> Result<(Outgoing, Incoming), String> {
        loop {
            if let Ok(result) = timeout(ROUND_TRIPS * self.timeout, self.attempt()).await {
                return result
                    .map(StreamExt::split)
                    .map_err(|error| format!("cannot open {}: {error}", self.url));
            }
        }
    }

    async fn attempt(&self) -> Result<WebSocketStream<TcpStream>, String> {
        let broken = |error: std::io::Error| error.to_string();
        let (mut url, mut token) = (self.url.clone(), String::new());
        if let Some(session) = &self.session {
            token = session.token().await.map_err(|error| error.to_string())?;
            url += &format!("&session={token}");
        }
        let stream = TcpStream::connect(self.address).await.map_err(broken)?;
        stream.set_nodelay(true).map_err(broken)?;
        let config = WebSocketConfig::default()
            .read_buffer_size(READ_BYTES)
            .max_message_size(Some(query::MAX_BYTES))
            .max_frame_size(Some(query::MAX_BYTES));
        match client_async_with_config(&*url, stream, Some(config)).await {
            Ok((socket, _)) => Ok(socket),
            Err(Error::Http(response)) => {
                let status = response.status();
                if let Some(session) = &self.session
                    && session::is_lost(status)
                {
                    session.forget(&token).await;
                }
                let text = response.into_body().unwrap_or_default();
                let text = excerpt(&String::from_utf8_lossy(&text));
                Err(format!("{status}: {text}"))
            }
            Err(error) => Err(error.to_string()),
        }
    }
}

/// Sends commands until there can be no more, or one cannot be sent; returns the reason.
async fn write(
    check: bool,
    sink: &mut Outgoing,
    orders: &mut mpsc::Receiver<Order>,
    under_way: &Mutex<UnderWay>,
) -> String {
    while let Some(order) = orders.recv().await {
        let (command, waiting) = match order {
            Order::Send(command, waiting) => (command, waiting),
            Order::Open(done) => {
                let _ = done.send(());
                continue;
            }
        };
        // After a stall, commands that nobody waits for any more are not sent, as a request over HTTP
        // ends with its timeout.
        if waiting.answer.is_closed() {
            continue;
        }
        lock(under_way).add(waiting);
        // Each is sent by itself, like a request.
        let mut text = command.to_string();
        if check {
            text = checksum::signed(&text);
        }
        if let Err(error) = sink.send(Message::text(text)).await {
            return format!("the socket broke: {error}");
        }
    }
    "the controller has ended".to_owned()
}

/// Receives answers until the plant closes the connection or an answer is invalid; returns the reason.
async fn read(
    mode: Mode,
    check: bool,
    stream: &mut Incoming,
    under_way: &Mutex<UnderWay>,
) -> String {
    while let Some(message) = stream.next().await {
        match message {
            Ok(Message::Text(text)) => match answer(mode, check, &text) {
                Ok(answer) => lock(under_way).answered(answer),
                // Without a number it cannot be assigned to a message, so all of them fail.
                Err(error) => return format!("the plant's answer cannot be read: {error}"),
            },
            Ok(Message::Binary(_)) => return "the plant's answer is bytes, not text".to_owned(),
            Ok(Message::Close(None)) => return "the plant closed the socket".to_owned(),
            Ok(Message::Close(Some(CloseFrame { code, reason }))) => {
                let code = u16::from(code);
                return format!("the plant closed the socket: {code} {}", excerpt(&reason));
            }
            Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => {}
            Err(error) => return format!("the socket broke: {error}"),
        }
    }
    "the plant hung up".to_owned()
}

/// Closes the socket by the protocol: each side sends a close frame, then the plant closes the
/// connection. If the plant began, this is the answer.
async fn leave(mut sink: Outgoing, mut stream: Incoming) {
    let farewell = CloseFrame {
        code: CloseCode::Normal,
        reason: "".into(),
    };
    if sink.send(Message::Close(Some(farewell))).await.is_ok() {
        while let Some(Ok(_)) = stream.next().await {}
    }
}

fn answer(mode: Mode, check: bool, text: &str) -> Result<Answer, InvalidMessage> {
    let (text, _) = checksum::checked(text, check)?;
    Ok(match mode {
        Mode::Closed => Answer::State(text.parse()?),
        Mode::Open => Answer::Acknowledgement(text.parse()?),
    })
}

/// Both halves of a socket are in one task, so this never blocks.
fn lock(under_way: &Mutex<UnderWay>) -> MutexGuard<'_, UnderWay> {
    under_way.lock().unwrap_or_else(PoisonError::into_inner)
}
