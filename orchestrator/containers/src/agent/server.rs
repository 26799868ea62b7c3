//! The connections of an agent: accepts them and serves HTTP/1 on them.
//!
//! There are few: an orchestrator, its followers, a health check. The limits are for faults;
//! exceeding one costs a connection, never the agent; `seat` has whose. `axum::serve` has no settings for them.

use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use rustix::net::sockopt::set_tcp_user_timeout;
use tokio::net::{TcpListener, TcpSocket};

use crate::agent::seat::Seats;

/// How long a connection may wait for a request's head, and so how long it may be idle between
/// requests. Clients close idle connections earlier, or a request could meet the close of its
/// connection.
const HEAD_WITHIN: Duration = Duration::from_secs(5);

/// Maximum size of a request's head.
const HEAD_BYTES: usize = 16 << 10;

/// Maximum number of connections at a time.
const CONNECTIONS: usize = 64;

/// How long what was sent may stay without an acknowledgement, as from a client that does not read: the kernel
/// ends the connection then.
const SENT_WITHIN_MS: u32 = 5_000;

/// Maximum number of connections that the kernel completes before they are accepted.
const BACKLOG: u32 = 64;

/// Pause while no connection can be spared.
const FULL_PAUSE: Duration = Duration::from_millis(10);

/// Pause after a failed accept, so that running out of file descriptors is no busy loop.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// Listens on `address`. Needs the runtime's context.
pub(crate) fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() {
        TcpSocket::new_v4()
    } else {
        TcpSocket::new_v6()
    }?;
    // An agent that starts again must not wait for the old one's connections.
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Accepts connections for ever; `open` can close them in good order.
pub(crate) async fn accept(
    listener: &TcpListener,
    router: &Router,
    open: &GracefulShutdown,
) -> Infallible {
    let mut seats = Seats::new(CONNECTIONS);
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                tracing::warn!(%error, "cannot accept a connection");
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        // Answers are small: waiting for more to send would add a delayed acknowledgement. If this
        // fails, the connection is broken, and serving it will report that.
        let _ = stream.set_nodelay(true);
        let _ = set_tcp_user_timeout(&stream, SENT_WITHIN_MS);
        while !seats.has_room() {
            tokio::time::sleep(FULL_PAUSE).await;
        }
        let its = seats.new_use();
        let routes = TowerToHyperService::new(router.clone());
        let service = service_fn({
            let its = Arc::clone(&its);
            move |request| {
                let (under_way, answer) = (its.begin(), routes.call(request));
                async move {
                    let answer = answer.await;
                    drop(under_way);
                    answer
                }
            }
        });
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(HEAD_WITHIN)
            .max_header_size(HEAD_BYTES)
            .serve_connection(TokioIo::new(stream), service);
        let connection = open.watch(connection);
        let task = tokio::spawn(async move {
            if let Err(error) = connection.await {
                tracing::debug!(%error, "connection ended");
            }
        });
        seats.take(its, task.abort_handle());
    }
}
