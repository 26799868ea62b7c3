//! What to blame: the moment of a run at which the plant was steered by the oldest y, and what that age was
//! made of.
//!
//! At each instant a command is in effect that follows from some y; how long ago that y was measured is its
//! age. It grows until a command takes effect that follows from a newer one, and the run counts from its first
//! deadline to its planned end, whatever arrived; a loop that was lost counts until then, since what came after did
//! not lose it. The age's peak is cut into parts by the stamps in the rows and
//! by what the link had at each instant; the parts add up to the nanosecond. While no newer command came, the
//! message is asked that was to bring one: on the link, lost, opening a connection, or not sent at all.
//!
//! Whether the loop was hurt by it is not asked here: that is the verdict's.

mod asked;
mod chain;
mod message;
mod traffic;
mod walk;
mod words;

use endpoint::{
    ArrivalOutcome, ArrivalRow, Connection, MessageRow, Mode, Outstanding, TickRow, Transport,
};
use link::Timeline;
use plan::Plan;
use record::{Held, ReadError};

use crate::budget::timeline;
use crate::campaign::Run;
use crate::numbered::Numbered;

/// What a part of an age was spent with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The link's delay, of both ways.
    Link,
    /// A packet that the link lost: the message never came, or was sent again.
    Loss,
    /// A connection had to be opened first.
    Connection,
    /// No message was sent, since an earlier one was still without its answer.
    Queue,
    /// The controller stood still: it sent late or not at all, or took an answer late.
    Controller,
    /// The plant stood still: its ticks were late, and what came waited for them.
    Plant,
    /// Waits that every sampled loop has: for the next message, the next deadline, the next tick.
    Sampling,
    /// The programs and kernels of the ends, where the rows do not show which.
    Ends,
    /// The controller's rows do not say when it sent, so that these parts cannot be told apart.
    Untold,
}

impl Cause {
    /// All causes.
    pub const ALL: [Cause; 9] = [
        Cause::Link,
        Cause::Loss,
        Cause::Connection,
        Cause::Queue,
        Cause::Controller,
        Cause::Plant,
        Cause::Sampling,
        Cause::Ends,
        Cause::Untold,
    ];
}

/// What is known of a run beside its rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facts {
    /// The first deadline, ns.
    pub start_ns: u64,
    /// The planned end, ns, or when the loop was lost, if that was before.
    pub end_ns: u64,
    /// Whether the loop was lost then.
    pub is_lost: bool,
    /// The sample time, ns.
    pub h_ns: u64,
    /// How many messages may be under way at once.
    pub outstanding: Outstanding,
    /// Whether each message opens a connection.
    pub connection: Connection,
    /// What carries messages.
    pub transport: Transport,
    /// How long a message waits for its answer, ns.
    pub timeout_ns: u64,
    /// Length of a message's packets up and down, bytes: it matters if the link has a rate.
    pub bytes: [u32; 2],
}

/// Which stamps a controller left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stamps {
    /// When it sent each message and had its answer.
    All,
    /// When it sent, and not when it had the answers: these are taken to come as soon as the link allows.
    Sent,
    /// None: messages are taken to be sent as late as the link allows, or at their deadline if that explains them.
    None,
}

/// What ended an age.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// A newer y took its place.
    Newer,
    /// The loop was lost.
    Lost,
    /// The run was over.
    Over,
}

/// The greatest age of a run, and what it was made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blame {
    /// When the y was measured, ns after the first deadline; 0 for a command that follows from none, as the first do.
    pub from_ns: u64,
    /// When it ended, ns after the first deadline.
    pub to_ns: u64,
    /// What ended it.
    pub end: End,
    /// The median over the run of what the age grew to before each newer y, ns.
    pub usual_ns: u64,
    /// The parts, ns, in the order of [`Cause::ALL`]; their sum is the age.
    pub parts_ns: [u64; 9],
    /// The parts of an age that is usual.
    pub usual_parts_ns: [u64; 9],
    /// Of the link's part, what was spent on the way up, ns.
    pub up_ns: u64,
    /// Which stamps the controller left.
    pub stamps: Stamps,
}

