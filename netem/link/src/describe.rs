//! A profile in plain words, with the round trips that `ping` will see and those that it should see.

use std::fmt::Write as _;

use text::decimals;

use crate::drawn::Drawn;
use crate::fault::{Again, Effect, Fault};
use crate::law::{Form, Law};
use crate::prediction::{Band, Pings, Prediction, Rtt, predict, typical};
use crate::profile::{Asked, Delay, Level, Loss, Order, PathLaw, Profile, Rate, Stall};
use crate::time::LinkTime;
use crate::trace::{Start, Then, Trace};

/// Describes a link: each direction in words, then the round trips of a
/// thousand pings once a second beside those the profile asks for.
#[must_use]
pub fn describe(profile: &Profile) -> String {
    let mut text = format!("{}: {}\n", profile.name(), profile.about());
    if profile.is_loopback() {
        text.push_str("\nNo link: both ends are on one machine and nothing is played.\n");
        if let Some(asked) = profile.asked() {
            text.push_str("\nRound trips in ms:\n");
            text.push_str(HEADER);
            row(&mut text, "asked", &asked_cells(&asked));
        }
        return text;
    }
    let without_faults = |law: &PathLaw| PathLaw {
        faults: Vec::new(),
        ..law.clone()
    };
    if without_faults(&profile.up) == without_faults(&profile.down) {
        text.push_str("\nFrom controller to plant, and likewise back:\n");
        path(&mut text, &profile.up);
    } else {
        text.push_str("\nFrom controller to plant:\n");
        path(&mut text, &profile.up);
        text.push_str("\nFrom plant to controller:\n");
        path(&mut text, &profile.down);
    }
    faults(&mut text, profile);
    seed(&mut text, profile);
    let prediction = predict(profile, Pings::TABLE_2);
    round_trips(&mut text, &prediction, profile.asked());
    if let (Some(span_ns), Some(typical)) = (profile.trace_span_ns(), typical(profile)) {
        let _ = writeln!(
            text,
            "Over the trace's {}, half of them take at most {:.3} ms, nine of ten at most {:.3} ms.",
            time(span_ns as f64),
            typical.p50_ms,
            typical.p90_ms
        );
    }
    text
}

/// What the seed draws of the link, and what is the same with each.
fn seed(text: &mut String, profile: &Profile) {
    let drawn = profile.drawn(LinkTime::from_ns(u64::MAX));
    let (each, both): (Vec<Drawn>, Vec<Drawn>) =
        drawn.iter().partition(|drawn| drawn.is_of_each_way());
    let mut parts = Vec::new();
    for (drawn, how) in [
        (each, "each direction by itself"),
        (both, "both directions alike"),
    ] {
        let words: Vec<String> = drawn.iter().map(Drawn::to_string).collect();
        match words.as_slice() {
            [] => {}
            [one] => parts.push(format!("{one}, {how}")),
            [first @ .., last] => parts.push(format!("{} and {last}, {how}", first.join(", "))),
        }
    }
    let _ = match parts.is_empty() {
        true => writeln!(
            text,
            "\nNothing is drawn: the link is the same with every seed."
        ),
        false => writeln!(text, "\nDrawn by the seed: {}.", parts.join("; ")),
    };
}

fn path(text: &mut String, law: &PathLaw) {
    delay(text, &law.delay);
    if let Some(stall) = &law.stall {
        stalls(text, stall);
    }
    line(text, "Loss", &loss(&law.loss));
    match &law.rate {
        None => {}
        Some(Rate::Constant { rate_bps, limit }) => line(
            text,
            "Rate",
            &format!(
                "{} before the delay, with a queue of {limit} packets",
                rate(*rate_bps)
            ),
        ),
        Some(Rate::Trace { limit }) => {
            line(
                text,
                "Rate",
                &format!("from the trace, with a queue of {limit} packets"),
            );
        }
    }
    line(
        text,
        "Order",
        match law.order {
            Order::Kept => "kept: no packet overtakes another",
            Order::Free => "free: a packet overtakes others when the delay falls",
        },
    );
}

