//! All that speaks for and against a run, and what it makes of the verdict.

use certificate::Pause;
use endpoint::{
    Connection, ControllerSettings, MessageRow, Schedule, TickNoise, TickRow, Transport,
};
use plan::{Disturbance, Verdict};
use serde::{Deserialize, Serialize};

use crate::end;
use crate::fault::Fault;
use crate::machine::{self, Pulse, Watched};
use crate::message::Messages;
use crate::terms::{Swamped, Terms};

/// What a run recorded of itself.
#[derive(Debug)]
pub struct Records<'a> {
    /// What the controller was set up with.
    pub settings: &'a ControllerSettings,
    /// When the first message was due, and until when they were, monotonic.
    pub from_ns: u64,
    /// See `from_ns`.
    pub to_ns: u64,
    /// The plant's ticks, and what they were asked to wait beyond their deadlines.
    pub ticks: &'a [TickRow],
    /// See `ticks`.
    pub tick_noise: Option<TickNoise>,
    /// Whether the plant's thread had real-time scheduling.
    pub plant_real_time: bool,
    /// Whether the controller's had.
    pub controller_real_time: bool,
    /// The controller's deadlines.
    pub messages: &'a [MessageRow],
    /// When the player was held up, and whether it had real-time scheduling.
    pub pauses: &'a [Pause],
    /// See `pauses`.
    pub player_real_time: bool,
    /// The pulse, where one was taken.
    pub pulse: Option<&'a Pulse>,
    /// What was seen of each part from outside: its name, and what.
    pub watched: &'a [(String, Watched)],
}

/// What a run's records come to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// What was done to it that nobody asked for.
    pub disturbances: Vec<Disturbance>,
    /// What speaks against its link, in sentences.
    pub faults: Vec<String>,
    /// Whether one of those cannot be explained by a machine that stood still.
    pub is_other: bool,
}

/// Judges a run by its records, given what its messages say.
#[must_use]
pub fn judge(records: &Records<'_>, messages: &Messages, terms: &Terms) -> Judgement {
    let Records {
        settings,
        from_ns,
        to_ns,
        ..
    } = *records;
    let h_ns = settings.h.ns();
    let keeps_time = terms.allowance.keeps_time && settings.schedule == Schedule::Absolute;
    let mut disturbances = Vec::new();
    disturbances.extend(records.pulse.and_then(|pulse| pulse.judge(from_ns, to_ns)));
    disturbances.extend(machine::player(
        records.pauses,
        records.player_real_time,
        from_ns,
        to_ns,
    ));
    disturbances.extend(end::plant(
        records.ticks,
        records.tick_noise,
        h_ns,
        records.plant_real_time,
        from_ns,
        to_ns,
    ));
    if keeps_time {
        let limit = settings.outstanding.limit();
        let swamped = Swamped::of(terms);
        disturbances.extend(end::controller(
            records.messages,
            limit,
            h_ns,
            records.controller_real_time,
            from_ns,
            to_ns,
            |t_ns| swamped.contains(t_ns),
        ));
    }
    for (what, watched) in records.watched {
        let said = disturbances.iter().any(|known| known.what == *what);
        disturbances.extend(
            (!said)
                .then(|| watched.judge(what, from_ns, to_ns))
                .flatten(),
        );
    }
    let faults = messages.faults(terms);
    Judgement {
        disturbances,
        is_other: faults.iter().any(|fault: &Fault| !fault.by_lateness),
        faults: faults.into_iter().map(|fault| fault.words).collect(),
    }
}

impl Judgement {
    /// The verdict on a run that came to its end. `doubts` are what else speaks against it, and
    /// `is_other` whether a machine that stood still cannot explain those.
    ///
    /// What was held up makes a link look late, or lossy, and never quick. So a run that was disturbed
    /// is `disturbed`, unless something speaks against its link that no delay can do.
    #[must_use]
    pub fn verdict(&self, doubts: &[String], is_other: bool) -> Verdict {
        let is_clean = self.faults.is_empty() && doubts.is_empty();
        match (self.disturbances.is_empty(), is_clean) {
            (true, true) => Verdict::Complete,
            (true, false) => Verdict::Invalid,
            (false, _) if self.is_other || is_other => Verdict::Invalid,
            (false, _) => Verdict::Disturbed,
        }
    }
}

/// Whether each message of a client set up so has a connection of its own.
#[must_use]
pub fn opens_always(settings: &ControllerSettings) -> bool {
    settings.connection == Connection::New
}

/// Whether all share one.
#[must_use]
pub fn shares_one(settings: &ControllerSettings) -> bool {
    settings.transport == Transport::WebSocket
}
