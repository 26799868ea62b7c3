//! Finds the texts that an experiment names: profiles and systems.

use crate::system::System;

use crate::profile_text::ProfileText;

/// Finds texts by the names or paths that an experiment uses for them.
///
/// A function that finds profiles is a library too; its systems are the built-in ones.
pub trait Library {
    /// The text of a profile.
    ///
    /// # Errors
    /// A sentence that says what cannot be read.
    fn profile(&mut self, asked: &str) -> Result<ProfileText, String>;

    /// The text of a system.
    ///
    /// # Errors
    /// A sentence that says what cannot be read.
    fn system(&mut self, asked: &str) -> Result<String, String> {
        match System::built_in(asked) {
            Some(text) => Ok(text.to_owned()),
            None => Err(format!("there is no system `{asked}`")),
        }
    }

    /// A word of a program's command, where one that begins with `./` is a path beside the experiment.
    fn word(&mut self, asked: &str) -> String {
        asked.to_owned()
    }

    /// A word of the command of a system's plant, where one that begins with `./` is a path beside the
    /// system's file.
    fn word_beside(&mut self, system: &str, asked: &str) -> String {
        let _ = system;
        asked.to_owned()
    }
}

impl<F: FnMut(&str) -> Result<ProfileText, String>> Library for F {
    fn profile(&mut self, asked: &str) -> Result<ProfileText, String> {
        self(asked)
    }
}
