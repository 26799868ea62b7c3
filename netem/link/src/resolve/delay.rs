//! Delays and stalls.

use toml::Spanned;

use super::law;
use crate::file::{DelayFile, StallFile};
use crate::finding::Findings;
use crate::law::{Form, Law};
use crate::profile::{Delay, Level, Stall};

/// Share of a law's draws that may be clipped without a finding.
const CLIPPED_SILENTLY: f64 = 1e-6;
/// Share of draws above which clipping causes a warning even if it was asked for.
const CLIPPED_NOTABLY: f64 = 0.05;
/// For each packet the player looks back over as many redraws as fit into the greatest delay; with
/// more than this it would be late.
pub(super) const MOST_HOLDS_IN_FLIGHT: f64 = 1000.0;
/// A link that holds packets for longer than this has other problems.
pub(super) const LONGEST_DELAY_NS: f64 = 3600e9;

pub(super) fn delay(file: &Spanned<DelayFile>, findings: &mut Findings<'_>) -> Option<Delay> {
    let at = file.get_ref();
    let base_ns = findings.duration_ns(&at.base);
    let hold_ns = optional(&at.hold, |hold| findings.positive_ns(hold));
    let min_ns = optional(&at.min, |min| findings.duration_ns(min));
    let max_ns = optional(&at.max, |max| findings.duration_ns(max));
    let spread = optional(&at.spread, |spread| law::form(spread, findings));
    let (base_ns, hold_ns, min_ns, max_ns) = (base_ns?, hold_ns?, min_ns?, max_ns?);

    if let (Some(min_ns), Some(max_ns), Some(max)) = (min_ns, max_ns, &at.max)
        && min_ns > max_ns
    {
        findings.error(max.span(), "max is below min", "correct min or max");
        return None;
    }
    let (Some(form), Some(spread)) = (spread?, &at.spread) else {
        check_idle(at, findings);
        return Some(Delay::Constant {
            delay_ns: base_ns as u64,
        });
    };
    let (Some(hold), Some(hold_ns)) = (&at.hold, hold_ns) else {
        let message = "a spread needs a `hold`: how long a drawn delay stays";
        let remedy = "add hold, such as hold = \"100ms\"";
        findings.error(spread.span(), message, remedy);
        return None;
    };
    let limits = (
        min_ns.unwrap_or(0.0) - base_ns,
        max_ns.map_or(f64::INFINITY, |max_ns| max_ns - base_ns),
    );
    let law = Law::new(form, limits.0, limits.1);
    check_clipping(at, spread, &law, limits, findings);
    let reach_ns = base_ns + law.reach_ns();
    if reach_ns > LONGEST_DELAY_NS {
        let message = "draws of this law can exceed an hour";
        let remedy = "write a max beside the spread, such as max = \"1s\"";
        findings.error(spread.span(), message, remedy);
        return None;
    }
    check_redraws(hold, hold_ns, reach_ns, findings)?;
    Some(Delay::Held(Level {
        base_ns: base_ns as u64,
        spread: law,
        hold_ns: hold_ns as u64,
    }))
}

/// Reports keys that do nothing where the delay is constant.
fn check_idle(at: &DelayFile, findings: &mut Findings<'_>) {
    for (name, idle) in [("hold", &at.hold), ("min", &at.min), ("max", &at.max)] {
        if let Some(idle) = idle {
            let message = format!("`{name}` has no effect without a spread");
            let remedy = "add a spread, or drop this key";
            findings.error(idle.span(), message, remedy);
        }
    }
}

/// `None`, after an error, if the level is redrawn too often while a packet is under way.
fn check_redraws(
    hold: &Spanned<String>,
    hold_ns: f64,
    reach_ns: f64,
    findings: &mut Findings<'_>,
) -> Option<()> {
    let redraws = reach_ns / hold_ns;
    if redraws > MOST_HOLDS_IN_FLIGHT {
        let message =
            format!("the level is redrawn {redraws:.0} times while a packet is under way");
        let remedy = format!(
            "write a hold of {:.3} ms or more, or a smaller max",
            reach_ns / MOST_HOLDS_IN_FLIGHT / 1e6
        );
        findings.error(hold.span(), message, remedy);
        return None;
    }
    Some(())
}

