//! Why a message has no valid answer, in the words of `first_failure`.

use std::{io, rc::Rc};

use endpoint::InvalidMessage;
use endpoint::http::{StatusCode, answer::InvalidAnswer};
use tokio_tungstenite::tungstenite::Error;

/// Number of characters of a plant's text that are quoted.
const EXCERPT_CHARS: usize = 200;

/// Why a message has no valid answer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ExchangeError {
    /// No answer in time.
    #[error("no answer in time")]
    Timeout,
    /// No connection could be opened.
    #[error("cannot connect to the plant: {0}")]
    Connecting(io::Error),
    /// The connection broke before the answer was whole.
    #[error("the connection to the plant broke: {0}")]
    Broken(io::Error),
    /// What came is no answer in HTTP.
    #[error(transparent)]
    Answer(#[from] InvalidAnswer),
    /// The plant does not take the request.
    #[error("the plant answered {}", said(*status, text))]
    Refused {
        /// Its status.
        status: StatusCode,
        /// What it says, short enough for a line.
        text: String,
    },
    /// The answer's text is not that of an answer to this message.
    #[error("the plant's answer cannot be read: {0}")]
    Message(#[from] InvalidMessage),
    /// The plant took a claim and gave no session.
    #[error("the claim's answer has no session: {text}")]
    NoSession {
        /// What it says, short enough for a line.
        text: String,
    },
    /// The socket of all messages under way broke, or none could be opened.
    #[error("{0}")]
    Socket(Rc<SocketError>),
    /// The controller ended meanwhile.
    #[error("the controller has ended")]
    Ended,
}

impl ExchangeError {
    /// What a plant says to a request that it does not take.
    pub(super) fn refused(status: StatusCode, text: &str) -> Self {
        let text = excerpt(text);
        Self::Refused { status, text }
    }
}

/// Why a socket could not be opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OpeningError {
    #[error(transparent)]
    Connection(#[from] io::Error),
    /// No session could be claimed, or the plant answered, but not with a socket.
    #[error(transparent)]
    Refused(#[from] ExchangeError),
    #[error(transparent)]
    Handshake(Box<Error>),
}

/// Why messages in a socket fail.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SocketError {
    #[error("cannot open {url}: {problem}")]
    Opening { url: String, problem: OpeningError },
    #[error("the socket broke: {0}")]
    Broken(Box<Error>),
    /// Without a number the answer cannot be assigned to a message.
    #[error("the plant's answer cannot be read: {0}")]
    Invalid(InvalidMessage),
    #[error("the plant's answer is bytes, not text")]
    Binary,
    #[error("the plant closed the socket")]
    Closed,
    #[error("the plant closed the socket: {code} {reason}")]
    ClosedFor { code: u16, reason: String },
    #[error("the plant closed the connection: {reason}")]
    Said { reason: String },
    #[error("a line of the plant is too long")]
    Long,
    #[error("the plant takes no datagrams: {0}; start it with --udp")]
    Datagram(io::Error),
    #[error("the plant hung up")]
    HungUp,
}

impl SocketError {
    pub(super) fn broken(error: Error) -> Self {
        Self::Broken(Box::new(error))
    }
}

/// A status as a number, with its name and the text, if there are any.
fn said(status: StatusCode, text: &str) -> String {
    let reason = status.canonical_reason().unwrap_or_default();
    let mut said = status.as_str().to_owned();
    for (before, part) in [(" ", reason), (": ", text)] {
        if !part.is_empty() {
            said = said + before + part;
        }
    }
    said
}

/// The beginning of a plant's text, short enough for a line.
pub(super) fn excerpt(text: &str) -> String {
    text::excerpt(text.trim_end(), EXCERPT_CHARS)
}
