//! What was seen of a run's parts while the controller ran: how often they stood still, and who used the processors.
//!
//! It only counts; `judge` says what it means.

use std::ops::Range;
use std::thread;

use plan::evidence::Watched;
use plan::{End, EndFaultDone};

use super::end::EndPart;
use crate::error::RunError;

/// Who used the processors while the controller ran.
pub(super) struct Shares {
    /// When it ran, monotonic.
    loop_ns: Range<u64>,
    /// The first count and the last: when it was made, how long all processors had been busy, and how
    /// long this process and its descendants had run, in ns.
    taken: Option<[[u64; 3]; 2]>,
}

impl Shares {
    pub(super) fn new(loop_ns: Range<u64>) -> Shares {
        Shares {
            loop_ns,
            taken: None,
        }
    }

    pub(super) fn count(&mut self, now_ns: u64) {
        let taken = [now_ns, process::busy_ns(), process::own_strain().ran_ns];
        let [first, _] = self.taken.unwrap_or([taken; 2]);
        self.taken = Some([first, taken]);
    }

    /// Share of the time of all processors, 0 to 1, that went to processes other than this one and its
    /// descendants; 0 if it was not counted.
    fn others(&self) -> f64 {
        let Some(
            [
                [first_ns, busy_first, own_first],
                [last_ns, busy_last, own_last],
            ],
        ) = self.taken
        else {
            return 0.0;
        };
        let processors = thread::available_parallelism().map_or(1, usize::from) as f64;
        let all_ns = last_ns.saturating_sub(first_ns) as f64 * processors;
        let own_ns = own_last.saturating_sub(own_first) as f64;
        let others_ns = busy_last.saturating_sub(busy_first) as f64 - own_ns;
        (others_ns / all_ns.max(1.0)).max(0.0)
    }
}

/// What was seen of a part since its start.
pub(super) struct PartSeen {
    /// Its name in a manifest, which calls the link `player`.
    name: String,
    /// `None` for the link.
    pub(super) end: Option<End>,
    is_beneath: bool,
    pub(super) seen: process::Seen,
}

impl PartSeen {
    pub(super) fn of_end(part: &EndPart<'_>) -> Result<PartSeen, RunError> {
        Ok(PartSeen {
            name: part.end.to_string(),
            end: Some(part.end),
            is_beneath: part.is_beneath(),
            seen: part.seen()?,
        })
    }

    pub(super) fn of_player(seen: process::Seen) -> PartSeen {
        PartSeen {
            name: "player".to_owned(),
            end: None,
            is_beneath: false,
            seen,
        }
    }

    /// What was observed while the controller ran, with the part's name; without the stops that a fault asked for.
    /// For a controller that descends from this process, and may be a browser, this includes how long it waited
    /// while others had the processors. Elsewhere, those others cannot be told from the other parts of the run.
    pub(super) fn watched(self, shares: &Shares, end_faults: &[EndFaultDone]) -> (String, Watched) {
        let Range { start, end } = shares.loop_ns;
        let own = || end_faults.iter().filter(|one| Some(one.end) == self.end);
        let is_asked = |t_ns: &u64| own().any(|one| one.shows_at(*t_ns));
        let stops = self.seen.stops_within(start, end);
        let mut stops = stops.filter(|t_ns| !is_asked(t_ns)).peekable();
        let mut watched = Watched {
            looks: self.seen.looks_within(start, end),
            stopped_at_ns: stops.peek().copied().unwrap_or_default(),
            stopped: stops.count() as u64,
            ..Watched::default()
        };
        if self.end == Some(End::Controller)
            && self.is_beneath
            && let Some(strain) = self.seen.strain_within(start, end)
        {
            watched.ran_ms = strain.ran_ns as f64 * 1e-6;
            watched.waited_ms = strain.waited_ns as f64 * 1e-6;
            watched.others = shares.others();
        }
        (self.name, watched)
    }
}
