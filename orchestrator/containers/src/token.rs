//! The token that proves that a request comes from the agent's own orchestrator.

use std::env;
use std::fmt;
use std::io;
use std::str::FromStr;

use subtle::ConstantTimeEq;

/// Length of a token: long enough that it cannot be guessed, short enough for a header.
const BYTES: std::ops::RangeInclusive<usize> = 16..=256;

/// Bytes of a random token; each is written as two hexadecimal digits.
const RANDOM_BYTES: usize = 16;

/// A bearer token. It is never printed.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// The environment variable that sets it. Roles do not get this variable.
    pub const VARIABLE: &'static str = process::SECRET;

    /// A new random token from the kernel.
    ///
    /// # Errors
    /// When the kernel gives no random numbers.
    pub fn random() -> io::Result<Token> {
        let mut bytes = [0; RANDOM_BYTES];
        let mut filled = 0;
        while filled < bytes.len() {
            filled += rustix::rand::getrandom(
                &mut bytes[filled..],
                rustix::rand::GetRandomFlags::empty(),
            )?;
        }
        Ok(Token(
            bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        ))
    }

    /// The token in [`Token::VARIABLE`]; `None` if that is unset or empty.
    ///
    /// # Errors
    /// When its value is not a valid token.
    pub fn from_environment() -> Result<Option<Token>, BadToken> {
        match env::var_os(Token::VARIABLE) {
            None => Ok(None),
            Some(text) if text.is_empty() => Ok(None),
            Some(text) => text.to_str().ok_or(BadToken)?.parse().map(Some),
        }
    }

    /// Whether `presented` is this token. The time this takes does not reveal where they differ.
    pub(crate) fn is(&self, presented: &Token) -> bool {
        self.0.as_bytes().ct_eq(presented.0.as_bytes()).into()
    }

    /// The token itself, for the environment of a child that acts for us.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// The value of an `Authorization` header.
    pub(crate) fn header(&self) -> String {
        format!("Bearer {}", self.0)
    }

    /// The token in the value of an `Authorization` header, if there is one.
    pub(crate) fn from_header(value: &str) -> Option<Token> {
        let (scheme, token) = value.split_once(' ')?;
        scheme
            .eq_ignore_ascii_case("Bearer")
            .then(|| token.trim().parse().ok())?
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Token(..)")
    }
}

impl FromStr for Token {
    type Err = BadToken;

    fn from_str(text: &str) -> Result<Self, BadToken> {
        // The characters that RFC 6750 allows in the header.
        let allowed = |c: char| c.is_ascii_alphanumeric() || "-._~+/=".contains(c);
        if BYTES.contains(&text.len()) && text.chars().all(allowed) {
            Ok(Token(text.to_owned()))
        } else {
            Err(BadToken)
        }
    }
}

/// A text that is not a valid token. It is not quoted, since it may be a mistyped secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a token is 16 to 256 of A-Z a-z 0-9 - . _ ~ + / =; set {} to one, or leave it unset",
    Token::VARIABLE
)]
pub struct BadToken;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_header_carries_a_token_there_and_back() {
        let (token, other) = (Token::random().unwrap(), Token::random().unwrap());
        assert!(Token::from_header(&token.header()).unwrap().is(&token));
        assert!(!other.is(&token));
        let longer: Token = format!("{}0", token.0).parse().unwrap();
        assert!(!longer.is(&token));
    }

    #[test]
    fn what_is_no_bearer_token_is_none() {
        for value in [
            "",
            "Bearer",
            "Bearer ",
            "Bearer short",
            "Basic 0123456789abcdef0123456789abcdef",
            "Bearer 0123456789abcdef 0123456789abcdef",
        ] {
            assert!(Token::from_header(value).is_none(), "{value:?}");
        }
    }

    #[test]
    fn a_token_is_not_printed() {
        assert_eq!(format!("{:?}", Token::random().unwrap()), "Token(..)");
    }
}
