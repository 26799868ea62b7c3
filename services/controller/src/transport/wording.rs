//! The text of commands and answers, where they are no requests.

use endpoint::{Answer, Command, InvalidMessage, Mode, checksum};

/// How messages are worded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wording {
    pub(super) mode: Mode,
    /// Whether commands have a checksum, and answers need one.
    pub(super) check: bool,
}

impl Wording {
    /// A command's text.
    pub(super) fn command(self, command: &Command) -> String {
        let text = command.to_string();
        if self.check {
            checksum::signed(&text)
        } else {
            text
        }
    }

    /// The answer of a text, whatever command it belongs to.
    pub(super) fn answer(self, text: &str) -> Result<Answer, InvalidMessage> {
        let (text, _) = checksum::checked(text, self.check)?;
        Ok(match self.mode {
            Mode::Closed => Answer::State(text.parse()?),
            Mode::Open => Answer::Acknowledgement(text.parse()?),
        })
    }
}
