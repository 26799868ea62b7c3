//! `webloop margin`: how much delay the loop survives, by analysis, and how often a link stays within. Where the plant
//! is a program, by simulation.

mod border;
mod links;
mod lockstep;
mod own;

use std::io::Write;

use analysis::layout::{Column, align, digits, number};
use anyhow::{Context, anyhow};
use control::{
    Analysis, Fate, Hidden, InvalidDeadTime, Untold, largest_stable_blocking_round_trip_s,
};
use endpoint::SampleTime;
use link::Profile;
use plan::system::System;

use crate::argument::Margin;
use crate::command::serve::at;
use crate::exit::{Exit, Failure, Outcome};
use crate::{source, stop};

use self::links::{Limits, of_links};
use self::own::Own;

/// What is known of the loop at a sample time.
struct Loop {
    h: SampleTime,
    /// Its margins, and the longest constant round trip at which it is stable with any number of requests in
    /// flight; not known where rounding would decide.
    found: Result<Analysis, InvalidDeadTime>,
    /// The modes of the plant that the loop does not see.
    hidden: Vec<Hidden>,
    /// The same with one request in flight; not known for a loop with too many states.
    one_s: Result<Option<f64>, Untold>,
}

/// Prints the margins, and how often each link stays within them.
pub(crate) fn run(argument: &Margin) -> Outcome {
    let system = asked(argument)?;
    let names: Vec<&str> = match argument.topology.as_slice() {
        [] => Profile::BUILTIN.to_vec(),
        asked => asked.iter().map(String::as_str).collect(),
    };
    let profiles = names
        .iter()
        .map(|name| source::profile(name))
        .collect::<Result<Vec<_>, _>>()?;
    let (found, limits, legend) = if system.plant_program().is_some() {
        by_simulation(argument, &system)?
    } else {
        by_analysis(argument, &system)?
    };
    writeln!(
        crate::console::out(),
        "{}\n\n{found}\n{}\n{legend}",
        title(&system, argument),
        of_links(&limits, &names, &profiles),
    )?;
    Ok(Exit::Fine)
}

/// The margins of a linear plant, the limits that follow, and what they mean.
fn by_analysis(
    argument: &Margin,
    system: &System,
) -> Result<(String, Vec<Limits>, String), Failure> {
    let loops = argument
        .h
        .iter()
        .map(|h| look(*h, system))
        .collect::<Result<Vec<_>, _>>()?;
    let limits = |of: &Loop| Limits {
        h: of.h,
        unlimited_s: of.found.as_ref().ok().and_then(|found| found.longest_s),
        one_s: of.one_s.clone().ok().flatten(),
    };
    let legend = format!("{LEGEND}{}", notes(system, &loops));
    Ok((of_loops(&loops), loops.iter().map(limits).collect(), legend))
}

/// The borders of a plant that is a program, by running it.
fn by_simulation(
    argument: &Margin,
    system: &System,
) -> Result<(String, Vec<Limits>, String), Failure> {
    let duration_ns = argument.duration_ns;
    let program = source::plant_program(&argument.system, system).unwrap_or_default();
    if program.run.is_empty() {
        return Err(Failure::usage(anyhow!(
            "the plant of {} is what its image starts, and margin runs programs of this machine alone; give \
             [plant] in {} a `run`",
            system.name(),
            argument.system
        )));
    }
    if !system.gives_each_input() {
        return Err(Failure::usage(anyhow!(
            "the plant of {} is a program with two inputs, and the law in {} gives one, so there is no loop to find \
             the border of; run it with a controller of your own, or describe the plant by matrices",
            system.name(),
            argument.system
        )));
    }
    // Nothing is left half done, so nothing has to be brought to an end; the program ends with this process.
    stop::told_to_end()?;
    stop::at_once();
    let loops = argument
        .h
        .iter()
        .map(|h| Own::look(system, &argument.system, &program, *h, duration_ns))
        .collect::<Result<Vec<_>, _>>()?;
    let limits = |of: &Own| Limits {
        h: of.h,
        unlimited_s: of.longest_s(),
        one_s: None,
    };
    Ok((
        own::of_programs(&loops, duration_ns),
        loops.iter().map(limits).collect(),
        BY_SIMULATION.to_owned(),
    ))
}

/// The loop in one line.
fn title(system: &System, argument: &Margin) -> String {
    let mut title = format!("{}: {}", system.name(), system.about());
    for (name, gain) in [("kp", argument.kp), ("ki", argument.ki)] {
        if let Some(gain) = gain {
            title += &format!(", {name} = {gain}");
        }
    }
    title
}

const LEGEND: &str = "\
Margins: of the loop without a network, which itself takes two ticks; `-` and `none` if it is unstable
already.
Longest round trip: the loop is stable at this constant round trip and at every shorter one. One
request: for a client that waits for each answer, so that longer round trips also make commands rarer;
unknown if the dead time is many samples.
Within: share of time in which the link's round trip is at most that, and nothing is lost. A link that
exceeds it for moments need not make the loop unstable; one that stays beyond it does.";

