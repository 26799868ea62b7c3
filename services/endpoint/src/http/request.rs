//! The head of a request, read strictly.
//!
//! What two readers could take for different requests is refused, whatever a lenient one would make of it: lines
//! that do not end with CR LF, a body with two lengths, lengths that are not digits, codings that are not
//! `chunked` once. `httparse` reads names and values; whoever serves judges what is asked.

use hyper_http::{Uri, uri::PathAndQuery};

use crate::http::{
    body::Chunks,
    framing::{Afterwards, Length, Protocol, Rest},
    lines::{self, LINES, Lines, Room},
};

/// Greatest size of a head.
pub const HEAD_BYTES: usize = 16 * 1024;

/// A head, with what it says of its connection. It borrows the bytes that it was read from.
#[derive(Clone, Copy, Debug)]
pub struct Head<'a> {
    /// The method.
    pub method: &'a str,
    /// What is asked for.
    pub target: Target<'a>,
    /// Its version.
    pub protocol: Protocol,
    /// Its header lines.
    pub lines: Lines<'a>,
    /// The bytes that it took.
    pub bytes: usize,
    /// Where its request ends.
    pub framing: Framing,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target<'a> {
    /// The path.
    pub path: &'a str,
    /// The query; empty if there is none.
    pub query: &'a str,
    /// The host, if it names one.
    pub authority: Authority<'a>,
}

/// What a target says of a host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Authority<'a> {
    /// Nothing, as nearly all: the host is in `Host`.
    Absent,
    /// That it is this one, over `http` (RFC 9112, 3.2.2).
    Http(&'a str),
    /// What only a proxy takes.
    Proxys,
}

/// Where the request ends, and what is to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// How long the body is.
    pub length: Length,
    /// What becomes of the connection.
    pub then: Afterwards,
    /// Whether the client waits for a word before it sends the body.
    pub waits: bool,
}

/// Why bytes are not a head.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Malformed {
    /// It is too long.
    #[error("the request's head has more than {HEAD_BYTES} bytes or {LINES} lines; send less")]
    Long,
    /// It can be read in two ways, or in none.
    #[error("the request is not HTTP/1.1: {0}")]
    Syntax(&'static str),
}

/// Reads the head at the beginning of `bytes`; `None` if it is not whole yet. Its lines are put into `room`.
///
/// # Errors
/// If it is too long, or can be read in two ways or in none.
#[inline]
pub fn read<'a>(bytes: &'a [u8], room: &'a mut Room<'a>) -> Result<Option<Head<'a>>, Malformed> {
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
    let lines = Lines(headers);
    let protocol = Protocol::of(version);
    let framing = Framing {
        length: length(lines, protocol)?,
        then: Afterwards::of(lines, protocol),
        waits: protocol == Protocol::Http11 && lines.says("expect", "100-continue"),
    };
    Ok(Some(Head {
        method: method.unwrap_or_default(),
        target,
        protocol,
        lines,
        bytes: before + bytes,
        framing,
    }))
}

impl Head<'_> {
    /// The head with the chunks behind it that amount to no body, which a library may write for none (RFC 9112, 7.1);
    /// `None` while that cannot be told. A POST has a body all the same.
    #[inline]
    pub fn settled(mut self, behind: &[u8], rest: Rest) -> Option<Self> {
        if self.framing.length == Length::Chunked && self.method != "POST" {
            match Chunks::of(behind) {
                Chunks::Empty(bytes) => {
                    self.framing.length = Length::Bytes(0);
                    self.bytes += bytes;
                }
                Chunks::Unknown if rest == Rest::MayCome && !self.framing.waits => return None,
                Chunks::Unknown | Chunks::Full => {}
            }
        }
        Some(self)
    }

    /// Whether its request has a body.
    #[inline]
    pub fn has_body(&self) -> bool {
        self.framing.length != Length::Bytes(0)
    }
}

