//! What speaks against a link, in a sentence.

/// What is wrong with a link by its messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// A sentence, with its limit.
    pub words: String,
    /// Whether a machine that stood still could have done it: that makes messages late, and never
    /// quick.
    pub by_lateness: bool,
}
