//! A body, taken from the bytes of its connection as they arrive.
//!
//! It has one of two lengths, and neither is believed beyond the limit of its kind. Like a head, it is read
//! strictly; extensions of chunks and trailers are passed over.

use crate::http::framing::Length;

/// The longest line between chunks, and the most bytes of a trailer.
const LINE_BYTES: usize = 256;

/// A body that is being read.
#[derive(Debug)]
pub struct Body {
    taken: Vec<u8>,
    next: Next,
    limit: usize,
    trailer: usize,
}

/// Why bytes are no body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidBody {
    /// It is longer than is taken.
    #[error("the body has more than {limit} bytes")]
    Long {
        /// How much is taken.
        limit: usize,
    },
    /// A chunk's line, its end or the trailer is none.
    #[error("the chunks of the body cannot be read")]
    Broken,
}

/// What comes next.
#[derive(Debug)]
enum Next {
    /// This many bytes, and then no more.
    Last(usize),
    /// The line with a chunk's size.
    Size,
    /// The rest of a chunk.
    Chunk(usize),
    /// The end of its line.
    ChunkEnd,
    /// The lines after the last chunk.
    Trailer,
    Nothing,
}

impl Body {
    /// A body of this length, and of at most `limit` bytes.
    ///
    /// # Errors
    /// If it says that it is longer.
    pub fn new(length: Length, limit: usize) -> Result<Self, InvalidBody> {
        let next = match length {
            Length::Bytes(bytes) => usize::try_from(bytes)
                .ok()
                .filter(|bytes| *bytes <= limit)
                .map(Next::Last)
                .ok_or(InvalidBody::Long { limit })?,
            Length::Chunked => Next::Size,
        };
        Ok(Self {
            taken: Vec::new(),
            next,
            limit,
            trailer: 0,
        })
    }

    /// The bytes that it holds.
    pub fn held(&self) -> usize {
        self.taken.len()
    }

    /// The whole body.
    pub fn into_bytes(self) -> Vec<u8> {
        self.taken
    }

    /// Takes from the beginning of `bytes` what belongs to it; whether it is whole then.
    ///
    /// # Errors
    /// If its chunks are none, or more than its limit.
    pub fn take(&mut self, bytes: &mut Vec<u8>) -> Result<bool, InvalidBody> {
        let mut at = 0;
        let whole = loop {
            let rest = &bytes[at..];
            match self.next {
                Next::Nothing => break true,
                Next::Last(left) | Next::Chunk(left) => {
                    let now = left.min(rest.len());
                    self.taken.extend_from_slice(&rest[..now]);
                    at += now;
                    let is_last = matches!(self.next, Next::Last(_));
                    self.next = match left - now {
                        0 if is_last => Next::Nothing,
                        0 => Next::ChunkEnd,
                        left if is_last => Next::Last(left),
                        left => Next::Chunk(left),
                    };
                    if left > now {
                        break false;
                    }
                }
                Next::Size => {
                    let Some(line) = line(rest)? else { break false };
                    at += line.len() + 2;
                    let bytes = size(line)?;
                    if bytes > self.limit - self.taken.len() {
                        return Err(InvalidBody::Long { limit: self.limit });
                    }
                    self.next = match bytes {
                        0 => Next::Trailer,
                        bytes => Next::Chunk(bytes),
                    };
                }
                Next::ChunkEnd => match rest {
                    [b'\r', b'\n', ..] => {
                        at += 2;
                        self.next = Next::Size;
                    }
                    [] | [b'\r'] => break false,
                    _ => return Err(InvalidBody::Broken),
                },
                Next::Trailer => {
                    let Some(line) = line(rest)? else { break false };
                    at += line.len() + 2;
                    self.trailer += line.len();
                    if self.trailer > LINE_BYTES {
                        return Err(InvalidBody::Broken);
                    }
                    if line.is_empty() {
                        self.next = Next::Nothing;
                    }
                }
            }
        };
        bytes.drain(..at);
        Ok(whole)
    }
}

/// What chunks amount to, as far as they have arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chunks {
    /// No body at all, in so many bytes.
    Empty(usize),
    /// A body, or none that can be read.
    Full,
    /// It cannot be told yet.
    Unknown,
}

impl Chunks {
    /// Looks at the bytes behind a head.
    pub fn of(bytes: &[u8]) -> Self {
        let mut rest = bytes.to_vec();
        let whole = Body::new(Length::Chunked, 0).and_then(|mut body| body.take(&mut rest));
        match whole {
            Ok(true) => Self::Empty(bytes.len() - rest.len()),
            Ok(false) => Self::Unknown,
            Err(_) => Self::Full,
        }
    }
}

