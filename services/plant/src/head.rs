//! The head of a request, read strictly.
//!
//! What two readers could take for different requests is refused, whatever a lenient one would make of it: lines
//! that do not end with CR LF, a body with two lengths, lengths that are not digits, codings that are not
//! `chunked` once. `httparse` reads names and values; `route` judges what is asked.

use std::mem::MaybeUninit;

use httparse::Header;
use hyper::{Uri, http::uri::PathAndQuery};

/// Greatest size of a head.
pub(crate) const HEAD_BYTES: usize = 16 * 1024;

/// Greatest number of header lines.
const LINES: usize = 100;

/// Room for the lines of a head.
pub(crate) type Room<'a> = [MaybeUninit<Header<'a>>; LINES];

/// Room that nothing has been put into.
pub(crate) fn room<'a>() -> Room<'a> {
    [const { MaybeUninit::uninit() }; LINES]
}

/// A head, with what it says of its connection. It borrows the bytes that it was read from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Head<'a> {
    pub(crate) method: &'a str,
    pub(crate) target: Target<'a>,
    /// Whether it is of HTTP/1.1, and not of HTTP/1.0.
    pub(crate) is_new: bool,
    pub(crate) lines: Lines<'a>,
    /// The bytes that it took.
    pub(crate) bytes: usize,
    pub(crate) framing: Framing,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target<'a> {
    pub(crate) path: &'a str,
    /// Empty if there is none.
    pub(crate) query: &'a str,
    /// Whether it names a host too, as for a proxy.
    pub(crate) has_authority: bool,
}

/// Header lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lines<'a>(pub(crate) &'a [Header<'a>]);

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

/// Reads the head at the beginning of `bytes`; `None` if it is not whole yet. Its lines are put into `room`.
pub(crate) fn read<'a>(
    bytes: &'a [u8],
    room: &'a mut Room<'a>,
) -> Result<Option<Head<'a>>, Malformed> {
    // A client may send an empty line after a body (RFC 9112, 2.2).
    let before = if bytes.starts_with(b"\r\n") { 2 } else { 0 };
    let text = &bytes[before..];
    if text.first().is_some_and(|byte| b"\r\n".contains(byte)) && text != b"\r" {
        return Err(Malformed::Syntax("it begins with empty lines"));
    }
    let mut request = httparse::Request::new(&mut []);
    let bytes = match request.parse_with_uninit_headers(text, room) {
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
    let httparse::Request {
        method,
        path,
        version,
        headers,
    } = request;
    let target = Target::read(path.unwrap_or_default())
        .ok_or(Malformed::Syntax("the request target is not a path"))?;
    let (is_new, lines) = (version == Some(1), Lines(headers));
    let length = length(lines, is_new)?;
    let keeps =
        !lines.says("connection", "close") && (is_new || lines.says("connection", "keep-alive"));
    let waits = is_new && lines.says("expect", "100-continue");
    Ok(Some(Head {
        method: method.unwrap_or_default(),
        target,
        is_new,
        lines,
        bytes: before + bytes,
        framing: Framing {
            length,
            keeps,
            waits,
        },
    }))
}

impl<'a> Target<'a> {
    /// Takes a target apart, if it is one.
    fn read(text: &'a str) -> Option<Self> {
        let is_shown = |byte: u8| byte.is_ascii_graphic() && byte != b'#';
        if !text.bytes().all(is_shown) {
            return None;
        }
        if !text.starts_with('/') {
            // `CONNECT host:port` and `GET http://host/path` are for proxies; besides there is only `*`.
            let uri = Uri::try_from(text).ok()?;
            return Some(Self {
                path: text,
                query: "",
                has_authority: uri.authority().is_some(),
            });
        }
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/?&=.,+-_%".contains(&byte);
        if !text.bytes().all(is_plain) {
            PathAndQuery::try_from(text).ok()?;
        }
        let (path, query) = text.split_once('?').unwrap_or((text, ""));
        Some(Self {
            path,
            query,
            has_authority: false,
        })
    }
}

