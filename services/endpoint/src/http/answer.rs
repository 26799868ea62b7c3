//! An answer, read from the bytes of its connection when it is whole.
//!
//! Where it ends is read strictly (RFC 9112, 6.3), and it is not believed beyond a limit.

use std::borrow::Cow;

use httparse::{ParserConfig, Response, Status};
use hyper_http::StatusCode;

use crate::http::{
    body::{Body, InvalidBody},
    framing::{Afterwards, Length, Protocol, Rest},
    lines::{self, LINES, Lines},
};

/// A whole answer.
#[derive(Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// Its status.
    pub status: StatusCode,
    /// Its body.
    pub body: Cow<'a, [u8]>,
    /// Whether another request may follow on its connection.
    pub then: Afterwards,
}

/// Why bytes are no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidAnswer {
    /// A line of its head is none, or says what HTTP/1.1 does not know.
    #[error("the answer is not HTTP/1.1: {0}")]
    Syntax(&'static str),
    /// Its head has too many lines.
    #[error("the answer's head has more than {LINES} lines")]
    Lines,
    /// It is longer than is taken.
    #[error("the answer has more than {limit} bytes")]
    Long {
        /// How much is taken.
        limit: usize,
    },
    /// Nothing of it came.
    #[error("the connection was closed before an answer came")]
    Nothing,
    /// Some of it is missing.
    #[error("the connection was closed within the {part} of the answer")]
    Ended {
        /// Which part had begun: head or body.
        part: &'static str,
    },
    /// Its body cannot be read.
    #[error("the chunks of the answer cannot be read")]
    Chunks,
}

impl From<httparse::Error> for InvalidAnswer {
    fn from(error: httparse::Error) -> Self {
        match error {
            httparse::Error::TooManyHeaders => Self::Lines,
            httparse::Error::Status => Self::Syntax("its status is not three digits"),
            error => Self::Syntax(
                lines::words(error).unwrap_or("it does not begin with a version and a status"),
            ),
        }
    }
}

impl From<InvalidBody> for InvalidAnswer {
    fn from(problem: InvalidBody) -> Self {
        match problem {
            InvalidBody::Long { limit } => Self::Long { limit },
            InvalidBody::Broken => Self::Chunks,
        }
    }
}

/// Reads the answer at the beginning of `bytes`, of which head and body have at most `limit` bytes each; `None` if it
/// is not whole yet.
///
/// # Errors
/// If it is none, too long, or its rest is missing.
#[inline]
pub fn read(bytes: &[u8], rest: Rest, limit: usize) -> Result<Option<Answer<'_>>, InvalidAnswer> {
    let answer = whole(bytes, rest, limit)?;
    if answer.is_none() && bytes.len() >= limit {
        return Err(InvalidAnswer::Long { limit });
    }
    Ok(answer)
}

#[inline]
fn whole(mut bytes: &[u8], rest: Rest, limit: usize) -> Result<Option<Answer<'_>>, InvalidAnswer> {
    let missing = |what| match rest {
        Rest::IsMissing => Err(what),
        Rest::MayCome => Ok(None),
    };
    loop {
        let mut room = lines::room();
        let mut response = Response::new(&mut []);
        let parsed = ParserConfig::default().parse_response_with_uninit_headers(
            &mut response,
            bytes,
            &mut room,
        );
        let Status::Complete(head) = parsed? else {
            return missing(if bytes.is_empty() {
                InvalidAnswer::Nothing
            } else {
                InvalidAnswer::Ended { part: "head" }
            });
        };
        let status = StatusCode::from_u16(response.code.unwrap_or_default())
            .map_err(|_| InvalidAnswer::Syntax("its status is not one of HTTP's"))?;
        let behind = &bytes[head..];
        // Word that the answer is still to come.
        if status.is_informational() && status != StatusCode::SWITCHING_PROTOCOLS {
            bytes = behind;
            continue;
        }
        let (lines, protocol) = (Lines(response.headers), Protocol::of(response.version));
        let ended = InvalidAnswer::Ended { part: "body" };
        let (body, taken) = match length(status, lines, protocol)? {
            Some(Length::Bytes(length)) => {
                let length = usize::try_from(length).ok().filter(|bytes| *bytes <= limit);
                let length = length.ok_or(InvalidAnswer::Long { limit })?;
                match behind.get(..length) {
                    Some(body) => (Cow::Borrowed(body), length),
                    None => return missing(ended),
                }
            }
            Some(Length::Chunked) => {
                let (mut left, mut body) = (behind.to_vec(), Body::new(Length::Chunked, limit)?);
                if !body.take(&mut left)? {
                    return missing(ended);
                }
                (Cow::Owned(body.into_bytes()), behind.len() - left.len())
            }
            None if rest == Rest::IsMissing => (Cow::Borrowed(behind), behind.len()),
            None => return Ok(None),
        };
        // What comes behind it is nobody's answer.
        let is_last = rest == Rest::IsMissing || taken < behind.len();
        let then = if is_last {
            Afterwards::Close
        } else {
            Afterwards::of(lines, protocol)
        };
        return Ok(Some(Answer { status, body, then }));
    }
}

