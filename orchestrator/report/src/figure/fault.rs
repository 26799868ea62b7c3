//! Figure H: how soon loops were back after each fault; and the fault on the time axis of other figures.

use analysis::{Campaign, grouped};
use chart::{Guide, GuideAt, Mark, Panel, Series};
use plan::FaultSpell;

use super::{Figure, panel};
use crate::loops::{self, Loop};
use crate::number::duration;
use crate::origin::Origin;
use crate::tone::Tones;

/// More spells than this are shown as one, from the first beginning to the last end.
const MOST_SPELLS: usize = 3;

/// Where a dot lies that did not come back, as a multiple of the slowest that did.
const NEVER: f64 = 1.15;

/// A panel for each fault; `None` without any.
pub(super) fn figure(campaign: &Campaign) -> Option<Figure> {
    let mut loops = loops::all(campaign);
    loops.retain(|one| one.fault.is_some() && !one.group.runs.is_empty());
    let places = grouped(loops.iter(), |one| one.topology);
    let places: Vec<&str> = places.iter().map(|(topology, _)| *topology).collect();
    let faults = grouped(loops.iter(), |one| (one.fault, one.system, one.h_ns));
    let tones = Tones::of(campaign);
    // All panels have one scale, so that faults can be compared.
    let all_s = loops.iter().flat_map(|one| back_s(one)).flatten();
    let slowest_s = all_s.fold(0.001, f64::max);
    let (mut origin, mut sentences, mut panels) = (Origin::default(), Vec::new(), Vec::new());
    for ((name, ..), loops) in &faults {
        for one in loops {
            origin.all(&one.group);
        }
        let name = name.unwrap_or_default();
        let panel = of_fault(name, loops, &places, slowest_s, &tones);
        sentences.extend(loops.iter().map(|one| sentence(name, one)));
        panels.push(panel);
    }
    if panels.is_empty() {
        return None;
    }
    let columns = panels.len().min(3);
    let figure = Figure::new(
        "H",
        "Back after a fault",
        columns,
        "How long after the fault's end the error came into 2 % of the reference's range and stayed there; a dot for each run. Above the line are the runs that did not come back before they ended.",
        None,
    );
    Some(figure.drawn(panels, &sentences, &origin, campaign))
}

/// How soon each run of a loop was back, s; `None` if it was not.
fn back_s(one: &Loop<'_>) -> Vec<Option<f64>> {
    let runs = one.group.runs.iter();
    runs.map(|run| Some(run.recovery?.back_ms? / 1e3)).collect()
}

fn of_fault(
    name: &str,
    loops: &[&Loop<'_>],
    places: &[&str],
    slowest_s: f64,
    tones: &Tones,
) -> Panel {
    let mut panel = panel("", name, "", "back after/s");
    panel.x.names = places.iter().map(|place| (*place).to_owned()).collect();
    panel.x.range = Some((-0.5, places.len() as f64 - 0.5));
    panel.y.range = Some((0.0, slowest_s * f64::midpoint(NEVER, 1.3)));
    if loops.iter().any(|one| back_s(one).contains(&None)) {
        panel.guides.push(Guide {
            name: "not back".to_owned(),
            at: GuideAt::Y(slowest_s * f64::midpoint(1.0, NEVER)),
        });
    }
    let clients = grouped(loops.iter(), |one| (one.client, &one.setup));
    let kinds = clients.len() as f64;
    for (nth, ((client, _), loops)) in clients.iter().enumerate() {
        // Beside each other, so that no client's dots hide another's.
        let beside = (nth as f64 - (kinds - 1.0) / 2.0) * 0.6 / kinds;
        let mut points = Vec::new();
        for one in loops {
            let at = places.iter().position(|place| *place == one.topology);
            let x = at.unwrap_or_default() as f64 + beside;
            points.extend(
                back_s(one)
                    .iter()
                    .map(|s| (x, s.unwrap_or(slowest_s * NEVER))),
            );
        }
        panel.series.push(Series::new(
            client.to_string(),
            Mark::Dots,
            tones.tone(*client),
            points,
        ));
    }
    panel
}

fn sentence(fault: &str, one: &Loop<'_>) -> String {
    let back = one.group.median_or_never(|run| run.recovery?.back_ms);
    let words = match back {
        Some(of) if of.value.is_finite() => format!("back after {}", duration(of.value)),
        _ => "not back".to_owned(),
    };
    format!("{fault}, {}, {}: {words}.", one.topology, one.client)
}

/// Where a fault begins and ends, as lines across a panel whose x is the time in s.
pub(super) fn guides(spells: &[FaultSpell]) -> Vec<Guide> {
    let line = |name: &str, t_ns: u64| Guide {
        name: name.to_owned(),
        at: GuideAt::X(t_ns as f64 / 1e9),
    };
    let (Some(first), Some(last)) = (spells.first(), spells.iter().map(|one| one.to_ns).max())
    else {
        return Vec::new();
    };
    if spells.len() > MOST_SPELLS {
        return vec![line(first.word, first.from_ns), line("", last)];
    }
    spells
        .iter()
        .flat_map(|spell| [line(spell.word, spell.from_ns), line("", spell.to_ns)])
        .collect()
}
