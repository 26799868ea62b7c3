//! A sentence in a file, which is shown as it stands.

use serde::de::{Deserialize, Deserializer, Error};

/// Reads a sentence. It has no character that would act on a terminal.
///
/// # Errors
/// If it has one.
pub fn sentence<'de, D: Deserializer<'de>>(text: D) -> Result<String, D::Error> {
    let text = String::deserialize(text)?;
    let acts = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t');
    if text.contains(acts) {
        return Err(D::Error::custom("a control character; write plain text"));
    }
    Ok(text)
}
