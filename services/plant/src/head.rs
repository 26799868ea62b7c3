//! The head of a request, read strictly.
//!
//! What two readers could take for different requests is refused, whatever a lenient one would make of it: lines
//! that do not end with CR LF, a body with two lengths, lengths that are not digits, codings that are not
//! `chunked` once. `httparse` reads names and values; `route` judges what is asked.

use hyper::{
    Method, Request, Uri, Version,
    header::{self, HeaderMap, HeaderName, HeaderValue},
    http::request::Parts,
};

/// Greatest size of a head.
pub(crate) const HEAD_BYTES: usize = 16 * 1024;

/// Greatest number of header lines.
const LINES: usize = 100;

/// A head, with what it says of its connection.
pub(crate) struct Head {
    pub(crate) parts: Box<Parts>,
    /// The bytes that it took.
    pub(crate) bytes: usize,
    pub(crate) framing: Framing,
}

/// Where the request ends, and what is to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Framing {
    pub(crate) length: Length,
    /// Whether the client wants to send another request on this connection.
    pub(crate) keeps: bool,
    /// Whether the client waits for a word before it sends the body.
    pub(crate) waits: bool,
}

/// How long the body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Length {
    Bytes(u64),
    /// As long as its chunks say.
    Chunked,
}

/// Why bytes are not a head.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Malformed {
    #[error("the request's head has more than {HEAD_BYTES} bytes or {LINES} lines; send less")]
    Long,
    #[error("the request is not HTTP/1.1: {0}")]
    Syntax(&'static str),
}

/// Reads the head at the beginning of `bytes`; `None` if it is not whole yet.
pub(crate) fn read(bytes: &[u8]) -> Result<Option<Head>, Malformed> {
    // A client may send an empty line after a body (RFC 9112, 2.2).
    let before = if bytes.starts_with(b"\r\n") { 2 } else { 0 };
    let text = &bytes[before..];
    if text.first().is_some_and(|byte| b"\r\n".contains(byte)) && text != b"\r" {
        return Err(Malformed::Syntax("it begins with empty lines"));
    }
    let mut lines = [httparse::EMPTY_HEADER; LINES];
    let mut request = httparse::Request::new(&mut lines);
    let bytes = match request.parse(text) {
        Ok(httparse::Status::Complete(bytes)) => bytes,
        Ok(httparse::Status::Partial) => {
            has_whole_lines(text)?;
            let long = text.len() >= HEAD_BYTES;
            return if long { Err(Malformed::Long) } else { Ok(None) };
        }
        Err(httparse::Error::TooManyHeaders) => return Err(Malformed::Long),
        Err(error) => return Err(Malformed::Syntax(words(error))),
    };
    if bytes > HEAD_BYTES {
        return Err(Malformed::Long);
    }
    has_whole_lines(&text[..bytes])?;
    Ok(Some(take(&request, before + bytes)?))
}

fn take(request: &httparse::Request<'_, '_>, bytes: usize) -> Result<Head, Malformed> {
    let wrong = |what| move || Malformed::Syntax(what);
    let (mut parts, ()) = Request::new(()).into_parts();
    let method = request.method.unwrap_or_default().as_bytes();
    parts.method = Method::from_bytes(method)
        .ok()
        .ok_or_else(wrong("the method is not a word"))?;
    let target = request.path.unwrap_or_default();
    parts.uri = Some(target)
        .filter(|target| {
            target
                .bytes()
                .all(|byte| byte.is_ascii_graphic() && byte != b'#')
        })
        .and_then(|target| Uri::try_from(target).ok())
        .ok_or_else(wrong("the request target is not a path"))?;
    parts.version = match request.version {
        Some(1) => Version::HTTP_11,
        _ => Version::HTTP_10,
    };
    let headers = &mut parts.headers;
    for line in request.headers.iter() {
        let name = HeaderName::from_bytes(line.name.as_bytes());
        let value = HeaderValue::from_bytes(line.value);
        let (Ok(name), Ok(value)) = (name, value) else {
            return Err(Malformed::Syntax("a header line is not `name: value`"));
        };
        headers.append(name, value);
    }
    let length = length(&parts.headers, parts.version)?;
    let is_new = parts.version == Version::HTTP_11;
    let keeps = !says(&parts.headers, &header::CONNECTION, "close")
        && (is_new || says(&parts.headers, &header::CONNECTION, "keep-alive"));
    let waits = is_new && says(&parts.headers, &header::EXPECT, "100-continue");
    Ok(Head {
        parts: Box::new(parts),
        bytes,
        framing: Framing {
            length,
            keeps,
            waits,
        },
    })
}

/// The length of the body. Each doubt is an error: a proxy in front may see it another way.
fn length(headers: &HeaderMap, version: Version) -> Result<Length, Malformed> {
    let refuse = |what| Err(Malformed::Syntax(what));
    let mut codings = headers.get_all(header::TRANSFER_ENCODING).iter();
    let mut lengths = headers.get_all(header::CONTENT_LENGTH).iter();
    match (codings.next(), lengths.next()) {
        (None, None) => Ok(Length::Bytes(0)),
        (Some(_), Some(_)) => refuse("it has both Content-Length and Transfer-Encoding"),
        (Some(coding), None) => {
            let is_chunked = coding.as_bytes().eq_ignore_ascii_case(b"chunked");
            if version == Version::HTTP_11 && is_chunked && codings.next().is_none() {
                Ok(Length::Chunked)
            } else {
                refuse("its Transfer-Encoding is not `chunked`, once")
            }
        }
        (None, Some(length)) => {
            let digits = length
                .to_str()
                .ok()
                .filter(|text| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()));
            match digits.and_then(|digits| digits.parse().ok()) {
                Some(bytes) if lengths.next().is_none() => Ok(Length::Bytes(bytes)),
                _ => refuse("its Content-Length is not one number"),
            }
        }
    }
}

/// Whether a header that is a list of words has this one.
fn says(headers: &HeaderMap, name: &HeaderName, word: &str) -> bool {
    let values = headers.get_all(name).iter();
    values
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .any(|given| given.trim().eq_ignore_ascii_case(word))
}

/// Whether CR and LF are only found together; the last byte may wait for its other half.
fn has_whole_lines(text: &[u8]) -> Result<(), Malformed> {
    let mut before = 0;
    for &byte in text {
        if (byte == b'\n') != (before == b'\r') {
            return Err(Malformed::Syntax("a line does not end with CR LF"));
        }
        before = byte;
    }
    Ok(())
}

fn words(error: httparse::Error) -> &'static str {
    match error {
        httparse::Error::HeaderName => "the name of a header is not a word",
        httparse::Error::HeaderValue => "the value of a header has a control character",
        httparse::Error::NewLine => "a line does not end with CR LF",
        httparse::Error::Version => "its version is not HTTP/1.1 or HTTP/1.0",
        _ => "it does not begin with a method, a path and a version",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_is_the_same_however_it_arrives() {
        let text = b"\r\nPOST /session HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\nu=1";
        for end in 0..text.len() - 3 {
            assert!(matches!(read(&text[..end]), Ok(None)), "{end}");
        }
        for end in text.len() - 3..=text.len() {
            let head = read(&text[..end]).expect("HTTP").expect("whole");
            assert_eq!(head.bytes, text.len() - 3);
            let framing = Framing {
                length: Length::Bytes(3),
                keeps: true,
                waits: false,
            };
            assert_eq!(head.framing, framing);
        }
    }
}
