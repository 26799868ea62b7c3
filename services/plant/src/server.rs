//! The thread that accepts connections and serves HTTP/1.
//!
//! Its limits are for clients that misbehave: incomplete heads, endless headers, more connections
//! than sockets. A client that reaches a limit loses its connection; the plant never loses a tick.

use std::{
    cell::RefCell, convert::Infallible, io, net::SocketAddr, rc::Rc, sync::Arc, time::Duration,
};

use http_body_util::Full;
use hyper::{
    Request, Response,
    body::{Body, Bytes, Incoming},
    server::conn::http1,
    service::service_fn,
    upgrade::OnUpgrade,
};
use hyper_util::rt::{TokioIo, TokioTimer};
use pace::now_ns;
use tokio::{
    net::{TcpListener, TcpSocket, TcpStream},
    sync::{OwnedSemaphorePermit, Semaphore},
    task::{self, JoinError, JoinHandle},
};

use crate::{handler::Handler, route::Reply, socket, upload};

/// How long a connection may wait until a head is complete, and so also how long it may idle between
/// two requests. Clients must close idle connections earlier, or a request could be sent just as the
/// plant closes its connection.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);

/// Greatest size of a request's head.
const HEAD_BYTES: usize = 16 * 1024;

/// Most simultaneous connections. Others wait in the backlog.
const CONNECTIONS: usize = 8192;

/// Connections that the kernel completes in advance.
const BACKLOG: u32 = 4096;

/// Files of the process other than connections.
const OTHER_FILES: u64 = 64;

/// Pause after a failed accept: without it, running out of files would cause a busy loop.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// Listens on `address`. Needs the runtime's context.
pub(crate) fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() {
        TcpSocket::new_v4()
    } else {
        TcpSocket::new_v6()
    }?;
    // A restarted plant must not wait for the old one's connections.
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Accepts connections forever; `open_files` is the limit of the process. Runs on the thread that
/// owns `handler`; dropping it drops all connections.
pub(crate) async fn accept(
    listener: TcpListener,
    handler: Rc<RefCell<Handler>>,
    accepted: &RefCell<u64>,
    open_files: u64,
) -> Infallible {
    let room = usize::try_from(open_files.saturating_sub(OTHER_FILES)).unwrap_or(usize::MAX);
    let free = Arc::new(Semaphore::new(room.clamp(1, CONNECTIONS)));
    loop {
        let slot = Arc::clone(&free)
            .acquire_owned()
            .await
            .expect("the semaphore is never closed");
        match listener.accept().await {
            Ok((stream, _)) => {
                *accepted.borrow_mut() += 1;
                let handler = Rc::clone(&handler);
                task::spawn_local(async move {
                    // If a connection ends badly, only its client is affected, and the client's rows show it.
                    if let Err(error) = converse(stream, handler, Rc::new(slot)).await {
                        tracing::debug!(%error, "connection ended");
                    }
                });
            }
            Err(error) => {
                tracing::warn!(%error, "cannot accept a connection");
                tokio::time::sleep(ACCEPT_PAUSE).await;
            }
        }
    }
}

/// Serves one connection to its end. `slot` counts it among all connections; a WebSocket that it
/// becomes keeps the slot.
async fn converse(
    stream: TcpStream,
    handler: Rc<RefCell<Handler>>,
    slot: Rc<OwnedSemaphorePermit>,
) -> hyper::Result<()> {
    // Answers are one small segment each: waiting for more data would add the other end's delayed
    // acknowledgement, 40 ms. If this call fails, the connection is already broken, and serving it
    // will report that.
    let _ = stream.set_nodelay(true);
    let peer = stream.peer_addr().map(|peer| peer.ip());
    let service = service_fn(|request: Request<Incoming>| {
        let now_ns = now_ns();
        let (mut head, body) = request.into_parts();
        // For the lease. A connection without another end is broken, and gets no answer.
        if let Ok(peer) = peer {
            head.extensions.insert(peer);
        }
        let reply = handler
            .borrow_mut()
            .answer(&head, !body.is_end_stream(), now_ns);
        let response = match reply {
            Reply::Done(response) => Next::Response(response),
            // In a task of its own, so that an upload is completed even if its connection breaks.
            Reply::Upload(upload) => Next::Upload(task::spawn_local(upload::run(
                upload,
                body,
                Rc::clone(&handler),
            ))),
            Reply::Socket(response, opening) => {
                if let Some(upgrade) = head.extensions.remove::<OnUpgrade>() {
                    let (handler, slot) = (Rc::clone(&handler), Rc::clone(&slot));
                    task::spawn_local(async move {
                        socket::serve(upgrade, opening, handler).await;
                        drop(slot);
                    });
                }
                Next::Response(response)
            }
        };
        async move {
            let response = match response {
                Next::Response(response) => response,
                Next::Upload(task) => task.await?,
            };
            Ok::<_, JoinError>(response.map(Full::new))
        }
    });
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_header_size(HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades()
        .await
}

/// The source of a response.
enum Next {
    Response(Response<Bytes>),
    Upload(JoinHandle<Response<Bytes>>),
}
