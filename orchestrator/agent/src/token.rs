//! What proves that a request comes from the agent's own orchestrator.

use std::env;
use std::fmt;
use std::io;
use std::str::FromStr;

use subtle::ConstantTimeEq;

/// A token is at least as long as to be beyond guessing, and at most what a header carries.
const BYTES: std::ops::RangeInclusive<usize> = 16..=256;

/// Bytes of a token that we make ourselves; two letters each.
const RANDOM_BYTES: usize = 16;

/// A bearer token. It is never printed.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// The environment variable that gives one. It is kept from the roles.
    pub const VARIABLE: &'static str = "WEBLOOP_TOKEN";

    /// A new one, from the kernel's randomness.
    ///
    /// # Errors
    /// What the kernel says.
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

    /// The token of [`Token::VARIABLE`]; `None` where it is not set, or empty.
    ///
    /// # Errors
    /// When it is set to what cannot be a token.
    pub fn from_environment() -> Result<Option<Token>, BadToken> {
        match env::var_os(Token::VARIABLE) {
            None => Ok(None),
            Some(text) if text.is_empty() => Ok(None),
            Some(text) => text.to_str().ok_or(BadToken)?.parse().map(Some),
        }
    }

    /// Whether `presented` is this token, in a time that says nothing about where they differ.
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
        // What RFC 6750 allows in the header.
        let allowed = |c: char| c.is_ascii_alphanumeric() || "-._~+/=".contains(c);
        if BYTES.contains(&text.len()) && text.chars().all(allowed) {
            Ok(Token(text.to_owned()))
        } else {
            Err(BadToken)
        }
    }
}

/// A text that cannot be a token. It is not quoted: it may be a secret with a slip in it.
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
