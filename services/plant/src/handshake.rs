//! The handshake of a WebSocket, from the plant's side: RFC 6455, 4.2.

use endpoint::http::lines::Lines;
use hyper::{
    Response, StatusCode,
    body::Bytes,
    header::{self, HeaderValue},
};
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

/// Why a request does not open a socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{field}` is not a WebSocket's; /socket takes the handshake of RFC 6455, version 13")]
pub struct InvalidHandshake {
    /// The header that is another.
    pub(crate) field: &'static str,
}

/// The response that opens a socket, if the request asks for one.
///
/// # Errors
/// The header that is another.
pub fn response(lines: Lines<'_>) -> Result<Response<Bytes>, InvalidHandshake> {
    let expect = |field, given| {
        if given {
            Ok(())
        } else {
            Err(InvalidHandshake { field })
        }
    };
    expect("Connection", lines.says("connection", "upgrade"))?;
    expect("Upgrade", lines.says("upgrade", "websocket"))?;
    let version = lines.first("sec-websocket-version");
    expect("Sec-WebSocket-Version", version == Some(b"13"))?;
    let key = lines
        .first("sec-websocket-key")
        .filter(|key| is_key(key))
        .ok_or(InvalidHandshake {
            field: "Sec-WebSocket-Key",
        })?;
    let accept = HeaderValue::try_from(derive_accept_key(key)).expect("base64 is ASCII");
    let mut response = Response::new(Bytes::new());
    *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
    let answer = response.headers_mut();
    answer.insert(header::CONNECTION, HeaderValue::from_static("upgrade"));
    answer.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
    answer.insert(header::SEC_WEBSOCKET_ACCEPT, accept);
    Ok(response)
}

/// Whether this is the base64 encoding of 16 bytes.
fn is_key(key: &[u8]) -> bool {
    let digit = |byte: &u8| byte.is_ascii_alphanumeric() || b"+/".contains(byte);
    key.len() == 24 && key.ends_with(b"==") && key[..22].iter().all(digit)
}
