//! The ages of a run, and the greatest of them part by part: from the tick at which y was measured, by the way
//! of the command that follows from it, to its effect, and on to the effect of a newer one.

use std::collections::BTreeMap;
use std::ops::Range;

use endpoint::TickRow;

use super::message::Message;
use super::traffic::Traffic;
use super::walk::{Goal, Walk};
use super::{Blame, Cause, End, Facts};

/// A tick is late from here on, ns.
const PUNCTUAL_NS: u64 = 100_000;

/// A command in effect.
#[derive(Debug, Clone, Copy)]
struct Effect {
    t_ns: u64,
    /// Its place among the messages; `None` if none has its number.
    message: Option<usize>,
    /// The place of the message whose answer had the y from which it follows; `None` for a command without one.
    known: Option<usize>,
    /// When that y was measured, ns.
    measured_ns: u64,
}

/// The age that was greatest; `None` without a tick.
pub(super) fn worst(traffic: &Traffic, ticks: &[TickRow], facts: &Facts) -> Option<Blame> {
    ticks.first()?;
    let effects = effects(traffic, ticks, facts);
    let next_ns = |at: usize| {
        let next = effects.get(at + 1).map_or(facts.end_ns, |next| next.t_ns);
        next.min(facts.end_ns)
    };
    let late = late(ticks);
    let walked = |age: &Age| {
        let mut walk = Walk::new(traffic, &late, facts, age.from_ns..age.to_ns);
        match age.effect {
            Some(at) => follow(&mut walk, traffic, &effects[at], facts),
            None => walk.wait(age.to_ns, Goal::Effect(None)),
        }
        // The last tick of what is waited for.
        walk.go(age.to_ns, Cause::Sampling);
        walk
    };
    // Before the first command the plant is steered by nothing, as old as the run.
    let mut ages = vec![Age {
        from_ns: facts.start_ns,
        to_ns: effects.first().map_or(facts.end_ns, |first| first.t_ns),
        effect: None,
    }];
    ages.extend(effects.iter().enumerate().map(|(at, effect)| Age {
        from_ns: effect.measured_ns,
        to_ns: next_ns(at),
        effect: Some(at),
    }));
    // In a stable order: of equal ages the first.
    ages.sort_by_cached_key(Age::ns);
    let usual = ages.get(ages.len() / 2)?;
    let worst = ages.last().map(Age::ns)?;
    let worst = ages.iter().find(|age| age.ns() == worst)?;
    let walk = walked(worst);
    Some(Blame {
        from_ns: worst.from_ns.saturating_sub(facts.start_ns),
        to_ns: worst.to_ns.saturating_sub(facts.start_ns),
        end: match (worst.to_ns >= facts.end_ns, facts.is_lost) {
            (false, _) => End::Newer,
            (true, true) => End::Lost,
            (true, false) => End::Over,
        },
        usual_ns: usual.ns(),
        parts_ns: walk.parts_ns,
        usual_parts_ns: walked(usual).parts_ns,
        up_ns: walk.up_ns,
        stamps: traffic.stamps,
    })
}

/// From the measurement of a y to the effect of a newer one, or to the end of the run.
#[derive(Debug, Clone, Copy)]
struct Age {
    from_ns: u64,
    to_ns: u64,
    /// The effect of the command that follows from it; `None` before the first.
    effect: Option<usize>,
}

impl Age {
    fn ns(&self) -> u64 {
        self.to_ns.saturating_sub(self.from_ns)
    }
}

/// Follows a sample from its measurement to the effect of the next.
fn follow(walk: &mut Walk<'_>, traffic: &Traffic, effect: &Effect, facts: &Facts) {
    let known = effect.known.map(|at| &traffic.messages[at]);
    if let Some(known) = known {
        walk.go(known.arrive_ns.unwrap_or(0), Cause::Sampling);
        walk.down(known);
    }
    if let Some(one) = effect.message.map(|at| &traffic.messages[at]) {
        let received_ns = known.and_then(|known| known.receive_ns).unwrap_or(0);
        let ready_ns = if one.is_guessed {
            one.send_ns
        } else {
            one.due_ns.max(received_ns).min(one.send_ns)
        };
        // Up to h is the deadline's; before that a newer answer did not come.
        let tick = known.and_then(|known| known.tick);
        walk.wait(ready_ns.saturating_sub(facts.h_ns), Goal::Answer(tick));
        walk.go(ready_ns, Cause::Sampling);
        walk.go(one.send_ns, Cause::Controller);
        walk.up(one);
    }
    walk.go(effect.t_ns, Cause::Sampling);
    walk.wait(u64::MAX, Goal::Effect(effect.message));
}

/// The commands in effect from the first deadline to the end, in order.
fn effects(traffic: &Traffic, ticks: &[TickRow], facts: &Facts) -> Vec<Effect> {
    let known = known(&traffic.messages);
    let mut places: BTreeMap<u64, usize> = BTreeMap::new();
    for (at, one) in traffic.messages.iter().enumerate() {
        places.entry(one.seq).or_insert(at);
    }
    let measured_ns = |k: u64| {
        let at = ticks.binary_search_by_key(&k, |row| row.k).ok();
        at.map(|at| ticks[at].t_tick_ns)
    };
    let mut newest = None;
    let mut effects = Vec::new();
    for row in ticks {
        let Some(seq) = row.seq.filter(|_| row.seq != newest) else {
            continue;
        };
        newest = row.seq;
        if row.t_tick_ns >= facts.end_ns {
            break;
        }
        let message = places.get(&seq).copied();
        let known = message.and_then(|at| known[at]);
        let tick = known.and_then(|at| traffic.messages[at].tick);
        let measured_ns = match (message, tick.and_then(measured_ns)) {
            (_, Some(t_ns)) => t_ns.min(row.t_tick_ns),
            // It follows from the plant at rest, which is known at the start.
            (Some(_), None) => facts.start_ns,
            (None, None) => row.t_tick_ns,
        };
        effects.push(Effect {
            t_ns: row.t_tick_ns.max(facts.start_ns),
            message,
            known,
            measured_ns: measured_ns.max(facts.start_ns),
        });
    }
    effects
}

/// For each message the one whose answer was the newest known when it was sent: by the plant's tick, since
/// answers may overtake.
fn known(messages: &[Message]) -> Vec<Option<usize>> {
    let mut answered: Vec<usize> = (0..messages.len())
        .filter(|at| messages[*at].receive_ns.is_some() && messages[*at].tick.is_some())
        .collect();
    answered.sort_by_cached_key(|at| messages[*at].receive_ns);
    let mut answered = answered.into_iter().peekable();
    let mut newest: Option<usize> = None;
    let of = |one: &Message| {
        while let Some(at) = answered.next_if(|at| messages[*at].receive_ns <= Some(one.send_ns)) {
            if newest.is_none_or(|newest| messages[at].tick > messages[newest].tick) {
                newest = Some(at);
            }
        }
        newest
    };
    messages.iter().map(of).collect()
}

/// When a tick was due that had not come yet: in order, and apart.
fn late(ticks: &[TickRow]) -> Vec<Range<u64>> {
    let mut late: Vec<Range<u64>> = Vec::new();
    for row in ticks {
        if row.t_tick_ns <= row.t_due_ns.saturating_add(PUNCTUAL_NS) {
            continue;
        }
        match late.last_mut() {
            Some(last) if row.t_due_ns <= last.end => last.end = last.end.max(row.t_tick_ns),
            Some(last) if row.t_due_ns < last.start => {}
            _ => late.push(row.t_due_ns..row.t_tick_ns),
        }
    }
    late
}