/// A line on a direction; without a name it goes on from the one before.
fn line(text: &mut String, name: &str, words: &str) {
    let _ = writeln!(text, "  {name:<7} {words}");
}

fn delay(text: &mut String, delay: &Delay) {
    match delay {
        Delay::Constant { delay_ns } => line(text, "Delay", &time(*delay_ns as f64)),
        Delay::Held(level) => {
            let base = time(level.base_ns as f64);
            line(
                text,
                "Delay",
                &format!("{base} plus {}", words(&level.spread)),
            );
            line(text, "", &held(level));
        }
        Delay::Trace(trace) => {
            let steps = match trace.steps().len() {
                1 => "one step".to_owned(),
                count => format!("{count} steps"),
            };
            let (low, high) = (trace.floor_ns() as f64, trace.reach_ns() as f64);
            let levels = format!("{} to {}", time(low), time(high));
            line(text, "Delay", &format!("a trace of {steps}, {levels}"));
            line(text, "", &turns(trace));
        }
    }
}

fn stalls(text: &mut String, stall: &Stall) {
    let every_ns = stall.every_ns as f64;
    let every = time(every_ns);
    let share = percent(stall.length.mean_ns() / every_ns);
    line(
        text,
        "Stalls",
        &format!("one about every {every}; packets wait until it ends"),
    );
    line(text, "", &format!("length: {}", words(&stall.length)));
    line(text, "", &format!("stalled {share} of the time"));
}

/// What a run meets of the traces of a link, in words; `None` without one.
#[must_use]
pub fn traces(profile: &Profile) -> Option<String> {
    let [up, down] = [&profile.up, &profile.down].map(|law| law.trace().map(turns));
    match (up, down) {
        (None, None) => None,
        (Some(up), Some(down)) if up == down => Some(format!("its trace {up}")),
        (up, down) => {
            let ways = [("up", up), ("down", down)];
            let parts = ways.into_iter().filter_map(|(way, turns)| {
                let turns = turns?;
                Some(format!("its trace {way} {turns}"))
            });
            Some(parts.collect::<Vec<_>>().join("; "))
        }
    }
}

/// Where a run begins in a trace, and what comes after its end.
pub(crate) fn turns(trace: &Trace) -> String {
    let begins = match trace.start() {
        Start::Drawn => "begins at an instant of it that the seed draws".to_owned(),
        Start::At { t_ns } => format!("begins at {} of it", time(t_ns as f64)),
    };
    match trace.then() {
        Then::Again { span_ns } => format!("{begins}, and again after {}", time(span_ns as f64)),
        Then::Hold => format!("{begins}, and holds its last step for ever"),
    }
}

/// The faults of both directions, in order of their beginning.
fn faults(text: &mut String, profile: &Profile) {
    let (up, down) = (&profile.up.faults, &profile.down.faults);
    let mut faults: Vec<(&Fault, &str)> = Vec::new();
    faults.extend(up.iter().map(|fault| match down.contains(fault) {
        true => (fault, "both ways"),
        false => (fault, "up"),
    }));
    let of_down_only = down.iter().filter(|fault| !up.contains(fault));
    faults.extend(of_down_only.map(|fault| (fault, "down")));
    if faults.is_empty() {
        return;
    }
    faults.sort_by_key(|(fault, _)| (fault.at_ns, fault.number));
    text.push_str("\nFaults:\n");
    for (fault, way) in faults {
        let again = match fault.again {
            _ if fault.times == Some(1) => String::new(),
            Again::Never => String::new(),
            Again::Random { every_ns } => format!(
                ", then once at a random instant of each {}",
                time(every_ns as f64)
            ),
            Again::Exact { period_ns } => format!(", then every {}", time(period_ns as f64)),
        };
        let times = match fault.times {
            None | Some(1) => String::new(),
            Some(times) => format!(", {times} times in all"),
        };
        let _ = writeln!(
            text,
            "  At {} for {}{again}{times}, {way}: {}",
            time(fault.at_ns as f64),
            time(fault.for_ns as f64),
            effect(fault.effect)
        );
    }
}

