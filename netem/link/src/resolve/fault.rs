//! Faults: when each is in force, its one effect, and whether a player can keep up with them.

use toml::Spanned;

use super::delay::{LONGEST_DELAY_NS, MOST_HOLDS_IN_FLIGHT, optional};
use crate::fault::{Again, Effect, Fault, SLOT_NS};
use crate::file::{FaultFile, ProfileFile};
use crate::finding::Findings;
use crate::profile::{Delay, PathLaw};
use crate::way::Way;

/// For each packet the player asks each fault.
const MOST_FAULTS: usize = 100;
/// How long `reorder` holds packets back if the profile does not say.
const BY_NS: u64 = 5_000_000;

/// A valid fault, and the direction that it concerns if it is only one.
pub(super) type Placed = (Option<Way>, Fault);

/// The valid faults of a profile, in the order of its source.
pub(super) fn faults(profile: &ProfileFile, findings: &mut Findings<'_>) -> Vec<Placed> {
    let files = &profile.fault;
    if let (true, Some(first)) = (profile.loopback, files.first()) {
        let message = "the link is loopback, where nothing is played";
        let remedy = "drop the faults or `loopback`";
        findings.error(first.span(), message, remedy);
        return Vec::new();
    }
    if let Some(more) = files.get(MOST_FAULTS) {
        let message = format!("there are more than {MOST_FAULTS} faults");
        let remedy = "let a fault come again, with `every` or `period`";
        findings.error(more.span(), message, remedy);
        return Vec::new();
    }
    let each = files.iter().zip(0..);
    each.filter_map(|(file, number)| fault(file, number, findings))
        .collect()
}

/// Gives each direction its faults, and checks that its delay does not change too often for a player.
pub(super) fn share_out(
    faults: &[Placed],
    files: &[Spanned<FaultFile>],
    laws: [&mut PathLaw; 2],
    findings: &mut Findings<'_>,
) {
    for (own, law) in Way::BOTH.into_iter().zip(laws) {
        let is_own = |(way, fault): &Placed| {
            let concerns = way.is_none_or(|way| way == own);
            concerns.then(|| fault.clone())
        };
        law.faults = faults.iter().filter_map(is_own).collect();
        let borders = law.faults.iter().map(|fault| match fault.effect {
            Effect::Delay { .. } => fault.step_ns().map_or(0.0, |step_ns| 2.0 / step_ns as f64),
            _ => 0.0,
        });
        let borders_per_ns: f64 = borders.sum();
        let holds_per_ns = match &law.delay {
            Delay::Held(level) => 1.0 / level.hold_ns as f64,
            Delay::Constant { .. } | Delay::Trace(_) => 0.0,
        };
        let reach_ns = law.reach_ns() as f64;
        let changes = reach_ns * (borders_per_ns + holds_per_ns);
        let is_delay = |fault: &&Fault| matches!(fault.effect, Effect::Delay { .. });
        let Some(last) = law.faults.iter().rfind(is_delay) else {
            continue;
        };
        let Some(file) = files.get(last.number as usize) else {
            continue;
        };
        if reach_ns > LONGEST_DELAY_NS || changes > MOST_HOLDS_IN_FLIGHT {
            let message = match reach_ns > LONGEST_DELAY_NS {
                true => "with its faults the delay can exceed an hour".to_owned(),
                false => {
                    format!("the delay changes {changes:.0} times while a packet is under way")
                }
            };
            let remedy = "write a smaller `delay`, or let the fault come less often";
            let delay = file.get_ref().delay.as_ref();
            let span = delay.map_or(file.span(), Spanned::span);
            findings.error(span, message, remedy);
            // Both directions have the same trouble; once is enough.
            return;
        }
    }
}

