//! The thread that accepts connections.
//!
//! `place` says who may stay when there are too many, `turn` whose request is next, and `connection` serves one.
//! A client that reaches a limit loses its connection; the plant never loses a tick.

use std::{cell::RefCell, convert::Infallible, io, net::SocketAddr, rc::Rc, time::Duration};

use clock::now::now_ns;
use tokio::{
    net::{TcpListener, TcpSocket},
    task,
    time::sleep,
};

use crate::{
    connection,
    place::Places,
    shared::{PAUSE, Shared},
    turn::Bucket,
};

/// Most simultaneous connections: a controller that opens one for each message needs 5000 at 1 kHz, when its link
/// stands still for as long as it waits for an answer.
const CONNECTIONS: usize = 5248;

/// How many are accepted in a millisecond, over some time, and how many at once: a controller may open
/// one for each message, and thousands when a link moves again.
const ACCEPTED_MS: f64 = 6.0;
const ACCEPTED: f64 = 4_096.0;

/// Connections that the kernel completes in advance.
const BACKLOG: u32 = 4096;

/// Files of the process other than connections.
const OTHER_FILES: u64 = 64;

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
/// owns the handler; dropping it drops all connections.
pub(crate) async fn accept(
    listener: TcpListener,
    shared: Rc<Shared>,
    accepted: &RefCell<u64>,
    open_files: u64,
) -> Infallible {
    let room = usize::try_from(open_files.saturating_sub(OTHER_FILES)).unwrap_or(usize::MAX);
    let places = Rc::new(Places::new(room.clamp(1, CONNECTIONS)));
    let mut passes = Bucket::new(ACCEPTED_MS, ACCEPTED);
    loop {
        while !passes.takes(now_ns()) {
            sleep(Duration::from_millis(1)).await;
        }
        match listener.accept().await {
            Ok((stream, peer)) => {
                *accepted.borrow_mut() += 1;
                let Some(seat) = places.enter(peer.ip(), now_ns()) else {
                    continue;
                };
                let (place, shared) = (Rc::clone(&seat.place), Rc::clone(&shared));
                let task = task::spawn_local(async move {
                    connection::serve(stream, peer.ip(), &shared, &seat.place).await;
                });
                place.belongs_to(task.abort_handle());
            }
            Err(error) => {
                tracing::warn!(%error, "cannot accept a connection");
                sleep(PAUSE).await;
            }
        }
        // What arrived meanwhile, on the connections that are there, goes first.
        task::yield_now().await;
    }
}