fn effect(effect: Effect) -> String {
    let of_slots = |share| format!("the packets of {} of the slots of 1 ms", percent(share));
    match effect {
        Effect::Down => "every packet is lost".to_owned(),
        Effect::Delay { delay_ns } => format!("{} more delay", time(delay_ns as f64)),
        Effect::Loss { share } => format!("{} are lost", of_slots(share)),
        Effect::Duplicate { share } => format!("{} come out twice", of_slots(share)),
        Effect::Reorder { share, by_ns } => {
            let by = time(by_ns as f64);
            format!("{} are held back by {by} and overtaken", of_slots(share))
        }
        Effect::Corrupt { share } => format!("{} have a bit flipped", of_slots(share)),
        Effect::Reset => "segments of TCP become resets of their connection".to_owned(),
        Effect::Rebind => "the controller's ports of TCP change".to_owned(),
    }
}

fn held(level: &Level) -> String {
    let (min_ns, max_ns) = level.spread.limits_ns();
    let base_ns = level.base_ns as f64;
    let mut limits = String::new();
    if min_ns + base_ns > 0.0 {
        let _ = write!(limits, ", never below {}", time(min_ns + base_ns));
    }
    if max_ns.is_finite() {
        let _ = write!(limits, ", never above {}", time(max_ns + base_ns));
    }
    format!(
        "drawn anew about every {}{limits}",
        time(level.hold_ns as f64)
    )
}

fn words(law: &Law) -> String {
    match law.form() {
        Form::Constant { value_ns } => format!("always {}", time(*value_ns)),
        Form::Uniform { min_ns, max_ns } => {
            format!("anything from {} to {}", time(*min_ns), time(*max_ns))
        }
        Form::Normal { mean_ns, sd_ns } => {
            format!("a normal law, mean {}, sd {}", time(*mean_ns), time(*sd_ns))
        }
        Form::Exponential { mean_ns } => format!("an exponential law, mean {}", time(*mean_ns)),
        Form::Gamma { mean_ns, sd_ns } => {
            format!("a gamma law, mean {}, sd {}", time(*mean_ns), time(*sd_ns))
        }
        Form::Beta {
            min_ns,
            max_ns,
            mean_ns,
            sd_ns,
        } => format!(
            "a beta law from {} to {}, mean {}, sd {}",
            time(*min_ns),
            time(*max_ns),
            time(*mean_ns),
            time(*sd_ns)
        ),
        Form::Pareto { scale_ns, shape } => {
            format!("a Pareto law of shape {shape} from {} on", time(*scale_ns))
        }
        Form::Table { points } => {
            let points: Vec<String> = points
                .iter()
                .map(|&(p, x_ns)| format!("{} at {}", time(x_ns), percent(p)))
                .collect();
            format!("a table: {}", points.join(", "))
        }
    }
}

fn loss(loss: &Loss) -> String {
    match loss {
        Loss::Never => "none".to_owned(),
        Loss::Random { share, hold_ns } => {
            format!(
                "{} of the time, by slots of {}",
                percent(*share),
                time(*hold_ns as f64)
            )
        }
        Loss::GilbertElliott {
            good_ns,
            bad_ns,
            in_good,
            in_bad,
            hold_ns,
        } => format!(
            "{} in good spells of about {}, {} in bad ones of about {}, by slots of {}",
            percent(*in_good),
            time(*good_ns as f64),
            percent(*in_bad),
            time(*bad_ns as f64),
            time(*hold_ns as f64)
        ),
        Loss::Trace { hold_ns } => {
            format!("from the trace, by slots of {}", time(*hold_ns as f64))
        }
    }
}

