//! What a table has: the contenders that it compares, and goals.
//!
//! A goal is what webloop strives for on a machine of two cores; docs/performance.md has what was reached.

use crate::contender::Contender;

/// What a contender should come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    /// Whose goal it is.
    pub(crate) contender: &'static str,
    /// Which figure.
    pub(crate) figure: &'static str,
    /// Another contender whose figure it is to be a multiple of; else it is the figure itself.
    pub(crate) times: Option<&'static str>,
    /// The bound.
    pub(crate) bound: Bound,
}

/// A bound of a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
}

impl Bound {
    /// Whether a value keeps it.
    pub(crate) fn is_met(self, value: f64) -> bool {
        match self {
            Bound::AtMost(most) => value <= most,
            Bound::AtLeast(least) => value >= least,
        }
    }
}

/// A table: what it compares, by whose figures, and what webloop strives for.
#[derive(Debug)]
pub(crate) struct Table {
    /// What it compares.
    pub(crate) about: &'static str,
    /// The contender to which the others are compared, if they are of a kind.
    pub(crate) base: Option<&'static str>,
    /// On how many processors all is that a contender starts, if not on all there are.
    pub(crate) processors: Option<usize>,
    /// Those it compares, in the order of measuring.
    pub(crate) contenders: &'static [Contender],
    /// What webloop strives for.
    pub(crate) goals: &'static [Goal],
}

pub(crate) const fn goal(
    contender: &'static str,
    figure: &'static str,
    times: Option<&'static str>,
    bound: Bound,
) -> Goal {
    Goal {
        contender,
        figure,
        times,
        bound,
    }
}
