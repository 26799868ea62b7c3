//! Loss, and the rate limit with its queue.

use toml::Spanned;

use super::delay::optional;
use crate::file::{LossFile, PathFile};
use crate::finding::Findings;
use crate::profile::{Loss, Rate};
use crate::trace::Trace;

/// Loss is decided once a millisecond by default: the burst of packets of one control message shares
/// its fate, as it would on air.
const HOLD_NS: f64 = 1e6;
/// The default of tc.
const LIMIT: u32 = 1000;
/// Bytes of the largest packet on an Ethernet.
const LARGE_PACKET_BYTES: f64 = 1500.0;
/// A rate at which a packet takes longer than this to send is a mistake.
const LONGEST_SEND_S: f64 = 10.0;

pub(super) fn loss(
    file: Option<&Spanned<LossFile>>,
    trace: Option<&Trace>,
    findings: &mut Findings<'_>,
) -> Option<Loss> {
    let recorded = trace.is_some_and(|t| t.steps().iter().any(|step| step.loss > 0.0));
    let Some(file) = file else {
        let hold_ns = HOLD_NS as u64;
        return Some(if recorded {
            Loss::Trace { hold_ns }
        } else {
            Loss::Never
        });
    };
    if recorded {
        let message = "the trace has losses of its own";
        findings.error(
            file.span(),
            message,
            "drop this table, or the trace's losses",
        );
        return None;
    }
    match file.get_ref() {
        LossFile::Random { share, hold } => {
            let hold_ns = hold_ns(hold.as_ref(), findings);
            let p = findings.share(share);
            all_lost(share, p?, findings);
            Some(Loss::Random {
                share: p?,
                hold_ns: hold_ns?,
            })
        }
        LossFile::GilbertElliott {
            good,
            bad,
            in_good,
            in_bad,
            hold,
        } => {
            let hold_ns = hold_ns(hold.as_ref(), findings);
            let good_ns = findings.positive_ns(good);
            let bad_ns = findings.positive_ns(bad);
            let p_good = optional(in_good, |p| findings.share(p));
            let p_bad = optional(in_bad, |p| findings.share(p));
            let (p_good, p_bad) = (p_good?.unwrap_or(0.0), p_bad?.unwrap_or(1.0));
            let (good_ns, bad_ns, hold_ns) = (good_ns?, bad_ns?, hold_ns?);
            if bad_ns < hold_ns as f64 {
                let message = "bad spells are shorter than the slot in which loss is decided";
                findings.error(bad.span(), message, "write a shorter hold");
                return None;
            }
            if p_good >= p_bad {
                let message = "the good state loses as much as the bad one, or more";
                findings.warning(good.span(), message, "swap the two states");
            }
            Some(Loss::GilbertElliott {
                good_ns: good_ns as u64,
                bad_ns: bad_ns as u64,
                in_good: p_good,
                in_bad: p_bad,
                hold_ns,
            })
        }
    }
}

fn hold_ns(hold: Option<&Spanned<String>>, findings: &mut Findings<'_>) -> Option<u64> {
    match hold {
        None => Some(HOLD_NS as u64),
        Some(hold) => findings.positive_ns(hold).map(|ns| ns as u64),
    }
}

fn all_lost(share: &Spanned<String>, p: f64, findings: &mut Findings<'_>) {
    if p >= 1.0 {
        let message = "every packet is lost";
        findings.warning(share.span(), message, "write less than 100%");
    }
}

/// The rate limit; `Some(None)` for a path without one.
pub(super) fn rate(
    path: &PathFile,
    trace: Option<&Trace>,
    findings: &mut Findings<'_>,
) -> Option<Option<Rate>> {
    let recorded = trace.is_some_and(|t| t.steps().iter().any(|step| step.rate_bps.is_some()));
    let limit = match &path.limit {
        None => LIMIT,
        Some(limit) => match u32::try_from(*limit.get_ref()) {
            Ok(packets) if packets > 0 => packets,
            _ => {
                let message = format!("a queue of {} packets", limit.get_ref());
                findings.error(limit.span(), message, "write 1 or more");
                return None;
            }
        },
    };
    match (&path.rate, recorded) {
        (Some(rate), true) => {
            let message = "the trace has rates of its own";
            findings.error(rate.span(), message, "drop this key, or the trace's");
            None
        }
        (None, true) => Some(Some(Rate::Trace { limit })),
        (None, false) => {
            if let Some(at) = &path.limit {
                let message = "a queue limit without a rate: no packet ever waits";
                findings.error(at.span(), message, "add a rate, or drop `limit`");
            }
            Some(None)
        }
        (Some(rate), false) => {
            let rate_bps = findings.rate_bps(rate)?;
            if let Some(problem) = too_slow(rate_bps) {
                let remedy = "write a greater rate, such as \"1mbit\"";
                findings.error(rate.span(), problem, remedy);
                return None;
            }
            Some(Some(Rate::Constant { rate_bps, limit }))
        }
    }
}

/// What is wrong with a rate at which nothing gets through, or hardly anything.
pub(super) fn too_slow(rate_bps: u64) -> Option<String> {
    if rate_bps == 0 {
        return Some("a rate of 0 bit/s lets nothing through".to_owned());
    }
    let takes_s = LARGE_PACKET_BYTES * 8.0 / rate_bps as f64;
    (takes_s > LONGEST_SEND_S)
        .then(|| format!("at {rate_bps} bit/s one packet of 1500 bytes takes {takes_s:.0} s"))
}
