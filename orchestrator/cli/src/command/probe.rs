//! `webloop probe`: pings through a link, and compares with what the link should have done.

use std::io::{self, Write};

use ::link::{Asked, Band, LinkTime, Pings, Prediction, Profile, predict};
use anyhow::anyhow;
use backend::Probed;
use link::certificate::{ANSWERS_NEEDED, Certificate, Echo, RttStatistics, Verdict};

use crate::argument::Probe;
use crate::exit::{Exit, Failure, Outcome};
use crate::{source, stop};

/// Pings, prints what `ping` prints, and judges the link.
pub(crate) fn run(argument: &Probe) -> Outcome {
    // First of all: a user namespace can only be entered while there is one thread.
    let authority = shaper::become_root();
    let profile = source::profile(&argument.topology)?;
    authority.map_err(Failure::unsupported)?;
    let stop = stop::told_to_end()?;
    let interval_ns = (argument.interval * 1e9).round() as u64;
    let mut out = crate::console::out();
    writeln!(
        out,
        "PING {} through its link, seed {}: {} echoes, one every {} s",
        profile.name(),
        argument.seed,
        argument.count,
        argument.interval
    )?;
    let mut broken_pipe = Ok(());
    let probed = backend::probe(
        &profile,
        argument.seed,
        argument.player.into(),
        argument.count,
        interval_ns,
        &stop,
        |echo| {
            if !argument.quiet && broken_pipe.is_ok() {
                broken_pipe = answer(&mut out, echo);
            }
        },
    )
    .map_err(|problem| match problem {
        backend::RunError::Unsupported(_) => Failure::unsupported(problem),
        other => other.into(),
    })?;
    broken_pipe?;
    summary(&mut out, &profile, &probed, interval_ns)?;
    let judged = probed.certificate.filter(is_judged);
    match judged.map(|certificate| certificate.verdict) {
        Some(Verdict::Broken(reasons)) => {
            Err(anyhow!("the link did not hold: {}", reasons.join("; ")).into())
        }
        _ => Ok(Exit::Fine),
    }
}

/// Whether there are enough answers to judge the link by: so many as it should have let through, or as many
/// as it did although it should not.
fn is_judged(certificate: &Certificate) -> bool {
    let due = certificate.sent as f64 * (1.0 - certificate.predicted.loss);
    let is_as_due = certificate.fates.came_though_lost + certificate.fates.lost_though_due == 0;
    let is_lossy = is_as_due && due.round() < ANSWERS_NEEDED as f64;
    certificate.sent >= ANSWERS_NEEDED && !is_lossy
}

fn answer(out: &mut impl Write, echo: &Echo) -> io::Result<()> {
    let (Some(reach), Some(rtt)) = (echo.t_reach_ns, echo.rtt_ns()) else {
        return Ok(());
    };
    let up = reach.saturating_sub(echo.t_send_ns);
    writeln!(
        out,
        "icmp_seq={} time={} ms (up {}, down {})",
        echo.seq + 1,
        ms(rtt),
        ms(up),
        ms(rtt.saturating_sub(up))
    )
}

/// Milliseconds with three decimals, as in ping's summary.
fn ms(ns: u64) -> String {
    format!("{:.3}", ns as f64 / 1e6)
}

fn summary(
    out: &mut impl Write,
    profile: &Profile,
    probed: &Probed,
    interval_ns: u64,
) -> io::Result<()> {
    let rtts: Vec<_> = probed
        .echoes
        .iter()
        .filter_map(Echo::rtt_ns)
        .map(|ns| ns as f64 / 1e6)
        .collect();
    let (sent, received) = (probed.echoes.len(), rtts.len());
    let measured = RttStatistics::of(sent, &rtts);
    writeln!(out, "\n--- {} ping statistics ---", profile.name())?;
    writeln!(
        out,
        "{sent} packets transmitted, {received} received, {:.1}% packet loss",
        measured.loss * 100.0
    )?;
    match measured.times_ms() {
        Some([min, avg, max, sd]) => writeln!(
            out,
            "rtt min/avg/max/mdev = {min:.3}/{avg:.3}/{max:.3}/{sd:.3} ms"
        )?,
        None => writeln!(out, "no echo was answered, so there are no round trips")?,
    }
    writeln!(
        out,
        "\n{:<26}{:>11}{:>11}{:>11}{:>11}{:>9}",
        "RTT in ms", "min", "avg", "max", "sd", "loss %"
    )?;
    row(out, "measured", &measured)?;
    if let Some(certificate) = &probed.certificate {
        row(out, "model at these instants", &certificate.predicted)?;
    }
    if let Some(asked) = profile.asked() {
        row(out, "asked by the profile", &statistics(asked))?;
    }
    let Some(certificate) = &probed.certificate else {
        return writeln!(out, "\nNo link to judge: both ends are on one machine.");
    };
    let count = u32::try_from(sent).unwrap_or(u32::MAX);
    let until = LinkTime::from_ns(interval_ns.saturating_mul(u64::from(count)));
    if sent == 0 {
        return writeln!(out, "\nNo echo was sent: there is nothing to judge.");
    }
    if profile.varies_by_seed(until) {
        let prediction = predict(profile, Pings { count, interval_ns });
        bands(
            out,
            &prediction,
            &measured,
            probed.baseline.rtt_ms,
            profile.asked(),
        )?;
    } else {
        writeln!(out, "\nNothing in this link depends on the seed.")?;
    }
    proof(out, certificate)
}

