//! Where a request or an answer ends, and what becomes of its connection.

use crate::http::lines::Lines;

/// The version of HTTP that a request is of, and so its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// HTTP/1.0.
    Http10,
    /// HTTP/1.1.
    Http11,
}

/// What becomes of a connection after an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Afterwards {
    /// Another request may follow.
    Keep,
    /// It is closed.
    Close,
}

/// How long a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// So many bytes.
    Bytes(u64),
    /// As long as its chunks say.
    Chunked,
}

/// What is to be expected behind the bytes that came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// More.
    MayCome,
    /// Nothing: the connection has ended, or it is too late.
    IsMissing,
}

impl Protocol {
    /// That of httparse's minor version.
    #[inline]
    pub(crate) fn of(minor: Option<u8>) -> Self {
        match minor {
            Some(1) => Self::Http11,
            _ => Self::Http10,
        }
    }
}

impl Afterwards {
    /// What a head of this version says (RFC 9112, 9.3).
    #[inline]
    pub(crate) fn of(lines: Lines<'_>, protocol: Protocol) -> Self {
        let keeps = !lines.says("connection", "close")
            && (protocol == Protocol::Http11 || lines.says("connection", "keep-alive"));
        if keeps { Self::Keep } else { Self::Close }
    }
}
