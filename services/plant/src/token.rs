//! The proof that a request belongs to the session in control.

use std::{fmt, io};

use rustix::rand::{GetRandomFlags, getrandom};
use subtle::ConstantTimeEq;

/// 128 bits, which cannot be guessed.
const BYTES: usize = 16;

/// A session's token. It is never printed.
#[derive(Clone)]
pub(crate) struct Token([u8; BYTES]);

/// The token of a request.
#[derive(Clone, Debug)]
pub(crate) enum Pass {
    /// No token: the request is from a controller without a session.
    Nothing,
    /// A token, of any session.
    Token(Token),
    /// A text that cannot be a token.
    Unreadable,
}

impl Token {
    /// A new token, from the kernel's randomness.
    pub(crate) fn random() -> io::Result<Self> {
        let mut bytes = [0; BYTES];
        let mut filled = 0;
        while filled < bytes.len() {
            filled += getrandom(&mut bytes[filled..], GetRandomFlags::empty())?;
        }
        Ok(Self(bytes))
    }

    #[cfg(test)]
    pub(crate) fn of(byte: u8) -> Self {
        Self([byte; BYTES])
    }

    /// Whether `other` is this token, in a time that does not depend on where they differ.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.0.ct_eq(&other.0).into()
    }

    /// The token as its page gets it: 32 hex digits.
    pub(crate) fn reveal(&self) -> String {
        self.0.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

impl From<&[u8]> for Pass {
    /// Reads 32 hex digits as [`Token::reveal`] writes them.
    fn from(text: &[u8]) -> Self {
        let mut bytes = [0; BYTES];
        if text.len() != 2 * BYTES {
            return Self::Unreadable;
        }
        for (byte, pair) in bytes.iter_mut().zip(text.chunks_exact(2)) {
            let (Some(high), Some(low)) = (digit(pair[0]), digit(pair[1])) else {
                return Self::Unreadable;
            };
            *byte = high << 4 | low;
        }
        Self::Token(Token(bytes))
    }
}

fn digit(letter: u8) -> Option<u8> {
    match letter {
        b'0'..=b'9' => Some(letter - b'0'),
        b'a'..=b'f' => Some(letter - b'a' + 10),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_read_as_it_was_written_and_nothing_else_is_one() {
        let token = Token::random().expect("randomness");
        let text = token.reveal();
        assert_eq!(text.len(), 32);
        let Pass::Token(read) = Pass::from(text.as_bytes()) else {
            panic!("{text} is a token");
        };
        assert!(read.is(&token) && !read.is(&Token::random().expect("randomness")));
        let capital = "A".repeat(32);
        for wrong in [
            "",
            "0",
            &text[1..],
            &format!("{text}0"),
            &capital,
            &"g".repeat(32),
        ] {
            let pass = Pass::from(wrong.as_bytes());
            assert!(matches!(pass, Pass::Unreadable), "{wrong}");
        }
        assert_eq!(format!("{token:?}"), "Token(..)");
    }
}
