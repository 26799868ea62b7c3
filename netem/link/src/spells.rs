//! Two-state processes in time: gaps and the spells between them.
//!
//! A stall of a radio and the bad state of a Gilbert-Elliott loss are both spells. What a spell does
//! to packets is decided elsewhere.

use std::collections::VecDeque;

use crate::draws::Draws;
use crate::law::Law;

/// The process begins this many of its mean periods before link time 0, so that at link time 0 it is
/// as likely to be within a spell as at any other time.
const WARM_PERIODS: f64 = 10.0;

/// One spell: from `start_ns` up to but not including `end_ns`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Spell {
    pub(crate) start_ns: u64,
    pub(crate) end_ns: u64,
}

/// An alternating renewal process: exponential gaps, spells of any length law.
#[derive(Debug, Clone)]
pub(crate) struct Spells {
    gap: Law,
    length: Law,
    draws: Draws,
    drawn: u64,
    /// Time from the beginning of the process to link time 0.
    warm_ns: u64,
    /// Everything up to this time (since the process began) has been generated.
    known_ns: u64,
    kept: VecDeque<Spell>,
    /// The spell or gap of the newest query, since the next is mostly about the same.
    newest: Around,
}

/// A piece of link time in which the answer is the same.
#[derive(Debug, Clone, Copy)]
struct Around {
    from_ns: u64,
    to_ns: u64,
    is_spell: bool,
}

impl Spells {
    pub(crate) fn new(mean_gap_ns: f64, length: Law, draws: Draws) -> Self {
        let period_ns = mean_gap_ns + length.mean_ns();
        Self {
            gap: Law::exponential(mean_gap_ns),
            length,
            draws,
            drawn: 0,
            warm_ns: (WARM_PERIODS * period_ns) as u64,
            known_ns: 0,
            kept: VecDeque::new(),
            newest: Around {
                from_ns: 0,
                to_ns: 0,
                is_spell: false,
            },
        }
    }

    /// The end of the spell that contains link time `t_ns`, if there is one.
    #[inline]
    pub(crate) fn end_at(&mut self, t_ns: u64) -> Option<u64> {
        self.stretch(t_ns).ok()
    }

    /// The end of the spell that contains link time `t_ns`; or else, as an error, an instant before which none
    /// begins.
    #[inline]
    pub(crate) fn stretch(&mut self, t_ns: u64) -> Result<u64, u64> {
        if !(self.newest.from_ns..self.newest.to_ns).contains(&t_ns) {
            self.newest = self.around(t_ns);
        }
        match self.newest.is_spell {
            true => Ok(self.newest.to_ns),
            false => Err(self.newest.to_ns),
        }
    }

    /// The spell or the gap at link time `t_ns`. What is known of a gap before the first spell that is kept
    /// begins at that time.
    #[cold]
    fn around(&mut self, t_ns: u64) -> Around {
        let warm_ns = self.warm_ns;
        let t_ns = t_ns.saturating_add(warm_ns);
        while self.known_ns <= t_ns && self.known_ns < u64::MAX {
            self.generate();
        }
        let next = self.kept.partition_point(|spell| spell.end_ns <= t_ns);
        let before = next.checked_sub(1).and_then(|last| self.kept.get(last));
        let (from_ns, to_ns, is_spell) = match self.kept.get(next) {
            Some(spell) if spell.start_ns <= t_ns => (spell.start_ns, spell.end_ns, true),
            spell => (
                before.map_or(t_ns, |spell| spell.end_ns),
                spell.map_or(self.known_ns, |spell| spell.start_ns),
                false,
            ),
        };
        Around {
            from_ns: from_ns.saturating_sub(warm_ns),
            to_ns: to_ns - warm_ns,
            is_spell,
        }
    }

    /// The first spell that ends after link time `t_ns`, in link time; a start before link time 0 becomes 0.
    pub(crate) fn after(&mut self, t_ns: u64) -> Option<Spell> {
        let t_ns = t_ns.saturating_add(self.warm_ns);
        loop {
            let next = self.kept.partition_point(|spell| spell.end_ns <= t_ns);
            if let Some(spell) = self.kept.get(next) {
                return Some(Spell {
                    start_ns: spell.start_ns.saturating_sub(self.warm_ns),
                    end_ns: spell.end_ns - self.warm_ns,
                });
            }
            if self.known_ns == u64::MAX {
                return None;
            }
            self.generate();
        }
    }

    /// Extends the process by one gap and one spell.
    fn generate(&mut self) {
        let gap_ns = self.draw(|spells| &spells.gap);
        let length_ns = self.draw(|spells| &spells.length);
        let start_ns = self.known_ns.saturating_add(gap_ns);
        let end_ns = start_ns.saturating_add(length_ns);
        // Even a spell and a gap of zero length advance the process.
        self.known_ns = end_ns.max(self.known_ns.saturating_add(1));
        if end_ns > self.warm_ns {
            self.kept.push_back(Spell { start_ns, end_ns });
        }
    }

    /// Drops the spells that ended before link time `t_ns`.
    pub(crate) fn forget_before(&mut self, t_ns: u64) {
        let t_ns = t_ns.saturating_add(self.warm_ns);
        while self.kept.front().is_some_and(|spell| spell.end_ns < t_ns) {
            self.kept.pop_front();
        }
    }

    fn draw(&mut self, law: impl Fn(&Self) -> &Law) -> u64 {
        let u = self.draws.at(self.drawn);
        self.drawn += 1;
        law(self).quantile_ns(u) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_time_within_spells_is_length_over_period_from_the_start_on() {
        // Over 2000 seeds the share at one instant has a standard error of sqrt(0.2 * 0.8 / 2000) =
        // 0.009; the limit is four of them.
        for t_ns in [0, 1_000_000_000, 50_000_000_000] {
            let within = (0..2000)
                .filter(|&seed| {
                    let draws = Draws::new(seed, b"up.stall");
                    Spells::new(4e9, Law::exponential(1e9), draws)
                        .end_at(t_ns)
                        .is_some()
                })
                .count();
            assert!(
                (within as f64 / 2000.0 - 0.2).abs() < 0.036,
                "{t_ns}: {within}"
            );
        }
    }
}
