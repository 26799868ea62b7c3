//! The text of a datagram: a command's, behind the mode of the loop, which no connection has told.

use crate::query::InvalidMessage;
use crate::setting::Mode;

/// How the first field begins.
const FIELD: &str = "mode=";

/// A command's text as a datagram has it.
#[must_use]
pub fn written(mode: Mode, command: &str) -> String {
    format!("{FIELD}{mode}&{command}")
}

/// The mode of a datagram, and its command's text.
///
/// # Errors
/// [`InvalidMessage::Missing`], if it does not begin with a mode.
pub fn read(text: &str) -> Result<(Mode, &str), InvalidMessage> {
    let field = text.strip_prefix(FIELD);
    field
        .and_then(|text| text.split_once('&'))
        .and_then(|(mode, command)| Some((mode.parse().ok()?, command)))
        .ok_or_else(|| InvalidMessage::Missing {
            field: "mode",
            expected: "mode first, closed or open; then u, seq and t_send_ns".to_owned(),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_comes_first_and_is_one() {
        for mode in [Mode::Open, Mode::Closed] {
            assert_eq!(read(&written(mode, "u=1&seq=2")), Ok((mode, "u=1&seq=2")));
        }
        for wrong in [
            "",
            "u=1",
            "mode=",
            "mode=open",
            "mode=ajar&u=1",
            "u=1&mode=open&",
            " mode=open&u=1",
        ] {
            let error = read(wrong).expect_err(wrong).to_string();
            assert!(error.contains("`mode`"), "{error}");
        }
    }
}