const BY_SIMULATION: &str = "\
Gain: the factor of all gains of the law; up and down from 1, in steps of 1 %. Further delay: in whole
samples, beyond the two that the loop takes without a network. `at` still does, `not at` does not; `any`
is as far as was tried, a thousandfold or a quarter of a run. Steps double and are then halved, so an
island that does not hold can be missed.
Holds: by the rule that every run is judged by, in a run of this length. Dies out: what moves y is less
in the last quarter of a run than in the second; that is where the margins of a linear loop are.
Within: share of time in which the link's round trip is at most what holds, and nothing is lost.";

fn look(h: SampleTime, system: &System) -> Result<Loop, Failure> {
    let own = at(system, h)?;
    let open = own
        .open()
        .with_context(|| format!("{} has no margins at h = {h}", system.name()))
        .map_err(Failure::usage)?;
    Ok(Loop {
        h,
        found: Analysis::of(&open),
        hidden: open.hidden().to_vec(),
        one_s: largest_stable_blocking_round_trip_s(&own.plant, &own.law),
    })
}

/// What is particular to these loops: modes that no loop sees, figures that are not known, two channels.
fn notes(system: &System, loops: &[Loop]) -> String {
    let mut notes = String::new();
    for mode in loops.first().into_iter().flat_map(|of| &of.hidden) {
        // Of two complex poles one stands for both.
        if mode.pole.im >= 0.0 {
            notes += &format!("\n{}", told(mode));
        }
    }
    for of in loops {
        if let Err(unsure) = &of.found {
            notes += &format!("\n`?` at h = {}: {unsure}.", of.h);
        }
    }
    if system.measures_age() {
        notes += "\nThe law measures how old an output is. These figures are those of the same law for outputs that are \
                  always as old as `round_trip` in its file says; a run shows what measuring adds.";
    }
    if !system.is_single() {
        notes += "\nMargins are where the loop has fewest channels: with two inputs and two outputs, of a change of \
                  both channels at once.";
    }
    notes
}

/// A mode that a zero cancels.
fn told(mode: &Hidden) -> String {
    // A pole at 0 is off by rounding.
    let at = match (mode.fate, mode.pole.im) {
        (Fate::Stays, 0.0) => "0 rad/s".to_owned(),
        (_, 0.0) => format!("{} rad/s", digits(Some(mode.pole.re))),
        (_, im) => format!(
            "{} +- {}j rad/s",
            digits(Some(mode.pole.re)),
            digits(Some(im))
        ),
    };
    if mode.pole.im == 0.0 {
        let fate = match mode.fate {
            Fate::DiesOut => "it dies out, and the figures are of the rest",
            Fate::Stays => "it neither dies out nor grows, and the figures are of the rest",
            Fate::Grows => "it grows, so the loop is unstable under every law",
        };
        return format!(
            "The plant's pole at {at} is cancelled by a zero, so no loop sees it: {fate}."
        );
    }
    let fate = match mode.fate {
        Fate::DiesOut => "they die out, and the figures are of the rest",
        Fate::Stays => "they neither die out nor grow, and the figures are of the rest",
        Fate::Grows => "they grow, so the loop is unstable under every law",
    };
    format!("The plant's poles at {at} are cancelled by zeros, so no loop sees them: {fate}.")
}

/// The requested system with the requested gains.
fn asked(argument: &Margin) -> Result<System, Failure> {
    let system = source::system(&argument.system)?;
    system.with_gains(argument.kp, argument.ki).ok_or_else(|| {
        Failure::usage(anyhow!(
            "the law of {} has no finite kp and ki to replace; leave --kp and --ki out",
            system.name()
        ))
    })
}

fn of_loops(loops: &[Loop]) -> String {
    const COLUMNS: [Column; 6] = [
        number("", "h"),
        number("margin", "gain"),
        number("margin", "phase/deg"),
        number("margin", "delay/ms"),
        number("longest round trip/ms", "unlimited"),
        number("longest round trip/ms", "one request"),
    ];
    let rows: Vec<Vec<String>> = loops
        .iter()
        .map(|of| {
            let mut row = vec![of.h.to_string()];
            row.extend(figures(&of.found));
            row.push(longest(of.one_s.clone().ok()));
            row
        })
        .collect();
    align(&COLUMNS, &rows)
}

/// Margins and the longest round trip; of an unstable loop none.
fn figures(found: &Result<Analysis, InvalidDeadTime>) -> [String; 4] {
    match found {
        Err(_) => std::array::from_fn(|_| "?".to_owned()),
        Ok(found) => {
            let m = found.margins;
            let margins = [m.gain, m.phase_deg, m.delay_s * 1e3];
            let [gain, phase, delay] = margins.map(|x| match found.longest_s {
                Some(_) => figure(x),
                None => digits(None),
            });
            [gain, phase, delay, longest(Some(found.longest_s))]
        }
    }
}

/// The longest round trip; `None` if it is not computed.
fn longest(s: Option<Option<f64>>) -> String {
    match s {
        None => "unknown".to_owned(),
        Some(None) => "none".to_owned(),
        Some(Some(s)) => figure(s * 1e3),
    }
}

fn figure(x: f64) -> String {
    if x.is_infinite() {
        "any".to_owned()
    } else {
        digits(Some(x))
    }
}