const HEADER: &str = "                     min         avg         max          sd      loss\n";

fn round_trips(text: &mut String, prediction: &Prediction, asked: Option<Asked>) {
    text.push_str("\nA thousand pings, one a second, will see round trips in ms of\n");
    text.push_str(HEADER);
    let Rtt {
        min_ms,
        avg_ms,
        max_ms,
        sd_ms,
        loss,
    } = prediction.expected;
    row(
        text,
        "expected",
        &cells([min_ms, avg_ms, max_ms, sd_ms], loss),
    );
    let bands = |end: fn(&Band) -> f64| {
        let p = prediction;
        cells(
            [
                end(&p.min_ms),
                end(&p.avg_ms),
                end(&p.max_ms),
                end(&p.sd_ms),
            ],
            end(&p.loss),
        )
    };
    row(text, "99 % from", &bands(|band| band.low));
    row(text, "     to", &bands(|band| band.high));
    if loss >= 1.0 {
        text.push_str("No ping will have an answer.\n");
    }
    if let Some(asked) = asked {
        row(text, "asked", &asked_cells(&asked));
        let judged = [
            ("min", prediction.min_ms, asked.rtt_min_ms),
            ("avg", prediction.avg_ms, asked.rtt_avg_ms),
            ("max", prediction.max_ms, asked.rtt_max_ms),
            ("sd", prediction.sd_ms, asked.rtt_sd_ms),
            ("loss", prediction.loss, asked.loss),
        ];
        let outside: Vec<&str> = judged
            .iter()
            .filter(|(_, band, value)| !band.contains(*value))
            .map(|(name, ..)| *name)
            .collect();
        if outside.is_empty() {
            text.push_str("All figures that the profile asks for lie inside the 99 % band.\n");
        } else {
            let _ = writeln!(text, "Outside the 99 % band: {}.", outside.join(", "));
        }
    }
}

fn asked_cells(asked: &Asked) -> [String; 5] {
    let times = [
        asked.rtt_min_ms,
        asked.rtt_avg_ms,
        asked.rtt_max_ms,
        asked.rtt_sd_ms,
    ];
    cells(times, asked.loss)
}

fn cells(times_ms: [f64; 4], loss: f64) -> [String; 5] {
    // Pings without an answer have no times.
    let [min, avg, max, sd] = times_ms.map(|ms| match ms.is_finite() {
        true => format!("{ms:.3}"),
        false => "-".to_owned(),
    });
    [min, avg, max, sd, format!("{:.2} %", 100.0 * loss)]
}

fn row(text: &mut String, name: &str, cells: &[String; 5]) {
    let [min, avg, max, sd, loss] = cells;
    let _ = writeln!(
        text,
        "  {name:<10}{min:>12}{avg:>12}{max:>12}{sd:>12}{loss:>10}"
    );
}

/// A time to four digits, in the unit that reads best.
pub(crate) fn time(ns: f64) -> String {
    let (scale, unit) = match ns {
        _ if ns >= 1e9 => (1e9, "s"),
        _ if ns >= 1e5 || ns == 0.0 => (1e6, "ms"),
        _ if ns >= 1e3 => (1e3, "us"),
        _ => (1.0, "ns"),
    };
    format!("{} {unit}", short(ns / scale))
}

fn rate(bps: u64) -> String {
    let bps = bps as f64;
    let (scale, unit) = match bps {
        _ if bps >= 1e9 => (1e9, "Gbit/s"),
        _ if bps >= 1e6 => (1e6, "Mbit/s"),
        _ if bps >= 1e3 => (1e3, "kbit/s"),
        _ => (1.0, "bit/s"),
    };
    format!("{} {unit}", short(bps / scale))
}

fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// At most four significant digits and three decimals, no trailing zeros.
fn short(x: f64) -> String {
    let decimals = decimals(x, 4).map_or(0, |all| all.clamp(0, 3));
    let text = format!("{x:.*}", decimals as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
