//! One socket from its opening to its end: what goes out, what comes in, and
//! and the errors for those who wait when it is over.

use std::{
    net::SocketAddr,
    sync::{Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use endpoint::{Answer, Command, InvalidMessage, Mode, query};
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
use crate::transport::{ExchangeError, excerpt};

/// An answer has about 100 bytes: this is some 40 of them at once.
const READ_BYTES: usize = 4096;

/// Round trips to open a socket, TCP's and the WebSocket's. An attempt that had
/// to be done within a message's timeout would never end on a link whose round
/// trip takes more than half of it, though messages would be answered there.
const ROUND_TRIPS: u32 = 2;

/// Where messages go out.
type Outgoing = SplitSink<WebSocketStream<TcpStream>, Message>;

/// Where messages come in.
type Incoming = SplitStream<WebSocketStream<TcpStream>>;

/// What a socket is asked to do.
#[derive(Debug)]
pub(super) enum Order {
    /// To be open, and to say so.
    Open(oneshot::Sender<()>),
    /// To send a command for someone who waits for its answer.
    Send(Command, Waiting),
}

/// What it takes to open a socket.
#[derive(Clone, Debug)]
pub(super) struct Socket {
    pub(super) url: String,
    pub(super) address: SocketAddr,
    pub(super) mode: Mode,
    /// How long an answer is waited for.
    pub(super) timeout: Duration,
}

impl Socket {
    /// Opens the socket and carries out orders until the connection ends, or
    /// until there can be no more orders. Whoever waits by then is told why.
    pub(super) async fn serve(self, mut orders: mpsc::Receiver<Order>) {
        let under_way = Mutex::new(UnderWay::default());
        let mut socket = self.connect().await;
        let why = match &mut socket {
            Err(why) => why.clone(),
            Ok((sink, stream)) => tokio::select! {
                // What the plant says goes first: when it hangs up, a command
                // fails too, and does not know why.
                biased;
                why = read(self.mode, stream, &under_way) => why,
                why = write(sink, &mut orders, &under_way) => why,
            },
        };
        // From here on commands open another one.
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

    /// Connects, or says why it cannot. An attempt to which nothing comes back
    /// is made again: those who wait for it end by their own timeouts.
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
        let stream = TcpStream::connect(self.address).await.map_err(broken)?;
        stream.set_nodelay(true).map_err(broken)?;
        let config = WebSocketConfig::default()
            .read_buffer_size(READ_BYTES)
            .max_message_size(Some(query::MAX_BYTES))
            .max_frame_size(Some(query::MAX_BYTES));
        match client_async_with_config(&*self.url, stream, Some(config)).await {
            Ok((socket, _)) => Ok(socket),
            Err(Error::Http(response)) => {
                let status = response.status();
                let text = response.into_body().unwrap_or_default();
                let text = excerpt(&String::from_utf8_lossy(&text));
                Err(format!("{status}: {text}"))
            }
            Err(error) => Err(error.to_string()),
        }
    }
}

/// Sends commands until there can be no more, or one cannot be sent; says why.
async fn write(
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
        // After a stall nothing is sent that is not waited for any more, as a
        // request over HTTP ends with its timeout.
        if waiting.answer.is_closed() {
            continue;
        }
        lock(under_way).add(waiting);
        // Each goes out by itself, as a request does.
        if let Err(error) = sink.send(Message::text(command.to_string())).await {
            return format!("the socket broke: {error}");
        }
    }
    "the controller has ended".to_owned()
}

/// Takes in answers until the plant hangs up or makes no sense; says why.
async fn read(mode: Mode, stream: &mut Incoming, under_way: &Mutex<UnderWay>) -> String {
    while let Some(message) = stream.next().await {
        match message {
            Ok(Message::Text(text)) => match answer(mode, &text) {
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

/// Closes the socket as the protocol wants it: a word each, then the plant hangs
/// up. If the plant began, this is the answer.
async fn leave(mut sink: Outgoing, mut stream: Incoming) {
    let farewell = CloseFrame {
        code: CloseCode::Normal,
        reason: "".into(),
    };
    if sink.send(Message::Close(Some(farewell))).await.is_ok() {
        while let Some(Ok(_)) = stream.next().await {}
    }
}

fn answer(mode: Mode, text: &str) -> Result<Answer, InvalidMessage> {
    Ok(match mode {
        Mode::Closed => Answer::State(text.parse()?),
        Mode::Open => Answer::Acknowledgement(text.parse()?),
    })
}

/// Both ways of a socket are in one task, so this is never waited for.
fn lock(under_way: &Mutex<UnderWay>) -> MutexGuard<'_, UnderWay> {
    under_way.lock().unwrap_or_else(PoisonError::into_inner)
}