fn row(out: &mut impl Write, name: &str, rtt: &RttStatistics) -> io::Result<()> {
    line(out, name, rtt.times_ms().unwrap_or([f64::NAN; 4]), rtt.loss)
}

/// A row of the table; a time that is not there is a dash.
fn line(out: &mut dyn Write, name: &str, times_ms: [f64; 4], loss: f64) -> io::Result<()> {
    let [min, avg, max, sd] = times_ms.map(|ms| match ms.is_finite() {
        true => format!("{ms:.3}"),
        false => "-".to_owned(),
    });
    writeln!(
        out,
        "{name:<26}{min:>11}{avg:>11}{max:>11}{sd:>11}{:>9.2}",
        loss * 100.0
    )
}

fn statistics(asked: Asked) -> RttStatistics {
    RttStatistics {
        min_ms: asked.rtt_min_ms,
        avg_ms: asked.rtt_avg_ms,
        max_ms: asked.rtt_max_ms,
        sd_ms: asked.rtt_sd_ms,
        loss: asked.loss,
    }
}

/// Prints the band in which 99 of 100 seeds put each statistic, and which measured ones are outside.
///
/// `own_ms` is the player's own cost. It belongs to this machine and is subtracted first.
fn bands(
    out: &mut impl Write,
    model: &Prediction,
    measured: &RttStatistics,
    own_ms: f64,
    asked: Option<Asked>,
) -> io::Result<()> {
    let times = [model.min_ms, model.avg_ms, model.max_ms, model.sd_ms];
    let end = |name: &str, pick: fn(&Band) -> f64, out: &mut dyn Write| {
        line(out, name, times.each_ref().map(pick), pick(&model.loss))
    };
    end("99 % of seeds: from", |band| band.low, out)?;
    end("               to", |band| band.high, out)?;
    writeln!(out)?;
    // Where all seeds agree, what is measured differs by the machine alone.
    let judged: Vec<_> = columns(model, measured, own_ms)
        .filter(|(_, band, _)| band.low < band.high)
        .collect();
    let names = |is_inside: bool| {
        let judged = judged.iter();
        let some = judged.filter(|(_, band, value)| band.contains(*value) == is_inside);
        some.map(|(name, ..)| *name).collect::<Vec<_>>().join(", ")
    };
    let (inside, outside) = (names(true), names(false));
    let own = format!("less {own_ms:.3} ms, the player's own cost");
    match (judged.len(), outside.is_empty()) {
        (0, _) => writeln!(out, "No figure of these echoes depends on the seed.")?,
        (5, true) => writeln!(
            out,
            "All five are inside the band of 99 % of seeds ({own})."
        )?,
        (_, true) => writeln!(
            out,
            "Inside the band of 99 % of seeds: {inside}; nothing else depends on the seed."
        )?,
        (_, false) => writeln!(out, "Outside the band of 99 % of seeds: {outside} ({own}).")?,
    }
    if let (Some(asked), Some([.., max_ms, _])) = (asked, measured.times_ms())
        && asked.rtt_max_ms > 0.0
    {
        let factor = max_ms / asked.rtt_max_ms;
        writeln!(out, "The greatest RTT is {factor:.2} times the profile's.")?;
    }
    Ok(())
}

/// What can be held against a band: the loss, and the times if there are any.
fn columns(
    model: &Prediction,
    measured: &RttStatistics,
    own_ms: f64,
) -> impl Iterator<Item = (&'static str, Band, f64)> {
    let times = measured.times_ms().map(|[min, avg, max, sd]| {
        [
            ("min", model.min_ms, min - own_ms),
            ("avg", model.avg_ms, avg - own_ms),
            ("max", model.max_ms, max - own_ms),
            ("sd", model.sd_ms, sd),
        ]
    });
    let loss = ("loss", model.loss, measured.loss);
    times.into_iter().flatten().chain([loss])
}

fn proof(out: &mut impl Write, certificate: &Certificate) -> io::Result<()> {
    let rtt = &certificate.residuals.rtt;
    let fates = certificate.fates.came_though_lost + certificate.fates.lost_though_due;
    let told = certificate.sent - fates.min(certificate.sent);
    if certificate.answered > 0 {
        write!(
            out,
            "Against the model, echo by echo: median {:.3} ms, 99 % {:.3} ms, greatest {:.3} ms; ",
            rtt.median_ms, rtt.p99_ms, rtt.max_ms
        )?;
    } else {
        write!(out, "No delay to hold against the model; ")?;
    }
    writeln!(
        out,
        "the model predicted the fate of {told} of {}.",
        certificate.sent
    )?;
    match &certificate.verdict {
        _ if !is_judged(certificate) => {
            writeln!(
                out,
                "Too few answers to judge the link; it takes {ANSWERS_NEEDED}."
            )
        }
        Verdict::Holds => writeln!(out, "The link held."),
        Verdict::Broken(reasons) => reasons
            .iter()
            .try_for_each(|reason| writeln!(out, "The link did not hold: {reason}.")),
    }
}
