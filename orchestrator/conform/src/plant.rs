//! A plant for one trial and one controller: an HTTP server on a thread of its own.
//!
//! It listens on a free port of 127.0.0.1, and tells what it heard when it is closed. `route` says what a
//! request gets; here are the connections, which are read and answered as the plant's are, and when they are closed.

use std::cell::RefCell;
use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::panic::resume_unwind;
use std::rc::Rc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use clock::now::now_ns;
use endpoint::http::framing::{Afterwards, Protocol, Rest};
use endpoint::http::request::Malformed;
use endpoint::http::{lines, request};
use hyper::StatusCode;
use plant::answer::written;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::runtime::{self, Runtime};
use tokio::sync::oneshot;
use tokio::task::{self, LocalSet};

use crate::error::Error;
use crate::exchange::{Exchange, Refusal, wait_until};
use crate::record::Heard;
use crate::route::{self, Reply, Then};
use crate::socket;
use crate::trial::{LISTENS_BEFORE_NS, Script, Trial};

/// Connections that the kernel completes in advance.
const BACKLOG: u32 = 1024;

/// Pause after a failed accept: without it, running out of files would cause a busy loop.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// A running plant. Dropping it ends it, some time later.
#[derive(Debug)]
pub(crate) struct Plant {
    /// Where it listens, or will.
    pub(crate) address: SocketAddr,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<io::Result<Heard>>,
}

impl Plant {
    /// Starts the plant of a trial whose first message is due at `start_ns`.
    ///
    /// # Errors
    /// When the motor cannot be sampled, or the system refuses a socket or a thread.
    pub(crate) fn open(trial: &Trial, start_ns: u64) -> Result<Plant, Error> {
        let exchange = Exchange::new(trial, start_ns, now_ns())?;
        let listen_ns = match trial.script {
            Script::ListenLate => start_ns.saturating_sub(LISTENS_BEFORE_NS),
            _ => 0,
        };
        let runtime = runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        // It has its port from now on, and refuses connections until it listens.
        let socket = TcpSocket::new_v4()?;
        socket.bind(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)))?;
        let address = socket.local_addr()?;
        let (stop, stopped) = oneshot::channel();
        let thread = thread::Builder::new()
            .name("plant".to_owned())
            .spawn(move || serve(&runtime, socket, listen_ns, exchange, stopped))?;
        Ok(Plant {
            address,
            stop,
            thread,
        })
    }

    /// Ends the plant; what it heard.
    ///
    /// # Errors
    /// When it could not listen.
    pub(crate) fn close(self) -> io::Result<Heard> {
        drop(self.stop);
        self.thread
            .join()
            .unwrap_or_else(|panic| resume_unwind(panic))
    }
}

/// Serves until the other half of `stopped` is dropped.
fn serve(
    runtime: &Runtime,
    socket: TcpSocket,
    listen_ns: u64,
    exchange: Exchange,
    stopped: oneshot::Receiver<()>,
) -> io::Result<Heard> {
    let exchange = Rc::new(RefCell::new(exchange));
    let tasks = LocalSet::new();
    let outcome: io::Result<()> = tasks.block_on(runtime, async {
        tokio::select! {
            _ = stopped => Ok(()),
            never = accept(socket, listen_ns, &exchange) => never.map(|never| match never {}),
        }
    });
    outcome?;
    let heard = std::mem::take(&mut exchange.borrow_mut().heard);
    Ok(heard)
}

/// Accepts connections for ever, from `listen_ns` on.
async fn accept(
    socket: TcpSocket,
    listen_ns: u64,
    exchange: &Rc<RefCell<Exchange>>,
) -> io::Result<Infallible> {
    wait_until(listen_ns).await;
    let listener = socket.listen(BACKLOG)?;
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_PAUSE).await;
            continue;
        };
        let connection = exchange.borrow_mut().heard.connect();
        task::spawn_local(converse(stream, connection, Rc::clone(exchange)));
    }
}

/// Serves one connection to its end, which may be the script's.
async fn converse(mut stream: TcpStream, connection: u64, exchange: Rc<RefCell<Exchange>>) {
    // If this fails, the connection is broken already.
    let _ = stream.set_nodelay(true);
    let mut bytes = Vec::new();
    loop {
        let reply = match take(&mut bytes, connection, &exchange) {
            Ok(Some(reply)) => reply,
            Ok(None) => match stream.read_buf(&mut bytes).await {
                Ok(1..) => continue,
                Ok(0) | Err(_) => return,
            },
            Err(problem) => {
                let words = problem.to_string();
                exchange.borrow_mut().heard.refuse(&words);
                let refused = route::refused(&Refusal::new(StatusCode::BAD_REQUEST, words));
                let text = written(&refused, Protocol::Http11, Afterwards::Close);
                let _ = stream.write_all(&text).await;
                return;
            }
        };
        wait_until(reply.at_ns).await;
        if stream.write_all(&reply.text).await.is_err() {
            return;
        }
        match reply.then {
            Then::Request => {}
            Then::End => return,
            Then::Socket(mode) => {
                return socket::serve(stream, bytes, mode, connection, exchange).await;
            }
        }
    }
}

/// Takes the next request, if its head is whole, and what it gets.
fn take(
    bytes: &mut Vec<u8>,
    connection: u64,
    exchange: &RefCell<Exchange>,
) -> Result<Option<Reply>, Malformed> {
    let mut room = lines::room();
    let Some(head) = request::read(bytes, &mut room)? else {
        return Ok(None);
    };
    let Some(head) = head.settled(&bytes[head.bytes..], Rest::MayCome) else {
        return Ok(None);
    };
    let taken = head.bytes;
    let reply = route::reply(&mut exchange.borrow_mut(), &head, connection, now_ns());
    bytes.drain(..taken);
    Ok(Some(reply))
}

#[cfg(test)]
mod tests;
