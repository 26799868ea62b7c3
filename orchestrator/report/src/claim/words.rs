//! Numbers and parts as a person reads them.

use super::{Part, Verdict, rule};
use crate::group::Estimate;

/// The most parts that a sentence lists one by one.
const LISTED: usize = 4;

/// A number with three significant digits.
pub(super) fn number(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if x.is_infinite() => "infinite".to_owned(),
        _ if size == 0.0 => "0".to_owned(),
        _ if size >= 99.95 => format!("{x:.0}"),
        _ if size >= 9.995 => format!("{x:.1}"),
        _ if size >= 0.9995 => format!("{x:.2}"),
        _ if size >= 0.0999_5 => format!("{x:.3}"),
        _ if size >= 0.0099_95 => format!("{x:.4}"),
        _ => format!("{x:.1e}"),
    }
}

/// A part with its number, and where it does not agree with what is accepted:
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

/// That all agree, with their numbers as far as they fit in a sentence.
pub(super) fn all_agree(parts: &[Part]) -> String {
    if parts.len() <= LISTED {
        let list: Vec<String> = parts.iter().map(part).collect();
        return format!("{}.", list.join("; "));
    }
    let mut quantities: Vec<(&str, &'static str)> = Vec::new();
    for part in parts {
        if !quantities.contains(&(quantity(part), part.unit)) {
            quantities.push((quantity(part), part.unit));
        }
    }
    let list: Vec<String> = quantities
        .into_iter()
        .map(|of| {
            let alike = parts
                .iter()
                .filter(|part| (quantity(part), part.unit) == of);
            let values: Vec<f64> = alike.filter_map(|part| Some(part.ours?.value)).collect();
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let unit = if of.1.is_empty() { "" } else { " " };
            format!("{} {}{unit}{}", of.0, range((least, most)), of.1)
        })
        .collect();
    format!("All {} agree: {}.", parts.len(), list.join("; "))
}

/// What was measured, without where.
fn quantity(part: &Part) -> &str {
    part.of.split(", ").next().unwrap_or_default()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let numbers = [3033.374, 10.9, 1.004, 0.2494, 0.0746, 0.00098, -2.4e-3, 0.0];
        let words = numbers.map(number);
        assert_eq!(
            words,
            [
                "3033", "10.9", "1.00", "0.249", "0.0746", "9.8e-4", "-2.4e-3", "0"
            ]
        );
        assert_eq!(number(f64::INFINITY), "infinite");
    }
}
