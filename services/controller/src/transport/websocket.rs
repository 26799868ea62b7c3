//! Messages over a WebSocket: each a text, all in one socket.
//!
//! [`WebSocket`] passes commands to the current [`Socket`], which runs in a task of its own and ends
//! with its connection; the next command then opens another. [`socket`] has what a socket does,
//! [`under_way`] assigns answers to commands. Answers may come in any order.

mod socket;
mod under_way;

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use endpoint::{Answer, Command, Mode, Observation, Outstanding};
use tokio::{
    sync::{
        mpsc::{self, error::SendError},
        oneshot,
    },
    task::JoinHandle,
    time::timeout,
};

use self::{
    socket::{Order, Socket},
    under_way::Waiting,
};
use super::{Address, ExchangeError, Http, Transport};
use crate::{Config, DriveError};

/// How long to wait for the plant to close the socket. No rows depend on it.
const LEAVE: Duration = Duration::from_millis(100);

/// One socket for all messages.
#[derive(Clone, Debug)]
pub(crate) struct WebSocket {
    /// Reads the plant's state as in HTTP.
    http: Http,
    socket: Socket,
    timeout: Duration,
    line: Arc<Mutex<Option<Line>>>,
}

/// The channel to the current socket's task.
#[derive(Debug)]
struct Line {
    orders: mpsc::Sender<Order>,
    task: JoinHandle<()>,
}

impl WebSocket {
    pub(crate) fn try_new(address: &Address, config: &Config) -> Result<Self, DriveError> {
        let settings = &config.settings;
        let timeout = Duration::from_nanos(settings.timeout_ns);
        let mut url = address.at(match settings.mode {
            Mode::Closed => "/socket?mode=closed",
            Mode::Open => "/socket?mode=open",
        })?;
        url.set_scheme("ws")
            .map_err(|()| address.refused(&"it has no WebSocket"))?;
        let http = Http::try_new(address, config)?;
        Ok(Self {
            socket: Socket {
                session: http.session.clone(),
                check: config.check,
                url: url.to_string(),
                address: address.socket,
                mode: settings.mode,
                timeout,
            },
            http,
            timeout,
            line: Arc::default(),
        })
    }

    /// The channel to the current socket, or to a new one if there is none. A new one accepts orders
    /// at once, and executes them when it is open.
    fn orders(&self) -> mpsc::Sender<Order> {
        // A controller has only one thread, so this never blocks.
        let mut line = self.line.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Line { orders, .. }) = &*line
            && !orders.is_closed()
        {
            return orders.clone();
        }
        // No more messages than this can be under way.
        let (orders, given) = mpsc::channel(usize::from(Outstanding::CAP));
        let task = tokio::spawn(self.socket.clone().serve(given));
        *line = Some(Line {
            orders: orders.clone(),
            task,
        });
        orders
    }

    /// Gives an order to the current socket, or to the next one if that has just ended.
    async fn order(&self, mut order: Order) {
        while let Err(SendError(back)) = self.orders().send(order).await {
            order = back;
        }
    }
}

impl Transport for WebSocket {
    async fn observe(self) -> Result<Observation, ExchangeError> {
        self.http.observe().await
    }

    async fn open(self) {
        let (done, is_done) = oneshot::channel();
        let opened = async {
            self.order(Order::Open(done)).await;
            is_done.await
        };
        let _ = timeout(self.timeout, opened).await;
    }

    async fn exchange(self, command: Command) -> Result<Answer, ExchangeError> {
        let (answer, answered) = oneshot::channel();
        let waiting = Waiting {
            seq: command.seq,
            answer,
        };
        let ended = async {
            self.order(Order::Send(command, waiting)).await;
            answered.await
        };
        match timeout(self.timeout, ended).await {
            Ok(Ok(result)) => result,
            // The task gives every waiting message a reason when it ends, unless it is stopped.
            Ok(Err(_)) => Err(ExchangeError::Failed("the socket was given up".into())),
            Err(_) => Err(ExchangeError::Timeout),
        }
    }

    async fn close(self) {
        let line = self
            .line
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(Line { orders, task }) = line {
            drop(orders);
            let _ = timeout(LEAVE, task).await;
        }
        self.http.close().await;
    }
}
