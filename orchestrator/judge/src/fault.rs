//! Evidence against a link, as a sentence.

/// A fault of a link that its messages show.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// The fault in a sentence, with its limit.
    pub words: String,
    /// Whether a machine that stood still could be the cause: it makes messages late, but never quick.
    pub by_lateness: bool,
}