impl Blame {
    /// Reads the rows of a closed loop and asks its link; `None` without a tick.
    ///
    /// # Errors
    /// [`ReadError`] if rows cannot be read.
    pub fn of(run: &Run, plan: &Plan) -> Result<Option<Blame>, ReadError> {
        Ok(Self::by(&Held::read(&run.folder)?, run, plan))
    }

    /// The same by rows that have been read.
    #[must_use]
    pub fn by(rows: &Held, run: &Run, plan: &Plan) -> Option<Blame> {
        let start_ns = run.start_ns();
        let (cell, settings) = (&run.cell, &run.cell.settings);
        let lost_ns = lost_ns(run).filter(|lost_ns| *lost_ns < cell.duration_ns);
        let facts = Facts {
            start_ns,
            end_ns: start_ns.saturating_add(lost_ns.unwrap_or(cell.duration_ns)),
            is_lost: lost_ns.is_some(),
            h_ns: settings.h.ns(),
            // Of a program of one's own it is not known; the plainest waits for each answer.
            outstanding: if cell.client.is_own() {
                Outstanding::ONE
            } else {
                settings.outstanding
            },
            connection: settings.connection,
            transport: settings.transport,
            timeout_ns: settings.timeout_ns,
            bytes: cell.client.message_bytes(settings.transport),
        };
        if settings.mode == Mode::Open {
            return None;
        }
        Self::among(
            &rows.messages,
            &rows.arrivals,
            &rows.ticks,
            timeline(run, plan),
            &facts,
        )
    }

    /// The same from rows; `None` without a tick.
    #[must_use]
    pub fn among(
        messages: &[MessageRow],
        arrivals: &[ArrivalRow],
        ticks: &[TickRow],
        link: Option<Timeline>,
        facts: &Facts,
    ) -> Option<Blame> {
        // Of a command that came twice, the first counts.
        let arrived = arrivals.iter().map(|row| {
            let is_taken = row.outcome == ArrivalOutcome::Applied;
            (row.seq, (row.t_arrive_ns, is_taken))
        });
        let arrived: Numbered<(u64, bool)> = arrived.collect();
        let traffic = traffic::Traffic::of(messages, &arrived, link, facts);
        chain::worst(&traffic, ticks, facts)
    }

    /// The age, ns.
    #[must_use]
    pub fn age_ns(&self) -> u64 {
        self.to_ns.saturating_sub(self.from_ns)
    }

    /// One of its parts, ns.
    #[must_use]
    pub fn part_ns(&self, cause: Cause) -> u64 {
        self.parts_ns[cause as usize]
    }

    /// What made it so old: the part that grew most beyond what is usual, where the age stands out from that; or
    /// else the largest part.
    #[must_use]
    pub fn cause(&self) -> Cause {
        let usual_ns = |cause: Cause| match self.stands_out() {
            true => self.usual_parts_ns[cause as usize],
            false => 0,
        };
        let beyond_ns = |cause: Cause| self.part_ns(cause).saturating_sub(usual_ns(cause));
        let mut most = Cause::Link;
        for cause in Cause::ALL {
            if beyond_ns(cause) > beyond_ns(most) {
                most = cause;
            }
        }
        most
    }

    /// Whether the age is more than a quarter above what is usual in its run.
    #[must_use]
    pub fn stands_out(&self) -> bool {
        self.age_ns() > self.usual_ns.saturating_add(self.usual_ns / 4)
    }
}

/// When the loop of a run was lost, ns after the first deadline.
fn lost_ns(run: &Run) -> Option<u64> {
    let response = run.metrics.as_ref()?.response?;
    response.lost_s.map(|lost_s| (lost_s * 1e9) as u64)
}
