//! The times at which an end stands still: what its program would do then, it does when they are over.
//!
//! Its kernel goes on: it acknowledges, resends and answers echoes.

use std::ops::Range;

/// When an end stands still, in order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frozen<'a>(pub(super) &'a [Range<u64>]);

impl Frozen<'_> {
    /// When an end does what is due at `t_ns`.
    #[inline]
    pub(super) fn over_ns(self, t_ns: u64) -> u64 {
        if self.0.is_empty() {
            return t_ns;
        }
        let next = self.0.partition_point(|stop| stop.end <= t_ns);
        match self.0.get(next) {
            Some(stop) if stop.start <= t_ns => stop.end,
            _ => t_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_due_while_an_end_stands_still_is_done_at_the_end_of_that() {
        let stops = [10..20, 30..40];
        let frozen = Frozen(&stops);
        let done = [0, 9, 10, 19, 20, 29, 35, 40, 99].map(|t_ns| frozen.over_ns(t_ns));
        assert_eq!(done, [0, 9, 20, 20, 20, 29, 40, 40, 99]);
    }
}
