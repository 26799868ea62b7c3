//! `webloop margin`: how much delay the loop survives, by analysis, and how often a link stays within.

use std::io::Write;

use analysis::layout::{Column, align, digits, number, text};
use anyhow::Context;
use control::{
    Discrete, Gains, Margins, Method, StateSpace, TransferFunction, discretise,
    largest_stable_blocking_round_trip_s, largest_stable_round_trip_s, margins, preset,
};
use endpoint::SampleTime;
use link::{Pings, Profile, share_within};

use crate::argument::Margin;
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

/// A link is looked at a hundred times a second for this long.
const LOOKS: Pings = Pings {
    count: 200_000,
    interval_ns: 10_000_000,
};
/// Of a link's realisations any is as good as another.
const SEED: u64 = 1;

/// Two free-running ends take two ticks around the loop, without any network between them.
const OWN_TICKS: f64 = 2.0;

/// What is known of the loop at a sample time.
struct Loop {
    h: SampleTime,
    margins: Margins,
    /// The longest constant round trip with which it is stable, s: with any number of requests
    /// under way, and with one.
    unlimited_s: Option<f64>,
    one_s: Option<f64>,
}

/// Prints the margins, and the chances of each link.
pub(crate) fn run(argument: &Margin) -> Outcome {
    let gains = Gains::pi(argument.kp, argument.ki);
    let loops = argument
        .h
        .iter()
        .map(|h| look(*h, &gains))
        .collect::<anyhow::Result<Vec<_>>>()
        .map_err(Failure::usage)?;
    let names: Vec<&str> = match argument.topology.as_slice() {
        [] => Profile::BUILTIN.to_vec(),
        asked => asked.iter().map(String::as_str).collect(),
    };
    let profiles = names
        .iter()
        .map(|name| source::profile(name))
        .collect::<Result<Vec<_>, _>>()?;
    let mut out = std::io::stdout();
    writeln!(
        out,
        "The paper's motor with a PI controller, kp = {}, ki = {}/s\n\n{}\n{}\n{}",
        argument.kp,
        argument.ki,
        of_loops(&loops),
        of_links(&loops, &names, &profiles),
        LEGEND
    )?;
    Ok(Exit::Fine)
}

const LEGEND: &str = "\
Margins: of the loop without a network, which takes two ticks by itself; `-` where it is unstable.
Longest round trip: a constant one with which the loop is still stable, every shorter one too. One
request: a client that waits for each answer, whose commands a longer round trip makes rarer too.
Within: of the time, how much a link's round trip is no longer than that and nothing is lost. A link
that leaves it for moments need not make the loop unstable; one that stays outside does.";

fn look(h: SampleTime, gains: &Gains) -> anyhow::Result<Loop> {
    let unfit = || format!("there is no loop with these gains at h = {h}");
    let plant = sampled(&preset::motor(), h).with_context(unfit)?;
    let law = gains.transfer_function().with_context(unfit)?;
    let law = sampled(&law, h)?.transfer_function().with_context(unfit)?;
    let system = plant
        .transfer_function()
        .and_then(|motor| motor.series(&law))
        .with_context(unfit)?;
    Ok(Loop {
        h,
        margins: margins(&system, OWN_TICKS * h.seconds())?,
        unlimited_s: largest_stable_round_trip_s(&system),
        one_s: largest_stable_blocking_round_trip_s(&plant, gains),
    })
}

fn sampled(system: &TransferFunction, h: SampleTime) -> anyhow::Result<StateSpace<Discrete>> {
    Ok(discretise(
        &StateSpace::from(system),
        Method::BackwardEuler,
        h.seconds(),
    )?)
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
            let stable = |margin: f64| of.unlimited_s.map_or(f64::NAN, |_| margin);
            vec![
                of.h.to_string(),
                figure(stable(of.margins.gain)),
                figure(stable(of.margins.phase_deg)),
                figure(stable(of.margins.delay_s * 1e3)),
                longest(of.unlimited_s),
                longest(of.one_s),
            ]
        })
        .collect();
    align(&COLUMNS, &rows)
}

fn of_links(loops: &[Loop], names: &[&str], profiles: &[Profile]) -> String {
    const COLUMNS: [Column; 4] = [
        text("topology"),
        number("", "h"),
        number("within/%", "unlimited"),
        number("within/%", "one request"),
    ];
    let mut rows = Vec::new();
    for (name, profile) in names.iter().zip(profiles) {
        for of in loops {
            let within = |limit_s: Option<f64>| {
                let Some(limit_s) = limit_s else {
                    return "-".to_owned();
                };
                // An infinite limit becomes the longest time there is.
                let limit_ns = (limit_s * 1e9).round() as u64;
                let share = share_within(profile, SEED, LOOKS, limit_ns);
                format!("{:.1}", share * 100.0)
            };
            rows.push(vec![
                (*name).to_owned(),
                of.h.to_string(),
                within(of.unlimited_s),
                within(of.one_s),
            ]);
        }
    }
    align(&COLUMNS, &rows)
}

fn longest(s: Option<f64>) -> String {
    match s {
        None => "none".to_owned(),
        Some(s) => figure(s * 1e3),
    }
}

fn figure(x: f64) -> String {
    match x.is_infinite() {
        true => "any".to_owned(),
        false => digits(Some(x)),
    }
}
