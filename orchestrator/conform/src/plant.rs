//! A plant for one trial and one controller: an HTTP server on a thread of its own.
//!
//! It listens on a free port of 127.0.0.1, and tells what it heard when it is closed. `route` says what a
//! request gets; here are the connections, and when they are closed.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::poll_fn;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::panic::resume_unwind;
use std::pin::pin;
use std::rc::Rc;
use std::task::Poll;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use http_body_util::Full;
use hyper::Request;
use hyper::body::{Body, Incoming};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::upgrade::OnUpgrade;
use hyper_util::rt::{TokioIo, TokioTimer};
use pace::now_ns;
use tokio::net::{TcpSocket, TcpStream};
use tokio::runtime::{self, Runtime};
use tokio::sync::oneshot;
use tokio::task::{self, LocalSet};

use crate::Error;
use crate::exchange::{Exchange, wait_until};
use crate::record::Heard;
use crate::trial::{LISTENS_BEFORE_NS, Script, Trial};
use crate::{route, socket};

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
async fn converse(stream: TcpStream, connection: u64, exchange: Rc<RefCell<Exchange>>) {
    // If this fails, the connection is broken already.
    let _ = stream.set_nodelay(true);
    let is_over = Rc::new(Cell::new(false));
    let service = service_fn(|request: Request<Incoming>| {
        let now_ns = now_ns();
        let (mut head, body) = request.into_parts();
        let has_body = !body.is_end_stream();
        let reply = route::reply(
            &mut exchange.borrow_mut(),
            &head,
            has_body,
            connection,
            now_ns,
        );
        if let Some(mode) = reply.socket
            && let Some(upgrade) = head.extensions.remove::<OnUpgrade>()
        {
            let exchange = Rc::clone(&exchange);
            task::spawn_local(socket::serve(upgrade, mode, connection, exchange));
        }
        let is_over = Rc::clone(&is_over);
        async move {
            wait_until(reply.at_ns).await;
            is_over.set(reply.is_last);
            Ok::<_, Infallible>(reply.response.map(Full::new))
        }
    });
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    let mut served = pin!(served);
    // A poll that has made the last answer has also written it. The connection is closed by being
    // dropped: an orderly end would be announced in the answer's head.
    let ended = poll_fn(|context| match served.as_mut().poll(context) {
        Poll::Pending if is_over.get() => Poll::Ready(Ok(())),
        other => other,
    })
    .await;
    if let Err(problem) = ended
        && problem.is_parse()
    {
        let words = format!("the request is not HTTP/1.1: {problem}");
        exchange.borrow_mut().heard.refuse(&words);
    }
}

#[cfg(test)]
mod tests;
