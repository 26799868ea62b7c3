//! What is wrong with a fault that an experiment describes, each with the words that its reader sees.

/// What is wrong with a fault or with one of its events.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BadFault {
    /// It does nothing.
    #[error("it has no [[fault.event]]")]
    NoEvent,
    /// One of its events is wrong.
    #[error("its event {number}: {problem}")]
    Event {
        /// The event's number, from 1.
        number: usize,
        /// What is wrong with it.
        problem: Box<BadFault>,
    },
    /// Its beginning is no time.
    #[error("`at`: {0}")]
    At(text::InvalidQuantity),
    /// How much is taken away is missing.
    #[error("`starve` needs a `share` such as \"70%\": how much is taken away")]
    NoShare,
    /// How much is taken away of nothing.
    #[error("`share` without `starve`: drop it")]
    ShareAlone,
    /// How much is taken away is no share.
    #[error("`share` is `{}`; write 1% to 99%: all of it is `freeze`", .0.escape_debug())]
    Share(String),
    /// So many programs make no load, or no machine that goes on.
    #[error("`busy` is {0}; write how many programs compute, 1 to {1}")]
    Busy(u16, u16),
    /// It does two things.
    #[error("an event has one effect, and this one has more: write two events")]
    Effects,
    /// It hits an end, and has a direction.
    #[error("`way` is of the link, and this event hits an end: drop it")]
    WayOfEnd,
    /// What a link says of it.
    #[error("{0}")]
    Link(String),
}
