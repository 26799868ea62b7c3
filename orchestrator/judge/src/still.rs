//! Times apart from each other, and those when a processor stood still.

use std::ops::Range;

use link::certificate::Pause;

use crate::milliseconds::ms;

/// Disjoint times, in order, monotonic ns.
#[derive(Debug, Clone, Default)]
pub(crate) struct Times(Vec<Range<u64>>);

impl FromIterator<Range<u64>> for Times {
    /// Joins times in any order.
    fn from_iter<I: IntoIterator<Item = Range<u64>>>(times: I) -> Times {
        let mut times: Vec<Range<u64>> = times.into_iter().collect();
        times.sort_unstable_by_key(|time| time.start);
        let mut apart = Times::default();
        for time in times {
            apart.join(time);
        }
        apart
    }
}

impl Times {
    /// Whether an instant lies in one of these.
    pub(crate) fn contains(&self, t_ns: u64) -> bool {
        let mut times = self.after(t_ns);
        times.next().is_some_and(|time| time.contains(&t_ns))
    }

    /// How much of the time between two instants lies in one of these, ns.
    pub(crate) fn within_ns(&self, from_ns: u64, to_ns: u64) -> u64 {
        let met = self.after(from_ns).take_while(|time| time.start < to_ns);
        met.map(|time| time.end.min(to_ns).saturating_sub(time.start.max(from_ns)))
            .sum()
    }

    /// Adds a time that starts no earlier than those before; it joins one that it touches.
    pub(crate) fn join(&mut self, time: Range<u64>) {
        match self.0.last_mut() {
            Some(last) if time.start <= last.end => last.end = last.end.max(time.end),
            _ => self.0.push(time),
        }
    }

    /// The times that end after an instant.
    pub(crate) fn after(&self, t_ns: u64) -> impl Iterator<Item = &Range<u64>> {
        let first = self.0.partition_point(|time| time.end <= t_ns);
        self.0.iter().skip(first)
    }
}

/// When a processor stood still.
#[derive(Debug, Clone, Default)]
pub struct Still(Times);

impl Still {
    /// Joins the gaps in the pulse of all processors: any of them may have handled the message.
    #[must_use]
    pub fn of(gaps: &[Pause]) -> Still {
        let times = gaps
            .iter()
            .map(|gap| gap.t_ns.saturating_sub(gap.ns)..gap.t_ns);
        Still(times.collect())
    }

    /// How long a processor stood still between two instants, ms.
    pub(crate) fn between_ms(&self, from_ns: u64, to_ns: u64) -> f64 {
        ms(self.0.within_ns(from_ns, to_ns))
    }
}
