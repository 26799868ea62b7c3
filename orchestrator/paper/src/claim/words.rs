//! Numbers and parts as text for people.

use report::claim::{Part, Verdict, rule};
use report::group::Estimate;
use report::number::number;

/// The most parts that a sentence lists one by one.
const LISTED: usize = 4;

/// A part with its number and, if it does not agree, with what is accepted:
/// `settling, python, diego-vpn, 333 Hz: 5.2 (4.8 to 5.6, n = 20; accepted 3 to 5)`.
pub(super) fn part(part: &Part) -> String {
    let Some(ours) = part.ours else {
        return format!("{}: nothing", part.of);
    };
    let mut about = vec![];
    if ours.has_interval() && ours.low < ours.high {
        about.push(format!("{} to {}", number(ours.low), number(ours.high)));
    }
    about.push(format!("n = {}", ours.n));
    about.extend(rule::too_few(&ours));
    let is_open = part.verdict != Verdict::Agrees;
    if let Some(accepted) = part.accepted.filter(|_| is_open) {
        about.push(format!("accepted {}", range(accepted)));
    }
    format!("{}: {} ({})", part.of, value(part, ours), about.join("; "))
}

/// A sentence that all parts agree, with as many of their numbers as fit.
pub(super) fn all_agree(parts: &[Part]) -> String {
    if parts.len() <= LISTED {
        let list: Vec<String> = parts.iter().map(part).collect();
        return format!("{}.", list.join("; "));
    }
    let mut quantities: Vec<(&str, &'static str)> = Vec::new();
    for part in parts {
        let quantity = (part.quantity.as_str(), part.unit);
        if !quantities.contains(&quantity) {
            quantities.push(quantity);
        }
    }
    let list: Vec<String> = quantities
        .into_iter()
        .map(|of| {
            let alike = parts
                .iter()
                .filter(|part| (part.quantity.as_str(), part.unit) == of);
            let values: Vec<f64> = alike.filter_map(|part| Some(part.ours?.value)).collect();
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let unit = if of.1.is_empty() { "" } else { " " };
            format!("{} {}{unit}{}", of.0, range((least, most)), of.1)
        })
        .collect();
    format!("All {} agree: {}.", parts.len(), list.join("; "))
}

fn value(part: &Part, ours: Estimate) -> String {
    match part.unit {
        "" => number(ours.value),
        unit => format!("{} {unit}", number(ours.value)),
    }
}

fn range((low, high): (f64, f64)) -> String {
    match (low.is_finite(), high.is_finite()) {
        (true, true) if number(low) == number(high) => number(low),
        (true, true) => format!("{} to {}", number(low), number(high)),
        (true, false) => format!("{} or more", number(low)),
        (false, true) => format!("{} or less", number(high)),
        (false, false) => "anything".to_owned(),
    }
}