/// The next line without its end, if that has arrived.
fn line(bytes: &[u8]) -> Result<Option<&[u8]>, InvalidBody> {
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let line = match end {
        Some(end) => bytes[..end]
            .strip_suffix(b"\r")
            .ok_or(InvalidBody::Broken)?,
        None => bytes.strip_suffix(b"\r").unwrap_or(bytes),
    };
    let is_text = line
        .iter()
        .all(|byte| *byte == b'\t' || !byte.is_ascii_control());
    if line.len() > LINE_BYTES || !is_text {
        return Err(InvalidBody::Broken);
    }
    Ok(end.map(|_| line))
}

/// The size in a chunk's line: hex digits, perhaps with extensions.
fn size(line: &[u8]) -> Result<usize, InvalidBody> {
    let digits = line.split(|byte| *byte == b';').next().unwrap_or_default();
    Some(digits)
        .filter(|digits| !digits.is_empty() && digits.iter().all(u8::is_ascii_hexdigit))
        .and_then(|digits| std::str::from_utf8(digits).ok())
        .and_then(|digits| usize::from_str_radix(digits, 16).ok())
        .ok_or(InvalidBody::Broken)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(length: Length, text: &[u8], step: usize) -> Result<(Vec<u8>, Vec<u8>), InvalidBody> {
        let mut body = Body::new(length, 20)?;
        let (mut bytes, mut whole) = (Vec::new(), body.take(&mut Vec::new())?);
        for piece in text.chunks(step) {
            bytes.extend_from_slice(piece);
            whole = whole || body.take(&mut bytes)?;
        }
        if whole {
            Ok((body.into_bytes(), bytes))
        } else {
            Err(InvalidBody::Broken)
        }
    }

    #[test]
    fn a_body_is_the_same_in_whatever_pieces_it_arrives() {
        let table: [(Length, &[u8], &[u8]); 6] = [
            (Length::Bytes(0), b"", b""),
            (Length::Bytes(3), b"u=1", b"u=1"),
            (Length::Chunked, b"0\r\n\r\n", b""),
            (Length::Chunked, b"3\r\nu=1\r\n0\r\n\r\n", b"u=1"),
            (
                Length::Chunked,
                b"A;x=y\r\n0123456789\r\n00a\r\n0123456789\r\n0\r\n\r\n",
                b"01234567890123456789",
            ),
            (
                Length::Chunked,
                b"1\r\nu\r\n2\r\n=1\r\n0\r\nA: b\r\n\r\n",
                b"u=1",
            ),
        ];
        for (length, text, expected) in table {
            let text = [text, b"GET"].concat();
            for step in 1..=text.len() {
                let (body, rest) = read(length, &text, step).expect("a body");
                assert_eq!(body, expected, "{step}");
                assert_eq!(rest, b"GET", "{step}");
            }
        }
    }

    #[test]
    fn no_chunks_are_told_from_some_in_whatever_pieces_they_arrive() {
        for text in ["0\r\n\r\n", "000;a=b\r\n\r\n", "0\r\nX: y\r\n\r\n"] {
            for end in 0..text.len() {
                assert_eq!(
                    Chunks::of(&text.as_bytes()[..end]),
                    Chunks::Unknown,
                    "{text:?}"
                );
            }
            let more = format!("{text}GET");
            assert_eq!(Chunks::of(more.as_bytes()), Chunks::Empty(text.len()));
        }
        for text in ["1", "3\r\nodd\r\n0\r\n\r\n", "x\r\n", "0\n"] {
            let text = format!("{text}\r\n");
            assert_eq!(Chunks::of(text.as_bytes()), Chunks::Full, "{text:?}");
        }
    }

    #[test]
    fn what_is_no_body_is_refused_at_every_length_of_its_pieces() {
        let table: [(Length, &[u8]); 13] = [
            (Length::Bytes(21), b""),
            (Length::Bytes(u64::MAX), b""),
            (Length::Bytes(3), b"u="),
            (Length::Chunked, b"\r\n"),
            (Length::Chunked, b"x\r\n"),
            (Length::Chunked, b"-1\r\n"),
            (Length::Chunked, b"3 \r\nu=1\r\n0\r\n\r\n"),
            (Length::Chunked, b"3\nu=1\r\n0\r\n\r\n"),
            (Length::Chunked, b"3\r\nu=1\n0\r\n\r\n"),
            (Length::Chunked, b"3\r\nu=12\r\n0\r\n\r\n"),
            (Length::Chunked, b"15\r\n"),
            (Length::Chunked, b"ffffffffffffffff1\r\n"),
            (Length::Chunked, b"1;\x00\r\nu\r\n0\r\n\r\n"),
        ];
        for (length, text) in table {
            for step in 1..=text.len().max(1) {
                assert!(read(length, text, step).is_err(), "{text:?}");
            }
        }
        let long = [b"1;".as_slice(), &b"x".repeat(300)].concat();
        assert!(read(Length::Chunked, &long, 7).is_err());
        let trailer = [b"0\r\n".as_slice(), &b"A: b\r\n".repeat(100)].concat();
        assert!(read(Length::Chunked, &trailer, 7).is_err());
    }
}
