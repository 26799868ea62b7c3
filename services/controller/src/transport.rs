//! Sends commands and receives their answers.
//!
//! [`Transport`] is the interface: the loop does not know what carries its messages. [`Http`] sends
//! each as a request, with its command in the query or in a body of JSON. [`WebSocket`] and [`Tcp`] use one connection
//! for all, a [`conduit`], and [`Udp`] none. All use the plant's [`Address`], and but for the last a [`session`]
//! where the plant is to be claimed.

mod conduit;
mod datagram;
mod error;
mod http;
mod line;
mod session;
mod under_way;
mod websocket;
mod wording;

pub(crate) use datagram::Udp;
pub(crate) use error::ExchangeError;
pub(crate) use http::{Http, Pool};
pub(crate) use line::Tcp;
pub(crate) use websocket::WebSocket;

use std::{
    net::SocketAddr,
    task::{Context, Poll},
};

use endpoint::{Answer, Command, Observation};
use url::Url;

use crate::config::DriveError;

/// The end of a message: its number, its time, and its result.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) seq: u64,
    pub(crate) t_ns: u64,
    pub(crate) result: Result<Answer, ExchangeError>,
}

/// A way to send messages to the plant. Everything happens while one of its functions runs or its future is
/// polled: there are no tasks to wake for a message.
pub(crate) trait Transport {
    /// Reads the plant's state.
    async fn observe(&mut self) -> Result<Observation, ExchangeError>;

    /// Opens so many connections in advance, each for one more message under way. If that fails now, a message
    /// opens its own later.
    async fn open(&mut self, connections: u16);

    /// Sends a command: at once, if there is a connection for it and room in its socket.
    fn send(&mut self, command: Command);

    /// The next message that has ended. To be polled again and again, also while no message is under way.
    fn poll_ended(&mut self, context: &mut Context<'_>) -> Poll<Ended>;

    /// Disconnects from the plant, and gives up what is under way.
    async fn close(self);
}

/// The plant's address.
#[derive(Clone, Debug)]
pub(crate) struct Address {
    /// The address as given, for errors.
    plant: String,
    base: Url,
    /// A name is looked up once, outside the loop.
    socket: SocketAddr,
}

impl Address {
    /// Reads an address like `http://10.77.0.2:8080`; if it has a name, looks it up.
    pub(crate) fn parse(plant: &str) -> Result<Self, DriveError> {
        let bad = |why: &dyn ToString| DriveError::Address {
            plant: plant.to_owned(),
            why: why.to_string(),
        };
        let base = Url::parse(plant).map_err(|error| bad(&error))?;
        if base.host_str().is_none() || base.port_or_known_default().is_none() {
            return Err(bad(&"it has no host"));
        }
        if base.scheme() != "http" {
            return Err(bad(&"the scheme is not http"));
        }
        if base.path() != "/" || base.query().is_some() || base.fragment().is_some() {
            return Err(bad(&"it is more than a host and a port"));
        }
        let sockets = base.socket_addrs(|| None).map_err(|error| bad(&error))?;
        let socket = *sockets
            .first()
            .ok_or_else(|| bad(&"its name has no address"))?;
        Ok(Self {
            plant: plant.to_owned(),
            base,
            socket,
        })
    }

    /// Its host and port as a request names them.
    fn host(&self) -> String {
        let host = self.base.host_str().unwrap_or_default();
        match self.base.port() {
            Some(port) => format!("{host}:{port}"),
            None => host.to_owned(),
        }
    }

    /// The URL of one of the plant's paths.
    fn at(&self, path: &str) -> Result<Url, DriveError> {
        self.base.join(path).map_err(|error| self.refused(&error))
    }

    /// The error that a client cannot be made for this address.
    fn refused(&self, why: &dyn ToString) -> DriveError {
        DriveError::Address {
            plant: self.plant.clone(),
            why: why.to_string(),
        }
    }
}