/// Reports draws that the profile's limits clip.
fn check_clipping(
    at: &DelayFile,
    spread: &Spanned<crate::file::LawFile>,
    law: &Law,
    limits: (f64, f64),
    findings: &mut Findings<'_>,
) {
    let below = share_of_draws(law, |x| x < limits.0);
    let above = share_of_draws(law, |x| x > limits.1);
    if at.min.is_none() && below > CLIPPED_SILENTLY {
        let message = format!(
            "{:.4} % of the draws make the delay negative",
            100.0 * below
        );
        let remedy = "write min = \"0ms\" (or more) to clip them, a greater base or a smaller sd";
        findings.error(spread.span(), message, remedy);
    } else if below + above > CLIPPED_NOTABLY {
        let message = format!(
            "{:.1} % of the draws are clipped: mean and sd are not those of the law",
            100.0 * (below + above)
        );
        let remedy = "check the round trips that `webloop link show` predicts";
        findings.warning(spread.span(), message, remedy);
    }
}

/// The share of unclipped draws for which `is` is true, which must all be at one end of the law: by
/// bisection of the quantile function.
fn share_of_draws(law: &Law, is: impl Fn(f64) -> bool) -> f64 {
    const BISECTIONS: usize = 60;
    let (low, high) = (f64::EPSILON / 2.0, 1.0 - f64::EPSILON / 2.0);
    match (is(law.raw_ns(low)), is(law.raw_ns(high))) {
        (false, false) => 0.0,
        (true, true) => 1.0,
        (at_low, _) => {
            let (mut a, mut b) = (low, high);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (a + b);
                if is(law.raw_ns(middle)) == at_low {
                    a = middle;
                } else {
                    b = middle;
                }
            }
            if at_low { a } else { 1.0 - a }
        }
    }
}

pub(super) fn stall(file: &Spanned<StallFile>, findings: &mut Findings<'_>) -> Option<Stall> {
    let at = file.get_ref();
    let every_ns = findings.positive_ns(&at.every);
    let max_ns = optional(&at.max, |max| findings.positive_ns(max));
    let form = law::form(&at.length, findings);
    let (every_ns, max_ns, form) = (every_ns?, max_ns?, form?);
    if let Form::Normal { mean_ns, sd_ns } = form {
        // As for a delay, but without a base: five sd keep it above zero.
        if mean_ns < 5.0 * sd_ns {
            let message = "a normal law gives stalls of negative length";
            let remedy = "use a gamma law, or an sd below a fifth of the mean";
            findings.error(at.length.span(), message, remedy);
            return None;
        }
    }
    let length = Law::new(form, 0.0, max_ns.unwrap_or(f64::INFINITY));
    if length.reach_ns() > LONGEST_DELAY_NS {
        let message = "draws of this law can exceed an hour";
        let remedy = "write a max beside the length, such as max = \"5s\"";
        findings.error(at.length.span(), message, remedy);
        return None;
    }
    let mean_ns = length.mean_ns();
    if mean_ns >= every_ns {
        let message = format!(
            "stalls last {:.3} ms on average and begin every {:.3} ms",
            mean_ns / 1e6,
            every_ns / 1e6
        );
        let remedy = "write a longer `every` (from start to start) or shorter stalls";
        findings.error(at.every.span(), message, remedy);
        return None;
    }
    if mean_ns > every_ns / 2.0 {
        let message = "the link is stalled for more than half of the time";
        let remedy = "check `every`: it counts from start to start";
        findings.warning(at.every.span(), message, remedy);
    }
    Some(Stall {
        every_ns: every_ns as u64,
        length,
    })
}

/// `Some(None)` if the key is absent, `None` if its value is wrong.
pub(super) fn optional<T, U>(
    key: &Option<T>,
    resolve: impl FnOnce(&T) -> Option<U>,
) -> Option<Option<U>> {
    match key {
        None => Some(None),
        Some(value) => resolve(value).map(Some),
    }
}
