//! Times as they are written for people, and the units that they have. `duration` reads them.

/// A minute, ns.
pub const MINUTE_NS: u64 = 60_000_000_000;
/// A day, ns.
pub const DAY_NS: u64 = 24 * 3_600_000_000_000;
/// A week, ns: the longest duration of a run. Anything longer is more likely a typing error.
pub const WEEK_NS: u64 = 7 * DAY_NS;

/// Units of times, smallest first.
pub(crate) const UNITS: [(&str, u64); 6] = [
    ("ns", 1),
    ("µs", 1_000),
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
    ("m", MINUTE_NS),
    ("h", 60 * MINUTE_NS),
];

/// A time as people write it: `10ms`, `1s 500ms`.
#[must_use]
pub fn duration_text(ns: u64) -> String {
    let mut rest_ns = ns;
    let mut parts = Vec::new();
    for (unit, unit_ns) in UNITS.iter().rev() {
        if rest_ns >= *unit_ns {
            parts.push(format!("{}{unit}", rest_ns / unit_ns));
            rest_ns %= unit_ns;
        }
    }
    if parts.is_empty() {
        return "0s".to_owned();
    }
    parts.join(" ")
}

/// A time with the largest unit up to a second that divides it: `3ms`, not `3000us`.
#[must_use]
pub fn span_text(ns: u64) -> String {
    let unit = [("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000)]
        .into_iter()
        .find(|(_, unit_ns)| ns.is_multiple_of(*unit_ns));
    let (unit, unit_ns) = unit.unwrap_or(("ns", 1));
    format!("{}{unit}", ns / unit_ns)
}
