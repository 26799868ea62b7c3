//! How a client comes by the connections of its messages: what webloop's own clients are known to do, and what
//! the plant's count shows of a program of one's own.

use endpoint::{Carriage, Connection, ControllerSettings};
use plan::Client;

use crate::limit::WAITERS;

/// Which messages may have had a connection opened for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Connecting {
    /// One is opened in advance, and another where none is free: webloop's own clients. Where none is known to be
    /// free, one may have been opened, but no more than the plant accepted.
    Pool {
        /// Connections that the plant accepted; `None` where that is not known.
        accepted: Option<u64>,
    },
    /// Each message opens its own.
    Each,
    /// All messages share one, which was opened in advance.
    Shared,
    /// No message needs one, and none is sent again: what is lost never comes.
    None,
    /// A program's own way. Nobody knows which messages opened one, but no more than this did: the plant accepted
    /// no more. `None` where that is not known.
    Own {
        /// Connections that the plant accepted.
        accepted: Option<u64>,
    },
}

/// Whether a connection was opened for a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Opened {
    /// None was.
    No,
    /// None was free, as far as is known, so one may have been.
    Perhaps,
    /// One was: the handshake crossed the link before the message.
    Yes,
    /// Its rows do not tell.
    Untold,
}

impl Connecting {
    /// That of a client with these settings, to whose plant so many connections came.
    #[must_use]
    pub fn of(client: Client, settings: &ControllerSettings, accepted: Option<u64>) -> Connecting {
        if client.is_own() {
            // Its program is not bound by the settings.
            return Connecting::Own { accepted };
        }
        match (settings.transport.carriage(), settings.connection) {
            (Carriage::Stream, _) => Connecting::Shared,
            (Carriage::Datagrams, _) => Connecting::None,
            (Carriage::Requests, Connection::New) => Connecting::Each,
            // A browser opens some six to a host, and all other messages wait for these.
            (Carriage::Requests, Connection::Keep) => Connecting::Pool {
                accepted: accepted.filter(|_| !client.is_browser()),
            },
        }
    }

    /// Whether a connection was opened for a message that found one free, or none.
    pub(crate) fn opened(self, is_free: bool) -> Opened {
        match self {
            Connecting::Shared | Connecting::None => Opened::No,
            Connecting::Pool { .. } if is_free => Opened::No,
            Connecting::Pool { .. } => Opened::Perhaps,
            Connecting::Each => Opened::Yes,
            Connecting::Own { .. } => Opened::Untold,
        }
    }

    /// Whether so many messages may follow each other on one connection without waiting for answers.
    pub(crate) fn is_stream(self, count: usize) -> bool {
        match self {
            Connecting::Shared => true,
            Connecting::Own { .. } => self.most_untold(count) < count,
            Connecting::Pool { .. } | Connecting::Each | Connecting::None => false,
        }
    }

    /// Whether what is lost is sent again.
    pub(crate) fn resends(self) -> bool {
        self != Connecting::None
    }

    /// Whether it is known how many connections there were, at most, for messages that may have opened one.
    pub(crate) fn is_counted(self) -> bool {
        !matches!(self, Connecting::Pool { accepted: None })
    }

    /// How many of `count` messages may have waited for a connection to be opened although their rows do not tell.
    pub(crate) fn most_untold(self, count: usize) -> usize {
        let most = match self {
            Connecting::Own { accepted: Some(n) } => n,
            Connecting::Pool { accepted: Some(n) } => n.saturating_mul(WAITERS),
            _ => return count,
        };
        usize::try_from(most).unwrap_or(count).min(count)
    }
}
