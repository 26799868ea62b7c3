//! Collects the evidence for and against a run, and derives the verdict from it.

use endpoint::{ControllerSettings, MessageRow, Mode, Schedule, TickNoise, TickRow};
use link::certificate::Pause;
use plan::{Disturbance, EndEffect, EndFaultDone, Verdict};
use serde::{Deserialize, Serialize};

use crate::end;
use crate::fault::LinkFault;
use crate::hit;
use crate::limit::Stillness;
use crate::machine;
use crate::message::faults;
use crate::met::Met;
use crate::terms::{Swamped, Terms};
use plan::evidence::{Messages, Pulse, Watched};

/// What a run recorded about itself.
#[derive(Debug)]
pub struct Records<'a> {
    /// The controller's settings.
    pub settings: &'a ControllerSettings,
    /// When the first message was due, monotonic.
    pub from_ns: u64,
    /// When the deadlines ended, monotonic.
    pub to_ns: u64,
    /// The plant's ticks.
    pub ticks: &'a [TickRow],
    /// The time that the ticks were asked to wait beyond their deadlines.
    pub tick_noise: Option<TickNoise>,
    /// Whether the plant's thread had real-time scheduling.
    pub plant_real_time: bool,
    /// Whether the controller's thread had real-time scheduling.
    pub controller_real_time: bool,
    /// The controller's deadlines.
    pub messages: &'a [MessageRow],
    /// When the player was held up.
    pub pauses: &'a [Pause],
    /// Whether the player had real-time scheduling.
    pub player_real_time: bool,
    /// The pulse, if one was recorded.
    pub pulse: Option<&'a Pulse>,
    /// What was observed of each part from outside, with the part's name.
    pub watched: &'a [(String, Watched)],
    /// What faults that the experiment asked for did to the ends.
    pub end_faults: &'a [EndFaultDone],
}

/// The result of judging a run's records.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// What was done to the run that nobody asked for.
    pub disturbances: Vec<Disturbance>,
    /// Evidence against its link, in sentences.
    pub faults: Vec<String>,
    /// Whether a machine that stood still cannot explain one of the faults.
    pub is_other: bool,
}

/// Judges a run by its records and the comparison of its messages with the link.
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
    let mut disturbances = stood_still(records);
    // In an open loop a plant's ticks steer nothing.
    if settings.mode == Mode::Closed {
        disturbances.extend(end::plant(
            records.ticks,
            records.tick_noise,
            &terms.hits,
            h_ns,
            Stillness::of(records.plant_real_time),
            from_ns,
            to_ns,
        ));
    }
    if keeps_time {
        let limit = settings.outstanding.limit();
        let swamped = Swamped::of(terms);
        disturbances.extend(end::controller(
            records.messages,
            limit,
            h_ns,
            Stillness::of(records.controller_real_time),
            from_ns,
            to_ns,
            |t_ns| swamped.contains(t_ns) || terms.hits.excuses_deadline(t_ns),
        ));
    }
    disturbances.extend(hit::off(records.end_faults, from_ns));
    // What was asked to compute beside the ends makes them wait.
    let is_busy = |one: &EndFaultDone| matches!(one.effect, EndEffect::Busy(_));
    let may_wait = records.end_faults.iter().any(is_busy);
    for (what, watched) in records.watched {
        let said = disturbances.iter().any(|known| known.what == *what);
        let is_excused = may_wait && watched.stopped == 0;
        if !said && !is_excused {
            disturbances.extend(machine::watched(watched, what, from_ns, to_ns));
        }
    }
    let (busy, faults): (Vec<LinkFault>, Vec<LinkFault>) = faults(messages, terms)
        .into_iter()
        .partition(|fault| fault.is_busy);
    disturbances.extend(busy.into_iter().map(|fault| Disturbance {
        what: "machine".to_owned(),
        at_s: 0.0,
        longest_ms: 0.0,
        words: format!("{}; this machine was as busy as that", fault.words),
    }));
    Judgement {
        disturbances,
        is_other: faults.iter().any(|fault: &LinkFault| !fault.by_lateness),
        faults: faults.into_iter().map(|fault| fault.words).collect(),
    }
}

/// What held the run up that has no rows: a processor, the player.
fn stood_still(records: &Records<'_>) -> Vec<Disturbance> {
    let Records { from_ns, to_ns, .. } = *records;
    let met = Met::of(records.settings.mode, records.messages);
    let pulse = records.pulse;
    let machine = pulse.and_then(|pulse| machine::pulse(pulse, &met, from_ns, to_ns));
    let limit = Stillness::of(records.player_real_time);
    let player = machine::player(records.pauses, &met, limit, from_ns, to_ns);
    machine.into_iter().chain(player).collect()
}

impl Judgement {
    /// Adds what the host took, if there is evidence against the run and nothing else explains it.
    pub fn excuse(&mut self, doubts: &[String], taken: Option<Disturbance>) {
        if !self.is_clean(doubts) && self.disturbances.is_empty() {
            self.disturbances.extend(taken);
        }
    }

    fn is_clean(&self, doubts: &[String]) -> bool {
        self.faults.is_empty() && doubts.is_empty()
    }

    /// The verdict on a run that came to its end. `doubts` is further evidence against it, and
    /// `is_other` says whether a machine that stood still cannot explain one of the doubts.
    ///
    /// A machine that holds up the run makes a link look late or lossy, never quick. So a run with
    /// disturbances is `disturbed`, unless there is evidence against its link that no delay can
    /// explain.
    #[must_use]
    pub fn verdict(&self, doubts: &[String], is_other: bool) -> Verdict {
        match (self.disturbances.is_empty(), self.is_clean(doubts)) {
            (true, true) => Verdict::Complete,
            (true, false) => Verdict::Invalid,
            (false, _) if self.is_other || is_other => Verdict::Invalid,
            (false, _) => Verdict::Disturbed,
        }
    }
}