impl<'a> Target<'a> {
    /// Takes a target apart, if it is one.
    fn read(text: &'a str) -> Option<Self> {
        let is_shown = |byte: u8| byte.is_ascii_graphic() && byte != b'#';
        if !text.bytes().all(is_shown) {
            return None;
        }
        if !text.starts_with('/') {
            return Self::absolute(text);
        }
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/?&=.,+-_%".contains(&byte);
        if !text.bytes().all(is_plain) {
            PathAndQuery::try_from(text).ok()?;
        }
        let (path, query) = text.split_once('?').unwrap_or((text, ""));
        Some(Self {
            path,
            query,
            authority: Authority::Absent,
        })
    }

    /// Takes one apart that does not begin with a slash: `http://host/path`, which a server takes too, what is for
    /// proxies, `host:port` or another scheme, and `*`.
    fn absolute(text: &'a str) -> Option<Self> {
        let uri = Uri::try_from(text).ok()?;
        let (path, query, authority) = match (uri.authority(), text.split_once("://")) {
            (None, _) => (text, "", Authority::Absent),
            (Some(_), Some((scheme, rest))) if scheme.eq_ignore_ascii_case("http") => {
                let end = rest.find(['/', '?']).unwrap_or(rest.len());
                let (host, rest) = rest.split_at(end);
                let (path, query) = rest.split_once('?').unwrap_or((rest, ""));
                let path = if path.is_empty() { "/" } else { path };
                (path, query, Authority::Http(host))
            }
            (Some(_), _) => (text, "", Authority::Proxys),
        };
        Some(Self {
            path,
            query,
            authority,
        })
    }
}

/// The length of the body. Each doubt is an error: a proxy in front may see it another way.
fn length(lines: Lines<'_>, protocol: Protocol) -> Result<Length, Malformed> {
    let refuse = |what| Err(Malformed::Syntax(what));
    let mut codings = lines.all("transfer-encoding");
    let mut lengths = lines.all("content-length");
    match (codings.next(), lengths.next()) {
        (None, None) => Ok(Length::Bytes(0)),
        (Some(_), Some(_)) => refuse("it has both Content-Length and Transfer-Encoding"),
        (Some(coding), None) => {
            let is_chunked = coding.eq_ignore_ascii_case(b"chunked");
            if protocol == Protocol::Http11 && is_chunked && codings.next().is_none() {
                Ok(Length::Chunked)
            } else {
                refuse("its Transfer-Encoding is not `chunked`, once")
            }
        }
        (None, Some(length)) => match lines::number(length) {
            Some(bytes) if lengths.next().is_none() => Ok(Length::Bytes(bytes)),
            _ => refuse("its Content-Length is not one number"),
        },
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
    lines::words(error).unwrap_or("it does not begin with a method, a path and a version")
}

#[cfg(test)]
mod tests {
    use hyper_http::header::{HeaderName, HeaderValue};
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_head_is_the_same_however_it_arrives() {
        let text = b"\r\nPOST /session HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\nu=1";
        for end in 0..text.len() - 3 {
            assert!(
                matches!(read(&text[..end], &mut lines::room()), Ok(None)),
                "{end}"
            );
        }
        for end in text.len() - 3..=text.len() {
            let mut room = lines::room();
            let head = read(&text[..end], &mut room).expect("HTTP").expect("whole");
            assert_eq!(head.bytes, text.len() - 3);
            let framing = Framing {
                length: Length::Bytes(3),
                then: Afterwards::Keep,
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
            text in r"(/|//||http://|HTTP://a|https://a|http://a:1)([a-z0-9/?&=.,+_%:@~;!$*'()\[\]|{}<>\\^`-]|\x22){0,12}",
        ) {
            let own = Target::read(&text);
            match taken_apart(&text) {
                None => prop_assert_eq!(own, None),
                Some((path, query, has_authority)) => {
                    let own = own.expect("a target");
                    prop_assert_eq!(own.authority != Authority::Absent, has_authority);
                    if own.authority != Authority::Proxys {
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
            let mut room = lines::room();
            if let Ok(Some(head)) = read(&text, &mut room) {
                for line in head.lines.0 {
                    prop_assert!(HeaderName::from_bytes(line.name.as_bytes()).is_ok());
                    let value = HeaderValue::from_bytes(line.value);
                    let value = value.expect("a value");
                    prop_assert_eq!(text_of(&value), lines::text(line.value));
                }
            }
        }
    }

    fn text_of(value: &HeaderValue) -> Option<&str> {
        value.to_str().ok()
    }
}