impl<'a> Lines<'a> {
    /// The values of all lines with this name.
    pub(crate) fn all(self, name: &'static str) -> impl Iterator<Item = &'a [u8]> {
        let lines = self.0.iter();
        lines
            .filter(move |line| line.name.eq_ignore_ascii_case(name))
            .map(|line| line.value)
    }

    /// The value of the first line with this name.
    pub(crate) fn first(self, name: &'static str) -> Option<&'a [u8]> {
        self.all(name).next()
    }

    /// Whether a header that is a list of words has this one.
    pub(crate) fn says(self, name: &'static str, word: &str) -> bool {
        self.all(name)
            .filter_map(text)
            .flat_map(|value| value.split(','))
            .any(|given| given.trim().eq_ignore_ascii_case(word))
    }
}

/// A value, if it is plain text.
pub(crate) fn text(value: &[u8]) -> Option<&str> {
    std::str::from_utf8(value).ok().filter(|text| {
        text.bytes()
            .all(|byte| byte == b'\t' || (b' '..=b'~').contains(&byte))
    })
}

/// The length of the body. Each doubt is an error: a proxy in front may see it another way.
fn length(lines: Lines<'_>, is_new: bool) -> Result<Length, Malformed> {
    let refuse = |what| Err(Malformed::Syntax(what));
    let mut codings = lines.all("transfer-encoding");
    let mut lengths = lines.all("content-length");
    match (codings.next(), lengths.next()) {
        (None, None) => Ok(Length::Bytes(0)),
        (Some(_), Some(_)) => refuse("it has both Content-Length and Transfer-Encoding"),
        (Some(coding), None) => {
            let is_chunked = coding.eq_ignore_ascii_case(b"chunked");
            if is_new && is_chunked && codings.next().is_none() {
                Ok(Length::Chunked)
            } else {
                refuse("its Transfer-Encoding is not `chunked`, once")
            }
        }
        (None, Some(length)) => {
            let digits = text(length)
                .filter(|text| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()));
            match digits.and_then(|digits| digits.parse().ok()) {
                Some(bytes) if lengths.next().is_none() => Ok(Length::Bytes(bytes)),
                _ => refuse("its Content-Length is not one number"),
            }
        }
    }
}

/// Whether CR and LF are only found together; the last byte may wait for its other half.
fn has_whole_lines(text: &[u8]) -> Result<(), Malformed> {
    // Without a way out, so that it is done for many bytes at once.
    let mut is_torn = text.first() == Some(&b'\n');
    for (before, byte) in text.iter().zip(text.iter().skip(1)) {
        is_torn |= (*before == b'\r') != (*byte == b'\n');
    }
    if is_torn {
        return Err(Malformed::Syntax("a line does not end with CR LF"));
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
    use hyper::header::{HeaderName, HeaderValue};
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_head_is_the_same_however_it_arrives() {
        let text = b"\r\nPOST /session HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\nu=1";
        for end in 0..text.len() - 3 {
            assert!(matches!(read(&text[..end], &mut room()), Ok(None)), "{end}");
        }
        for end in text.len() - 3..=text.len() {
            let mut room = room();
            let head = read(&text[..end], &mut room).expect("HTTP").expect("whole");
            assert_eq!(head.bytes, text.len() - 3);
            let framing = Framing {
                length: Length::Bytes(3),
                keeps: true,
                waits: false,
            };
            assert_eq!(head.framing, framing);
        }
    }

    /// What a general library makes of a target.
    fn taken_apart(text: &str) -> Option<(String, String, bool)> {
        if !text
            .bytes()
            .all(|byte| byte.is_ascii_graphic() && byte != b'#')
        {
            return None;
        }
        let uri = Uri::try_from(text).ok()?;
        let query = uri.query().unwrap_or_default().to_owned();
        Some((uri.path().to_owned(), query, uri.authority().is_some()))
    }

    proptest! {
        #[test]
        fn a_target_is_what_a_general_library_takes_it_for(
            text in r"(/|//|)([a-z0-9/?&=.,+_%:@~;!$*'()\[\]|{}<>\\^`-]|\x22){0,12}",
        ) {
            let own = Target::read(&text);
            match taken_apart(&text) {
                None => prop_assert_eq!(own, None),
                Some((path, query, has_authority)) => {
                    let own = own.expect("a target");
                    prop_assert_eq!(own.has_authority, has_authority);
                    if !has_authority {
                        prop_assert_eq!((own.path, own.query), (&*path, &*query));
                    }
                }
            }
        }

        /// So that lines need not be checked again.
        #[test]
        fn every_line_that_is_read_is_one_for_a_general_library(
            line in prop::collection::vec(any::<u8>(), 0..12), name in "[!-~]{0,6}",
        ) {
            let text = [b"GET / HTTP/1.1\r\n", name.as_bytes(), b":", &line, b"\r\n\r\n"].concat();
            let mut room = room();
            if let Ok(Some(head)) = read(&text, &mut room) {
                for line in head.lines.0 {
                    prop_assert!(HeaderName::from_bytes(line.name.as_bytes()).is_ok());
                    let value = HeaderValue::from_bytes(line.value);
                    let value = value.expect("a value");
                    prop_assert_eq!(text_of(&value), super::text(line.value));
                }
            }
        }
    }

    fn text_of(value: &HeaderValue) -> Option<&str> {
        value.to_str().ok()
    }
}
