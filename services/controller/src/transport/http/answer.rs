//! A plant's answer, read from the bytes of its connection.
//!
//! Where it ends is read strictly (RFC 9112, 6.3), and it is not believed beyond a limit.

use std::{borrow::Cow, mem::MaybeUninit};

use httparse::{Header, ParserConfig, Status};
use reqwest::StatusCode;

/// Greatest number of header lines.
const LINES: usize = 100;

/// Greatest size of a head with its body. A plant's answers have some hundred bytes.
pub(super) const BYTES: usize = 64 * 1024;

/// A whole answer.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Answer<'a> {
    pub(super) status: StatusCode,
    pub(super) body: Cow<'a, [u8]>,
    /// Whether another request may follow on its connection.
    pub(super) keeps: bool,
}

/// Why bytes are no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Malformed {
    #[error("invalid HTTP version parsed")]
    Version,
    #[error("invalid HTTP status-code parsed")]
    Status,
    #[error("invalid HTTP header parsed")]
    Header,
    #[error("invalid content-length parsed")]
    Length,
    #[error("unexpected transfer-encoding parsed")]
    Coding,
    #[error("message head is too large")]
    Lines,
    #[error("the answer has more than {BYTES} bytes")]
    Long,
    #[error("connection closed before message completed")]
    Ended,
    #[error("error reading a body from connection: invalid chunk")]
    Chunk,
    #[error("error reading a body from connection: end of file before message length reached")]
    BodyEnded,
}

impl From<httparse::Error> for Malformed {
    fn from(error: httparse::Error) -> Self {
        match error {
            httparse::Error::Version => Self::Version,
            httparse::Error::Status => Self::Status,
            httparse::Error::TooManyHeaders => Self::Lines,
            _ => Self::Header,
        }
    }
}

/// Where a body ends.
enum Length {
    Bytes(usize),
    Chunked,
    /// Where the connection does.
    UntilEnd,
}

/// Reads the answer at the beginning of `bytes`; `None` if it is not whole yet. `has_ended` tells that no more
/// will come.
pub(super) fn read(bytes: &[u8], has_ended: bool) -> Result<Option<Answer<'_>>, Malformed> {
    let answer = whole(bytes, has_ended)?;
    if answer.is_none() && bytes.len() >= BYTES {
        return Err(Malformed::Long);
    }
    Ok(answer)
}

fn whole(mut bytes: &[u8], has_ended: bool) -> Result<Option<Answer<'_>>, Malformed> {
    loop {
        let mut lines = [const { MaybeUninit::uninit() }; LINES];
        let mut response = httparse::Response::new(&mut []);
        let parsed = ParserConfig::default().parse_response_with_uninit_headers(
            &mut response,
            bytes,
            &mut lines,
        );
        let Status::Complete(head) = parsed? else {
            return if has_ended {
                Err(Malformed::Ended)
            } else {
                Ok(None)
            };
        };
        let status = StatusCode::from_u16(response.code.unwrap_or_default())
            .map_err(|_| Malformed::Status)?;
        let rest = &bytes[head..];
        // Word that the answer is still to come.
        if status.is_informational() && status != StatusCode::SWITCHING_PROTOCOLS {
            bytes = rest;
            continue;
        }
        let is_new = response.version == Some(1);
        let length = length(status, response.headers, is_new)?;
        let (body, taken) = match length {
            Length::Bytes(length) => match rest.get(..length) {
                Some(body) => (Cow::Borrowed(body), length),
                None if has_ended => return Err(Malformed::BodyEnded),
                None => return Ok(None),
            },
            Length::Chunked => match chunks(rest)? {
                Some((body, taken)) => (Cow::Owned(body), taken),
                None if has_ended => return Err(Malformed::BodyEnded),
                None => return Ok(None),
            },
            Length::UntilEnd if has_ended => (Cow::Borrowed(rest), rest.len()),
            Length::UntilEnd => return Ok(None),
        };
        // What comes behind it is nobody's answer.
        let keeps = !has_ended
            && taken == rest.len()
            && !says(response.headers, "connection", "close")
            && (is_new || says(response.headers, "connection", "keep-alive"));
        return Ok(Some(Answer {
            status,
            body,
            keeps,
        }));
    }
}

