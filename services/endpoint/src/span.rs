//! A time span in text form: a number with a unit that gives whole nanoseconds, `2.5ms`.

/// Units, longest name first so that `ms` is not read as `s`.
const UNITS: [(&str, u64); 4] = [
    ("ns", 1),
    ("us", 1_000),
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
];

/// Reads a text such as `3ms`, `100us` or `0.3s` in nanoseconds; `None` if it is not a time span, or
/// not a whole number of nanoseconds.
#[must_use]
pub fn span_ns(text: &str) -> Option<u64> {
    let (number, unit_ns) = UNITS
        .iter()
        .find_map(|(unit, ns)| text.strip_suffix(unit).map(|number| (number, *ns)))?;
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let is_digits = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !is_digits(whole) || !is_digits(fraction) {
        return None;
    }
    // Computed digit by digit: 0.3 ms must be exactly 300000 ns, without rounding.
    let mut ns = whole.parse::<u64>().ok()?.checked_mul(unit_ns)?;
    let mut place_ns = unit_ns;
    for digit in fraction.bytes().map(|byte| u64::from(byte - b'0')) {
        if digit != 0 && !place_ns.is_multiple_of(10) {
            return None;
        }
        place_ns /= 10;
        ns = ns.checked_add(digit * place_ns)?;
    }
    Some(ns)
}

/// A span with the largest unit that divides it: `3ms`, not `3000us`.
#[must_use]
pub fn span_text(ns: u64) -> String {
    let (unit, unit_ns) = UNITS
        .iter()
        .rev()
        .find(|(_, unit_ns)| ns.is_multiple_of(*unit_ns))
        .unwrap_or(&UNITS[0]);
    format!("{}{unit}", ns / unit_ns)
}
