//! What all connections share: the handler, whose turn it is, how long each step may take, and how each ends.
//!
//! What is said on one is in `connection`, and on one that carries a whole loop in `conversation`.

use std::{
    cell::{Cell, RefCell},
    io::{self, ErrorKind},
    rc::Rc,
    time::Duration,
};

use rustix::net::sockopt::set_socket_recv_buffer_size;
use tokio::{io::AsyncWriteExt, net::TcpStream, time::timeout};

use crate::{handler::Handler, place::Place, turn::Turns};

/// How long each step may take: waiting for a request, its head, its body, sending the answer. Clients must close
/// idle connections earlier, or a request could be sent just as the plant closes its connection.
///
/// Where others of the same peer move the plant, one may be idle for twice as long: a controller keeps those that
/// it needed when its link stood still, and the request on one may be under way for that long again.
pub(crate) const WITHIN: Duration = Duration::from_secs(5);

/// How long the other end has to read why the connection is closed, and how much of what it still sends is
/// discarded meanwhile: closing earlier would lose the reason.
pub(crate) const LINGER: Duration = Duration::from_secs(1);
const LINGER_BYTES: usize = 256 * 1024;

/// Pause after a failed accept or receipt: without it, running out of files would cause a busy loop.
pub(crate) const PAUSE: Duration = Duration::from_millis(50);

/// How much of it is discarded at a time.
const DISCARD_BYTES: usize = 32 * 1024;

/// What all connections share.
pub(crate) struct Shared {
    pub(crate) handler: Rc<RefCell<Handler>>,
    pub(crate) turns: Turns,
    /// The bytes of bodies that are being read.
    pub(crate) bodies: Cell<usize>,
}

impl Shared {
    pub(crate) fn new(handler: Rc<RefCell<Handler>>) -> Self {
        Self {
            handler,
            turns: Turns::new(),
            bodies: Cell::new(0),
        }
    }

    /// Ends what we send, and reads what the other end still sends.
    pub(crate) async fn linger(&self, stream: &mut TcpStream, place: &Place) {
        let rest = async {
            stream.shutdown().await?;
            // The kernel need not keep what is discarded.
            set_socket_recv_buffer_size(&*stream, DISCARD_BYTES)?;
            let mut left = LINGER_BYTES;
            while left > 0 {
                stream.readable().await?;
                let mut turn = self.turns.wait(place).await;
                let read = stream.try_read_buf(&mut Vec::with_capacity(DISCARD_BYTES));
                turn.on_bytes(read.as_ref().map_or(0, |read| *read));
                turn.end().await;
                match read {
                    Ok(0) => break,
                    Ok(read) => left = left.saturating_sub(read),
                    Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                    Err(error) => return Err(error),
                }
            }
            io::Result::Ok(())
        };
        // It does not matter whether the other end listens.
        let _ = timeout(LINGER, rest).await;
    }
}