/// The length of the body; `None` if it ends where the connection does.
#[inline]
fn length(
    status: StatusCode,
    lines: Lines<'_>,
    protocol: Protocol,
) -> Result<Option<Length>, InvalidAnswer> {
    if matches!(
        status,
        StatusCode::SWITCHING_PROTOCOLS | StatusCode::NO_CONTENT | StatusCode::NOT_MODIFIED
    ) {
        return Ok(Some(Length::Bytes(0)));
    }
    if let Some(coding) = lines.all("transfer-encoding").last() {
        if protocol == Protocol::Http10 {
            return Err(InvalidAnswer::Syntax("HTTP/1.0 has no Transfer-Encoding"));
        }
        let last = coding.rsplit(|byte| *byte == b',').next();
        let is_chunked =
            last.is_some_and(|word| word.trim_ascii().eq_ignore_ascii_case(b"chunked"));
        return Ok(is_chunked.then_some(Length::Chunked));
    }
    let mut told = None;
    for value in lines.all("content-length") {
        let bytes = lines::number(value);
        if bytes.is_none() || told.is_some_and(|other| bytes != Some(other)) {
            return Err(InvalidAnswer::Syntax(
                "its Content-Length is not one number",
            ));
        }
        told = bytes;
    }
    Ok(told.map(Length::Bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OK: &str = "HTTP/1.1 200 OK\r\n";
    const LIMIT: usize = 64 * 1024;

    fn read(text: &[u8], rest: Rest) -> Result<Option<Answer<'_>>, InvalidAnswer> {
        super::read(text, rest, LIMIT)
    }

    /// The body of a whole answer, and whether its connection is kept.
    fn body(text: &[u8], rest: Rest) -> Option<(Vec<u8>, bool)> {
        let answer = read(text, rest).expect("no error")?;
        Some((answer.body.into_owned(), answer.then == Afterwards::Keep))
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
                assert_eq!(body(&text[..end], Rest::MayCome), None, "{head}: {end}");
                assert!(
                    read(&text[..end], Rest::IsMissing).is_err(),
                    "{head}: {end}"
                );
            }
            let expected = expected.as_bytes().to_vec();
            assert_eq!(
                body(text, Rest::MayCome),
                Some((expected.clone(), true)),
                "{head}"
            );
            let more = [text, b"HTTP"].concat();
            assert_eq!(
                body(&more, Rest::MayCome),
                Some((expected, false)),
                "{head}"
            );
        }
    }

    #[test]
    fn without_a_length_an_answer_ends_with_its_connection() {
        let text = format!("{OK}\r\nu=1");
        assert_eq!(body(text.as_bytes(), Rest::MayCome), None);
        assert_eq!(
            body(text.as_bytes(), Rest::IsMissing),
            Some((b"u=1".to_vec(), false))
        );
        let none = b"HTTP/1.1 204 No Content\r\n\r\n";
        assert_eq!(body(none, Rest::MayCome), Some((Vec::new(), true)));
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
                body(text.as_bytes(), Rest::MayCome),
                Some((Vec::new(), keeps)),
                "{start} {line}"
            );
        }
    }

    #[test]
    fn what_is_no_answer_is_named_and_what_is_too_long_ends() {
        let syntax = InvalidAnswer::Syntax;
        let long = InvalidAnswer::Long { limit: LIMIT };
        for (text, error) in [
            (
                "HTTQ/1.1 200 OK\r\n\r\n".to_owned(),
                syntax("its version is not HTTP/1.1 or HTTP/1.0"),
            ),
            (
                "HTTP/1.1 2x0 OK\r\n\r\n".to_owned(),
                syntax("its status is not three digits"),
            ),
            (
                "HTTP/1.1 099 Odd\r\n\r\n".to_owned(),
                syntax("its status is not one of HTTP's"),
            ),
            (
                format!("{OK}a b\r\n\r\n"),
                syntax("the name of a header is not a word"),
            ),
            (
                format!("{OK}Content-Length: +3\r\n\r\n"),
                syntax("its Content-Length is not one number"),
            ),
            (
                format!("{OK}Content-Length: 3\r\nContent-Length: 4\r\n\r\n"),
                syntax("its Content-Length is not one number"),
            ),
            (format!("{OK}Content-Length: 99999999\r\n\r\n"), long),
            (
                "HTTP/1.0 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n".to_owned(),
                syntax("HTTP/1.0 has no Transfer-Encoding"),
            ),
            (
                format!("{OK}Transfer-Encoding: chunked\r\n\r\nx\r\n"),
                InvalidAnswer::Chunks,
            ),
            (
                format!("{OK}Transfer-Encoding: chunked\r\n\r\n1\r\nuu"),
                InvalidAnswer::Chunks,
            ),
            (
                format!("{OK}Transfer-Encoding: chunked\r\n\r\nfffffffff\r\n"),
                long,
            ),
            (
                format!("{OK}{}", "A: b\r\n".repeat(101)),
                InvalidAnswer::Lines,
            ),
            (format!("{OK}A: {}", "x".repeat(LIMIT)), long),
        ] {
            let start = &text[..40.min(text.len())];
            assert_eq!(read(text.as_bytes(), Rest::MayCome), Err(error), "{start}");
        }
    }

    #[test]
    fn an_answer_that_is_cut_says_where() {
        for (text, error) in [
            ("", InvalidAnswer::Nothing),
            ("HTTP/1.1 200", InvalidAnswer::Ended { part: "head" }),
            (
                "HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nu=",
                InvalidAnswer::Ended { part: "body" },
            ),
            (
                "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nu",
                InvalidAnswer::Ended { part: "body" },
            ),
        ] {
            assert_eq!(read(text.as_bytes(), Rest::MayCome), Ok(None), "{text}");
            assert_eq!(read(text.as_bytes(), Rest::IsMissing), Err(error), "{text}");
        }
    }
}
