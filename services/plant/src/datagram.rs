//! Commands by UDP: each datagram is a command's query behind its mode, each answer a datagram with the text that HTTP
//! would return.
//!
//! Nothing but a command that was taken is answered, and by one short datagram, so that whoever writes another's address
//! into a datagram gains nothing by the plant. Such an address may be anybody's: no session can be had in this way, and
//! the lease `address` keeps out only those who do not forge.

use std::{net::IpAddr, rc::Rc};

use clock::now::now_ns;
use endpoint::{datagram, query::MAX_BYTES};
use rustix::net::sockopt::set_socket_recv_buffer_size;
use tokio::{net::UdpSocket, time::sleep};

use crate::{
    handler::Handler,
    place::Place,
    refusal::Refusal,
    session::Sender,
    shared::{PAUSE, Shared},
    token::Pass,
};

/// The longest answer. That of a loop with two inputs and outputs has some 160 bytes.
const ANSWER_BYTES: usize = 512;

/// How much the kernel is asked to keep of what arrives at once, as after a link stood still; it may keep less.
const KEPT_BYTES: usize = 4 * 1024 * 1024;

/// Answers datagrams forever.
pub(crate) async fn serve(socket: UdpSocket, shared: Rc<Shared>) {
    // With less some are lost, which a controller must bear anyway.
    let _ = set_socket_recv_buffer_size(&socket, KEPT_BYTES);
    let place = Place::default();
    // One byte more tells what is too long.
    let mut room = vec![0; MAX_BYTES + 1];
    loop {
        let (bytes, peer) = match socket.recv_from(&mut room).await {
            Ok(came) => came,
            Err(error) => {
                tracing::warn!(%error, "cannot receive a datagram");
                sleep(PAUSE).await;
                continue;
            }
        };
        let mut turn = shared.turns.wait(&place).await;
        let now_ns = now_ns();
        let told = shared
            .handler
            .borrow_mut()
            .datagram(&room[..bytes], peer.ip(), now_ns);
        match told {
            Ok(answer) => {
                place.on_command(now_ns);
                // One that the kernel has no room for is lost, as it may be on its way.
                let _ = socket.try_send_to(answer.as_bytes(), peer);
            }
            Err(refusal) => shared.handler.borrow_mut().refuse(refusal.kind()),
        }
        turn.end().await;
    }
}

impl Handler {
    /// Executes the command of a datagram from `address`; its answer.
    fn datagram(&mut self, bytes: &[u8], address: IpAddr, now_ns: u64) -> Result<String, Refusal> {
        let text = std::str::from_utf8(bytes).map_err(|_| Refusal::Datagram)?;
        let (mode, text) = datagram::read(text)?;
        let sender = Sender {
            pass: Pass::Nothing,
            address: address.to_canonical(),
        };
        let answer = self.command(mode, text, &sender, now_ns)?.text();
        if answer.len() > ANSWER_BYTES {
            return Err(Refusal::Datagram);
        }
        Ok(answer)
    }
}
