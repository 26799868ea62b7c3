//! The delay budget of a sample: from the tick at which y was measured to the tick at which the u that
//! follows from it took effect, part by part; and the round trip of each message in its parts.
//!
//! Everything is a difference of stamps in the rows, in whole nanoseconds, so the parts add up exactly.
//! Only the link's share of a way is not stamped: it is what the link had at the instant of sending, by
//! its profile and seed; what the way took beyond that is the ends' own: processes, kernel, and what was
//! sent again.

mod rows;

use link::{Profile, Timeline};
use plan::Plan;
use record::{Held, ReadError};

use crate::campaign::Run;
use crate::numbered::Numbered;
use crate::statistics::upper_median;

use self::rows::of_rows;

/// A part of a sample's delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// From the plant's tick to the arrival of the message whose answer carries its y.
    Read,
    /// From that arrival to the answer's, without the link's share.
    Answer,
    /// The link's share of the way down.
    Down,
    /// From the answer to the next deadline of the controller, or to the sending, if that is after it.
    Law,
    /// From the deadline to the sending of the command.
    Client,
    /// The link's share of the way up.
    Up,
    /// The rest of the way up.
    Request,
    /// From the command's arrival to the plant's next tick, which takes it.
    Tick,
}

impl Part {
    /// All parts, in the order in which a sample meets them.
    pub const ALL: [Part; 8] = [
        Part::Read,
        Part::Answer,
        Part::Down,
        Part::Law,
        Part::Client,
        Part::Up,
        Part::Request,
        Part::Tick,
    ];

    /// Its name: `y waits to be read`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Part::Read => "y waits to be read",
            Part::Answer => "answer, ends",
            Part::Down => "link down",
            Part::Law => "waits for the deadline",
            Part::Client => "client late",
            Part::Up => "link up",
            Part::Request => "request, ends",
            Part::Tick => "u waits for the tick",
        }
    }

    /// Whether it is the link's.
    #[must_use]
    pub fn is_link(self) -> bool {
        matches!(self, Part::Up | Part::Down)
    }
}

/// A command that took effect, with the delay of the y from which it follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// The command's number.
    pub seq: u64,
    /// When it was due, ns.
    pub t_due_ns: u64,
    /// The parts, ns, in the order of [`Part::ALL`]. A part may be a little below zero where two threads
    /// stamp what happens at once.
    pub parts_ns: [i64; 8],
}

impl Sample {
    /// From measurement to effect, ns.
    #[must_use]
    pub fn total_ns(&self) -> i64 {
        self.until_ns(Part::ALL.len())
    }

    /// The sum of the parts before one, ns: where it begins in a stack.
    #[must_use]
    pub fn before_ns(&self, part: Part) -> i64 {
        self.until_ns(part as usize)
    }

    /// Stamps may be anything: a sum that leaves the range comes back, and the whole is exact.
    fn until_ns(&self, end: usize) -> i64 {
        let parts = self.parts_ns[..end].iter();
        parts.fold(0, |sum: i64, part| sum.wrapping_add(*part))
    }

    /// One of its parts, ns.
    #[must_use]
    pub fn part_ns(&self, part: Part) -> i64 {
        self.parts_ns[part as usize]
    }
}

/// One way of a message, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Crossing {
    /// The link's share: at most the whole.
    pub link_ns: i64,
    /// The rest.
    pub ends_ns: i64,
}

impl Crossing {
    /// The whole way, ns.
    #[must_use]
    pub fn ns(self) -> i64 {
        self.link_ns.wrapping_add(self.ends_ns)
    }
}

/// A message that reached the plant, in the order of sending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trip {
    /// Its number.
    pub seq: u64,
    /// When it was due, ns.
    pub t_due_ns: u64,
    /// When it was sent, ns.
    pub t_send_ns: u64,
    /// Up, from sending to arrival.
    pub up: Crossing,
    /// Down, from arrival to the answer; `None` without one.
    pub down: Option<Crossing>,
}

