//! The header lines of a head, whichever it is.

use std::mem::MaybeUninit;

use httparse::Header;

/// Greatest number of header lines.
pub const LINES: usize = 100;

/// Room for the lines of a head.
pub type Room<'a> = [MaybeUninit<Header<'a>>; LINES];

/// Room that nothing has been put into.
#[inline]
pub fn room<'a>() -> Room<'a> {
    [const { MaybeUninit::uninit() }; LINES]
}

/// Header lines.
#[derive(Clone, Copy, Debug)]
pub struct Lines<'a>(pub &'a [Header<'a>]);

impl<'a> Lines<'a> {
    /// The values of all lines with this name.
    #[inline]
    pub fn all(self, name: &'static str) -> impl Iterator<Item = &'a [u8]> {
        let lines = self.0.iter();
        lines
            .filter(move |line| line.name.eq_ignore_ascii_case(name))
            .map(|line| line.value)
    }

    /// The value of the first line with this name.
    #[inline]
    pub fn first(self, name: &'static str) -> Option<&'a [u8]> {
        self.all(name).next()
    }

    /// Whether a header that is a list of words has this one.
    #[inline]
    pub fn says(self, name: &'static str, word: &str) -> bool {
        self.all(name)
            .filter_map(text)
            .flat_map(|value| value.split(','))
            .any(|given| given.trim().eq_ignore_ascii_case(word))
    }
}

/// A value, if it is plain text.
#[inline]
pub fn text(value: &[u8]) -> Option<&str> {
    std::str::from_utf8(value).ok().filter(|text| {
        text.bytes()
            .all(|byte| byte == b'\t' || (b' '..=b'~').contains(&byte))
    })
}

/// A value that is a number, in digits alone.
#[inline]
pub(crate) fn number(value: &[u8]) -> Option<u64> {
    text(value)
        .filter(|text| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()))?
        .parse()
        .ok()
}

/// What is wrong with a head that `httparse` cannot read, but for its first line.
pub(crate) fn words(error: httparse::Error) -> Option<&'static str> {
    match error {
        httparse::Error::HeaderName => Some("the name of a header is not a word"),
        httparse::Error::HeaderValue => Some("the value of a header has a control character"),
        httparse::Error::NewLine => Some("a line does not end with CR LF"),
        httparse::Error::Version => Some("its version is not HTTP/1.1 or HTTP/1.0"),
        _ => None,
    }
}
