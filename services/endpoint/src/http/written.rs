//! An answer as it is sent.

use hyper_http::StatusCode;

use crate::http::framing::{Afterwards, Protocol};

/// Room for a head, so that most are written without moving them.
const HEAD_BYTES: usize = 256;

/// Writes an answer with these header lines, in any pieces, and this body; what its framing needs is added. `then` is
/// said where its version does not say it; `None` if a line says it already. `date` is the time of day, as RFC 9110
/// writes it.
pub fn written(
    status: StatusCode,
    protocol: Protocol,
    then: Option<Afterwards>,
    lines: &[&[u8]],
    date: &str,
    body: &[u8],
) -> Vec<u8> {
    let mut text = Vec::with_capacity(HEAD_BYTES + body.len());
    match (status, protocol) {
        // Nearly all: a message passes through here.
        (StatusCode::OK, Protocol::Http11) => put(&mut text, [b"HTTP/1.1 200 OK\r\n"]),
        _ => {
            let version = match protocol {
                Protocol::Http11 => b"HTTP/1.1 ",
                Protocol::Http10 => b"HTTP/1.0 ",
            };
            let reason = status.canonical_reason().unwrap_or_default().as_bytes();
            let status = status.as_str().as_bytes();
            put(&mut text, [version, status, b" ", reason, b"\r\n"]);
        }
    }
    for piece in lines {
        text.extend_from_slice(piece);
    }
    if !status.is_informational() && status != StatusCode::NO_CONTENT {
        let mut digits = itoa::Buffer::new();
        let length = digits.format(body.len()).as_bytes();
        put(&mut text, [b"content-length: ", length, b"\r\n"]);
    }
    let label: &[u8] = match (then, protocol) {
        (Some(Afterwards::Close), Protocol::Http11) => b"connection: close\r\ndate: ",
        (Some(Afterwards::Keep), Protocol::Http10) => b"connection: keep-alive\r\ndate: ",
        _ => b"date: ",
    };
    put(&mut text, [label, date.as_bytes(), b"\r\n\r\n", body]);
    text
}

fn put<const N: usize>(text: &mut Vec<u8>, parts: [&[u8]; N]) {
    for part in parts {
        text.extend_from_slice(part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_says_where_it_ends_and_what_follows() {
        use Afterwards::{Close, Keep};
        use Protocol::{Http10, Http11};
        for (status, protocol, then, lines, expected) in [
            (
                200,
                Http11,
                Some(Keep),
                "",
                "HTTP/1.1 200 OK\r\ncontent-length: 3\r\n",
            ),
            (
                200,
                Http11,
                Some(Close),
                "a: b\r\n",
                "HTTP/1.1 200 OK\r\na: b\r\ncontent-length: 3\r\nconnection: close\r\n",
            ),
            (
                409,
                Http11,
                None,
                "connection: close\r\n",
                "HTTP/1.1 409 Conflict\r\nconnection: close\r\ncontent-length: 3\r\n",
            ),
            (
                200,
                Http10,
                Some(Keep),
                "",
                "HTTP/1.0 200 OK\r\ncontent-length: 3\r\nconnection: keep-alive\r\n",
            ),
            (
                200,
                Http10,
                Some(Close),
                "",
                "HTTP/1.0 200 OK\r\ncontent-length: 3\r\n",
            ),
            (
                101,
                Http11,
                Some(Keep),
                "connection: upgrade\r\n",
                "HTTP/1.1 101 Switching Protocols\r\nconnection: upgrade\r\n",
            ),
            (204, Http11, Some(Keep), "", "HTTP/1.1 204 No Content\r\n"),
        ] {
            let status = StatusCode::from_u16(status).expect("a status");
            let text = written(status, protocol, then, &[lines.as_bytes()], "now", b"u=1");
            let expected = format!("{expected}date: now\r\n\r\nu=1");
            assert_eq!(String::from_utf8_lossy(&text), expected);
        }
    }
}
