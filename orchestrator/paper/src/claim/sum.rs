//! Whether what each part costs the loop adds up to what all cost together: section 4.3's thesis, by one change at a
//! time and by all three.

use analysis::Campaign;
use endpoint::Mode;
use record::ReadError;
use report::claim::rule::ANY;
use report::claim::{Part, Verdict};
use report::group::Estimate;

use super::evidence::Evidence;
use super::plant::iae_from_command;
use super::source::Source;
use crate::printed::H_333_HZ_NS;
use crate::subject::{AskedRuns, NATIVE};

/// Where, and what is set beside the preset, as tables have it.
type Variation = (&'static str, &'static str);

/// No web server, no network, no desktop.
const NONE: Variation = ("arima", "udp");
/// One of them each: the web server, the network, the desktop.
const EACH: [Variation; 3] = [
    ("arima", ""),
    ("diego-vpn", "udp"),
    ("arima", "fault busy-machine, scheduling other, udp"),
];
/// All of them.
const ALL: Variation = ("diego-vpn", "fault busy-machine, scheduling other");

/// Compares the sum of three differences of the IAE with the difference of all together.
pub(super) fn of_parts(campaign: &Campaign) -> Result<Evidence, ReadError> {
    let mut evidence = Evidence::default();
    let mut iae = |(topology, words): Variation| {
        let asked = AskedRuns {
            subject: NATIVE,
            topology,
            mode: Mode::Closed,
            h_ns: H_333_HZ_NS,
            with: words.to_owned().into(),
        };
        let source = Source::of(campaign, asked);
        evidence.ask(&source);
        source.group.try_median(iae_from_command)
    };
    let (none, all) = (iae(NONE)?, iae(ALL)?);
    let [web, network, desktop] = EACH.map(&mut iae);
    let (web, network, desktop) = (web?, network?, desktop?);
    let (Some(none), Some(all), Some(web), Some(network), Some(desktop)) =
        (none, all, web, network, desktop)
    else {
        return Ok(evidence);
    };
    let parts = [web, network, desktop].map(|one| less(one, none));
    let whole = less(all, none);
    let sum = parts.into_iter().reduce(plus).unwrap_or(whole);
    for (name, part) in ["the web server", "the network", "the desktop"]
        .into_iter()
        .zip(parts)
    {
        let of = format!("IAE that {name} adds");
        evidence.show(Part::judged(&of, "s", None, Some(part), ANY));
    }
    evidence.show(Part::judged(
        "IAE that all add",
        "s",
        None,
        Some(whole),
        ANY,
    ));
    let part = Part::judged(
        "sum of what each adds to the IAE",
        "s",
        None,
        Some(sum),
        (whole.low, whole.high),
    );
    let overlap = sum.low <= whole.high && whole.low <= sum.high;
    let verdict = match (sum.has_interval() && whole.has_interval(), overlap) {
        (false, _) => Verdict::CannotBeTold,
        (true, true) => Verdict::Agrees,
        (true, false) => Verdict::Differs,
    };
    evidence.decide(Part { verdict, ..part });
    Ok(evidence)
}

/// The difference of two independent estimates, from the least to the greatest that their intervals allow.
fn less(one: Estimate, other: Estimate) -> Estimate {
    let ends = (one.low - other.high, one.high - other.low);
    Estimate::within(one.value - other.value, ends, one.n.min(other.n))
}

/// Their sum, likewise.
fn plus(one: Estimate, other: Estimate) -> Estimate {
    let ends = (one.low + other.low, one.high + other.high);
    Estimate::within(one.value + other.value, ends, one.n.min(other.n))
}
