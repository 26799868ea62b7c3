//! Messages by UDP: each command a datagram, each answer a datagram. Nothing is sent again.

use std::{
    collections::VecDeque,
    io,
    net::{Ipv4Addr, Ipv6Addr, SocketAddr},
    rc::Rc,
    task::{Context, Poll, ready},
    time::Duration,
};

use clock::now::now_ns;
use endpoint::{Answer, Command, Observation, datagram, query::MAX_BYTES};
use tokio::{io::ReadBuf, net::UdpSocket};

use super::{
    Address, Ended, ExchangeError, Transport, error::SocketError, http::Http, under_way::UnderWay,
    wording::Wording,
};
use crate::config::Config;

/// A datagram a message.
pub(crate) struct Udp {
    /// Reads the plant's state as in HTTP.
    http: Http,
    plant: SocketAddr,
    wording: Wording,
    /// Bound for the first message at the latest.
    socket: Option<UdpSocket>,
    under_way: UnderWay,
    /// Messages that have ended and are not told yet.
    ended: VecDeque<Ended>,
}

impl Udp {
    pub(crate) fn new(http: Http, address: &Address, config: &Config) -> Self {
        let settings = &config.settings;
        Self {
            http,
            plant: address.socket,
            wording: Wording {
                mode: settings.mode,
                check: config.check,
            },
            socket: None,
            under_way: UnderWay::new(Duration::from_nanos(settings.timeout_ns)),
            ended: VecDeque::new(),
        }
    }

    /// A socket that hears the plant only.
    fn bound(&self) -> io::Result<UdpSocket> {
        let own: SocketAddr = match self.plant {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = std::net::UdpSocket::bind(own)?;
        socket.connect(self.plant)?;
        socket.set_nonblocking(true)?;
        UdpSocket::from_std(socket)
    }

    /// Sends what waits; a datagram for which there is no room is lost, as it may be on its way.
    fn send_all(&mut self) -> io::Result<()> {
        let socket = match self.socket.take() {
            Some(socket) => socket,
            None => self.bound()?,
        };
        let socket = self.socket.insert(socket);
        while let Some(command) = self.under_way.take_unsent() {
            let text = self.wording.command(&command);
            let text = datagram::written(self.wording.mode, &text);
            match socket.try_send(text.as_bytes()) {
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The next answer to a message that waits for one. What cannot be read is as good as lost.
    fn poll_answer(&mut self, context: &mut Context<'_>) -> Poll<io::Result<Answer>> {
        let Some(socket) = &self.socket else {
            return Poll::Pending;
        };
        loop {
            let mut room = [0; MAX_BYTES];
            let mut room = ReadBuf::new(&mut room);
            ready!(socket.poll_recv(context, &mut room))?;
            let answer = str::from_utf8(room.filled())
                .ok()
                .and_then(|text| self.wording.answer(text).ok());
            if let Some(answer) = answer
                && self.under_way.answered(answer.seq())
            {
                return Poll::Ready(Ok(answer));
            }
        }
    }

    /// Ends all messages under way.
    fn fail(&mut self, error: io::Error) {
        let (t_ns, why) = (now_ns(), Rc::new(SocketError::Datagram(error)));
        for seq in self.under_way.give_up() {
            let result = Err(ExchangeError::Socket(Rc::clone(&why)));
            self.ended.push_back(Ended { seq, t_ns, result });
        }
    }
}

impl Transport for Udp {
    async fn observe(&mut self) -> Result<Observation, ExchangeError> {
        self.http.observe().await
    }

    async fn open(&mut self, _: u16) {
        // If it cannot be bound now, a message says why.
        self.socket = self.bound().ok();
    }

    fn send(&mut self, command: Command) {
        self.under_way.add(command);
        if let Err(error) = self.send_all() {
            self.fail(error);
        }
    }

    fn poll_ended(&mut self, context: &mut Context<'_>) -> Poll<Ended> {
        loop {
            if let Some(ended) = self.ended.pop_front() {
                return Poll::Ready(ended);
            }
            match self.poll_answer(context) {
                Poll::Ready(Ok(answer)) => {
                    return Poll::Ready(Ended {
                        seq: answer.seq(),
                        t_ns: now_ns(),
                        result: Ok(answer),
                    });
                }
                Poll::Ready(Err(error)) => self.fail(error),
                Poll::Pending => {
                    let seq = ready!(self.under_way.poll_timeout(context));
                    return Poll::Ready(Ended {
                        seq,
                        t_ns: now_ns(),
                        result: Err(ExchangeError::Timeout),
                    });
                }
            }
        }
    }

    async fn close(self) {
        self.http.close().await;
    }
}
