//! Evidence against a link, as a sentence.

/// A fault of a link that its messages show.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkFault {
    /// The fault in a sentence, with its limit.
    pub words: String,
    /// Whether a machine that stood still could be the cause: it makes messages late, but never quick.
    pub by_lateness: bool,
    /// Whether the machine was so busy, by its own records, that this explains all of it.
    pub is_busy: bool,
}