fn length(status: StatusCode, lines: &[Header<'_>], is_new: bool) -> Result<Length, Malformed> {
    if matches!(
        status,
        StatusCode::SWITCHING_PROTOCOLS | StatusCode::NO_CONTENT | StatusCode::NOT_MODIFIED
    ) {
        return Ok(Length::Bytes(0));
    }
    if let Some(coding) = values(lines, "transfer-encoding").last() {
        if !is_new {
            return Err(Malformed::Coding);
        }
        let last = coding.rsplit(|byte| *byte == b',').next();
        let is_chunked =
            last.is_some_and(|word| word.trim_ascii().eq_ignore_ascii_case(b"chunked"));
        return Ok(if is_chunked {
            Length::Chunked
        } else {
            Length::UntilEnd
        });
    }
    let mut told = None;
    for value in values(lines, "content-length") {
        let digits = std::str::from_utf8(value).map_err(|_| Malformed::Length)?;
        if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(Malformed::Length);
        }
        let bytes: usize = digits.parse().map_err(|_| Malformed::Length)?;
        if told.replace(bytes).is_some_and(|other| other != bytes) {
            return Err(Malformed::Length);
        }
    }
    Ok(match told {
        Some(bytes) if bytes > BYTES => return Err(Malformed::Long),
        Some(bytes) => Length::Bytes(bytes),
        None => Length::UntilEnd,
    })
}

/// A body in chunks and the bytes that it took; `None` if it is not whole yet.
fn chunks(bytes: &[u8]) -> Result<Option<(Vec<u8>, usize)>, Malformed> {
    let (mut body, mut at) = (Vec::new(), 0);
    loop {
        let size = httparse::parse_chunk_size(&bytes[at..]).map_err(|_| Malformed::Chunk)?;
        let Status::Complete((line, size)) = size else {
            return Ok(None);
        };
        at += line;
        if size == 0 {
            break;
        }
        let size = usize::try_from(size).ok().filter(|size| *size <= BYTES);
        let size = size.ok_or(Malformed::Long)?;
        let Some(chunk) = bytes[at..].get(..size) else {
            return Ok(None);
        };
        body.extend_from_slice(chunk);
        at += size;
        match &bytes[at..] {
            [b'\r', b'\n', ..] => at += 2,
            [] | [b'\r'] => return Ok(None),
            _ => return Err(Malformed::Chunk),
        }
    }
    // Trailers, up to an empty line.
    loop {
        let rest = &bytes[at..];
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
            return Ok(None);
        };
        let line = rest[..end].strip_suffix(b"\r").ok_or(Malformed::Chunk)?;
        at += end + 1;
        if line.is_empty() {
            return Ok(Some((body, at)));
        }
    }
}

fn values<'a>(lines: &'a [Header<'_>], name: &'static str) -> impl Iterator<Item = &'a [u8]> {
    let lines = lines.iter();
    lines
        .filter(move |line| line.name.eq_ignore_ascii_case(name))
        .map(|line| line.value)
}

