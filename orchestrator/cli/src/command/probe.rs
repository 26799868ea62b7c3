//! `webloop probe`: pings through a link, and compares with what the link should have done.

use std::io::{self, Write};

use ::link::{Asked, Band, Pings, Prediction, Profile, predict};
use anyhow::anyhow;
use backend::Probed;
use certificate::{ANSWERS_NEEDED, Certificate, Echo, RttStatistics, Verdict};

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
    let judged = probed
        .certificate
        .filter(|certificate| certificate.sent >= ANSWERS_NEEDED);
    match judged.map(|certificate| certificate.verdict) {
        Some(Verdict::Broken(reasons)) => {
            Err(anyhow!("the link did not hold: {}", reasons.join("; ")).into())
        }
        _ => Ok(Exit::Fine),
    }
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
    writeln!(
        out,
        "rtt min/avg/max/mdev = {:.3}/{:.3}/{:.3}/{:.3} ms",
        measured.min_ms, measured.avg_ms, measured.max_ms, measured.sd_ms
    )?;
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
    if sent > 0 {
        let prediction = predict(profile, Pings { count, interval_ns });
        bands(
            out,
            &prediction,
            &measured,
            probed.baseline.rtt_ms,
            profile.asked(),
        )?;
    }
    proof(out, certificate)
}

fn row(out: &mut impl Write, name: &str, rtt: &RttStatistics) -> io::Result<()> {
    writeln!(
        out,
        "{name:<26}{:>11.3}{:>11.3}{:>11.3}{:>11.3}{:>9.2}",
        rtt.min_ms,
        rtt.avg_ms,
        rtt.max_ms,
        rtt.sd_ms,
        rtt.loss * 100.0
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
    let columns = [
        ("min", model.min_ms, measured.min_ms - own_ms),
        ("avg", model.avg_ms, measured.avg_ms - own_ms),
        ("max", model.max_ms, measured.max_ms - own_ms),
        ("sd", model.sd_ms, measured.sd_ms),
        ("loss", model.loss, measured.loss),
    ];
    let end = |name: &str, pick: fn(&Band) -> f64, out: &mut dyn Write| {
        let [min, avg, max, sd, loss] = columns.each_ref().map(|(_, band, _)| pick(band));
        writeln!(
            out,
            "{name:<26}{min:>11.3}{avg:>11.3}{max:>11.3}{sd:>11.3}{:>9.2}",
            loss * 100.0
        )
    };
    if model.avg_ms.low == model.avg_ms.high {
        return writeln!(out, "\nNothing in this link depends on the seed.");
    }
    end("99 % of seeds: from", |band| band.low, out)?;
    end("               to", |band| band.high, out)?;
    let outside: Vec<_> = columns
        .iter()
        .filter(|(_, band, value)| !band.contains(*value))
        .map(|(name, _, _)| *name)
        .collect();
    writeln!(out)?;
    match outside.as_slice() {
        [] => writeln!(
            out,
            "All five are inside the band of 99 % of seeds (less {own_ms:.3} ms, the player's own cost)."
        )?,
        names => writeln!(
            out,
            "Outside the band of 99 % of seeds: {} (less {own_ms:.3} ms, the player's own cost).",
            names.join(", ")
        )?,
    }
    if let Some(asked) = asked {
        let factor = measured.max_ms / asked.rtt_max_ms;
        writeln!(out, "The greatest RTT is {factor:.2} times the profile's.")?;
    }
    Ok(())
}

fn proof(out: &mut impl Write, certificate: &Certificate) -> io::Result<()> {
    let rtt = &certificate.residuals.rtt;
    let fates = certificate.fates.came_though_lost + certificate.fates.lost_though_due;
    writeln!(
        out,
        "Against the model, echo by echo: median {:.3} ms, 99 % {:.3} ms, greatest {:.3} ms; the \
         model predicted the fate of {} of {}.",
        rtt.median_ms,
        rtt.p99_ms,
        rtt.max_ms,
        certificate.sent - fates.min(certificate.sent),
        certificate.sent
    )?;
    match &certificate.verdict {
        _ if certificate.sent < ANSWERS_NEEDED => {
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
