//! A plant by script, for what no real one does: it shows itself at rest over
//! HTTP, and what it does with a WebSocket is the test's.

use std::{
    net::SocketAddr,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
    time::Duration,
};

use endpoint::{Acknowledgement, Command};
use futures_util::{SinkExt, StreamExt};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpListener, TcpStream},
    sync::oneshot,
};
use tokio_tungstenite::{
    WebSocketStream, accept_async,
    tungstenite::{Message, protocol::CloseFrame},
};

const AT_REST: &str =
    "HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: 25\r\n\r\nt_ns=1&tick=1&y=0.0&u=0.0";

/// What a scripted plant does about a request for a WebSocket.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Meet {
    /// Takes it, for the script to go on with.
    Accept,
    /// Says this instead, and hangs up.
    Refuse(&'static str),
    /// Says nothing until the controller hangs up.
    Ignore,
}

/// What becomes of a scripted plant when a script is through with a socket.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Then {
    /// It takes the next one.
    GoOn,
    /// It is gone for some time: nobody listens where it was.
    Vanish(Duration),
}

/// A script: how each request is met, by its number, and what is done with the
/// sockets that were taken.
pub(crate) struct Script<F> {
    pub(crate) meet: fn(usize) -> Meet,
    pub(crate) socket: F,
}

/// Runs a scripted plant while `client` does; also how many sockets were
/// asked of it. It has one at a time, since a controller has.
pub(crate) fn with_script<T, F>(
    script: Script<F>,
    client: impl FnOnce(SocketAddr) -> T,
) -> (T, usize)
where
    F: AsyncFn(usize, &mut Socket) -> Then + Send + 'static,
{
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    listener.set_nonblocking(true).expect("a socket");
    let address = listener.local_addr().expect("bound");
    let asked = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&asked);
    let (stop, stopped) = oneshot::channel::<()>();
    let plant = thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .expect("a runtime");
        runtime.block_on(async {
            let listener = TcpListener::from_std(listener).expect("a socket");
            tokio::select! {
                () = play(script, listener, &count) => {}
                _ = stopped => {}
            }
        });
    });
    let result = client(address);
    drop(stop);
    plant.join().expect("no panic");
    (result, asked.load(Ordering::Relaxed))
}

async fn play<F>(script: Script<F>, mut listener: TcpListener, asked: &AtomicUsize)
where
    F: AsyncFn(usize, &mut Socket) -> Then,
{
    let address = listener.local_addr().expect("bound");
    loop {
        let (mut stream, _) = listener.accept().await.expect("a connection");
        let mut start = [0; 11];
        while matches!(stream.peek(&mut start).await, Ok(1..11)) {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        if &start != b"GET /socket" {
            say(&mut stream, AT_REST).await;
            continue;
        }
        let n = asked.fetch_add(1, Ordering::Relaxed);
        match (script.meet)(n) {
            Meet::Accept => {
                // A controller that has ended may leave half an attempt behind.
                let Ok(stream) = accept_async(stream).await else {
                    continue;
                };
                let mut socket = Socket(stream);
                if let Then::Vanish(time) = (script.socket)(n, &mut socket).await {
                    drop((socket, listener));
                    tokio::time::sleep(time).await;
                    listener = TcpListener::bind(address).await.expect("its own port");
                }
            }
            Meet::Refuse(answer) => say(&mut stream, answer).await,
            Meet::Ignore => while matches!(stream.read(&mut [0; 512]).await, Ok(1..)) {},
        }
    }
}

/// Reads a request and answers it.
async fn say(stream: &mut TcpStream, answer: &str) {
    let mut request = [0; 2048];
    let _ = stream.read(&mut request).await;
    let _ = stream.write_all(answer.as_bytes()).await;
}

/// The plant's end of a WebSocket.
pub(crate) struct Socket(WebSocketStream<TcpStream>);

impl Socket {
    /// The next command; `None` when the controller hangs up.
    pub(crate) async fn command(&mut self) -> Option<Command> {
        let message = self.0.next().await?.ok()?;
        let text = message.into_text().ok()?;
        text.parse().ok()
    }

    /// Answers command `seq`, with its number for the time.
    pub(crate) async fn acknowledge(&mut self, seq: u64) {
        let answer = Acknowledgement {
            seq,
            t_arrive_ns: seq,
        };
        self.send(Message::text(answer.to_string())).await;
    }

    /// Answers every command.
    pub(crate) async fn acknowledge_all(&mut self) {
        while let Some(command) = self.command().await {
            self.acknowledge(command.seq).await;
        }
    }

    /// Sends anything. That the controller may have hung up is no matter.
    pub(crate) async fn send(&mut self, message: Message) {
        let _ = self.0.send(message).await;
    }

    /// How the controller closes the socket, after all its commands.
    pub(crate) async fn farewell(&mut self) -> Option<CloseFrame> {
        loop {
            if let Message::Close(frame) = self.0.next().await?.ok()? {
                return frame;
            }
        }
    }
}