fn fault(file: &Spanned<FaultFile>, number: u32, findings: &mut Findings<'_>) -> Option<Placed> {
    let at = file.get_ref();
    let at_ns = findings.duration_ns(&at.at);
    let for_ns = findings.positive_ns(&at.r#for);
    let again = again(at, for_ns, findings);
    let times = times(at, findings);
    let effect = effect(file, findings);
    let fault = Fault {
        number,
        at_ns: at_ns? as u64,
        for_ns: for_ns? as u64,
        again: again?,
        times: times?,
        effect: effect?,
    };
    warn(file, &fault, findings);
    Some((at.way.as_ref().map(|way| *way.get_ref()), fault))
}

fn again(at: &FaultFile, for_ns: Option<f64>, findings: &mut Findings<'_>) -> Option<Again> {
    let every_ns = optional(&at.every, |every| findings.positive_ns(every));
    let period_ns = optional(&at.period, |period| findings.positive_ns(period));
    let (every_ns, period_ns, for_ns) = (every_ns?, period_ns?, for_ns?);
    if let (Some(_), Some(period)) = (&at.every, &at.period) {
        let message = "a fault comes again at random (`every`) or exactly so often (`period`)";
        findings.error(period.span(), message, "drop one of the two");
        return None;
    }
    for (name, key, ns) in [
        ("every", &at.every, every_ns),
        ("period", &at.period, period_ns),
    ] {
        if let (Some(key), Some(ns)) = (key, ns)
            && ns < for_ns
        {
            let message = format!("the fault lasts longer than its `{name}`");
            let remedy = format!("write a shorter `for` or a longer `{name}`");
            findings.error(key.span(), message, remedy);
            return None;
        }
    }
    Some(match (every_ns, period_ns) {
        (Some(every_ns), _) => Again::Random {
            every_ns: every_ns as u64,
        },
        (None, Some(period_ns)) => Again::Exact {
            period_ns: period_ns as u64,
        },
        (None, None) => Again::Never,
    })
}

fn times(at: &FaultFile, findings: &mut Findings<'_>) -> Option<Option<u64>> {
    let Some(times) = &at.times else {
        return Some(None);
    };
    let (message, remedy) = match u64::try_from(*times.get_ref()) {
        Ok(_) if at.every.is_none() && at.period.is_none() => (
            "`times` without `every` or `period`: the fault comes once".to_owned(),
            "add `every` or `period`, or drop `times`",
        ),
        Ok(count) if count > 0 => return Some(Some(count)),
        _ => (
            format!("a fault that comes {} times", times.get_ref()),
            "write 1 or more",
        ),
    };
    findings.error(times.span(), message, remedy);
    None
}

/// The one effect of a fault.
fn effect(file: &Spanned<FaultFile>, findings: &mut Findings<'_>) -> Option<Effect> {
    let at = file.get_ref();
    let by_ns = optional(&at.by, |by| findings.positive_ns(by))?;
    let by_ns = by_ns.map_or(BY_NS, |by_ns| by_ns as u64);
    let mut effects: Vec<Option<Effect>> = Vec::new();
    for (word, key, effect) in [
        ("down", &at.down, Effect::Down),
        ("reset", &at.reset, Effect::Reset),
        ("rebind", &at.rebind, Effect::Rebind),
    ] {
        let Some(is_on) = key else { continue };
        if !is_on.get_ref() {
            let message = format!("`{word} = false` does nothing");
            let remedy = format!("write {word} = true, or drop this key");
            findings.error(is_on.span(), message, remedy);
        }
        effects.push(is_on.get_ref().then_some(effect));
    }
    if let Some(delay) = &at.delay {
        let delay_ns = findings.positive_ns(delay);
        effects.push(delay_ns.map(|delay_ns| Effect::Delay {
            delay_ns: delay_ns as u64,
        }));
    }
    let of_share = [
        (&at.loss, Effect::Loss { share: 0.0 }),
        (&at.duplicate, Effect::Duplicate { share: 0.0 }),
        (&at.reorder, Effect::Reorder { share: 0.0, by_ns }),
        (&at.corrupt, Effect::Corrupt { share: 0.0 }),
    ];
    for (key, effect) in of_share {
        let Some(text) = key else { continue };
        let share = findings.share(text);
        if share == Some(0.0) {
            let message = "a share of nothing";
            findings.warning(text.span(), message, "write more than 0%");
        }
        effects.push(share.map(|share| effect.of(share)));
    }
    if let (Some(by), None) = (&at.by, &at.reorder) {
        let message = "`by` without `reorder`: nothing is held back";
        findings.error(by.span(), message, "add `reorder`, or drop `by`");
        return None;
    }
    if let (Some(_), Some(way)) = (&at.rebind, &at.way) {
        let message = "ports change in both directions, or nothing comes back";
        findings.error(way.span(), message, "drop `way`");
        return None;
    }
    if effects.len() == 1 {
        return effects.pop().flatten();
    }
    let message = match effects.len() {
        0 => "a fault needs an effect".to_owned(),
        count => format!("a fault has one effect, and this one has {count}"),
    };
    let remedy = "write one of down, delay, loss, duplicate, reorder, corrupt, reset, rebind";
    findings.error(file.span(), message, remedy);
    None
}

/// Reports what can be played but was hardly meant.
fn warn(file: &Spanned<FaultFile>, fault: &Fault, findings: &mut Findings<'_>) {
    let at = file.get_ref();
    if fault.step_ns() == Some(fault.for_ns) && fault.times != Some(1) {
        let message = "one spell follows the other without a gap";
        let remedy = "write a shorter `for`, or one long fault";
        findings.warning(at.r#for.span(), message, remedy);
    }
    let is_of_slots = matches!(
        fault.effect,
        Effect::Loss { share } | Effect::Duplicate { share } | Effect::Corrupt { share }
            | Effect::Reorder { share, .. } if share < 1.0
    );
    if is_of_slots && fault.for_ns < SLOT_NS {
        let message = "the fault is shorter than a slot of 1 ms, and may concern no packet";
        findings.warning(at.r#for.span(), message, "write 1ms or more");
    }
    if let (Effect::Loss { share }, Some(text)) = (fault.effect, &at.loss)
        && share >= 1.0
    {
        let message = "every packet is lost";
        findings.warning(text.span(), message, "say so: down = true");
    }
}
