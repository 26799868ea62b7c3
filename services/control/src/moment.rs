//! What a controller knows when it sends a command: the newest outputs and, where somebody measures it, when they
//! were.
//!
//! Which answer is the newest is the controller's to say; what follows from its times, a law's.

use crate::signals::Signals;

/// What a controller knows when it sends a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawInput {
    /// The newest outputs.
    pub y: Signals,
    /// When that was; `None` where nobody measures time, and each update comes h after the last.
    pub times: Option<Moment>,
}

/// When a command is sent, and when the newest outputs were.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// When the command is sent, on the controller's clock.
    pub send_ns: u64,
    /// The answer that brought the outputs; `None` before the first.
    pub told: Option<AnswerFacts>,
}

/// What an answer tells beside the outputs, and when it was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnswerFacts {
    /// The plant's tick to which the outputs belong.
    pub tick: u64,
    /// The inputs that the plant holds from the next tick on.
    pub u: Signals,
    /// When the message was sent that it answers, on the controller's clock.
    pub send_ns: u64,
}

impl<Y: Into<Signals>> From<Y> for LawInput {
    #[inline]
    fn from(y: Y) -> Self {
        Self {
            y: y.into(),
            times: None,
        }
    }
}
