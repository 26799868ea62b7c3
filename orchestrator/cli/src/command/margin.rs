//! `webloop margin`: how much delay the loop survives, by analysis, and how often a link stays within.

use std::io::Write;

use ::system::System;
use analysis::layout::{Column, align, digits, number, text};
use anyhow::{Context, anyhow};
use control::{
    Margins, Untold, largest_stable_blocking_round_trip_s, largest_stable_round_trip_s, margins,
};
use endpoint::{SampleTime, Transport};
use link::{Pings, Profile, share_within};
use plan::Client;

use crate::argument::Margin;
use crate::command::serve::at;
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

/// How to sample a link: a hundred times a second, for 2000 s.
const LOOKS: Pings = Pings {
    count: 200_000,
    interval_ns: 10_000_000,
};
/// For a client that waits for each answer: no message waits for another, whatever the rate limit.
const APART: Pings = Pings {
    count: 2_000,
    interval_ns: 1_000_000_000,
};
/// Any realisation of a link is as good as another.
const SEED: u64 = 1;

/// Two free-running ends take two ticks around the loop, without any network between them.
const OWN_TICKS: f64 = 2.0;

/// What is known of the loop at a sample time.
struct Loop {
    h: SampleTime,
    margins: Margins,
    /// The longest constant round trip at which it is stable with any number of requests in flight, s.
    unlimited_s: Option<f64>,
    /// The same with one request in flight; not known for a loop with too many states.
    one_s: Result<Option<f64>, Untold>,
}

/// Prints the margins, and how often each link stays within them.
pub(crate) fn run(argument: &Margin) -> Outcome {
    let system = asked(argument)?;
    let loops = argument
        .h
        .iter()
        .map(|h| look(*h, &system))
        .collect::<Result<Vec<_>, _>>()?;
    let names: Vec<&str> = match argument.topology.as_slice() {
        [] => Profile::BUILTIN.to_vec(),
        asked => asked.iter().map(String::as_str).collect(),
    };
    let profiles = names
        .iter()
        .map(|name| source::profile(name))
        .collect::<Result<Vec<_>, _>>()?;
    let mut out = crate::console::out();
    writeln!(
        out,
        "{}\n\n{}\n{}\n{}",
        title(&system, argument),
        of_loops(&loops),
        of_links(&loops, &names, &profiles),
        LEGEND
    )?;
    Ok(Exit::Fine)
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
Margins: of the loop without a network, which itself takes two ticks; `-` if it is unstable.
Longest round trip: the loop is stable at this constant round trip and at every shorter one. One
request: for a client that waits for each answer, so that longer round trips also make commands rarer;
unknown if the dead time is many samples.
Within: share of time in which the link's round trip is at most that, and nothing is lost. A link that
exceeds it for moments need not make the loop unstable; one that stays beyond it does.";

fn look(h: SampleTime, system: &System) -> Result<Loop, Failure> {
    let own = at(system, h)?;
    let open = own
        .open()
        .with_context(|| format!("{} has no margins at h = {h}", system.name()))
        .map_err(Failure::usage)?;
    let margins = margins(&open, OWN_TICKS * h.seconds())
        .with_context(|| format!("{} has no margins at h = {h}", system.name()))
        .map_err(Failure::usage)?;
    Ok(Loop {
        h,
        margins,
        unlimited_s: largest_stable_round_trip_s(&open),
        one_s: largest_stable_blocking_round_trip_s(&own.plant, &own.law),
    })
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
            let stable = |margin: f64| of.unlimited_s.map_or(f64::NAN, |_| margin);
            vec![
                of.h.to_string(),
                figure(stable(of.margins.gain)),
                figure(stable(of.margins.phase_deg)),
                figure(stable(of.margins.delay_s * 1e3)),
                longest(of.unlimited_s),
                of.one_s
                    .as_ref()
                    .map_or_else(|_| UNTOLD.to_owned(), |s| longest(*s)),
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
    let bytes = Client::Native.message_bytes(Transport::Http);
    let mut rows = Vec::new();
    for (name, profile) in names.iter().zip(profiles) {
        for of in loops {
            let (alone, together) = if profile.has_rate() {
                (APART, every(of.h))
            } else {
                (LOOKS, LOOKS)
            };
            let within = |limit_s: Option<f64>, looks: Pings| {
                let Some(limit_s) = limit_s else {
                    return "-".to_owned();
                };
                // An infinite limit becomes the longest time there is.
                let limit_ns = (limit_s * 1e9).round() as u64;
                let share = share_within(profile, SEED, looks, bytes, limit_ns);
                format!("{:.1}", share * 100.0)
            };
            rows.push(vec![
                (*name).to_owned(),
                of.h.to_string(),
                within(of.unlimited_s, together),
                within(of.one_s.clone().ok().flatten(), alone),
            ]);
        }
    }
    align(&COLUMNS, &rows)
}

/// A message every h, for as long as [`LOOKS`] take: they load the queue of a rate limit.
fn every(h: SampleTime) -> Pings {
    let span_ns = u64::from(LOOKS.count) * LOOKS.interval_ns;
    Pings {
        count: u32::try_from(span_ns / h.ns()).unwrap_or(u32::MAX),
        interval_ns: h.ns(),
    }
}

/// The text for a value that is not computed.
const UNTOLD: &str = "unknown";

fn longest(s: Option<f64>) -> String {
    match s {
        None => "none".to_owned(),
        Some(s) => figure(s * 1e3),
    }
}

fn figure(x: f64) -> String {
    if x.is_infinite() {
        "any".to_owned()
    } else {
        digits(Some(x))
    }
}