impl Trip {
    /// How late it was sent, ns.
    #[must_use]
    pub fn client_ns(&self) -> i64 {
        between(self.t_due_ns, self.t_send_ns)
    }

    /// Its round trip, ns; `None` without an answer.
    #[must_use]
    pub fn round_trip_ns(&self) -> Option<i64> {
        Some(self.up.ns().wrapping_add(self.down?.ns()))
    }
}

/// The messages of a run in their parts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Budget {
    /// When the controller's first message was due, ns: the origin of times in figures.
    pub start_ns: u64,
    /// When the first command took effect, ns: the start of the step response.
    pub effect_ns: Option<u64>,
    /// The messages that reached the plant.
    pub trips: Vec<Trip>,
    /// The commands that took effect; none in open loop.
    pub samples: Vec<Sample>,
    /// When each message was due that was not sent, ns.
    pub missed_ns: Vec<u64>,
    /// When each message was sent that never arrived, ns.
    pub lost_ns: Vec<u64>,
}

impl Budget {
    /// Reads a run's rows and asks its link.
    ///
    /// # Errors
    /// [`ReadError`] if rows cannot be read.
    pub fn of(run: &Run, plan: &Plan) -> Result<Budget, ReadError> {
        Self::through(run, timeline(run, plan))
    }

    /// The same with the run's link, by [`timeline`] or [`timeline_of`].
    ///
    /// # Errors
    /// [`ReadError`] if rows cannot be read.
    pub fn through(run: &Run, link: Option<Timeline>) -> Result<Budget, ReadError> {
        Ok(Self::by(&Held::read(&run.folder)?, run, link))
    }

    /// The same by rows that have been read.
    #[must_use]
    pub fn by(rows: &Held, run: &Run, link: Option<Timeline>) -> Budget {
        // Of a command that came twice, the first counts.
        let arrived = rows.arrivals.iter();
        let arrived: Numbered<u64> = arrived.map(|row| (row.seq, row.t_arrive_ns)).collect();
        let bytes = run.cell.client.message_bytes(run.cell.settings.transport);
        let link = link.map(|link| (link, bytes));
        Budget {
            start_ns: run.start_ns(),
            ..of_rows(&rows.messages, &arrived, &rows.ticks, link)
        }
    }

    /// An instant in the time of figures, s from the first deadline.
    #[must_use]
    pub fn second(&self, t_ns: u64) -> f64 {
        between(self.start_ns, t_ns) as f64 / 1e9
    }

    /// The median of each part over the samples, ns, in the order of [`Part::ALL`]; `None` without one.
    #[must_use]
    pub fn medians_ns(&self) -> Option<[i64; 8]> {
        let middle = |part: Part| {
            let mut values: Vec<i64> = self.samples.iter().map(|one| one.part_ns(part)).collect();
            upper_median(&mut values, Ord::cmp)
        };
        let mut medians = [0; 8];
        for part in Part::ALL {
            medians[part as usize] = middle(part)?;
        }
        Some(medians)
    }
}

/// The link of a run as it met it; `None` if the run or its profile is not known well enough to say.
#[must_use]
pub fn timeline(run: &Run, plan: &Plan) -> Option<Timeline> {
    timeline_of(run, &profile(run, plan)?)
}

/// The same by the run's profile, which is that of all runs of its topology with its fault: to read one takes as
/// long as all of a run's rows.
#[must_use]
pub fn timeline_of(run: &Run, profile: &Profile) -> Option<Timeline> {
    let manifest = run.manifest.as_ref()?;
    let link = Timeline::new(profile, run.cell.link_seed, manifest.epoch);
    Some(link.closing(run.cell.closes_at()))
}

/// The profile of a run's link; `None` if it is not known well enough to say.
#[must_use]
pub fn profile(run: &Run, plan: &Plan) -> Option<Profile> {
    let text = plan.profile(&run.cell)?;
    text.profile(&run.cell.topology).ok()
}

/// Time from one stamp to another, ns.
fn between(from_ns: u64, to_ns: u64) -> i64 {
    to_ns.wrapping_sub(from_ns).cast_signed()
}
