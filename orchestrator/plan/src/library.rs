//! Finds the texts that an experiment names: profiles and systems.

use system::System;

use crate::ProfileText;

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
}

impl<F: FnMut(&str) -> Result<ProfileText, String>> Library for F {
    fn profile(&mut self, asked: &str) -> Result<ProfileText, String> {
        self(asked)
    }
}
