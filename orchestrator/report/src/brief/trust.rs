//! Can one believe it: how much was run, what was checked of it, and what its repeats are a sample of.

use analysis::variety::Variety;
use analysis::{Campaign, unjudged};

use crate::answer::Coverage;
use crate::loops::Loop;
use crate::number::{duration, percent, spelled};

/// Below this number of repeats there are no intervals.
pub(super) const FEW: usize = 6;

/// What stands behind the answer.
pub(super) fn trust(campaign: &Campaign, loops: &[Loop<'_>]) -> String {
    let mut words = vec![Coverage::of(campaign).words()];
    words.extend(checked(campaign));
    words.extend(shown(campaign));
    words.extend(repeated(campaign, loops));
    let all: Vec<_> = campaign.runs.iter().map(unjudged::of).collect();
    words.extend(unjudged::sentence(&all));
    words.join(" ")
}

/// What makes a complete run one: its link, and its ends as far as they are the plan's.
fn checked(campaign: &Campaign) -> Option<String> {
    let complete = || campaign.runs.iter().filter(|run| run.is_complete());
    complete().next()?;
    if campaign.is_simulated() {
        return Some("In virtual time no machine and no kernel had a part in it.".to_owned());
    }
    let ends = |run: &analysis::Run| run.manifest.as_ref().and_then(|of| of.ends);
    if complete().any(|run| ends(run).is_none()) {
        return Some("In these the link was the one asked for.".to_owned());
    }
    let has_own_controller = complete().any(|run| run.cell.client.is_own());
    let has_own_plant = complete().any(|run| campaign.plan.plant_program(&run.cell).is_some());
    let ends = match (has_own_controller, has_own_plant) {
        (false, false) => "both ends computed what the plan says",
        (true, false) => "the plant computed what the plan says; a program’s commands are its own",
        (false, true) => "the controller computed what the plan says; a program’s y is its own",
        (true, true) => "what programs compute is their own",
    };
    Some(format!(
        "In these the link was the one asked for, and {ends}."
    ))
}

/// What else would have been found out on the way of any complete run: the verdict’s own resolution.
fn shown(campaign: &Campaign) -> Option<String> {
    if campaign.is_simulated() {
        return None;
    }
    let complete = campaign.runs.iter().filter(|run| run.is_complete());
    let messages = complete.filter_map(|run| run.manifest.as_ref()?.messages);
    let shows = messages
        .flat_map(|of| [of.up.shows, of.down.shows])
        .flatten();
    let (later_ms, share) = shows
        .map(|of| (of.later_ms, of.share))
        .reduce(|one, other| (one.0.max(other.0), one.1.max(other.1)))?;
    Some(format!(
        "Anything else that delayed {} of a run’s messages by {} would have shown.",
        percent(share),
        duration(later_ms)
    ))
}

fn each(loops: &[Loop<'_>]) -> &'static str {
    match loops.len() {
        1 => "The loop",
        _ => "Each loop",
    }
}

/// How often each loop ran, and what differs between its repeats.
fn repeated(campaign: &Campaign, loops: &[Loop<'_>]) -> Option<String> {
    let lengths = || loops.iter().map(|one| one.group.runs.len());
    let (least, most) = (lengths().min()?, lengths().max()?);
    let varieties: Vec<(&str, Variety)> = loops
        .iter()
        .filter_map(|one| {
            let cell = &one.group.runs.first()?.cell;
            let variety = if campaign.is_simulated() {
                Variety::simulated(&campaign.plan, cell)
            } else {
                Variety::real(&campaign.plan, cell)
            };
            Some((one.topology, variety))
        })
        .collect();
    let varies = varieties.iter().filter(|(_, of)| !of.is_none());
    let mut still: Vec<&str> = varieties
        .iter()
        .filter(|(_, of)| of.is_none())
        .map(|(topology, _)| *topology)
        .collect();
    still.dedup();
    let all = varies.fold(Variety::default(), |all, (_, of)| Variety {
        link: all.link || of.link,
        ticks: all.ticks || of.ticks,
        sensors: all.sensors || of.sensors,
        machine: all.machine || of.machine,
    });
    if most == 1 && all.is_none() {
        return Some(format!(
            "{} ran once, and nothing would vary between repeats.",
            each(loops)
        ));
    }
    if most == 1 {
        return Some(format!(
            "{} ran once: how another run would end is not known.",
            each(loops)
        ));
    }
    let number = |n: usize| match n {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{} times", spelled(n as f64)),
    };
    let often = match least == most {
        true => format!("Each loop ran {}", number(most)),
        false => format!("The loops ran {} to {}", number(least), number(most)),
    };
    if all.is_none() {
        return Some(format!(
            "{often}, but nothing varies between repeats: they are one run."
        ));
    }
    let few = if least < FEW {
        "; from six on, medians have intervals"
    } else {
        ""
    };
    let still = match still.is_empty() {
        true => String::new(),
        false => format!(" On {} nothing varies between repeats.", still.join(", ")),
    };
    Some(format!("{often}, over {all}{few}.{still}"))
}