/// Whether a header that is a list of words has this one.
fn says(lines: &[Header<'_>], name: &'static str, word: &str) -> bool {
    values(lines, name)
        .flat_map(|value| value.split(|byte| *byte == b','))
        .any(|given| given.trim_ascii().eq_ignore_ascii_case(word.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OK: &str = "HTTP/1.1 200 OK\r\n";

    /// The body of a whole answer, and whether its connection is kept.
    fn body(text: &[u8], has_ended: bool) -> Option<(Vec<u8>, bool)> {
        let answer = read(text, has_ended).expect("no error")?;
        Some((answer.body.into_owned(), answer.keeps))
    }

    #[test]
    fn an_answer_is_whole_at_its_last_byte_and_not_before() {
        for (head, body_text, expected) in [
            ("Content-Length: 3\r\n", "u=1", "u=1"),
            ("content-length: 3\r\nContent-Length: 3\r\n", "u=1", "u=1"),
            ("Content-Length: 0\r\n", "", ""),
            (
                "Transfer-Encoding: chunked\r\n",
                "3\r\nu=1\r\n0\r\n\r\n",
                "u=1",
            ),
            (
                "Content-Length: 7\r\nTransfer-Encoding: gzip, Chunked\r\n",
                "1;a=b\r\nu\r\n2\r\n=1\r\n0\r\nA: b\r\n\r\n",
                "u=1",
            ),
        ] {
            let text = format!("HTTP/1.1 103 Wait\r\nA: b\r\n\r\n{OK}{head}\r\n{body_text}");
            let text = text.as_bytes();
            for end in 0..text.len() {
                assert_eq!(body(&text[..end], false), None, "{head}: {end}");
                assert!(read(&text[..end], true).is_err(), "{head}: {end}");
            }
            let expected = expected.as_bytes().to_vec();
            assert_eq!(body(text, false), Some((expected.clone(), true)), "{head}");
            let more = [text, b"HTTP"].concat();
            assert_eq!(body(&more, false), Some((expected, false)), "{head}");
        }
    }

    #[test]
    fn without_a_length_an_answer_ends_with_its_connection() {
        let text = format!("{OK}\r\nu=1");
        assert_eq!(body(text.as_bytes(), false), None);
        assert_eq!(body(text.as_bytes(), true), Some((b"u=1".to_vec(), false)));
        let none = b"HTTP/1.1 204 No Content\r\n\r\n";
        assert_eq!(body(none, false), Some((Vec::new(), true)));
    }

    #[test]
    fn whether_the_connection_is_kept_is_said_in_one_of_its_words() {
        for (start, line, keeps) in [
            ("HTTP/1.1 200 OK", "", true),
            (
                "HTTP/1.1 200 OK",
                "Connection: keep-alive, CLOSE\r\n",
                false,
            ),
            ("HTTP/1.0 200 OK", "", false),
            ("HTTP/1.0 200 OK", "Connection: Keep-Alive\r\n", true),
        ] {
            let text = format!("{start}\r\n{line}Content-Length: 0\r\n\r\n");
            assert_eq!(
                body(text.as_bytes(), false),
                Some((Vec::new(), keeps)),
                "{start} {line}"
            );
        }
    }

    #[test]
    fn what_is_no_answer_is_named_and_what_is_too_long_ends() {
        for (text, error) in [
            ("HTTQ/1.1 200 OK\r\n\r\n".to_owned(), Malformed::Version),
            ("HTTP/1.1 2x0 OK\r\n\r\n".to_owned(), Malformed::Status),
            (format!("{OK}a b\r\n\r\n"), Malformed::Header),
            (format!("{OK}Content-Length: +3\r\n\r\n"), Malformed::Length),
            (
                format!("{OK}Content-Length: 3\r\nContent-Length: 4\r\n\r\n"),
                Malformed::Length,
            ),
            (
                format!("{OK}Content-Length: 99999999\r\n\r\n"),
                Malformed::Long,
            ),
            (
                "HTTP/1.0 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n".to_owned(),
                Malformed::Coding,
            ),
            (
                format!("{OK}Transfer-Encoding: chunked\r\n\r\nx\r\n"),
                Malformed::Chunk,
            ),
            (
                format!("{OK}Transfer-Encoding: chunked\r\n\r\n1\r\nuu"),
                Malformed::Chunk,
            ),
            (
                format!("{OK}Transfer-Encoding: chunked\r\n\r\nfffffffff\r\n"),
                Malformed::Long,
            ),
            (format!("{OK}{}", "A: b\r\n".repeat(101)), Malformed::Lines),
            (format!("{OK}A: {}", "x".repeat(BYTES)), Malformed::Long),
        ] {
            assert_eq!(
                read(text.as_bytes(), false),
                Err(error),
                "{}",
                &text[..40.min(text.len())]
            );
        }
    }
}
